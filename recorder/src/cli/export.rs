//! `ac-record export`: messages as JSON lines, recordings as pictures.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{FOUND, look::each_packet};
use crate::decode::{Decoder, RecordedMessage};
use crate::error::RecordError;
use crate::pictures::Pictures;

#[derive(clap::Args)]
pub(super) struct ExportArgs {
    /// A recording; several files are the parts of one recording, in order.
    #[arg(required = true)]
    input: Vec<PathBuf>,
    /// The messages as JSON, one per line.
    #[arg(short, long, required_unless_present = "foxglove")]
    output: Option<PathBuf>,
    /// An MCAP file of pictures for Foxglove and Rerun: objects and their paths, and the messages as a log (docs/foxglove.md).
    #[arg(long)]
    foxglove: Option<PathBuf>,
    /// Only messages whose name contains this text (JSON only).
    #[arg(long)]
    name: Option<String>,
}

/// A line of an export.
#[derive(Serialize)]
struct ExportLine {
    time_ns: u64,
    client: u32,
    to_server: bool,
    name: String,
    queue: u16,
    datagrams: Vec<u32>,
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
            queue: message.queue,
            datagrams: message.datagrams.clone(),
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

pub(super) fn export(args: &ExportArgs) -> Result<(String, u8), RecordError> {
    let (mut text, mut code) = (String::new(), 0);
    if let Some(output) = &args.output {
        let (count, damage) = export_json(args, output)?;
        let _ = writeln!(text, "{}: {count} messages", output.display());
        code = report_damage(&mut text, damage);
    }
    if let Some(output) = &args.foxglove {
        let damage = draw(&args.input, output, &mut text)?;
        code = code.max(report_damage(&mut text, damage));
    }
    Ok((text, code))
}

/// Draws a recording.
pub(super) fn draw(
    input: &[PathBuf],
    output: &Path,
    text: &mut String,
) -> Result<Damage, RecordError> {
    let mut pictures = Pictures::new(create(output)?)?;
    let mut result = Ok(());
    let files = each_packet(input, |packet| {
        if result.is_ok() {
            result = pictures.take(packet);
        }
    })?;
    result?;
    let _ = writeln!(text, "{}: {}", output.display(), pictures.finish()?);
    Ok(files.damage)
}

pub(super) type Damage = Option<(PathBuf, String)>;

fn report_damage(text: &mut String, damage: Damage) -> u8 {
    let Some((path, damage)) = damage else {
        return 0;
    };
    let _ = writeln!(text, "damaged: {}: {damage}", path.display());
    FOUND
}

fn export_json(args: &ExportArgs, output: &Path) -> Result<(usize, Damage), RecordError> {
    let failed = |source: std::io::Error| RecordError::File {
        path: output.into(),
        source,
    };
    let mut out = create(output)?;
    let (mut decoder, mut messages) = (Decoder::new(), Vec::new());
    let (mut count, mut result) = (0, Ok(()));
    let files = each_packet(&args.input, |packet| {
        messages.clear();
        decoder.take(packet, &mut messages);
        for message in &messages {
            let wanted = args.name.as_ref();
            if result.is_err() || wanted.is_some_and(|w| !message.name().contains(w.as_str())) {
                continue;
            }
            count += 1;
            result = serde_json::to_writer(&mut out, &ExportLine::of(message))
                .map_err(std::io::Error::from)
                .and_then(|()| out.write_all(b"\n"));
        }
    })?;
    result.and_then(|()| out.flush()).map_err(failed)?;
    Ok((count, files.damage))
}
