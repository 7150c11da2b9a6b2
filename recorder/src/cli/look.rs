//! Commands that look at a recording: info, ls, verify.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::fs::File;
use std::path::PathBuf;

use super::FOUND;
use crate::counters::Counts;
use crate::decode::{RecordedMessage, arrow};
use crate::error::RecordError;
use crate::format::{IndexEntry, Item, RecordedPacket, RecordingInfo, RecordingReader};
use crate::progress::Progress;
use crate::stats::Analysis;

/// Findings that are listed one by one.
const LISTED: usize = 200;

#[derive(clap::Args)]
pub(super) struct LsArgs {
    /// A recording; several files are the parts of one recording, in order.
    #[arg(required = true)]
    input: Vec<PathBuf>,
    /// Only messages whose name contains this text.
    #[arg(long)]
    name: Option<String>,
    /// Only messages of this client.
    #[arg(long)]
    client: Option<u32>,
}

/// What was learned about the files while they were read.
#[derive(Default)]
pub(super) struct Files {
    infos: Vec<RecordingInfo>,
    pub(super) damage: Option<(PathBuf, String)>,
    counts: Option<Counts>,
}

/// Reads files one after the other.
fn each(paths: &[PathBuf], mut take: impl FnMut(&Item)) -> Result<Files, RecordError> {
    let mut files = Files::default();
    for path in paths {
        let failed = |source| RecordError::File {
            path: path.clone(),
            source,
        };
        let file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_or(0, |m| m.len());
        let mut reader = RecordingReader::new(path, Progress::new(path, length, file))?;
        files.infos.push(reader.info().clone());
        while let Some(item) = reader.next_item() {
            take(&item);
        }
        if let Some(damage) = reader.damage() {
            files.damage = Some((path.clone(), damage.to_owned()));
        }
        files.counts = reader.last_counts().copied().or(files.counts);
    }
    Ok(files)
}

pub(super) fn each_packet(
    paths: &[PathBuf],
    mut take: impl FnMut(&RecordedPacket),
) -> Result<Files, RecordError> {
    each(paths, |item| {
        if let Item::Packet(packet) = item {
            take(packet);
        }
    })
}

const fn way(to_server: bool) -> &'static str {
    if to_server { "->" } else { "<-" }
}

pub(super) fn info(paths: &[PathBuf]) -> Result<(String, u8), RecordError> {
    let (mut analysis, mut messages) = (Analysis::default(), Vec::new());
    let files = each_packet(paths, |packet| {
        messages.clear();
        analysis.take(packet, &mut messages);
    })?;
    let mut text = String::new();
    if let Some(info) = files.infos.first() {
        let secrets = if files.infos.iter().any(|i| i.secrets_kept) {
            "SECRETS ARE IN THIS FILE"
        } else {
            "secrets redacted"
        };
        let _ = writeln!(
            text,
            "format {}, by {}, {secrets}",
            info.format, info.producer
        );
    }
    let _ = writeln!(
        text,
        "{} datagrams in {:.3} s",
        analysis.packets,
        analysis.seconds()
    );
    streams(&mut text, &analysis);
    lines(&mut text, &analysis);
    for ((to_server, name), (count, bytes)) in &analysis.messages {
        let way = way(*to_server);
        let _ = writeln!(text, "{way} {name:<40} {count:>8} {bytes:>12} bytes");
    }
    let mut code = counted(&mut text, &analysis, files.counts.as_ref());
    if let Some((path, damage)) = &files.damage {
        let _ = writeln!(
            text,
            "damaged: {}: {damage}; `ac-record recover` saves what is listed here",
            path.display()
        );
        code = FOUND;
    }
    Ok((text, code))
}

fn streams(text: &mut String, analysis: &Analysis) {
    for (stream, counts) in &analysis.streams {
        let _ = writeln!(
            text,
            "{:<32} {:>8} datagrams {:>12} bytes",
            stream.topic(),
            counts.datagrams,
            counts.bytes
        );
    }
}

fn lines(text: &mut String, analysis: &Analysis) {
    for ((client, to_server), c) in analysis.lines() {
        let way = way(to_server);
        let _ = write!(
            text,
            "client {client} {way} {} numbered packets",
            c.numbered
        );
        let rest = [
            (c.gaps, "never came"),
            (c.late, "late"),
            (c.repeated, "repeated"),
            (c.retransmissions, "marked as retransmission"),
            (c.naks, "requests for lost ones"),
            (c.checksum, "wrong checksums"),
            (c.key, "wrong key words"),
            (c.malformed, "no packets"),
            (c.unreadable, "unreadable messages"),
        ];
        for (count, what) in rest.into_iter().filter(|r| r.0 > 0) {
            let _ = write!(text, ", {count} {what}");
        }
        text.push('\n');
    }
}

/// What the proxy lost, as far as the files tell.
fn counted(text: &mut String, analysis: &Analysis, counts: Option<&Counts>) -> u8 {
    let mut code = 0;
    if analysis.not_recorded > 0 {
        code = FOUND;
        let _ = writeln!(
            text,
            "{} datagrams were passed on but are not in the recording",
            analysis.not_recorded
        );
    }
    let Some(counts) = counts else {
        return code;
    };
    let known = [
        (counts.unwritten_slow, "not recorded: the disk was too slow"),
        (
            counts.unwritten_failed,
            "not recorded: the file could not be written",
        ),
        (
            counts.system_dropped,
            "dropped by the system before the proxy saw them",
        ),
        (counts.not_sent, "refused by the system when passed on"),
        (
            counts.refused,
            "from unknown addresses, no login: not passed on",
        ),
    ];
    for (count, what) in known.into_iter().filter(|k| k.0 > 0) {
        let _ = writeln!(text, "proxy: {count} datagrams {what}");
    }
    code
}

pub(super) fn ls(args: &LsArgs) -> Result<(String, u8), RecordError> {
    let mut text = String::new();
    let (mut decoder, mut messages, mut start) = (crate::decode::Decoder::new(), Vec::new(), None);
    let wanted = |m: &RecordedMessage, name: &str| {
        args.client.is_none_or(|c| c == m.stream.client)
            && args
                .name
                .as_ref()
                .is_none_or(|wanted| name.contains(wanted))
    };
    let files = each_packet(&args.input, |packet| {
        let start = *start.get_or_insert(packet.time);
        messages.clear();
        decoder.take(packet, &mut messages);
        for message in &messages {
            let name = message.name();
            if wanted(message, &name) {
                let _ = writeln!(
                    text,
                    "{:>12.6} {} {} {name} {} bytes",
                    message.time.saturating_sub(start) as f64 / 1e9,
                    message.stream.client,
                    arrow(message.stream.direction()),
                    message.bytes.len()
                );
            }
        }
    })?;
    if let Some((path, damage)) = files.damage {
        tracing::warn!(file = %path.display(), damage, "only what could be read is listed");
        return Ok((text, FOUND));
    }
    Ok((text, 0))
}

/// Compares the index with the messages of the datagrams before it.
#[derive(Default)]
struct IndexCheck {
    expected: VecDeque<IndexEntry>,
    entries: usize,
    wrong: usize,
    first: Option<u32>,
}

impl IndexCheck {
    fn expect(&mut self, messages: &[RecordedMessage]) {
        self.expected.extend(messages.iter().map(IndexEntry::of));
    }

    fn entry(&mut self, entry: &IndexEntry) {
        self.entries += 1;
        // A message that began in a file that is not read here.
        let first = self.first.unwrap_or_default();
        if entry.datagrams.iter().any(|&d| d < first) {
            return;
        }
        if self.expected.pop_front().as_ref() != Some(entry) {
            self.wrong += 1;
        }
    }
}

pub(super) fn verify(paths: &[PathBuf]) -> Result<(String, u8), RecordError> {
    let (mut analysis, mut messages) = (Analysis::default(), Vec::new());
    let (mut text, mut found, mut count) = (String::new(), 0usize, 0);
    let mut index = IndexCheck::default();
    let files = each(paths, |item| match item {
        Item::Packet(packet) => {
            index.first.get_or_insert(packet.number);
            messages.clear();
            let what = analysis.take(packet, &mut messages);
            count += messages.len();
            index.expect(&messages);
            if let Some(what) = what {
                found += 1;
                if found <= LISTED {
                    let topic = packet.stream.topic();
                    let _ = writeln!(text, "datagram {}, {topic}: {what}", packet.number);
                }
            }
        }
        Item::Index(_, entry) => index.entry(entry),
        Item::Counts(..) => {}
    })?;
    if found > LISTED {
        let _ = writeln!(text, "... and {} more", found - LISTED);
    }
    if let Some((path, damage)) = &files.damage {
        found += 1;
        let _ = writeln!(text, "file {}: {damage}", path.display());
    }
    found += check_index(&mut text, &index, &files);
    if analysis.not_recorded > 0 {
        found += 1;
        let _ = writeln!(
            text,
            "{} datagrams were passed on but are not in the recording",
            analysis.not_recorded
        );
    }
    let gaps: usize = analysis.lines().map(|(_, c)| c.gaps).sum();
    let _ = writeln!(
        text,
        "{} datagrams, {count} messages, {gaps} packets never came, {found} findings",
        analysis.packets
    );
    Ok((text, if found == 0 { 0 } else { FOUND }))
}

/// Findings of the index. Files of the old format have none, and a part that is not the first knows messages that it cannot show.
fn check_index(text: &mut String, index: &IndexCheck, files: &Files) -> usize {
    let first = files.infos.first();
    if index.entries == 0 && first.is_none_or(|i| i.format == "1") {
        return 0;
    }
    let left = if files.damage.is_some() {
        0
    } else {
        index.expected.len()
    };
    if index.wrong + left == 0 || first.is_some_and(|i| i.part > 1) {
        return 0;
    }
    let _ = writeln!(
        text,
        "index: {} of {} entries are not what the datagrams say, {left} are missing",
        index.wrong, index.entries
    );
    1
}
