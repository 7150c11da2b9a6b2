//! Pictures of what happens, for viewers such as Foxglove and Rerun: MCAP files with channels of well-known schemas.
//!
//! | topic | schema (protobuf) | content |
//! |---|---|---|
//! | `/scene` | `foxglove.SceneUpdate` | objects, the paths they took, borders of landblocks |
//! | `/tf` | `foxglove.FrameTransforms` | where objects are: frame `object/ID` in `origin`, and `origin` in `world` |
//! | `/log` | `foxglove.Log` | what happened |
//!
//! Distances are metres, z is up, x east, y north. `world` has its origin at the south-west corner of the map; `origin` is the south-west
//! corner of the landblock in which the first object appeared, so that a viewer starts near the action. An object is drawn as a cylinder
//! of a person's size with an arrow where it looks (its own +y).
//!
//! `docs/foxglove.md` says how to look at them.

mod shapes;
mod trace;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Seek, Write};

use foxglove::Encode;
use foxglove::messages::{
    FrameTransforms, Log, SceneEntity, SceneEntityDeletion, SceneUpdate, log, scene_entity_deletion,
};
use mcap::records::MessageHeader;
use mcap::{McapError, McapResult};

pub use trace::of_trace;

use shapes::{IDENTITY, border, figure, path, stamp, transform};

/// Side of a landblock, m.
const LANDBLOCK: f64 = 192.0;
/// Points of a path that stay visible.
const PATH: usize = 256;
/// A path gets a point when the object has moved so far, m.
const STEP: f64 = 0.25;
/// A longer move is no path: the object was somewhere else.
const JUMP: f64 = 96.0;
const WORLD: &str = "world";
const ORIGIN: &str = "origin";

/// A place: cell, landblock-local origin (m), rotation `[w, x, y, z]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Cell id.
    pub cell: u32,
    /// Landblock-local position, m.
    pub origin: [f32; 3],
    /// Orientation `[w, x, y, z]`.
    pub rotation: [f32; 4],
}

/// How an object is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Text above it.
    pub label: String,
    /// Red, green, blue, opacity; 0 to 1.
    pub color: [f64; 4],
    /// Further facts, shown when it is selected.
    pub facts: Vec<(String, String)>,
}

/// How serious a line of the log is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Of no interest most of the time.
    Debug,
    /// Something happened.
    Info,
    /// Something is odd.
    Warning,
}

/// What was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PictureCounts {
    /// Different objects.
    pub objects: usize,
    /// Places of objects.
    pub places: usize,
    /// Lines of the log.
    pub lines: usize,
}

struct Object {
    look: Look,
    visible: bool,
    path: Vec<[f64; 3]>,
}

/// Writes pictures.
pub struct PictureWriter<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    scene: u16,
    transforms: u16,
    log: u16,
    base: Option<[f64; 2]>,
    objects: BTreeMap<String, Object>,
    landblocks: BTreeSet<u32>,
    counts: PictureCounts,
    buffer: Vec<u8>,
}

fn add_channel<T: Encode, W: Write + Seek>(
    mcap: &mut mcap::Writer<W>,
    topic: &str,
) -> McapResult<u16> {
    let schema = match T::get_schema() {
        Some(schema) => mcap.add_schema(&schema.name, &schema.encoding, &schema.data)?,
        None => 0,
    };
    mcap.add_channel(schema, topic, &T::get_message_encoding(), &BTreeMap::new())
}

impl Place {
    /// South-west corner of the landblock in the world, m.
    fn corner(&self) -> [f64; 2] {
        [
            f64::from(self.cell >> 24) * LANDBLOCK,
            f64::from(self.cell >> 16 & 0xFF) * LANDBLOCK,
        ]
    }

    fn is_finite(&self) -> bool {
        self.origin
            .iter()
            .chain(&self.rotation)
            .all(|v| v.is_finite())
    }
}

impl<W: Write + Seek> PictureWriter<W> {
    /// Starts a file. `library` names the program that writes it.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(out: W, library: &str) -> McapResult<Self> {
        let mut mcap = mcap::WriteOptions::new()
            .library(library)
            .compression_threads(0)
            .create(out)?;
        let scene = add_channel::<SceneUpdate, W>(&mut mcap, "/scene")?;
        let transforms = add_channel::<FrameTransforms, W>(&mut mcap, "/tf")?;
        let log = add_channel::<Log, W>(&mut mcap, "/log")?;
        Ok(Self {
            mcap,
            scene,
            transforms,
            log,
            base: None,
            objects: BTreeMap::new(),
            landblocks: BTreeSet::new(),
            counts: PictureCounts::default(),
            buffer: Vec::new(),
        })
    }

    fn write(&mut self, channel_id: u16, time: u64, message: &impl Encode) -> McapResult<()> {
        self.buffer.clear();
        message
            .encode(&mut self.buffer)
            .map_err(|e| McapError::from(std::io::Error::other(e.to_string())))?;
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: time,
            publish_time: time,
        };
        self.mcap.write_to_known_channel(&header, &self.buffer)
    }

    /// An object is somewhere at `time`, ns. Places that are not finite are left out.
    ///
    /// # Errors
    /// When writing fails.
    pub fn place(&mut self, time: u64, id: &str, look: &Look, place: &Place) -> McapResult<()> {
        if !place.is_finite() || place.cell == 0 {
            return Ok(());
        }
        let corner = place.corner();
        let base = match self.base {
            Some(base) => base,
            None => self.start(time, corner)?,
        };
        let at = [
            corner[0] - base[0] + f64::from(place.origin[0]),
            corner[1] - base[1] + f64::from(place.origin[1]),
            f64::from(place.origin[2]),
        ];
        self.counts.places += 1;
        let transform = transform(
            time,
            ORIGIN,
            &format!("object/{id}"),
            at,
            place.rotation.map(f64::from),
        );
        let transforms = FrameTransforms {
            transforms: vec![transform],
        };
        self.write(self.transforms, time, &transforms)?;
        let mut entities = Vec::new();
        if !self.objects.contains_key(id) {
            self.counts.objects += 1;
        }
        let object = self.objects.entry(id.to_owned()).or_insert_with(|| Object {
            look: look.clone(),
            visible: false,
            path: Vec::new(),
        });
        if !object.visible || object.look != *look {
            object.visible = true;
            object.look = look.clone();
            entities.push(figure(time, id, look));
        }
        if object.extend(at) {
            entities.push(path(time, id, look, &object.path));
        }
        if place.cell & 0xFFFF < 0x100 && self.landblocks.insert(place.cell >> 16) {
            let corner = [corner[0] - base[0], corner[1] - base[1], at[2]];
            entities.push(border(time, place.cell >> 16, corner));
        }
        self.update(time, entities, Vec::new())
    }

    /// The first place decides where `origin` is.
    fn start(&mut self, time: u64, corner: [f64; 2]) -> McapResult<[f64; 2]> {
        self.base = Some(corner);
        let at = [corner[0], corner[1], 0.0];
        let transforms = FrameTransforms {
            transforms: vec![transform(time, WORLD, ORIGIN, at, IDENTITY)],
        };
        self.write(self.transforms, time, &transforms)?;
        Ok(corner)
    }

    fn update(
        &mut self,
        time: u64,
        entities: Vec<SceneEntity>,
        deletions: Vec<SceneEntityDeletion>,
    ) -> McapResult<()> {
        if entities.is_empty() && deletions.is_empty() {
            return Ok(());
        }
        let update = SceneUpdate {
            deletions,
            entities,
        };
        self.write(self.scene, time, &update)
    }

    /// An object is gone at `time`, ns, and its path with it.
    ///
    /// # Errors
    /// When writing fails.
    pub fn remove(&mut self, time: u64, id: &str) -> McapResult<()> {
        let Some(object) = self.objects.get_mut(id).filter(|o| o.visible) else {
            return Ok(());
        };
        object.visible = false;
        object.path.clear();
        let deletion = |id| SceneEntityDeletion {
            timestamp: stamp(time),
            r#type: scene_entity_deletion::Type::MatchingId as i32,
            id,
        };
        let deletions = vec![
            deletion(format!("object/{id}")),
            deletion(format!("path/{id}")),
        ];
        self.update(time, Vec::new(), deletions)
    }

    /// Something happened at `time`, ns, to somebody.
    ///
    /// # Errors
    /// When writing fails.
    pub fn log(&mut self, time: u64, level: Level, name: &str, message: String) -> McapResult<()> {
        self.counts.lines += 1;
        let level = match level {
            Level::Debug => log::Level::Debug,
            Level::Info => log::Level::Info,
            Level::Warning => log::Level::Warning,
        };
        let line = Log {
            timestamp: stamp(time),
            level: level as i32,
            message,
            name: name.to_owned(),
            file: String::new(),
            line: 0,
        };
        self.write(self.log, time, &line)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(mut self) -> McapResult<(W, PictureCounts)> {
        self.mcap.finish()?;
        Ok((self.mcap.into_inner(), self.counts))
    }
}

impl Object {
    /// Adds a point to the path when the object has moved far enough. Says whether the path is to be drawn again.
    fn extend(&mut self, at: [f64; 3]) -> bool {
        let moved = self.path.last().map(|last| {
            let square: f64 = last.iter().zip(at).map(|(a, b)| (a - b) * (a - b)).sum();
            square.sqrt()
        });
        match moved {
            Some(moved) if moved < STEP => return false,
            Some(moved) if moved > JUMP => self.path.clear(),
            _ => {}
        }
        if self.path.len() >= PATH {
            self.path.remove(0);
        }
        self.path.push(at);
        self.path.len() > 1
    }
}

#[cfg(test)]
mod tests;
