//! Reading a recording, as far as it can be read, in bounded memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::{
    COUNTERS_METADATA, COUNTERS_TOPIC, INDEX_TOPIC, IndexEntry, METADATA, OLD_VERSION,
    RecordedPacket, Stream, VERSION,
};
use crate::counters::Counts;
use crate::error::RecordError;
use crate::secrets::KEPT;

/// Longest record or chunk that is read.
const RECORD_LIMIT: usize = 64 << 20;
/// Bytes that are read at once.
const READ: usize = 1 << 18;

/// What a recording says of itself.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecordingInfo {
    /// Version of the format.
    pub format: String,
    /// Program that wrote it.
    pub producer: String,
    /// Whether secrets were kept.
    pub secrets_kept: bool,
    /// Which part of a recording in several files, from 1.
    pub part: u32,
}

/// Something of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Item {
    /// A datagram.
    Packet(RecordedPacket),
    /// A line of the message index, and its time, ns since 1970.
    Index(u64, IndexEntry),
    /// Counters at a time, ns since 1970.
    Counts(u64, Counts),
}

enum Topic {
    Packets(Stream),
    Index,
    Counters,
}

/// Hands out what a recording holds, in the order of the file.
pub struct RecordingReader<R> {
    source: R,
    mcap: LinearReader,
    topics: BTreeMap<u16, Topic>,
    info: RecordingInfo,
    damage: Option<String>,
    last_counts: Option<Counts>,
    bytes: u64,
    done: bool,
}

enum Step {
    Item(Box<Item>),
    Metadata(BTreeMap<String, String>),
    Other,
}

impl<R: Read> RecordingReader<R> {
    /// Reads the start of a recording. `path` is for messages only.
    ///
    /// # Errors
    /// It is no recording, or one of a newer format.
    pub fn new(path: &Path, source: R) -> Result<Self, RecordError> {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(RECORD_LIMIT);
        let mut reader = Self {
            source,
            mcap: LinearReader::new_with_options(options),
            topics: BTreeMap::new(),
            info: RecordingInfo::default(),
            damage: None,
            last_counts: None,
            bytes: 0,
            done: false,
        };
        // The metadata comes right after the header; damage behind it does not matter here.
        loop {
            match reader.step() {
                Some(Ok(Step::Metadata(metadata))) => {
                    reader.info = info_of(path, &metadata)?;
                    return Ok(reader);
                }
                Some(Ok(_)) => {}
                Some(Err(mcap::McapError::UnexpectedEof)) => {
                    return Err(RecordError::NotStarted { path: path.into() });
                }
                Some(Err(_)) | None => {
                    return Err(RecordError::NotARecording { path: path.into() });
                }
            }
        }
    }

    /// What the recording says of itself.
    pub const fn info(&self) -> &RecordingInfo {
        &self.info
    }

    /// Why reading ended before the end of the file, if it did. Known when there are no more items.
    pub fn damage(&self) -> Option<&str> {
        self.damage.as_deref()
    }

    /// The last counters so far.
    pub const fn last_counts(&self) -> Option<&Counts> {
        self.last_counts.as_ref()
    }

    /// Bytes read of the source.
    pub const fn position(&self) -> u64 {
        self.bytes
    }

    /// The next item. After damage there are no more.
    pub fn next_item(&mut self) -> Option<Item> {
        while !self.done {
            match self.step() {
                Some(Ok(Step::Item(mut item))) => {
                    if let (Item::Packet(packet), true) =
                        (&mut *item, self.info.format == OLD_VERSION)
                    {
                        // It was the arrival.
                        packet.forwarded = None;
                    }
                    return Some(*item);
                }
                Some(Ok(_)) => {}
                Some(Err(error)) => {
                    self.damage = Some(match error {
                        mcap::McapError::UnexpectedEof => "the file was not finished".into(),
                        error => error.to_string(),
                    });
                    self.done = true;
                }
                None => self.done = true,
            }
        }
        None
    }

    /// The next datagram.
    pub fn next_packet(&mut self) -> Option<RecordedPacket> {
        loop {
            if let Item::Packet(packet) = self.next_item()? {
                return Some(packet);
            }
        }
    }

    fn step(&mut self) -> Option<mcap::McapResult<Step>> {
        let wanted = match self.mcap.next_event()? {
            Ok(LinearReadEvent::ReadRequest(n)) => n,
            Ok(LinearReadEvent::Record { data, opcode }) => {
                let record = match opcode {
                    op::CHANNEL | op::MESSAGE | op::METADATA => mcap::parse_record(opcode, data),
                    _ => return Some(Ok(Step::Other)),
                };
                let taken = record.map(|r| take(r, &mut self.topics, &mut self.last_counts));
                return Some(taken);
            }
            Err(error) => return Some(Err(error)),
        };
        let room = self.mcap.insert(wanted.clamp(READ, 4 * READ));
        match self.source.read(room) {
            Ok(n) => {
                self.bytes += n as u64;
                self.mcap.notify_read(n);
                Some(Ok(Step::Other))
            }
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => Some(Ok(Step::Other)),
            Err(error) => Some(Err(error.into())),
        }
    }
}

fn take(
    record: Record<'_>,
    topics: &mut BTreeMap<u16, Topic>,
    last_counts: &mut Option<Counts>,
) -> Step {
    match record {
        Record::Channel(channel) => {
            let topic = match channel.topic.as_str() {
                INDEX_TOPIC => Some(Topic::Index),
                COUNTERS_TOPIC => Some(Topic::Counters),
                other => Stream::of(other).map(Topic::Packets),
            };
            if let Some(topic) = topic {
                topics.insert(channel.id, topic);
            }
            Step::Other
        }
        Record::Message { header, data } => {
            let item = match topics.get(&header.channel_id) {
                Some(&Topic::Packets(stream)) => Some(Item::Packet(RecordedPacket {
                    stream,
                    number: header.sequence,
                    time: header.log_time,
                    forwarded: (header.publish_time != 0).then_some(header.publish_time),
                    bytes: data.into_owned(),
                })),
                Some(Topic::Index) => serde_json::from_slice(&data)
                    .ok()
                    .map(|entry| Item::Index(header.log_time, entry)),
                Some(Topic::Counters) => serde_json::from_slice(&data).ok().map(|counts| {
                    *last_counts = Some(counts);
                    Item::Counts(header.log_time, counts)
                }),
                None => None,
            };
            item.map_or(Step::Other, |item| Step::Item(Box::new(item)))
        }
        Record::Metadata(metadata) if metadata.name == METADATA => {
            Step::Metadata(metadata.metadata)
        }
        Record::Metadata(metadata) if metadata.name == COUNTERS_METADATA => {
            let numbers: serde_json::Map<_, _> = metadata
                .metadata
                .into_iter()
                .filter_map(|(k, v)| Some((k, v.parse::<u64>().ok()?.into())))
                .collect();
            *last_counts = serde_json::from_value(numbers.into()).ok().or(*last_counts);
            Step::Other
        }
        _ => Step::Other,
    }
}

fn info_of(path: &Path, metadata: &BTreeMap<String, String>) -> Result<RecordingInfo, RecordError> {
    let entry = |name: &str| metadata.get(name).cloned().unwrap_or_default();
    let format = entry("format");
    match format.as_str() {
        VERSION | OLD_VERSION => Ok(RecordingInfo {
            format,
            producer: entry("producer"),
            secrets_kept: entry("secrets") == KEPT,
            part: entry("part").parse().unwrap_or(1),
        }),
        "" => Err(RecordError::NotARecording { path: path.into() }),
        _ => Err(RecordError::Version {
            path: path.into(),
            found: format,
        }),
    }
}

/// What could be read of a recording, all at once.
#[derive(Debug, Default)]
pub struct Recording {
    /// Datagrams in order of arrival.
    pub packets: Vec<RecordedPacket>,
    /// Why reading ended before the end of the file, if it did.
    pub damage: Option<String>,
}

/// Reads the bytes of a recording, as far as they can be read.
///
/// # Errors
/// The bytes are no recording.
pub fn read_bytes(path: &Path, bytes: &[u8]) -> Result<Recording, RecordError> {
    collect(RecordingReader::new(path, bytes)?)
}

fn collect<R: Read>(mut reader: RecordingReader<R>) -> Result<Recording, RecordError> {
    let mut recording = Recording::default();
    while let Some(packet) = reader.next_packet() {
        recording.packets.push(packet);
    }
    recording.damage = reader.damage.take();
    Ok(recording)
}

/// Opens a recording.
///
/// # Errors
/// The file cannot be opened, or is no recording.
pub fn open(path: &Path) -> Result<RecordingReader<File>, RecordError> {
    let file = File::open(path).map_err(|source| RecordError::File {
        path: path.into(),
        source,
    })?;
    RecordingReader::new(path, file)
}

/// Reads a recording, as far as it can be read.
///
/// # Errors
/// The file cannot be read, or is no recording.
pub fn read(path: &Path) -> Result<Recording, RecordError> {
    collect(open(path)?)
}

/// Reads the parts of a recording in several files, in the order given.
///
/// # Errors
/// A file cannot be read, or is no recording.
pub fn read_all(paths: &[PathBuf]) -> Result<Recording, RecordError> {
    let mut all = Recording::default();
    for path in paths {
        let part = read(path)?;
        all.packets.extend(part.packets);
        all.damage = all.damage.or(part.damage);
    }
    Ok(all)
}
