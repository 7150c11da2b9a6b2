//! Reads a trace as a stream: one chunk in memory at a time, whatever the length of the file.

use std::{
    collections::{BTreeMap, HashMap},
    io::Read,
    path::{Path, PathBuf},
};

use ac_client::frame::FrameStates;
use mcap::{
    McapError,
    records::{Record, op},
    sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions},
};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::{
    ChannelHeader, ChannelKind, ClockRun, FormatVersion, METADATA, SCENE_ATTACHMENT, TraceInfo,
};
use crate::{
    GoldenError, Scene,
    record::{self, RecordError, Unknown},
    scene::ScriptStep,
};

/// No record of a trace comes near this; a longer one is refused before it is read into memory.
pub(super) const MAX_RECORD: usize = 256 << 20;

/// Reads a trace file from start to end.
pub struct TraceReader<R> {
    path: PathBuf,
    source: R,
    mcap: LinearReader,
    info: TraceInfo,
    scene: Scene,
    scene_text: Vec<u8>,
    unknown: Unknown,
    channels: HashMap<u16, Channel>,
    wanted: ChannelFilter,
}

/// Which channels a caller wants; the messages of others are skipped unread.
pub type ChannelFilter = fn(&ChannelKind) -> bool;

struct Channel {
    kind: Option<ChannelKind>,
    topic: String,
    header: Option<ChannelHeader>,
}

/// What comes next in a trace.
#[derive(Debug)]
pub enum TraceEvent<'a> {
    /// Frames of the same length.
    Clock(ClockRun),
    /// An input.
    Script(Box<ScriptStep>),
    /// States of a frame, produced or expected; they are in the list given to [`TraceReader::next_event`].
    States {
        /// Which channel.
        kind: &'a ChannelKind,
        /// The frame.
        frame: i32,
        /// Seconds on its clock.
        time: f64,
    },
    /// Stage checkpoints of a frame.
    Stages {
        /// The oracle.
        oracle: &'a str,
        /// Its checkpoints.
        message: StageMessage,
    },
}

/// Stage checkpoints of one frame, as raw JSON.
#[derive(Debug, Deserialize)]
pub struct StageMessage {
    /// The frame.
    pub frame: i32,
    /// One per stage that ran, in order.
    pub records: Vec<Box<RawValue>>,
}

impl TraceReader<std::fs::File> {
    /// Opens a file and reads its metadata and scene.
    ///
    /// # Errors
    /// When it cannot be read, is no trace, or is of a version that this program does not read.
    pub fn open(path: &Path) -> Result<Self, GoldenError> {
        let file = std::fs::File::open(path).map_err(|source| GoldenError::Io {
            path: path.into(),
            source,
        })?;
        Self::new(file, path)
    }
}

impl<R: Read> TraceReader<R> {
    /// Starts reading; `path` is what errors call the source.
    ///
    /// # Errors
    /// As [`TraceReader::open`].
    pub fn new(source: R, path: &Path) -> Result<Self, GoldenError> {
        let options = LinearReaderOptions::default()
            .with_validate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(MAX_RECORD);
        let mut reader = Self {
            path: path.into(),
            source,
            mcap: LinearReader::new_with_options(options),
            info: TraceInfo {
                version: FormatVersion::CURRENT,
                scene: String::new(),
                producer: String::new(),
                profile: String::new(),
                world: BTreeMap::new(),
            },
            scene: Scene::empty(),
            scene_text: Vec::new(),
            unknown: Unknown::Refuse,
            channels: HashMap::new(),
            wanted: |_| true,
        };
        reader.read_head()?;
        Ok(reader)
    }

    /// What the metadata record says.
    pub fn info(&self) -> &TraceInfo {
        &self.info
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene file's text.
    pub fn scene_text(&self) -> &[u8] {
        &self.scene_text
    }

    /// What is done with fields that this version does not know.
    pub(super) fn unknown(&self) -> Unknown {
        self.unknown
    }

    /// What the channel of an oracle says about itself; known once the channel was seen, which is before its first message.
    pub fn header(&self, kind: &ChannelKind) -> Option<&ChannelHeader> {
        self.channels
            .values()
            .find(|channel| channel.kind.as_ref() == Some(kind))?
            .header
            .as_ref()
    }

    /// Skips the messages of channels that `wanted` does not name.
    pub fn select(&mut self, wanted: ChannelFilter) {
        self.wanted = wanted;
    }

    /// Reads metadata and scene, which a writer puts in front of everything else.
    fn read_head(&mut self) -> Result<(), GoldenError> {
        let mut has_metadata = false;
        while let Some(event) = self.mcap.next_event() {
            let (opcode, data) = match event.map_err(|error| damaged(&self.path, error))? {
                LinearReadEvent::ReadRequest(bytes) => {
                    feed(&mut self.mcap, &mut self.source, bytes, &self.path)?;
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => (opcode, data),
            };
            match opcode {
                op::ATTACHMENT if !is_whole_attachment(data) => {
                    return Err(damaged(&self.path, McapError::UnexpectedEof));
                }
                op::METADATA | op::ATTACHMENT => {}
                op::MESSAGE | op::DATA_END => {
                    return Err(container(
                        &self.path,
                        "there is no metadata `ac-trace` and no scene in front of its messages",
                    ));
                }
                _ => continue,
            }
            match mcap::parse_record(opcode, data).map_err(|error| damaged(&self.path, error))? {
                Record::Metadata(metadata) if metadata.name == METADATA => {
                    self.info = info(&metadata.metadata)
                        .map_err(|reason| container(&self.path, &reason))?;
                    self.unknown = self.info.version.accept(&self.path)?;
                    has_metadata = true;
                }
                Record::Attachment { header, data, .. } if header.name == SCENE_ATTACHMENT => {
                    if !has_metadata {
                        return Err(container(
                            &self.path,
                            "there is no metadata `ac-trace` in front of its scene",
                        ));
                    }
                    self.scene = Scene::parse(&data, &self.path.join(SCENE_ATTACHMENT))?;
                    self.scene_text = data.into_owned();
                    return Ok(());
                }
                _ => {}
            }
        }
        Err(container(&self.path, "it has no scene"))
    }

    /// The next message of a channel that is wanted; `None` at the end. States go into `states`, reusing its memory.
    ///
    /// # Errors
    /// When the file is damaged or cut off, or a message is not what its channel says.
    pub fn next_event(
        &mut self,
        states: &mut FrameStates,
    ) -> Result<Option<TraceEvent<'_>>, GoldenError> {
        while let Some(event) = self.mcap.next_event() {
            let (opcode, data) = match event.map_err(|error| damaged(&self.path, error))? {
                LinearReadEvent::ReadRequest(bytes) => {
                    feed(&mut self.mcap, &mut self.source, bytes, &self.path)?;
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => (opcode, data),
            };
            if opcode == op::CHANNEL {
                let record =
                    mcap::parse_record(opcode, data).map_err(|error| damaged(&self.path, error))?;
                if let Record::Channel(channel) = record {
                    self.channels.insert(channel.id, Channel::new(channel));
                }
            }
            if opcode != op::MESSAGE {
                continue;
            }
            let (id, sequence, payload) =
                message(data).ok_or_else(|| damaged(&self.path, McapError::UnexpectedEof))?;
            let Some(channel) = self.channels.get(&id) else {
                return Err(damaged(&self.path, McapError::UnknownChannel(sequence, id)));
            };
            let Some(kind) = channel.kind.as_ref().filter(|kind| (self.wanted)(kind)) else {
                continue;
            };
            return match parse(kind, payload, self.unknown, states) {
                Ok(parsed) => Ok(Some(self.event(id, parsed))),
                Err(error) => Err(GoldenError::Message {
                    path: self.path.clone(),
                    topic: channel.topic.clone(),
                    sequence,
                    error,
                }),
            };
        }
        Ok(None)
    }

    fn event(&self, id: u16, parsed: Parsed) -> TraceEvent<'_> {
        let kind = self
            .channels
            .get(&id)
            .and_then(|channel| channel.kind.as_ref())
            .unwrap_or(&ChannelKind::States);
        match parsed {
            Parsed::Clock(run) => TraceEvent::Clock(run),
            Parsed::Script(step) => TraceEvent::Script(step),
            Parsed::States(frame, time) => TraceEvent::States { kind, frame, time },
            Parsed::Stages(message) => {
                let oracle = if let ChannelKind::Stages(oracle) = kind {
                    oracle
                } else {
                    ""
                };
                TraceEvent::Stages { oracle, message }
            }
        }
    }
}

enum Parsed {
    Clock(ClockRun),
    Script(Box<ScriptStep>),
    States(i32, f64),
    Stages(StageMessage),
}

fn parse(
    kind: &ChannelKind,
    payload: &[u8],
    unknown: Unknown,
    states: &mut FrameStates,
) -> Result<Parsed, RecordError> {
    let bad = |error: serde_json::Error| RecordError {
        path: "message".into(),
        reason: error.to_string(),
    };
    Ok(match kind {
        ChannelKind::Clock => Parsed::Clock(serde_json::from_slice(payload).map_err(bad)?),
        ChannelKind::Script => Parsed::Script(serde_json::from_slice(payload).map_err(bad)?),
        ChannelKind::States | ChannelKind::Expect(_) => {
            let (frame, time) = record::read_message(payload, unknown, states)?;
            Parsed::States(frame, time)
        }
        ChannelKind::Stages(_) => Parsed::Stages(serde_json::from_slice(payload).map_err(bad)?),
    })
}

impl Channel {
    fn new(channel: mcap::records::Channel) -> Self {
        let text = |key: &str| channel.metadata.get(key).cloned().unwrap_or_default();
        let header = channel
            .metadata
            .contains_key("oracle")
            .then(|| ChannelHeader {
                schema: text("schema"),
                scene: String::new(),
                oracle: text("oracle"),
                oracle_version: serde_json::from_str(&text("oracle_version")).unwrap_or_default(),
                notes: serde_json::from_str(&text("notes")).unwrap_or_default(),
            });
        Self {
            kind: ChannelKind::of(&channel.topic),
            topic: channel.topic,
            header,
        }
    }
}

fn info(metadata: &BTreeMap<String, String>) -> Result<TraceInfo, String> {
    let text = |key: &str| {
        metadata
            .get(key)
            .cloned()
            .ok_or_else(|| format!("its metadata has no `{key}`"))
    };
    let world = metadata
        .iter()
        .filter_map(|(key, hash)| Some((key.strip_prefix("world/")?.to_owned(), hash.clone())));
    Ok(TraceInfo {
        version: text("format")?.parse()?,
        scene: text("scene")?,
        producer: text("producer")?,
        profile: metadata.get("profile").cloned().unwrap_or_default(),
        world: world.collect(),
    })
}

/// Whether an attachment record is as long as its lengths say: two times, name, media type, data, checksum.
pub(super) fn is_whole_attachment(body: &[u8]) -> bool {
    fn skip_text(rest: &[u8]) -> Option<&[u8]> {
        let (length, rest) = rest.split_first_chunk::<4>()?;
        rest.get(u32::from_le_bytes(*length) as usize..)
    }
    let rest = body.get(16..).and_then(skip_text).and_then(skip_text);
    let Some((length, rest)) = rest.and_then(|rest| rest.split_first_chunk::<8>()) else {
        return false;
    };
    rest.len() as u64 == u64::from_le_bytes(*length).saturating_add(4)
}

/// Channel, sequence number and payload of a message record.
fn message(data: &[u8]) -> Option<(u16, u32, &[u8])> {
    let (channel, rest) = data.split_first_chunk::<2>()?;
    let (sequence, rest) = rest.split_first_chunk::<4>()?;
    // Log time and publish time.
    let payload = rest.get(16..)?;
    Some((
        u16::from_le_bytes(*channel),
        u32::from_le_bytes(*sequence),
        payload,
    ))
}

/// Gives the reader more bytes of the source.
fn feed(
    mcap: &mut LinearReader,
    source: &mut impl Read,
    bytes: usize,
    path: &Path,
) -> Result<(), GoldenError> {
    let buffer = mcap.insert(bytes.clamp(1 << 16, 1 << 20));
    let read = source.read(buffer).map_err(|source| GoldenError::Io {
        path: path.into(),
        source,
    })?;
    mcap.notify_read(read);
    Ok(())
}

pub(super) fn container(path: &Path, reason: &str) -> GoldenError {
    GoldenError::Container {
        path: path.into(),
        reason: reason.into(),
    }
}

/// What the container reader says, in our words where they help.
pub(super) fn damaged(path: &Path, error: McapError) -> GoldenError {
    match error {
        McapError::UnexpectedEof => GoldenError::Truncated { path: path.into() },
        McapError::BadMagic => container(path, "it does not begin and end like an MCAP file"),
        error => container(path, &error.to_string()),
    }
}
