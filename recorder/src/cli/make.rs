//! Commands that make a recording of something: recover, redact, import.

use std::fmt::Write as _;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use super::{FOUND, proxy::policy};
use crate::error::RecordError;
use crate::format::{
    Continuation, Item, PartInfo, RecordingReader, RecordingWriter, WriterOptions,
};
use crate::pcap::{ImportReport, import};
use crate::progress::Progress;
use crate::scan::scan;
use crate::secrets::{SecretPolicy, SharedSecrets, locked};

#[derive(clap::Args)]
pub(super) struct CopyArgs {
    /// A recording.
    input: PathBuf,
    /// The file to write.
    #[arg(short, long)]
    output: PathBuf,
    /// Keep the secrets of a recording that was made with --keep-secrets.
    #[arg(long)]
    keep_secrets: bool,
}

#[derive(clap::Args)]
pub(super) struct RedactArgs {
    /// A recording.
    input: PathBuf,
    /// The file to write.
    #[arg(short, long)]
    output: PathBuf,
    /// Hide the lengths of account and password too.
    #[arg(long)]
    hide_length: bool,
    /// A file of further texts to overwrite wherever they are, one per line: names, accounts whose login was not recorded.
    #[arg(long)]
    words: Option<PathBuf>,
}

#[derive(clap::Args)]
pub(super) struct ImportArgs {
    /// A capture.
    input: PathBuf,
    /// The server's login port; the next one counts too.
    #[arg(long, default_value_t = 9000)]
    server_port: u16,
    /// The recording to write.
    #[arg(short, long)]
    output: PathBuf,
    /// Hide the lengths of account and password too.
    #[arg(long)]
    hide_length: bool,
    /// Write account names, passwords and tickets as they are. The file says so.
    #[arg(long, conflicts_with = "hide_length")]
    keep_secrets: bool,
}

type Out = RecordingWriter<BufWriter<File>>;

fn failed(path: &Path) -> impl Fn(std::io::Error) -> RecordError {
    move |source| RecordError::File {
        path: path.into(),
        source,
    }
}

fn create(
    path: &Path,
    secrets: SecretPolicy,
    known: &SharedSecrets,
    part: u32,
) -> Result<Out, RecordError> {
    let file = File::create_new(path).map_err(failed(path))?;
    let options = WriterOptions {
        secrets,
        ..WriterOptions::default()
    };
    let state = Continuation::new(known.clone());
    RecordingWriter::part(
        BufWriter::new(file),
        options,
        PartInfo { number: part },
        state,
    )
    .map_err(|failed| failed.0)
}

/// A source with progress.
fn source(path: &Path) -> Result<Progress<File>, RecordError> {
    let file = File::open(path).map_err(failed(path))?;
    let length = file.metadata().map_or(0, |m| m.len());
    Ok(Progress::new(path, length, file))
}

/// Ends a file and searches it for the secrets that were seen. Adds to the text when something is found.
fn end(
    writer: Out,
    path: &Path,
    policy: SecretPolicy,
    known: &SharedSecrets,
    text: &mut String,
) -> Result<u8, RecordError> {
    writer
        .finish()?
        .into_inner()
        .map_err(|e| failed(path)(e.into_error()))?;
    if policy == SecretPolicy::Keep {
        text.push_str("secrets were KEPT (--keep-secrets)\n");
        return Ok(0);
    }
    let searcher = locked(known).searcher();
    let found = scan(path, &searcher)?;
    if found.is_clean() {
        return Ok(0);
    }
    let _ = writeln!(
        text,
        "SECRET FOUND in {}: {} places in the file, {} in its records; do not share it",
        path.display(),
        found.in_file,
        found.in_records
    );
    Ok(FOUND)
}

/// Copies datagrams with their numbers and times, and counters.
fn copy(
    reader: &mut RecordingReader<Progress<File>>,
    writer: &mut Out,
) -> Result<u64, RecordError> {
    let mut packets = 0;
    while let Some(item) = reader.next_item() {
        match item {
            Item::Packet(packet) => {
                packets += 1;
                writer.continuation().set_number(packet.number);
                writer.write_forwarded(
                    packet.stream,
                    packet.time,
                    packet.forwarded,
                    &packet.bytes,
                )?;
            }
            Item::Counts(time, counts) => writer.write_counts(time, &counts)?,
            // The writer makes its own.
            Item::Index(..) => {}
        }
    }
    Ok(packets)
}

pub(super) fn recover(args: &CopyArgs) -> Result<(String, u8), RecordError> {
    let known = SharedSecrets::default();
    let policy = policy(args.keep_secrets, false);
    let mut reader = match RecordingReader::new(&args.input, source(&args.input)?) {
        Ok(reader) => reader,
        Err(RecordError::NotStarted { .. }) => {
            // Ended before anything could be recorded: that is what can be saved.
            create(&args.output, policy, &known, 1)?.finish()?;
            let text = format!("{}: 0 datagrams\n", args.output.display());
            return Ok((
                text + "lost from here: the file ends before the recording starts\n",
                FOUND,
            ));
        }
        Err(error) => return Err(error),
    };
    let mut writer = create(&args.output, policy, &known, reader.info().part)?;
    let packets = copy(&mut reader, &mut writer)?;
    let mut text = format!("{}: {packets} datagrams\n", args.output.display());
    let mut code = end(writer, &args.output, policy, &known, &mut text)?;
    if let Some(damage) = reader.damage() {
        let _ = writeln!(text, "lost from here: {damage}");
        code = FOUND;
    }
    Ok((text, code))
}

pub(super) fn redact(args: &RedactArgs) -> Result<(String, u8), RecordError> {
    let known = SharedSecrets::default();
    if let Some(path) = &args.words {
        let words = std::fs::read_to_string(path).map_err(failed(path))?;
        let mut secrets = locked(&known);
        for word in words.lines().map(str::trim).filter(|w| !w.is_empty()) {
            secrets.add(word);
        }
    }
    // The first reading only learns: a secret may come before the login that shows it.
    learn(&args.input, &known)?;
    let policy = policy(false, args.hide_length);
    let mut reader = RecordingReader::new(&args.input, source(&args.input)?)?;
    let mut writer = create(&args.output, policy, &known, reader.info().part)?;
    let packets = copy(&mut reader, &mut writer)?;
    let hidden = writer.totals().1;
    let mut text = format!(
        "{}: {packets} datagrams, {hidden} bytes under redaction\n",
        args.output.display()
    );
    let mut code = end(writer, &args.output, policy, &known, &mut text)?;
    if let Some(damage) = reader.damage() {
        let _ = writeln!(text, "lost from here: {damage}");
        code = FOUND;
    }
    Ok((text, code))
}

/// Learns the secrets of a recording.
fn learn(path: &Path, known: &SharedSecrets) -> Result<(), RecordError> {
    let mut reader = RecordingReader::new(path, source(path)?)?;
    while let Some(packet) = reader.next_packet() {
        if packet.stream.to_server {
            crate::secrets::learn(&packet.bytes, known);
        }
    }
    Ok(())
}

pub(super) fn import_capture(args: &ImportArgs) -> Result<(String, u8), RecordError> {
    let known = SharedSecrets::default();
    let policy = policy(args.keep_secrets, args.hide_length);
    let capture = source(&args.input)?;
    let mut writer = create(&args.output, policy, &known, 1)?;
    let report = import(&args.input, capture, args.server_port, &mut writer)?;
    let mut text = imported(&args.output, &report);
    let code = end(writer, &args.output, policy, &known, &mut text)?;
    Ok((text, code))
}

fn imported(path: &Path, report: &ImportReport) -> String {
    let mut text = format!(
        "{}: {} datagrams; {} secret bytes overwritten\n",
        path.display(),
        report.taken,
        report.redacted
    );
    let rest = [
        (report.others, "packets of others"),
        (report.cut, "packets captured only in part"),
        (
            report.incomplete,
            "fragments of datagrams that never became complete",
        ),
        (report.unreadable, "damaged packets"),
    ];
    for (count, what) in rest {
        if count > 0 {
            let _ = writeln!(text, "left out: {count} {what}");
        }
    }
    if report.reassembled > 0 {
        let _ = writeln!(
            text,
            "{} datagrams were put together from IP fragments",
            report.reassembled
        );
    }
    if let Some(damage) = &report.damage {
        let _ = writeln!(text, "the capture is read up to its damage: {damage}");
    }
    text
}
