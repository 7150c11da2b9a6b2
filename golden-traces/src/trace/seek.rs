//! Reads parts of a trace by its index, without reading what lies before.
//!
//! A trace ends with an index: where its chunks are and which times they cover, and where its attachments are. A [`SeekableTrace`] reads that
//! and the head of the file; a frame then costs the chunk that holds it, an attachment its own bytes, whatever the length of the file.

use std::{
    collections::BTreeSet,
    fs::File,
    io::{Read, Seek, SeekFrom},
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

use ac_client::frame::FrameStates;
use mcap::{
    McapError, Summary,
    records::{AttachmentIndex, Record, op},
    sans_io::{
        indexed_reader::{IndexedReadEvent, IndexedReader, IndexedReaderOptions},
        summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions},
    },
};

use super::{
    ChannelKind, TraceInfo, TraceReader,
    reader::{MAX_RECORD, container, damaged, is_whole_attachment},
    writer::nanoseconds,
};
use crate::{
    GoldenError, Scene,
    record::{self, Unknown},
};

/// Opcode and length in front of a record.
const RECORD_HEAD: u64 = 9;

/// A trace that is read by its index.
pub struct SeekableTrace<R> {
    path: PathBuf,
    source: R,
    summary: Summary,
    info: TraceInfo,
    scene: Scene,
    scene_text: Vec<u8>,
    unknown: Unknown,
}

impl SeekableTrace<File> {
    /// Opens a file and reads its head and its index.
    ///
    /// # Errors
    /// When it cannot be read, is no trace, is of a version that this program does not read, or has no index.
    pub fn open(path: &Path) -> Result<Self, GoldenError> {
        let file = File::open(path).map_err(|source| GoldenError::Io {
            path: path.into(),
            source,
        })?;
        Self::new(file, path)
    }
}

impl<R: Read + Seek> SeekableTrace<R> {
    /// As [`SeekableTrace::open`]; `path` is what errors call the source.
    ///
    /// # Errors
    /// As [`SeekableTrace::open`].
    pub fn new(mut source: R, path: &Path) -> Result<Self, GoldenError> {
        let head = TraceReader::new(&mut source, path)?;
        let (info, scene) = (head.info().clone(), head.scene().clone());
        let (scene_text, unknown) = (head.scene_text().to_vec(), head.unknown());
        let summary = read_summary(&mut source, path)?;
        Ok(Self {
            path: path.into(),
            source,
            summary,
            info,
            scene,
            scene_text,
            unknown,
        })
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

    /// The file's name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the file's channels hold; topics of other programs are left out.
    pub fn channels(&self) -> BTreeSet<ChannelKind> {
        let channels = self.summary.channels.values();
        channels
            .filter_map(|channel| ChannelKind::of(&channel.topic))
            .collect()
    }

    /// Names of the attachments, in the order of the file.
    pub fn attachments(&self) -> impl Iterator<Item = &str> {
        let indexes = self.summary.attachment_indexes.iter();
        indexes.map(|index| index.name.as_str())
    }

    /// The bytes of the last attachment of a name; `None` if there is none.
    ///
    /// # Errors
    /// When it cannot be read or is damaged.
    pub fn attachment(&mut self, name: &str) -> Result<Option<Vec<u8>>, GoldenError> {
        let mut indexes = self.summary.attachment_indexes.iter().rev();
        let Some(index) = indexes.find(|index| index.name == name).cloned() else {
            return Ok(None);
        };
        let record = self.record(&index)?;
        let whole = record
            .get(RECORD_HEAD as usize..)
            .filter(|body| record[0] == op::ATTACHMENT && is_whole_attachment(body));
        let Some(body) = whole else {
            return Err(self.bad_index(&format!("attachment `{name}`")));
        };
        match mcap::parse_record(op::ATTACHMENT, body) {
            Ok(Record::Attachment { data, .. }) => Ok(Some(data.into_owned())),
            Ok(_) => Err(self.bad_index(&format!("attachment `{name}`"))),
            Err(error) => Err(damaged(&self.path, error)),
        }
    }

    fn record(&mut self, index: &AttachmentIndex) -> Result<Vec<u8>, GoldenError> {
        let length = usize::try_from(index.length).unwrap_or(usize::MAX);
        if !(RECORD_HEAD as usize..=MAX_RECORD).contains(&length) {
            return Err(self.bad_index(&format!("attachment `{}`", index.name)));
        }
        self.read_at(index.offset, length)
    }

    /// Bytes of the file. No more memory is taken than the file has bytes.
    fn read_at(&mut self, offset: u64, length: usize) -> Result<Vec<u8>, GoldenError> {
        let mut bytes = Vec::new();
        self.source
            .seek(SeekFrom::Start(offset))
            .and_then(|_| {
                let mut part = (&mut self.source).take(length as u64);
                part.read_to_end(&mut bytes)
            })
            .map_err(|source| GoldenError::Io {
                path: self.path.clone(),
                source,
            })?;
        if bytes.len() < length {
            return Err(damaged(&self.path, McapError::UnexpectedEof));
        }
        Ok(bytes)
    }

    fn bad_index(&self, what: &str) -> GoldenError {
        container(&self.path, &format!("its index names no whole {what}"))
    }

    /// Calls `each` with the states of frames of a channel, in order: `(frame, time in s, records)`. Only the chunks that hold those frames are
    /// read. A frame that the channel does not have is left out.
    ///
    /// # Errors
    /// When the file cannot be read or is damaged.
    pub fn states(
        &mut self,
        kind: &ChannelKind,
        frames: RangeInclusive<i32>,
        mut each: impl FnMut(i32, f64, &FrameStates),
    ) -> Result<(), GoldenError> {
        let (first, last) = (
            log_time(&self.scene, *frames.start()),
            log_time(&self.scene, *frames.end()),
        );
        let options = IndexedReaderOptions {
            record_length_limit: Some(MAX_RECORD),
            ..IndexedReaderOptions::default()
        }
        .include_topics([kind.topic()])
        .starting_at(first)
        .ending_at(last.max(first));
        let mut reader = IndexedReader::new_with_options(&self.summary, options)
            .map_err(|error| damaged(&self.path, error))?;
        let mut states = FrameStates::new();
        let topic = kind.topic();
        while let Some(event) = reader.next_event() {
            match event.map_err(|error| damaged(&self.path, error))? {
                IndexedReadEvent::ReadChunkRequest { offset, length } => {
                    let chunk = self.read_at(offset, length)?;
                    reader
                        .insert_chunk_record_data(offset, &chunk)
                        .map_err(|error| damaged(&self.path, error))?;
                }
                IndexedReadEvent::Message { header, data } => {
                    let channel = self.summary.channels.get(&header.channel_id);
                    if channel.is_none_or(|channel| channel.topic != topic) {
                        continue;
                    }
                    let (frame, time) = record::read_message(data, self.unknown, &mut states)
                        .map_err(|error| GoldenError::Message {
                            path: self.path.clone(),
                            topic: topic.clone(),
                            sequence: header.sequence,
                            error,
                        })?;
                    if frames.contains(&frame) {
                        each(frame, time, &states);
                    }
                }
            }
        }
        Ok(())
    }
}

/// The log time that a writer gives to a frame: the scene's clock, which in a log never goes backwards.
fn log_time(scene: &Scene, frame: i32) -> u64 {
    let frames = usize::try_from(i64::from(frame) + 1).unwrap_or(0);
    let times = scene.times().take(frames).map(nanoseconds);
    times.fold(nanoseconds(scene.start_time), u64::max)
}

fn read_summary(source: &mut (impl Read + Seek), path: &Path) -> Result<Summary, GoldenError> {
    let io = |source| GoldenError::Io {
        path: path.into(),
        source,
    };
    let size = source.seek(SeekFrom::End(0)).map_err(io)?;
    source.rewind().map_err(io)?;
    let options = SummaryReaderOptions::default()
        .with_file_size(size)
        .with_record_length_limit(MAX_RECORD);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| damaged(path, error))? {
            SummaryReadEvent::ReadRequest(bytes) => {
                let read = source.read(reader.insert(bytes)).map_err(io)?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => {
                reader.notify_seeked(source.seek(to).map_err(io)?);
            }
        }
    }
    reader.finish().ok_or_else(|| {
        container(
            path,
            "it has no index, so that only reading from its start is possible",
        )
    })
}
