//! Writing a recording, or one part of it.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::records::{MessageHeader, Metadata};

use super::index::INDEX_SCHEMA;
use super::{
    COUNTERS_METADATA, COUNTERS_TOPIC, ENCODING, INDEX_TOPIC, IndexEntry, METADATA, Stream, VERSION,
};
use crate::counters::Counts;
use crate::decode::{Decoder, RecordedMessage};
use crate::error::RecordError;
use crate::secrets::{Guard, SecretPolicy, SharedSecrets};

/// Bytes after which a chunk is closed.
const CHUNK: usize = 1 << 20;

/// How a recording is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WriterOptions {
    /// What is done with secrets.
    pub secrets: SecretPolicy,
    /// Whether chunks are compressed (zstd, level 1).
    pub compress: bool,
}

impl Default for WriterOptions {
    fn default() -> Self {
        Self {
            secrets: SecretPolicy::default(),
            compress: true,
        }
    }
}

/// Which file of a recording in several files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartInfo {
    /// From 1.
    pub number: u32,
}

/// What goes on from one part of a recording to the next: what is known of secrets and of messages that are not complete, and counting.
pub struct Continuation {
    secrets: SharedSecrets,
    guards: BTreeMap<u32, Guard>,
    decoder: Decoder,
    number: u32,
    last_time: u64,
    redacted: usize,
    buffer: Vec<u8>,
    messages: Vec<RecordedMessage>,
}

impl Continuation {
    /// The start of a recording. Secrets that its logins show are added to `secrets`.
    pub fn new(secrets: SharedSecrets) -> Self {
        Self {
            secrets,
            guards: BTreeMap::new(),
            decoder: Decoder::new(),
            number: 0,
            last_time: 0,
            redacted: 0,
            buffer: Vec::new(),
            messages: Vec::new(),
        }
    }

    /// Forgets what is known of a client that will not come back. Its secrets stay known.
    pub fn forget(&mut self, client: u32) {
        self.guards.remove(&client);
        self.decoder.forget(client);
    }

    /// Sets the number of the next datagram: the numbers of datagrams that are not recorded are missing.
    pub const fn set_number(&mut self, number: u32) {
        self.number = number;
    }
}

/// Writes a recording. Unless it was told to keep secrets, there is no way to write a datagram that was not redacted.
///
/// Datagrams are collected in memory until [`flush`](Self::flush) or until there are enough for a chunk.
pub struct RecordingWriter<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    options: WriterOptions,
    channels: BTreeMap<Stream, u16>,
    index: u16,
    counters: u16,
    state: Continuation,
    /// Datagrams and bytes that are not in `W` yet.
    waiting: (u32, usize),
}

impl<W: Write + Seek> RecordingWriter<W> {
    /// Starts a recording with the default options.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(out: W) -> Result<Self, RecordError> {
        let start = Continuation::new(SharedSecrets::default());
        Self::part(out, WriterOptions::default(), PartInfo { number: 1 }, start)
            .map_err(|failed| failed.0)
    }

    /// Starts a part of a recording.
    ///
    /// # Errors
    /// When writing fails; what goes on is handed back.
    pub fn part(
        out: W,
        options: WriterOptions,
        part: PartInfo,
        state: Continuation,
    ) -> Result<Self, Box<(RecordError, Continuation)>> {
        match start(out, options, part, state.number) {
            Ok((mcap, index, counters)) => Ok(Self {
                mcap,
                options,
                channels: BTreeMap::new(),
                index,
                counters,
                state,
                waiting: (0, 0),
            }),
            Err(error) => Err(Box::new((error, state))),
        }
    }

    /// Redacts and writes a datagram of which only the arrival is known.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(&mut self, stream: Stream, time: u64, datagram: &[u8]) -> Result<(), RecordError> {
        self.write_forwarded(stream, time, None, datagram)
    }

    /// Redacts and writes a datagram. Times never go backwards: an earlier one is written as the last.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_forwarded(
        &mut self,
        stream: Stream,
        time: u64,
        forwarded: Option<u64>,
        datagram: &[u8],
    ) -> Result<(), RecordError> {
        let channel_id = self.channel(stream)?;
        let state = &mut self.state;
        let guard = state
            .guards
            .entry(stream.client)
            .or_insert_with(|| Guard::new(self.options.secrets, state.secrets.clone()));
        state.redacted += guard.clean(stream.to_server, datagram, &mut state.buffer);
        state.last_time = state.last_time.max(time);
        let header = MessageHeader {
            channel_id,
            sequence: state.number,
            log_time: state.last_time,
            publish_time: forwarded.unwrap_or_default(),
        };
        self.mcap.write_to_known_channel(&header, &state.buffer)?;
        state.messages.clear();
        state.decoder.take_bytes(
            stream,
            state.number,
            state.last_time,
            &state.buffer,
            &mut state.messages,
        );
        state.number = state.number.wrapping_add(1);
        self.waiting.0 += 1;
        self.waiting.1 += datagram.len() + 40;
        self.write_index()?;
        if self.waiting.1 >= CHUNK {
            self.flush()?;
        }
        Ok(())
    }

    fn channel(&mut self, stream: Stream) -> Result<u16, RecordError> {
        if let Some(&id) = self.channels.get(&stream) {
            return Ok(id);
        }
        let id = self
            .mcap
            .add_channel(0, &stream.topic(), ENCODING, &BTreeMap::new())?;
        self.channels.insert(stream, id);
        Ok(id)
    }

    fn write_index(&mut self) -> Result<(), RecordError> {
        for message in &self.state.messages {
            let header = MessageHeader {
                channel_id: self.index,
                sequence: 0,
                log_time: message.time,
                publish_time: message.time,
            };
            // Cannot fail: a struct of numbers and texts.
            let json = serde_json::to_vec(&IndexEntry::of(message)).unwrap_or_default();
            self.waiting.1 += json.len() + 40;
            self.mcap.write_to_known_channel(&header, &json)?;
        }
        Ok(())
    }

    /// Writes the counters of a proxy.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_counts(&mut self, time: u64, counts: &Counts) -> Result<(), RecordError> {
        self.state.last_time = self.state.last_time.max(time);
        let header = MessageHeader {
            channel_id: self.counters,
            sequence: 0,
            log_time: self.state.last_time,
            publish_time: self.state.last_time,
        };
        let json = serde_json::to_vec(counts).unwrap_or_default();
        self.waiting.1 += json.len() + 40;
        Ok(self.mcap.write_to_known_channel(&header, &json)?)
    }

    /// Puts everything written so far where a crash leaves it readable.
    ///
    /// # Errors
    /// When writing fails.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        self.mcap.flush()?;
        self.waiting = (0, 0);
        Ok(())
    }

    /// Datagrams that the last [`flush`](Self::flush) did not put away.
    pub const fn waiting(&self) -> u32 {
        self.waiting.0
    }

    /// Number of the next datagram, and secret bytes overwritten so far, in all parts.
    pub const fn totals(&self) -> (u32, usize) {
        (self.state.number, self.state.redacted)
    }

    /// What goes on in the next part; for what must be changed in between.
    pub const fn continuation(&mut self) -> &mut Continuation {
        &mut self.state
    }

    /// Ends the file.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(self) -> Result<W, RecordError> {
        let (out, _, result) = self.finish_part(None);
        result.map(|()| out)
    }

    /// Ends the part. What goes on and the output come back in any case.
    pub fn finish_part(
        mut self,
        counts: Option<&Counts>,
    ) -> (W, Continuation, Result<(), RecordError>) {
        let result = self.end(counts);
        (self.mcap.into_inner(), self.state, result)
    }

    fn end(&mut self, counts: Option<&Counts>) -> Result<(), RecordError> {
        if let Some(counts) = counts {
            let metadata = counts
                .iter()
                .map(|(name, value)| (name.to_owned(), value.to_string()))
                .collect();
            self.mcap.write_metadata(&Metadata {
                name: COUNTERS_METADATA.into(),
                metadata,
            })?;
        }
        self.mcap.finish()?;
        self.waiting = (0, 0);
        Ok(())
    }

    /// Gives up the part without ending the file.
    pub fn abandon(self) -> (W, Continuation) {
        (self.mcap.into_inner(), self.state)
    }
}

/// Header, metadata and the channels that are always there, put where a crash leaves them.
fn start<W: Write + Seek>(
    out: W,
    options: WriterOptions,
    part: PartInfo,
    first: u32,
) -> Result<(mcap::Writer<W>, u16, u16), RecordError> {
    let mut mcap = mcap::WriteOptions::new()
        .profile(METADATA)
        .library(concat!("ac-recorder ", env!("CARGO_PKG_VERSION")))
        .compression(options.compress.then_some(mcap::Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
        // A chunk is written in one piece, and only when this program says so: then it is known what is on the disk.
        .disable_seeking(true)
        .chunk_size(None)
        .create(out)?;
    let entries = [
        ("format", VERSION.to_owned()),
        (
            "producer",
            concat!("ac-record ", env!("CARGO_PKG_VERSION")).to_owned(),
        ),
        ("secrets", options.secrets.word().to_owned()),
        ("part", part.number.to_string()),
        ("first_datagram", first.to_string()),
    ];
    mcap.write_metadata(&Metadata {
        name: METADATA.into(),
        metadata: entries.map(|(k, v)| (k.to_owned(), v)).into(),
    })?;
    let schema = mcap.add_schema("ac.MessageIndex", "jsonschema", INDEX_SCHEMA.as_bytes())?;
    let index = mcap.add_channel(schema, INDEX_TOPIC, "json", &BTreeMap::new())?;
    let schema = mcap.add_schema("ac.Counters", "jsonschema", br#"{"type":"object"}"#)?;
    let counters = mcap.add_channel(schema, COUNTERS_TOPIC, "json", &BTreeMap::new())?;
    mcap.flush()?;
    Ok((mcap, index, counters))
}
