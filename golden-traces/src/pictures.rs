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

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek, Write};

use foxglove::Encode;
use foxglove::messages::{
    ArrowPrimitive, Color, CylinderPrimitive, FrameTransform, FrameTransforms, KeyValuePair,
    LinePrimitive, Log, Point3, Pose, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate,
    TextPrimitive, Timestamp, Vector3, line_primitive, log, scene_entity_deletion,
};
use mcap::records::MessageHeader;
use mcap::{McapError, McapResult};

use ac_client::frame::FrameStates;

use crate::GoldenError;
use crate::trace::{ChannelKind, TraceEvent, TraceReader};

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

fn stamp(time: u64) -> Option<Timestamp> {
    let seconds = u32::try_from(time / 1_000_000_000).ok()?;
    Some(Timestamp::new(seconds, (time % 1_000_000_000) as u32))
}

const fn color([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}

const fn point([x, y, z]: [f64; 3]) -> Point3 {
    Point3 { x, y, z }
}

const fn pose([x, y, z]: [f64; 3], [qw, qx, qy, qz]: [f64; 4]) -> Pose {
    Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w: qw,
        }),
    }
}

const IDENTITY: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
/// Turns +x, where arrows point, to +y, where objects look.
const TO_Y: [f64; 4] = [
    std::f64::consts::FRAC_1_SQRT_2,
    0.0,
    0.0,
    std::f64::consts::FRAC_1_SQRT_2,
];

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

fn transform(
    time: u64,
    parent: &str,
    child: &str,
    [x, y, z]: [f64; 3],
    [w, qx, qy, qz]: [f64; 4],
) -> FrameTransform {
    FrameTransform {
        timestamp: stamp(time),
        parent_frame_id: parent.into(),
        child_frame_id: child.into(),
        translation: Some(Vector3 { x, y, z }),
        rotation: Some(Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w,
        }),
    }
}

fn entity(time: u64, frame: &str, id: String) -> SceneEntity {
    SceneEntity {
        timestamp: stamp(time),
        frame_id: frame.into(),
        id,
        frame_locked: true,
        ..SceneEntity::default()
    }
}

/// A cylinder of a person's size, an arrow forward, and the label.
fn figure(time: u64, id: &str, look: &Look) -> SceneEntity {
    let frame = format!("object/{id}");
    let facts = look.facts.iter();
    SceneEntity {
        metadata: facts
            .map(|(key, value)| KeyValuePair {
                key: key.clone(),
                value: value.clone(),
            })
            .collect(),
        cylinders: vec![CylinderPrimitive {
            pose: Some(pose([0.0, 0.0, 0.9], IDENTITY)),
            size: Some(Vector3 {
                x: 0.6,
                y: 0.6,
                z: 1.8,
            }),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: Some(color(look.color)),
        }],
        arrows: vec![ArrowPrimitive {
            pose: Some(pose([0.0, 0.0, 1.2], TO_Y)),
            shaft_length: 0.7,
            shaft_diameter: 0.1,
            head_length: 0.3,
            head_diameter: 0.25,
            color: Some(color([1.0, 1.0, 1.0, look.color[3]])),
        }],
        texts: vec![TextPrimitive {
            pose: Some(pose([0.0, 0.0, 2.2], IDENTITY)),
            billboard: true,
            font_size: 14.0,
            scale_invariant: true,
            color: Some(color([1.0, 1.0, 1.0, 1.0])),
            text: look.label.clone(),
        }],
        ..entity(time, &frame, frame.clone())
    }
}

fn line(kind: line_primitive::Type, points: Vec<Point3>, colour: [f64; 4]) -> LinePrimitive {
    LinePrimitive {
        r#type: kind as i32,
        pose: Some(pose([0.0; 3], IDENTITY)),
        thickness: 2.0,
        scale_invariant: true,
        points,
        color: Some(color(colour)),
        ..LinePrimitive::default()
    }
}

fn path(time: u64, id: &str, look: &Look, points: &[[f64; 3]]) -> SceneEntity {
    let points = points.iter().map(|&p| point(p)).collect();
    let [r, g, b, _] = look.color;
    SceneEntity {
        lines: vec![line(
            line_primitive::Type::LineStrip,
            points,
            [r, g, b, 0.6],
        )],
        ..entity(time, ORIGIN, format!("path/{id}"))
    }
}

/// The border of a landblock, at the height where it was first entered.
fn border(time: u64, landblock: u32, [x, y, z]: [f64; 3]) -> SceneEntity {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let points = corners
        .map(|(u, v)| point([x + u * LANDBLOCK, y + v * LANDBLOCK, z]))
        .to_vec();
    SceneEntity {
        lines: vec![line(
            line_primitive::Type::LineLoop,
            points,
            [0.5, 0.5, 0.5, 0.6],
        )],
        ..entity(time, ORIGIN, format!("landblock/{landblock:04X}"))
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

/// Draws a trace: what was produced in blue, what is expected transparent in a colour for each oracle, inputs as log.
///
/// # Errors
/// The trace cannot be read, or the pictures cannot be written.
pub fn of_trace<R: Read, W: Write + Seek>(
    trace: &mut TraceReader<R>,
    out: W,
    library: &str,
    path: &std::path::Path,
) -> Result<PictureCounts, GoldenError> {
    let failed = |error: McapError| GoldenError::Io {
        path: path.into(),
        source: std::io::Error::other(error.to_string()),
    };
    let mut pictures = PictureWriter::new(out, library).map_err(failed)?;
    let scene = trace.scene().name.clone();
    pictures
        .log(0, Level::Info, "scene", scene)
        .map_err(failed)?;
    let (mut states, mut now) = (FrameStates::new(), 0);
    trace.select(|kind| !matches!(kind, ChannelKind::Stages(_) | ChannelKind::Clock));
    while let Some(event) = trace.next_event(&mut states)? {
        match event {
            TraceEvent::Script(step) => {
                let text = serde_json::to_string(&*step).unwrap_or_default();
                pictures.log(now, Level::Info, "script", text)
            }
            TraceEvent::States { kind, time, .. } => {
                now = (time.max(0.0) * 1e9) as u64;
                let (prefix, color) = style(kind);
                draw(&mut pictures, now, &prefix, color, &states)
            }
            TraceEvent::Clock(_) | TraceEvent::Stages { .. } => Ok(()),
        }
        .map_err(failed)?;
    }
    let (mut out, counts) = pictures.finish().map_err(failed)?;
    out.flush().map_err(|source| GoldenError::Io {
        path: path.into(),
        source,
    })?;
    Ok(counts)
}

/// Prefix of the ids, and colour.
fn style(kind: &ChannelKind) -> (String, [f64; 4]) {
    match kind {
        ChannelKind::Expect(oracle) => {
            let color = match oracle.as_str() {
                "ace" => [1.0, 0.6, 0.1, 0.4],
                "gdle" => [0.2, 0.8, 0.3, 0.4],
                _ => [0.8, 0.3, 0.8, 0.4],
            };
            (format!("{oracle}/"), color)
        }
        _ => (String::new(), [0.2, 0.5, 1.0, 1.0]),
    }
}

fn draw<W: Write + Seek>(
    pictures: &mut PictureWriter<W>,
    time: u64,
    prefix: &str,
    color: [f64; 4],
    states: &FrameStates,
) -> McapResult<()> {
    for state in states.iter() {
        let id = format!("{prefix}{:08X}", state.guid);
        if state.cell == 0 {
            pictures.remove(time, &id)?;
            continue;
        }
        let look = Look {
            label: id.clone(),
            color,
            facts: Vec::new(),
        };
        let place = Place {
            cell: state.cell,
            origin: state.origin,
            rotation: state.rotation,
        };
        pictures.place(time, &id, &look, &place)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
