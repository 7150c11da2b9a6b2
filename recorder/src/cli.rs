//! The command line of `ac-record`.
//!
//! Exit codes: 0 = done; 1 = `verify` found something, or `recover` and `info` met damage; 2 = it could not be done.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::net::{SocketAddr, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use serde::Serialize;

use crate::decode::{Decoder, Finding, RecordedMessage, all_messages, arrow};
use crate::error::RecordError;
use crate::format::{Recording, RecordingWriter, Stream, read};
use crate::pcap::import;
use crate::proxy::{Proxy, ProxyConfig, asked_to_stop};
use crate::relay::RelayLimits;

/// Something is wrong with a recording.
pub const FOUND: u8 = 1;
/// The command could not run.
pub const COULD_NOT_RUN: u8 = 2;

#[derive(Parser)]
#[command(
    name = "ac-record",
    version,
    about = "Records client/server sessions into MCAP"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Pass datagrams on between clients and a server, and record them.
    Proxy(ProxyArgs),
    /// Say what a recording holds.
    Info(Input),
    /// List the messages of a recording.
    Ls(LsArgs),
    /// Write the messages of a recording as JSON, one per line.
    Export(OutputArgs),
    /// Check every datagram and every message.
    Verify(Input),
    /// Save what can be read of a file that was cut off.
    Recover(OutputArgs),
    /// Make a recording of a network capture (pcap, pcapng).
    Import(ImportArgs),
    /// Redact a recording again, with the rules of this program.
    Redact(OutputArgs),
    /// Show a scene to one client over the game's protocol, on a network as bad as wanted. A development tool: it trusts every login.
    DemoServer(crate::demo_server::shell::Args),
    /// Write the golden packet sessions and the traces that are expected of them again.
    DemoSessions(crate::demo_server::shell::SessionArgs),
    /// Log in to a server without a screen and do what a script says.
    Play(crate::play::shell::Args),
}

#[derive(clap::Args)]
struct ProxyArgs {
    /// Login port of the server, HOST:PORT; the next port is used too.
    #[arg(long)]
    server: String,
    /// Where clients connect; the next port is used too. Other machines reach the proxy only if this says so.
    #[arg(long, default_value = "127.0.0.1:9000")]
    listen: SocketAddr,
    /// Clients at once.
    #[arg(long, default_value_t = RelayLimits::default().clients)]
    max_clients: usize,
    /// The recording to write.
    #[arg(short, long)]
    output: PathBuf,
}

#[derive(clap::Args)]
struct Input {
    /// A recording.
    input: PathBuf,
}

#[derive(clap::Args)]
struct LsArgs {
    /// A recording.
    input: PathBuf,
    /// Only messages whose name contains this text.
    #[arg(long)]
    name: Option<String>,
}

#[derive(clap::Args)]
struct OutputArgs {
    /// A recording.
    input: PathBuf,
    /// The file to write.
    #[arg(short, long)]
    output: PathBuf,
}

#[derive(clap::Args)]
struct ImportArgs {
    /// A capture.
    input: PathBuf,
    /// The server's login port; the next one counts too.
    #[arg(long, default_value_t = 9000)]
    server_port: u16,
    /// The recording to write.
    #[arg(short, long)]
    output: PathBuf,
}

/// Parses the arguments of the process and runs the command.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return if error.use_stderr() {
                ExitCode::from(COULD_NOT_RUN)
            } else {
                ExitCode::SUCCESS
            };
        }
    };
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .init();
    match run(cli.command) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            eprintln!("{:?}", miette::Report::new(error));
            ExitCode::from(COULD_NOT_RUN)
        }
    }
}

fn run(command: Command) -> Result<u8, RecordError> {
    let (text, code) = match command {
        Command::Proxy(args) => (proxy(&args)?, 0),
        Command::Info(args) => info(&args.input)?,
        Command::Ls(args) => (ls(&read(&args.input)?, args.name.as_deref()), 0),
        Command::Export(args) => (export(&args.input, &args.output)?, 0),
        Command::Verify(args) => verify(&read(&args.input)?),
        Command::Recover(args) => recover(&args.input, &args.output)?,
        Command::Import(args) => (import_capture(&args)?, 0),
        Command::Redact(args) => (copy(&read(&args.input)?, &args.output)?, 0),
        Command::DemoServer(args) => (crate::demo_server::shell::run(&args)?, 0),
        Command::DemoSessions(args) => (crate::demo_server::shell::write_sessions(&args)?, 0),
        Command::Play(args) => (crate::play::shell::run(&args)?, 0),
    };
    // A reader that has seen enough (`| head`) is no error.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    Ok(code)
}

fn resolve(text: &str) -> Result<SocketAddr, RecordError> {
    let bad = |reason: String| RecordError::Address {
        text: text.into(),
        reason,
    };
    let mut found = text.to_socket_addrs().map_err(|e| bad(e.to_string()))?;
    found.next().ok_or_else(|| bad("no address".into()))
}

fn proxy(args: &ProxyArgs) -> Result<String, RecordError> {
    let config = ProxyConfig {
        listen: args.listen,
        server: resolve(&args.server)?,
        output: args.output.clone(),
        limits: RelayLimits {
            clients: args.max_clients,
            ..RelayLimits::default()
        },
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|source| RecordError::Socket {
            address: args.listen,
            source,
        })?;
    let report = runtime.block_on(async {
        let proxy = Proxy::open(&config).await?;
        tracing::info!(listen = %config.listen, server = %config.server, "recording; Ctrl-C ends it");
        proxy.run(asked_to_stop()).await
    })?;
    Ok(format!(
        "{}: {} datagrams, {} secret bytes overwritten\n",
        args.output.display(),
        report.packets,
        report.redacted
    ))
}

fn seconds(from: u64, to: u64) -> f64 {
    to.saturating_sub(from) as f64 / 1e9
}

fn info(path: &Path) -> Result<(String, u8), RecordError> {
    let recording = read(path)?;
    let mut streams: BTreeMap<Stream, (usize, usize)> = BTreeMap::new();
    for packet in &recording.packets {
        let (count, bytes) = streams.entry(packet.stream).or_default();
        *count += 1;
        *bytes += packet.bytes.len();
    }
    let mut names: BTreeMap<_, usize> = BTreeMap::new();
    for message in all_messages(&recording.packets) {
        *names
            .entry((message.stream.to_server, message.name()))
            .or_default() += 1;
    }
    let ends = (recording.packets.first(), recording.packets.last());
    let length = match ends {
        (Some(first), Some(last)) => seconds(first.time, last.time),
        _ => 0.0,
    };
    let mut text = format!("{} datagrams in {length:.3} s\n", recording.packets.len());
    for (stream, (count, bytes)) in streams {
        let _ = writeln!(
            text,
            "{:<32} {count:>8} datagrams {bytes:>12} bytes",
            stream.topic()
        );
    }
    for ((to_server, name), count) in names {
        let _ = writeln!(
            text,
            "{} {name:<40} {count:>8}",
            if to_server { "->" } else { "<-" }
        );
    }
    let code = match &recording.damage {
        Some(damage) => {
            let _ = writeln!(
                text,
                "damaged: {damage}; `ac-record recover` saves what is listed here"
            );
            FOUND
        }
        None => 0,
    };
    Ok((text, code))
}

fn ls(recording: &Recording, name: Option<&str>) -> String {
    let start = recording.packets.first().map_or(0, |p| p.time);
    let mut text = String::new();
    for message in all_messages(&recording.packets) {
        let own = message.name();
        if name.is_some_and(|wanted| !own.contains(wanted)) {
            continue;
        }
        let _ = writeln!(
            text,
            "{:>12.6} {} {} {own} {} bytes",
            seconds(start, message.time),
            message.stream.client,
            arrow(message.stream.direction()),
            message.bytes.len()
        );
    }
    text
}

/// A line of an export.
#[derive(Serialize)]
struct ExportLine {
    time_ns: u64,
    client: u32,
    to_server: bool,
    name: String,
    hex: String,
}

impl ExportLine {
    fn of(message: &RecordedMessage) -> Self {
        let mut hex = String::with_capacity(2 * message.bytes.len());
        for byte in &message.bytes {
            let _ = write!(hex, "{byte:02x}");
        }
        Self {
            time_ns: message.time,
            client: message.stream.client,
            to_server: message.stream.to_server,
            name: message.name().into_owned(),
            hex,
        }
    }
}

fn create(path: &Path) -> Result<BufWriter<File>, RecordError> {
    let file = File::create_new(path).map_err(|source| RecordError::File {
        path: path.into(),
        source,
    })?;
    Ok(BufWriter::new(file))
}

fn export(input: &Path, output: &Path) -> Result<String, RecordError> {
    let failed = |source: std::io::Error| RecordError::File {
        path: output.into(),
        source,
    };
    let messages = all_messages(&read(input)?.packets);
    let mut out = create(output)?;
    for message in &messages {
        serde_json::to_writer(&mut out, &ExportLine::of(message)).map_err(|e| failed(e.into()))?;
        out.write_all(b"\n").map_err(failed)?;
    }
    out.flush().map_err(failed)?;
    Ok(format!(
        "{}: {} messages\n",
        output.display(),
        messages.len()
    ))
}

fn verify(recording: &Recording) -> (String, u8) {
    let (mut decoder, mut messages) = (Decoder::new(), Vec::new());
    let (mut text, mut found) = (String::new(), 0usize);
    for (number, packet) in recording.packets.iter().enumerate() {
        let what = match decoder.take(packet, &mut messages) {
            Finding::Good => continue,
            Finding::Checksum => "wrong checksum".to_owned(),
            Finding::Malformed(error) => error.to_string(),
            Finding::Message(error) => error,
        };
        found += 1;
        let _ = writeln!(text, "datagram {number}, {}: {what}", packet.stream.topic());
    }
    if let Some(damage) = &recording.damage {
        found += 1;
        let _ = writeln!(text, "file: {damage}");
    }
    let (packets, messages) = (recording.packets.len(), messages.len());
    let _ = writeln!(
        text,
        "{packets} datagrams, {messages} messages, {found} findings"
    );
    (text, if found == 0 { 0 } else { FOUND })
}

/// Writes the datagrams of a recording into a new one, which redacts them.
fn copy(recording: &Recording, output: &Path) -> Result<String, RecordError> {
    let mut writer = RecordingWriter::new(create(output)?)?;
    for packet in &recording.packets {
        writer.write(packet.stream, packet.time, &packet.bytes)?;
    }
    let (packets, redacted) = writer.totals();
    writer.finish()?;
    Ok(format!(
        "{}: {packets} datagrams, {redacted} bytes under redaction\n",
        output.display()
    ))
}

fn import_capture(args: &ImportArgs) -> Result<String, RecordError> {
    let capture = File::open(&args.input).map_err(|source| RecordError::File {
        path: args.input.clone(),
        source,
    })?;
    let mut writer = RecordingWriter::new(create(&args.output)?)?;
    let report = import(&args.input, capture, args.server_port, &mut writer)?;
    writer.finish()?;
    Ok(format!(
        "{}: {} datagrams; left out: {} of others, {} cut off; {} secret bytes overwritten\n",
        args.output.display(),
        report.taken,
        report.others,
        report.cut,
        report.redacted
    ))
}

fn recover(input: &Path, output: &Path) -> Result<(String, u8), RecordError> {
    let recording = read(input)?;
    let mut text = copy(&recording, output)?;
    let code = match &recording.damage {
        Some(damage) => {
            let _ = writeln!(text, "lost from here: {damage}");
            FOUND
        }
        None => 0,
    };
    Ok((text, code))
}
