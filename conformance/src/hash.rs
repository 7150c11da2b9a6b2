//! State hashes: one number per frame and one per scene that says whether two runs were the same.
//!
//! A trace comparison says *what* differs from an oracle. A hash asks less and answers faster: did this build, on this
//! machine, with this many threads, compute the same bits as the one that wrote the file of hashes? No expectation is needed.
//!
//! What is hashed is a byte form of the tracked state that does not depend on how the program lays out its data: for every
//! frame from -1 on, for every record in the order of the scene's `track`, every present field in the order of
//! [`Fields`], little-endian, numbers as their bits, lists with their length in front. An absent field differs from one that is
//! zero, and null from both. Every not-a-number counts as the same one: its bits are not defined by the language.
//!
//! A frame's hash is the BLAKE3 of its bytes; a scene's that of [`SCHEMA`] and all hashes of its frames. Written are the first 16 bytes.

use std::{collections::BTreeMap, fmt};

use ac_client::{
    frame::{
        FrameState, FrameStates,
        state::{Collision, Fields, FrameEvent},
    },
    profile::Profile,
};
use ac_golden_traces::{Scene, trace::TraceReader};
use ac_replayer::Simulator;
use rayon::prelude::*;

use crate::run::{Case, RunError};

/// Name and version of the byte form; the first word of a file of hashes.
pub const SCHEMA: &str = "ac-hash/1";

/// The hash of a frame or a scene.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StateHash([u8; 16]);

impl fmt::Display for StateHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for StateHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl StateHash {
    fn of(hasher: &blake3::Hasher) -> Self {
        let mut bytes = [0; 16];
        bytes.copy_from_slice(&hasher.finalize().as_bytes()[..16]);
        Self(bytes)
    }

    /// Reads 32 hexadecimal digits.
    fn parse(text: &str) -> Option<Self> {
        if text.len() != 32 || !text.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return None;
        }
        u128::from_str_radix(text, 16)
            .ok()
            .map(|number| Self(number.to_be_bytes()))
    }
}

/// The hashes of one scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneHash {
    /// Name of the scene.
    pub scene: String,
    /// Over all frames.
    pub hash: StateHash,
    /// Of the frames -1, 0, 1, …; empty in a file that has none.
    pub frames: Vec<StateHash>,
}

/// Runs a scene under a profile and hashes every frame.
///
/// # Errors
/// When the case cannot be read or the client cannot run it.
pub fn hash_case(
    simulator: &dyn Simulator,
    case: &Case,
    profile: &Profile,
) -> Result<SceneHash, RunError> {
    let scene = scene_of(case)?;
    let fail = |source| RunError::Simulation {
        path: case.path().into(),
        source,
    };
    let mut simulation = simulator.start(&scene, profile).map_err(fail)?;
    let mut whole = blake3::Hasher::new();
    whole.update(SCHEMA.as_bytes());
    let mut frames = Vec::new();
    let mut states = FrameStates::new();
    let mut bytes = Bytes::default();
    simulation.frame_minus_one(&mut states).map_err(fail)?;
    for frame in 0..=scene.frame_count() {
        let hash = bytes.frame(states.iter());
        whole.update(&hash.0);
        frames.push(hash);
        if frame < scene.frame_count() {
            states.clear();
            simulation.step(frame, &mut states).map_err(fail)?;
        }
    }
    Ok(SceneHash {
        scene: scene.name,
        hash: StateHash::of(&whole),
        frames,
    })
}

/// Runs all cases on the current thread pool; answers in the order of the scenes' names.
pub fn hash_all(
    simulator: &dyn Simulator,
    cases: &[Case],
    profile: &Profile,
    done: impl Fn() + Sync,
) -> (Vec<SceneHash>, Vec<RunError>) {
    let each: Vec<_> = cases
        .par_iter()
        .map(|case| {
            let hash = hash_case(simulator, case, profile);
            done();
            hash
        })
        .collect();
    let (mut hashes, mut errors) = (Vec::new(), Vec::new());
    for result in each {
        match result {
            Ok(hash) => hashes.push(hash),
            Err(error) => errors.push(error),
        }
    }
    hashes.sort_by(|a, b| a.scene.cmp(&b.scene));
    (hashes, errors)
}

/// The scene of a case.
///
/// # Errors
/// When it cannot be read.
pub fn scene_of(case: &Case) -> Result<Scene, RunError> {
    Ok(match case {
        Case::Trace(path) => TraceReader::open(path)?.scene().clone(),
        Case::Files { scene, .. } => Scene::open(scene)?,
    })
}

/// The byte form of records; keeps its memory from frame to frame.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn frame<'a>(&mut self, states: impl Iterator<Item = &'a FrameState>) -> StateHash {
        self.0.clear();
        for state in states {
            self.state(state);
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.0);
        StateHash::of(&hasher)
    }

    fn u32(&mut self, value: u32) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn f32(&mut self, value: f32) {
        let value = if value.is_nan() { f32::NAN } else { value };
        self.u32(value.to_bits());
    }

    fn f64(&mut self, value: f64) {
        let value = if value.is_nan() { f64::NAN } else { value };
        self.0.extend_from_slice(&value.to_bits().to_le_bytes());
    }

    fn f32s(&mut self, values: &[f32]) {
        values.iter().for_each(|value| self.f32(*value));
    }

    /// The length of a list; its items follow.
    fn length(&mut self, length: usize) {
        self.0.extend_from_slice(&(length as u64).to_le_bytes());
    }

    fn state(&mut self, state: &FrameState) {
        self.u32(state.has.bits());
        self.u32(state.frame.cast_unsigned());
        self.f64(state.time);
        self.u32(state.guid);
        self.u32(state.cell);
        let has = |field| state.has.contains(field);
        for (field, values) in [
            (Fields::ORIGIN, &state.origin[..]),
            (Fields::ROTATION, &state.rotation),
            (Fields::VELOCITY, &state.velocity),
            (Fields::ACCELERATION, &state.acceleration),
            (Fields::OMEGA, &state.omega),
        ] {
            if has(field) {
                self.f32s(values);
            }
        }
        for (field, value) in [
            (Fields::STATE, state.state),
            (Fields::TRANSIENT, state.transient),
        ] {
            if has(field) {
                self.u32(value);
            }
        }
        self.contact(state);
        self.animation(state);
        self.motion(state);
        self.lists(state);
    }

    fn contact(&mut self, state: &FrameState) {
        let has = |field| state.has.contains(field);
        if has(Fields::CONTACT_PLANE) {
            self.u32(state.contact_plane.is_some().into());
        }
        if let Some(plane) = state.contact_plane.filter(|_| has(Fields::CONTACT_PLANE)) {
            if has(Fields::PLANE_N) {
                self.f32s(&plane.n);
            }
            if has(Fields::PLANE_D) {
                self.f32(plane.d);
            }
            if has(Fields::PLANE_CELL) {
                self.u32(plane.cell);
            }
        }
        if has(Fields::SLIDING_NORMAL) {
            self.u32(state.sliding_normal.is_some().into());
            state
                .sliding_normal
                .iter()
                .for_each(|normal| self.f32s(normal));
        }
    }

    fn animation(&mut self, state: &FrameState) {
        let has = |field| state.has.contains(field);
        if !has(Fields::ANIM) {
            return;
        }
        self.u32(state.anim.is_some().into());
        let Some(anim) = &state.anim else { return };
        if has(Fields::ANIM_FRAME_NUMBER) {
            self.f64(anim.frame_number);
        }
        if has(Fields::ANIM_ID) {
            self.u32(anim.id);
        }
        if has(Fields::ANIM_FIRST_CYCLIC) {
            self.u32(anim.first_cyclic.into());
        }
        if has(Fields::ANIM_QUEUE) {
            self.length(anim.queue.len());
            anim.queue.iter().for_each(|id| self.u32(*id));
        }
        if has(Fields::ANIM_VELOCITY) {
            self.f32s(&anim.velocity);
        }
        if has(Fields::ANIM_OMEGA) {
            self.f32s(&anim.omega);
        }
    }

    fn motion(&mut self, state: &FrameState) {
        let has = |field| state.has.contains(field);
        if !has(Fields::MOTION) {
            return;
        }
        self.u32(state.motion.is_some().into());
        let Some(motion) = &state.motion else { return };
        for (field, bits) in [
            (Fields::MOTION_STYLE, motion.style),
            (Fields::MOTION_SUBSTATE, motion.substate),
            (Fields::MOTION_FORWARD, motion.forward),
            (Fields::MOTION_SIDESTEP, motion.sidestep),
            (Fields::MOTION_TURN, motion.turn),
        ] {
            if has(field) {
                self.u32(bits);
            }
        }
        for (field, speed) in [
            (Fields::MOTION_SUBSTATE_SPEED, motion.substate_speed),
            (Fields::MOTION_FORWARD_SPEED, motion.forward_speed),
            (Fields::MOTION_SIDESTEP_SPEED, motion.sidestep_speed),
            (Fields::MOTION_TURN_SPEED, motion.turn_speed),
        ] {
            if has(field) {
                self.f32(speed);
            }
        }
    }

    fn lists(&mut self, state: &FrameState) {
        let has = |field| state.has.contains(field);
        if has(Fields::STEPS) {
            self.length(state.steps.len());
            for step in &state.steps {
                self.f32(step.dt);
                self.u32(step.outcome as u32);
            }
        }
        if has(Fields::COLLISIONS) {
            self.length(state.collisions.len());
            for collision in &state.collisions {
                let (kind, guid) = match collision {
                    Collision::Environment => (0, 0),
                    Collision::Object(guid) => (1, *guid),
                };
                self.u32(kind);
                self.u32(guid);
            }
        }
        if has(Fields::EVENTS) {
            self.length(state.events.len());
            for event in &state.events {
                let (kind, value) = match event {
                    FrameEvent::HitGround => (0, 0),
                    FrameEvent::LeaveGround => (1, 0),
                    FrameEvent::MotionDone(motion) => (2, *motion),
                    FrameEvent::AnimHook(hook) => (3, *hook),
                };
                self.u32(kind);
                self.u32(value);
            }
        }
    }
}

/// A file of hashes: what a run is checked against.
///
/// The first line is `ac-hash/1 PROFILE`. Every other line is `HASH SCENE`, or `HASH SCENE FRAME` for one frame of the scene
/// above it. Empty lines and lines that start with `#` say nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HashFile {
    /// The profile that the hashes were made under.
    pub profile: String,
    /// By name of the scene.
    pub scenes: BTreeMap<String, SceneHash>,
}

/// A line of a file of hashes that cannot be read.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct HashFileError {
    /// Its number, from 1.
    pub line: usize,
    /// What is wrong.
    pub reason: &'static str,
}

impl HashFile {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// When a line is not as described, or a scene comes twice.
    pub fn parse(text: &str) -> Result<Self, HashFileError> {
        let mut lines = (1..)
            .zip(text.lines())
            .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let (line, head) = lines.next().unwrap_or((1, ""));
        let profile = head.strip_prefix(SCHEMA).map(str::trim);
        let mut file = Self {
            profile: profile
                .ok_or(HashFileError {
                    line,
                    reason: "expected `ac-hash/1 PROFILE`",
                })?
                .into(),
            scenes: BTreeMap::new(),
        };
        for (line, text) in lines {
            file.line(text)
                .map_err(|reason| HashFileError { line, reason })?;
        }
        Ok(file)
    }

    fn line(&mut self, text: &str) -> Result<(), &'static str> {
        let mut words = text.split_whitespace();
        let hash = words.next().and_then(StateHash::parse);
        let hash = hash.ok_or("expected a hash of 32 hexadecimal digits")?;
        let scene = words.next().ok_or("expected the name of a scene")?;
        let Some(frame) = words.next() else {
            let entry = SceneHash {
                scene: scene.into(),
                hash,
                frames: Vec::new(),
            };
            return match self.scenes.insert(scene.into(), entry) {
                None => Ok(()),
                Some(_) => Err("this scene came before"),
            };
        };
        let entry = self.scenes.get_mut(scene);
        let entry = entry.ok_or("a frame comes after its scene")?;
        let next = i64::try_from(entry.frames.len()).map_or(i64::MAX, |count| count - 1);
        if frame.parse() != Ok(next) || words.next().is_some() {
            return Err("frames count up from -1");
        }
        entry.frames.push(hash);
        Ok(())
    }
}

/// The text of a file of hashes; with the hash of every frame if `frames`.
pub fn text(profile: &str, hashes: &[SceneHash], frames: bool) -> String {
    let mut text = format!("{SCHEMA} {profile}\n");
    for scene in hashes {
        text += &format!("{} {}\n", scene.hash, scene.scene);
        for (frame, hash) in (-1..).zip(&scene.frames).filter(|_| frames) {
            text += &format!("{hash} {} {frame}\n", scene.scene);
        }
    }
    text
}

/// How a run differs from a file of hashes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HashDifference {
    /// Another hash.
    Changed {
        /// The scene.
        scene: String,
        /// In the file.
        expected: StateHash,
        /// Of the run.
        actual: StateHash,
        /// First frame that differs, when the file has hashes of frames.
        frame: Option<i64>,
    },
    /// The file does not have the scene.
    New(String),
    /// The run does not have the scene.
    Missing(String),
}

impl fmt::Display for HashDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Changed {
                scene,
                expected,
                actual,
                frame,
            } => {
                write!(f, "changed: {scene}: expected {expected}, got {actual}")?;
                frame.map_or(Ok(()), |frame| write!(f, ", from frame {frame} on"))
            }
            Self::New(scene) => write!(f, "new: {scene} is not in the file"),
            Self::Missing(scene) => write!(f, "missing: {scene} was not run"),
        }
    }
}

/// Everything in which a run differs from a file. A scene that is on one side only is a difference too.
pub fn check(file: &HashFile, hashes: &[SceneHash]) -> Vec<HashDifference> {
    let mut differences = Vec::new();
    for actual in hashes {
        let Some(expected) = file.scenes.get(&actual.scene) else {
            differences.push(HashDifference::New(actual.scene.clone()));
            continue;
        };
        let frames = || expected.frames.iter().zip(&actual.frames);
        let frame = (-1..)
            .zip(frames())
            .find(|(_, (a, b))| a != b)
            .map(|(frame, _)| frame);
        if expected.hash != actual.hash || frame.is_some() {
            differences.push(HashDifference::Changed {
                scene: actual.scene.clone(),
                expected: expected.hash,
                actual: actual.hash,
                frame,
            });
        }
    }
    let ran = |scene: &str| hashes.iter().any(|hash| hash.scene == scene);
    let missing = file.scenes.keys().filter(|scene| !ran(scene));
    differences.extend(missing.map(|scene| HashDifference::Missing(scene.clone())));
    differences
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(name: &str, states: &[&[FrameState]]) -> SceneHash {
        let frames: Vec<_> = states
            .iter()
            .map(|states| Bytes::default().frame(states.iter()))
            .collect();
        let mut whole = blake3::Hasher::new();
        frames.iter().for_each(|hash| {
            whole.update(&hash.0);
        });
        SceneHash {
            scene: name.into(),
            hash: StateHash::of(&whole),
            frames,
        }
    }

    fn of(change: impl FnOnce(&mut FrameState)) -> StateHash {
        let mut state = FrameState {
            has: Fields::all(),
            anim: Some(Default::default()),
            motion: Some(Default::default()),
            contact_plane: Some(Default::default()),
            ..FrameState::default()
        };
        change(&mut state);
        Bytes::default().frame([state].iter())
    }

    #[test]
    fn every_bit_counts() {
        let changes: [fn(&mut FrameState); 16] = [
            |_| {},
            |s| s.origin[0] = -0.0,
            |s| s.origin[1] = f32::MIN_POSITIVE,
            |s| s.has -= Fields::ORIGIN,
            |s| s.time = 1.0,
            |s| s.cell = 1,
            |s| s.contact_plane = None,
            |s| s.sliding_normal = Some([0.0; 3]),
            |s| s.anim = None,
            |s| s.motion = None,
            |s| s.motion.as_mut().unwrap().turn_speed = 1.0,
            |s| s.anim.as_mut().unwrap().queue.push(0),
            |s| s.steps.push(Default::default()),
            |s| s.collisions.push(Collision::Environment),
            |s| s.events.push(FrameEvent::HitGround),
            |s| s.events.push(FrameEvent::LeaveGround),
        ];
        let hashes: std::collections::BTreeSet<_> = changes.into_iter().map(of).collect();
        assert_eq!(hashes.len(), 16);
    }

    #[test]
    fn what_is_absent_or_undefined_does_not_count() {
        let absent = |x| {
            of(|s| {
                s.has -= Fields::VELOCITY;
                s.velocity[0] = x;
            })
        };
        assert_eq!(absent(1.0), absent(2.0));
        assert_eq!(
            of(|s| s.origin[0] = f32::NAN),
            of(|s| s.origin[0] = -f32::NAN)
        );
    }

    #[test]
    fn files_are_read_as_written_and_checked() {
        let (a, b) = (
            FrameState::default(),
            FrameState {
                cell: 1,
                ..FrameState::default()
            },
        );
        let (same, other) = (
            scene(
                "a/one",
                &[std::slice::from_ref(&a), std::slice::from_ref(&a)],
            ),
            scene("a/one", &[std::slice::from_ref(&a), &[b]]),
        );
        let written = text("retail", &[same.clone(), scene("a/two", &[])], true);
        insta::assert_snapshot!(written);
        let file = HashFile::parse(&written).unwrap();
        assert_eq!(file.scenes["a/one"], same);
        let differences = check(&file, &[other, scene("b/three", &[])]);
        let shown: Vec<_> = differences.iter().map(ToString::to_string).collect();
        assert_eq!(shown.len(), 3);
        assert!(
            shown[0].starts_with("changed: a/one: expected "),
            "{}",
            shown[0]
        );
        assert!(shown[0].ends_with(", from frame 0 on"), "{}", shown[0]);
        assert_eq!(shown[1], "new: b/three is not in the file");
        assert_eq!(shown[2], "missing: a/two was not run");
        let bad = |text: &str| HashFile::parse(text).unwrap_err().to_string();
        let hash = "00".repeat(16);
        insta::assert_snapshot!(bad(""), @"line 1: expected `ac-hash/1 PROFILE`");
        insta::assert_snapshot!(bad("ac-hash/1 retail\nxyz a/b"), @"line 2: expected a hash of 32 hexadecimal digits");
        insta::assert_snapshot!(bad(&format!("ac-hash/1 retail\n{hash} a/b\n{hash} a/b 0")), @"line 3: frames count up from -1");
        insta::assert_snapshot!(bad(&format!("ac-hash/1 retail\n{hash} a/b\n{hash} a/b")), @"line 3: this scene came before");
    }
}
