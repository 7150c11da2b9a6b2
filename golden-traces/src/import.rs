//! Makes a trace of a scene and the files that oracles wrote for it.

use std::{
    collections::BTreeMap,
    io::{Seek, Write},
    path::{Path, PathBuf},
};

use ac_client::frame::FrameState;
use serde_json::value::RawValue;

use crate::{
    GoldenError, Scene,
    expect::{ExpectReader, Header, StageReader},
    trace::{ChannelKind, Compression, FormatVersion, TraceInfo, TraceWriter},
};

/// What a trace is made of.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// The scene file.
    pub scene: PathBuf,
    /// Expected-state traces.
    pub expect: Vec<PathBuf>,
    /// Stage files.
    pub stages: Vec<PathBuf>,
    /// The folder of the scene's world, whose files are hashed; none: no hashes.
    pub world: Option<PathBuf>,
}

/// Writes a trace with all of `sources`, at the place `path` (for errors) in `out`.
///
/// Frames of all oracles are interleaved in time, so that they compress against each other.
///
/// # Errors
/// When a file cannot be read, belongs to another scene, or has records out of order.
pub fn import<W: Write + Seek>(sources: &Sources, out: W, path: &Path) -> Result<W, GoldenError> {
    let scene_text = read(&sources.scene)?;
    let scene = Scene::parse(&scene_text, &sources.scene)?;
    let mut expectations = sources
        .expect
        .iter()
        .map(|path| Expectation::open(path, &scene))
        .collect::<Result<Vec<_>, _>>()?;
    let mut stages = sources
        .stages
        .iter()
        .map(|path| Stages::open(path, &scene))
        .collect::<Result<Vec<_>, _>>()?;
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: scene.name.clone(),
        producer: concat!("ac-golden-traces ", env!("CARGO_PKG_VERSION")).into(),
        profile: String::new(),
        world: sources
            .world
            .as_deref()
            .map(hash_world)
            .transpose()?
            .unwrap_or_default(),
    };
    let failed = |error: mcap::McapError| GoldenError::Container {
        path: path.into(),
        reason: error.to_string(),
    };
    let mut writer =
        TraceWriter::new(out, &info, &scene_text, Compression::Archive).map_err(failed)?;
    writer
        .add_channel(ChannelKind::Clock, None)
        .map_err(failed)?;
    writer
        .add_channel(ChannelKind::Script, None)
        .map_err(failed)?;
    for expectation in &expectations {
        writer
            .add_channel(expectation.kind.clone(), Some(&expectation.reader.header))
            .map_err(failed)?;
    }
    for stage in &stages {
        writer
            .add_channel(stage.kind.clone(), Some(&stage.reader.header))
            .map_err(failed)?;
    }
    let times = std::iter::once(scene.start_time).chain(scene.times());
    for (frame, time) in (-1i32..).zip(times) {
        if let Ok(frame) = u32::try_from(frame) {
            writer.write_inputs(&scene, frame, time).map_err(failed)?;
        }
        for expectation in &mut expectations {
            let count = expectation.fill(frame)?;
            if count > 0 {
                let states = &expectation.states[..count];
                writer
                    .write_states(&expectation.kind, frame, states[0].time, states)
                    .map_err(failed)?;
            }
        }
        for stage in &mut stages {
            stage.fill(frame)?;
            if !stage.records.is_empty() {
                writer
                    .write_stages(&stage.reader.header.oracle, frame, time, &stage.records)
                    .map_err(failed)?;
            }
        }
    }
    expectations.iter().try_for_each(Expectation::check_empty)?;
    stages.iter().try_for_each(Stages::check_empty)?;
    writer.finish().map_err(failed)
}

fn read(path: &Path) -> Result<Vec<u8>, GoldenError> {
    std::fs::read(path).map_err(|source| GoldenError::Io {
        path: path.into(),
        source,
    })
}

/// BLAKE3 of each dat file of a world folder, by file name.
///
/// # Errors
/// When the folder or a file cannot be read.
pub fn hash_world(folder: &Path) -> Result<BTreeMap<String, String>, GoldenError> {
    let mut hashes = BTreeMap::new();
    for file in ["client_cell_1.dat", "client_portal.dat"] {
        hashes.insert(
            file.to_owned(),
            blake3::hash(&read(&folder.join(file))?)
                .to_hex()
                .to_string(),
        );
    }
    Ok(hashes)
}

fn check_scene(path: &Path, header: &Header, scene: &Scene) -> Result<(), GoldenError> {
    if header.scene == scene.name {
        return Ok(());
    }
    let reason = format!("is of scene `{}`, not of `{}`", header.scene, scene.name);
    Err(GoldenError::Line {
        path: path.into(),
        line: 1,
        reason,
    })
}

fn stray(path: &Path, frame: i32) -> GoldenError {
    GoldenError::Container {
        path: path.into(),
        reason: format!("a record of frame {frame} is out of order or beyond the scene"),
    }
}

/// An expected-state trace, one frame at a time.
struct Expectation {
    path: PathBuf,
    kind: ChannelKind,
    reader: ExpectReader,
    /// Records of the current frame, in front; their memory is reused.
    states: Vec<FrameState>,
    /// The record after those.
    next: Option<FrameState>,
}

impl Expectation {
    fn open(path: &Path, scene: &Scene) -> Result<Self, GoldenError> {
        let mut reader = ExpectReader::open(path)?;
        check_scene(path, &reader.header, scene)?;
        let mut next = FrameState::default();
        let next = reader.next_into(&mut next)?.then_some(next);
        let kind = ChannelKind::Expect(reader.header.oracle.clone());
        Ok(Self {
            path: path.into(),
            kind,
            reader,
            states: Vec::new(),
            next,
        })
    }

    /// Collects the records of a frame; their number.
    fn fill(&mut self, frame: i32) -> Result<usize, GoldenError> {
        let mut count = 0;
        while let Some(next) = &mut self.next {
            if next.frame != frame {
                break;
            }
            if count == self.states.len() {
                self.states.push(FrameState::default());
            }
            std::mem::swap(&mut self.states[count], next);
            if self.states[0].time.to_bits() != self.states[count].time.to_bits() {
                let reason = format!("the records of frame {frame} have different times");
                return Err(GoldenError::Container {
                    path: self.path.clone(),
                    reason,
                });
            }
            count += 1;
            if !self.reader.next_into(next)? {
                self.next = None;
            }
        }
        Ok(count)
    }

    fn check_empty(&self) -> Result<(), GoldenError> {
        self.next
            .as_ref()
            .map_or(Ok(()), |next| Err(stray(&self.path, next.frame)))
    }
}

/// A stage file, one frame at a time.
struct Stages {
    path: PathBuf,
    kind: ChannelKind,
    reader: StageReader,
    records: Vec<Box<RawValue>>,
    next: Option<(i32, Box<RawValue>)>,
}

impl Stages {
    fn open(path: &Path, scene: &Scene) -> Result<Self, GoldenError> {
        let reader = StageReader::open(path)?;
        check_scene(path, &reader.header, scene)?;
        let kind = ChannelKind::Stages(reader.header.oracle.clone());
        let mut stages = Self {
            path: path.into(),
            kind,
            reader,
            records: Vec::new(),
            next: None,
        };
        stages.advance()?;
        Ok(stages)
    }

    fn advance(&mut self) -> Result<(), GoldenError> {
        self.next = self
            .reader
            .next_record()?
            .map(|(head, text)| (head.frame, text.to_owned()));
        Ok(())
    }

    fn fill(&mut self, frame: i32) -> Result<(), GoldenError> {
        self.records.clear();
        while self.next.as_ref().is_some_and(|(of, _)| *of == frame) {
            self.records.extend(self.next.take().map(|(_, text)| text));
            self.advance()?;
        }
        Ok(())
    }

    fn check_empty(&self) -> Result<(), GoldenError> {
        self.next
            .as_ref()
            .map_or(Ok(()), |(frame, _)| Err(stray(&self.path, *frame)))
    }
}
