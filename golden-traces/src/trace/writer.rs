//! Writes a trace, frame by frame.

use std::{
    collections::BTreeMap,
    io::{Seek, Write},
};

use ac_client::frame::FrameState;
use mcap::{McapResult, WriteOptions, records::MessageHeader};
use schemars::Schema;
use serde_json::value::RawValue;

use super::{ChannelHeader, ChannelKind, ClockRun, METADATA, SCENE_ATTACHMENT, TraceInfo};
use crate::{Scene, record, scene::ScriptStep};

/// How hard to compress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// For traces written once and read often: slow to write, one large chunk window.
    Archive,
    /// For traces written while something runs.
    #[default]
    Fast,
}

impl Compression {
    const fn level(self) -> u32 {
        match self {
            Self::Archive => 19,
            Self::Fast => 3,
        }
    }

    /// Bytes of messages per chunk. In an archive the oracles' frames of the same time compress against each other, and the
    /// frames against those before; a larger chunk means fewer fresh starts.
    const fn chunk_size(self) -> u64 {
        match self {
            Self::Archive => 8 << 20,
            Self::Fast => 1 << 20,
        }
    }
}

/// Writes one trace file.
///
/// Messages should be written in the order of their frames. Log times never go backwards: where the scene's clock does, the
/// last time is repeated (a message carries its exact time).
pub struct TraceWriter<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    channels: BTreeMap<ChannelKind, u16>,
    log_time: u64,
    buffer: Vec<u8>,
    /// The next run of frames and the next step of the script: inputs are written in the order of their frames.
    next_run: usize,
    next_run_frame: u32,
    next_step: usize,
}

impl<W: Write + Seek> TraceWriter<W> {
    /// Starts a file with its metadata and the text of its scene.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(
        out: W,
        info: &TraceInfo,
        scene_text: &[u8],
        compression: Compression,
    ) -> McapResult<Self> {
        let mut mcap = options(compression).create(out)?;
        let mut metadata: BTreeMap<String, String> = [
            ("format".into(), info.version.to_string()),
            ("scene".into(), info.scene.clone()),
            ("producer".into(), info.producer.clone()),
        ]
        .into();
        if !info.profile.is_empty() {
            metadata.insert("profile".into(), info.profile.clone());
        }
        metadata.extend(
            info.world
                .iter()
                .map(|(file, hash)| (format!("world/{file}"), hash.clone())),
        );
        mcap.write_metadata(&mcap::records::Metadata {
            name: METADATA.into(),
            metadata,
        })?;
        mcap.attach(&mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: SCENE_ATTACHMENT.into(),
            media_type: "application/json".into(),
            data: scene_text.into(),
        })?;
        Ok(Self {
            mcap,
            channels: BTreeMap::new(),
            log_time: 0,
            buffer: Vec::new(),
            next_run: 0,
            next_run_frame: 0,
            next_step: 0,
        })
    }

    /// Adds a channel. `header` goes into its metadata: who wrote what it holds.
    ///
    /// # Errors
    /// When writing fails.
    pub fn add_channel(
        &mut self,
        kind: ChannelKind,
        header: Option<&ChannelHeader>,
    ) -> McapResult<()> {
        let (name, schema): (&str, fn() -> Schema) = match &kind {
            ChannelKind::Clock => ("ac.Clock", record::schema::clock_message),
            ChannelKind::Script => ("ac.ScriptStep", record::schema::script_message),
            ChannelKind::States | ChannelKind::Expect(_) => {
                ("ac.FrameStates", record::schema::frame_message)
            }
            ChannelKind::Stages(_) => ("ac.StageRecords", record::schema::stages_message),
        };
        let schema = self.mcap.add_schema(
            name,
            "jsonschema",
            schema().as_value().to_string().as_bytes(),
        )?;
        let metadata = header.map(header_metadata).unwrap_or_default();
        let id = self
            .mcap
            .add_channel(schema, &kind.topic(), "json", &metadata)?;
        self.channels.insert(kind, id);
        Ok(())
    }

    /// Writes what the scene's clock and script have for a frame. To be called for each frame, in order.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_inputs(&mut self, scene: &Scene, frame: u32, time: f64) -> McapResult<()> {
        while let Some(run) = scene.frames.get(self.next_run)
            && self.next_run_frame <= frame
        {
            let (dt, count) = (run.dt, run.count);
            if count > 0 {
                self.clock(ClockRun { frame, dt, count }, time)?;
            }
            self.next_run += 1;
            self.next_run_frame = self.next_run_frame.saturating_add(count);
        }
        while let Some(step) = scene.script.get(self.next_step)
            && step.frame <= frame
        {
            self.script(step, time)?;
            self.next_step += 1;
        }
        Ok(())
    }

    /// Begins the file at a later frame: its inputs are those of `frame`, at `time`, and after. To be called before the first
    /// [`TraceWriter::write_inputs`]; log times are as if the frames before had been written.
    ///
    /// # Errors
    /// When writing fails.
    pub fn begin_at(&mut self, scene: &Scene, frame: u32, time: f64) -> McapResult<()> {
        let before = scene.times().take(frame as usize).map(nanoseconds);
        self.log_time = before.fold(nanoseconds(scene.start_time), u64::max);
        while let Some(run) = scene.frames.get(self.next_run)
            && self.next_run_frame < frame
        {
            let end = self.next_run_frame.saturating_add(run.count);
            if end > frame {
                let (dt, count) = (run.dt, end - frame);
                self.clock(ClockRun { frame, dt, count }, time)?;
            }
            self.next_run += 1;
            self.next_run_frame = end;
        }
        let steps = scene.script.iter();
        self.next_step = steps.take_while(|step| step.frame < frame).count();
        Ok(())
    }

    fn clock(&mut self, run: ClockRun, time: f64) -> McapResult<()> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, &run).map_err(std::io::Error::from)?;
        self.send(&ChannelKind::Clock, sequence(run.frame.into()), time)
    }

    fn script(&mut self, step: &ScriptStep, time: f64) -> McapResult<()> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, step).map_err(std::io::Error::from)?;
        self.send(&ChannelKind::Script, sequence(step.frame.into()), time)
    }

    /// Writes the records of one frame to a channel of states or expectations.
    ///
    /// # Errors
    /// When writing fails or the channel was not added.
    pub fn write_states(
        &mut self,
        kind: &ChannelKind,
        frame: i32,
        time: f64,
        states: &[FrameState],
    ) -> McapResult<()> {
        self.buffer.clear();
        record::write_message(&mut self.buffer, frame, time, states);
        self.send(kind, sequence(frame.into()), time)
    }

    /// Writes the stage checkpoints of one frame.
    ///
    /// # Errors
    /// When writing fails or the channel was not added.
    pub fn write_stages(
        &mut self,
        oracle: &str,
        frame: i32,
        time: f64,
        records: &[Box<RawValue>],
    ) -> McapResult<()> {
        self.buffer.clear();
        write!(self.buffer, "{{\"frame\":{frame},\"records\":[")?;
        for (index, record) in records.iter().enumerate() {
            if index > 0 {
                self.buffer.push(b',');
            }
            self.buffer.extend_from_slice(record.get().as_bytes());
        }
        self.buffer.extend_from_slice(b"]}");
        self.send(
            &ChannelKind::Stages(oracle.into()),
            sequence(frame.into()),
            time,
        )
    }

    /// Attaches bytes that belong to a time of the scene's clock, s. The messages before them end a chunk.
    ///
    /// # Errors
    /// When writing fails.
    pub fn attach(
        &mut self,
        name: &str,
        media_type: &str,
        time: f64,
        data: &[u8],
    ) -> McapResult<()> {
        self.log_time = self.log_time.max(nanoseconds(time));
        self.mcap.attach(&mcap::Attachment {
            log_time: self.log_time,
            create_time: self.log_time,
            name: name.into(),
            media_type: media_type.into(),
            data: data.into(),
        })
    }

    fn send(&mut self, kind: &ChannelKind, sequence: u32, time: f64) -> McapResult<()> {
        let channel_id = *self
            .channels
            .get(kind)
            .ok_or_else(|| mcap::McapError::UnknownSchema(kind.topic(), 0))?;
        self.log_time = self.log_time.max(nanoseconds(time));
        let header = MessageHeader {
            channel_id,
            sequence,
            log_time: self.log_time,
            publish_time: self.log_time,
        };
        self.mcap.write_to_known_channel(&header, &self.buffer)
    }

    /// Writes index and summary, and gives back what was written to.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(mut self) -> McapResult<W> {
        self.mcap.finish()?;
        Ok(self.mcap.into_inner())
    }
}

/// How every trace is written.
pub(super) fn options(compression: Compression) -> WriteOptions {
    WriteOptions::new()
        .profile("ac-trace")
        .library(concat!("ac-golden-traces ", env!("CARGO_PKG_VERSION")))
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(compression.level())
        // Worker threads would change how the data is cut, and with it the bytes.
        .compression_threads(0)
        .chunk_size(Some(compression.chunk_size()))
}

/// Who wrote a channel, as the metadata of the channel.
pub(super) fn header_metadata(header: &ChannelHeader) -> BTreeMap<String, String> {
    let notes = serde_json::Value::from(header.notes.clone()).to_string();
    [
        ("schema".into(), header.schema.clone()),
        ("oracle".into(), header.oracle.clone()),
        ("oracle_version".into(), header.oracle_version.to_string()),
        ("notes".into(), notes),
    ]
    .into()
}

/// Frame -1 has sequence 0.
pub(super) fn sequence(frame: i64) -> u32 {
    u32::try_from(frame + 1).unwrap_or(0)
}

/// Clock seconds as a log time. Negative and not-a-number become 0, the infinite future the largest time.
pub(super) fn nanoseconds(time: f64) -> u64 {
    (time * 1e9).round() as u64
}
