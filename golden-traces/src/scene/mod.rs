//! Scenes: a world, the entities in it, frame times and a script of inputs (`spec/scene-format.md`, "Scene file").
//!
//! Reading is strict: a field that the format does not have is an error that names the file and the place, because a
//! misspelt field with a default would silently change what the scene means.

mod step;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::{GoldenError, number};

pub use step::{Action, HoldKey, MoveParams, ScriptStep};

/// The schema this version reads.
pub const SCENE_SCHEMA: &str = "ac-scene/1";

/// A scene with more frames than this is refused: running it would take days.
const MAX_FRAMES: u64 = 100_000_000;

/// A scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// `ac-scene/1`.
    pub schema: String,
    /// Path-like unique name, e.g. `terrain/walk-slope-east`.
    pub name: String,
    /// What this scene exercises, in one sentence.
    pub summary: String,
    /// Folder name of the world.
    pub world: String,
    /// Tags.
    #[serde(default)]
    pub features: Vec<String>,
    /// Seconds on the clock before the first frame.
    pub start_time: f64,
    /// Runs of frames.
    pub frames: Vec<FrameRun>,
    /// Entities created before frame 0, in order.
    #[serde(default)]
    pub entities: Vec<EntitySpec>,
    /// Inputs, sorted by frame.
    #[serde(default)]
    pub script: Vec<ScriptStep>,
    /// Entities to record, in the order of the records of a frame.
    #[serde(with = "number::hex_list")]
    pub track: Vec<u32>,
}

/// A run of frames of the same length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameRun {
    /// Seconds by which the clock advances before each of the frames.
    pub dt: f64,
    /// How many.
    pub count: u32,
}

/// An entity as it is created.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EntitySpec {
    /// Its GUID.
    #[serde(with = "number::hex")]
    pub guid: u32,
    /// What its weenie says it is.
    pub kind: EntityKind,
    /// DID of its setup.
    #[serde(with = "number::hex")]
    pub setup: u32,
    /// DID of its motion table; 0 for none.
    #[serde(with = "number::hex", default)]
    pub motion_table: u32,
    /// Scale.
    #[serde(with = "number::f32", default = "one")]
    pub scale: f32,
    /// Where it enters the world.
    pub position: PositionSpec,
    /// Physics state word.
    #[serde(with = "number::hex", default)]
    pub state: u32,
    /// World-space velocity, m/s.
    #[serde(with = "number::floats", default)]
    pub velocity: [f32; 3],
    /// World-space angular velocity, rad/s.
    #[serde(with = "number::floats", default)]
    pub omega: [f32; 3],
    /// Elasticity.
    #[serde(with = "number::f32", default = "default_elasticity")]
    pub elasticity: f32,
    /// Friction.
    #[serde(with = "number::f32", default = "default_friction")]
    pub friction: f32,
    /// What the run-rate callback answers.
    #[serde(with = "number::f32", default = "one")]
    pub run_rate: f32,
    /// What the jump-velocity callback answers for extent 1, m/s; 0: it cannot jump.
    #[serde(with = "number::f32", default)]
    pub jump_velocity: f32,
    /// GUID of its parent.
    #[serde(
        with = "number::opt_hex",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub parent: Option<u32>,
}

/// What an entity's weenie says it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EntityKind {
    /// A player (and creature).
    Player,
    /// A creature.
    Creature,
    /// Any other object.
    Object,
    /// A missile.
    Missile,
}

/// A position in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PositionSpec {
    /// Cell id.
    #[serde(with = "number::hex")]
    pub cell: u32,
    /// In the coordinates of the cell's landblock, metres.
    #[serde(with = "number::floats")]
    pub origin: [f32; 3],
    /// `[w, x, y, z]`.
    #[serde(with = "number::floats")]
    pub rotation: [f32; 4],
}

/// An offset from a parent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OffsetSpec {
    /// Metres, in the parent's space.
    #[serde(with = "number::floats")]
    pub origin: [f32; 3],
    /// `[w, x, y, z]`.
    #[serde(with = "number::floats")]
    pub rotation: [f32; 4],
}

fn one() -> f32 {
    1.0
}

fn default_elasticity() -> f32 {
    0.05
}

fn default_friction() -> f32 {
    0.95
}

impl Scene {
    /// A scene in which nothing is.
    pub(crate) fn empty() -> Self {
        Self {
            schema: SCENE_SCHEMA.into(),
            name: String::new(),
            summary: String::new(),
            world: String::new(),
            features: Vec::new(),
            start_time: 0.0,
            frames: Vec::new(),
            entities: Vec::new(),
            script: Vec::new(),
            track: Vec::new(),
        }
    }

    /// Reads a scene from its JSON. `path` is what errors call it.
    ///
    /// # Errors
    /// When the text is no scene of the schema this version reads, or is inconsistent.
    pub fn parse(text: &[u8], path: &Path) -> Result<Self, GoldenError> {
        let bad = |place: String, reason: String| GoldenError::Scene {
            path: path.into(),
            place,
            reason,
        };
        let mut deserializer = serde_json::Deserializer::from_slice(text);
        let scene: Self = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
            let place = error.path().to_string();
            bad(
                if place == "." { "scene".into() } else { place },
                error.into_inner().to_string(),
            )
        })?;
        deserializer
            .end()
            .map_err(|error| bad("scene".into(), error.to_string()))?;
        scene
            .check()
            .map_err(|(place, reason)| bad(place, reason))?;
        Ok(scene)
    }

    /// Reads a `*.scene.json` file.
    ///
    /// # Errors
    /// When the file cannot be read, and as [`Scene::parse`].
    pub fn open(path: &Path) -> Result<Self, GoldenError> {
        let text = std::fs::read(path).map_err(|source| GoldenError::Io {
            path: path.into(),
            source,
        })?;
        Self::parse(&text, path)
    }

    fn check(&self) -> Result<(), (String, String)> {
        if self.schema != SCENE_SCHEMA {
            return Err((
                "schema".into(),
                format!("is `{}`, this version reads `{SCENE_SCHEMA}`", self.schema),
            ));
        }
        if !is_plain_path(&self.world) || self.world.contains('/') {
            return Err((
                "world".into(),
                format!("`{}` is no folder name", self.world),
            ));
        }
        if !is_plain_path(&self.name) {
            return Err(("name".into(), format!("`{}` is no plain path", self.name)));
        }
        if self
            .frames
            .iter()
            .map(|run| u64::from(run.count))
            .sum::<u64>()
            > MAX_FRAMES
        {
            return Err(("frames".into(), format!("are more than {MAX_FRAMES}")));
        }
        if let Some(index) = self
            .script
            .windows(2)
            .position(|pair| pair[0].frame > pair[1].frame)
        {
            return Err((
                format!("script[{}].frame", index + 1),
                "is less than that of the step before".into(),
            ));
        }
        Ok(())
    }

    /// The part of the name before the first slash.
    pub fn area(&self) -> &str {
        self.name.split('/').next().unwrap_or("")
    }

    /// Number of frames.
    pub fn frame_count(&self) -> u32 {
        self.frames
            .iter()
            .fold(0, |sum, run| sum.saturating_add(run.count))
    }

    /// The clock after each frame's advance, from frame 0 on: the same f64 additions as every oracle's.
    pub fn times(&self) -> impl Iterator<Item = f64> + '_ {
        let steps = self
            .frames
            .iter()
            .flat_map(|run| std::iter::repeat_n(run.dt, run.count as usize));
        steps.scan(self.start_time, |time, dt| {
            *time += dt;
            Some(*time)
        })
    }
}

/// Whether a name is made of plain segments only, so that it can be joined to a folder safely.
pub(crate) fn is_plain_path(name: &str) -> bool {
    name.split('/').all(|segment| {
        !matches!(segment, "" | "." | "..")
            && segment
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '+'))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINIMAL: &str = r#"{"schema":"ac-scene/1","name":"a/b","summary":"s","world":"w","features":[],"start_time":1000,
        "frames":[{"dt":0.5,"count":2}],"track":["0x1"],
        "entities":[{"guid":"0x1","kind":"object","setup":"0x02000001","motion_table":"0x0",
            "position":{"cell":"0xA9B40001","origin":[0,0,0],"rotation":[1,0,0,0]},"state":"0x8"}],
        "script":[{"frame":1,"guid":"0x1","do":"jump","extent":1}]}"#;

    fn parse(text: &str) -> Result<Scene, GoldenError> {
        Scene::parse(text.as_bytes(), Path::new("b.scene.json"))
    }

    #[test]
    fn defaults_are_those_of_the_format() {
        let scene = parse(MINIMAL).unwrap();
        let entity = scene.entities[0];
        assert_eq!(
            (
                entity.scale,
                entity.elasticity,
                entity.friction,
                entity.run_rate
            ),
            (1.0, 0.05, 0.95, 1.0)
        );
        assert_eq!(scene.times().collect::<Vec<_>>(), [1000.5, 1001.0]);
        assert_eq!(scene.frame_count(), 2);
    }

    #[test]
    fn unknown_fields_name_file_and_place() {
        let error = parse(&MINIMAL.replace("\"motion_table\"", "\"motiontable\""))
            .unwrap_err()
            .to_string();
        insta::assert_snapshot!(error, @"b.scene.json, entities[0].motiontable: unknown field `motiontable`, expected one of `guid`, `kind`, `setup`, `motion_table`, `scale`, `position`, `state`, `velocity`, `omega`, `elasticity`, `friction`, `run_rate`, `jump_velocity`, `parent` at line 3 column 84");
        let error = parse(&MINIMAL.replace("\"extent\"", "\"height\""))
            .unwrap_err()
            .to_string();
        insta::assert_snapshot!(error, @"b.scene.json, script[0]: `jump` needs `extent` at line 5 column 66");
    }

    #[test]
    fn arguments_that_a_step_does_not_take_are_errors() {
        let error = parse(&MINIMAL.replace("\"extent\":1", "\"extent\":1,\"height\":1"))
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("b.scene.json, script[0]: `jump` takes no `height`"),
            "{error}"
        );
    }

    #[test]
    fn a_name_cannot_leave_the_folder() {
        assert!(parse(&MINIMAL.replace("\"w\"", "\"..\"")).is_err());
        assert!(parse(&MINIMAL.replace("\"a/b\"", "\"../b\"")).is_err());
        assert!(parse(&MINIMAL.replace("\"a/b\"", "\"/b\"")).is_err());
    }

    #[test]
    fn scenes_survive_writing() {
        let scene = parse(MINIMAL).unwrap();
        let text = serde_json::to_string(&scene).unwrap();
        assert_eq!(parse(&text).unwrap(), scene);
    }
}
