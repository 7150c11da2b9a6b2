//! The command line of `ac-record`.
//!
//! Exit codes: 0 = done; 1 = something is wrong with what was recorded, read or written (the text says what); 2 = it could not be done.

mod export;
mod look;
mod make;
mod proxy;
mod units;

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::RecordError;

/// Something is wrong with a recording.
pub const FOUND: u8 = 1;
/// The command could not run.
pub const COULD_NOT_RUN: u8 = 2;

#[derive(Parser)]
#[command(
    name = "ac-record",
    version,
    about = "Records client/server sessions into MCAP",
    after_help = "Exit codes: 0 done, 1 something is wrong with what was recorded, read or written, 2 could not run.\n\
                  How to record a session: docs/recording.md. What is in a file: docs/recording-format.md."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Pass datagrams on between clients and a server, and record them.
    Proxy(proxy::ProxyArgs),
    /// Say what a recording holds: streams, packets, losses, messages.
    Info(Inputs),
    /// List the messages of a recording.
    Ls(look::LsArgs),
    /// Write the messages of a recording as JSON, one per line, or as pictures for Foxglove and Rerun.
    Export(export::ExportArgs),
    /// Check every datagram, every message and the index.
    Verify(Inputs),
    /// Save what can be read of a file that was cut off.
    Recover(make::CopyArgs),
    /// Make a recording of a network capture (pcap, pcapng).
    Import(make::ImportArgs),
    /// Redact a recording again: one that was made with --keep-secrets, or by an older program.
    Redact(make::RedactArgs),
    /// Show a scene to one client over the game's protocol, on a network as bad as wanted. A development tool: it trusts every login.
    DemoServer(crate::demo_server::shell::Args),
    /// Write the golden packet sessions and the traces that are expected of them again.
    DemoSessions(crate::demo_server::shell::SessionArgs),
    /// Log in to a server without a screen and do what a script says.
    Play(crate::play::shell::Args),
    /// Measure what the proxy adds and loses on this machine.
    #[command(hide = true)]
    Bench(crate::measure::bench::BenchArgs),
    /// Kill the proxy at random moments and see what can be recovered.
    #[command(hide = true)]
    KillTrials(crate::measure::trials::TrialArgs),
}

#[derive(clap::Args)]
struct Inputs {
    /// A recording; several files are the parts of one recording, in order.
    #[arg(required = true)]
    input: Vec<PathBuf>,
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
        Ok((text, code)) => {
            // A reader that has seen enough (`| head`) is no error.
            let _ = std::io::stdout().lock().write_all(text.as_bytes());
            ExitCode::from(code)
        }
        Err(error) => {
            eprintln!("{:?}", miette::Report::new(error));
            ExitCode::from(COULD_NOT_RUN)
        }
    }
}

fn run(command: Command) -> Result<(String, u8), RecordError> {
    match command {
        Command::Proxy(args) => proxy::proxy(&args),
        Command::Info(args) => look::info(&args.input),
        Command::Ls(args) => look::ls(&args),
        Command::Export(args) => export::export(&args),
        Command::Verify(args) => look::verify(&args.input),
        Command::Recover(args) => make::recover(&args),
        Command::Import(args) => make::import_capture(&args),
        Command::Redact(args) => make::redact(&args),
        Command::DemoServer(args) => Ok((crate::demo_server::shell::run(&args)?, 0)),
        Command::DemoSessions(args) => Ok((crate::demo_server::shell::write_sessions(&args)?, 0)),
        Command::Play(args) => Ok((crate::play::shell::run(&args)?, 0)),
        Command::Bench(args) => crate::measure::bench::run(&args),
        Command::KillTrials(args) => crate::measure::trials::run(&args),
    }
}
