//! Goes to a frame of a trace.

use std::{fs::File, path::Path};

use ac_client::{frame::FrameStates, profile::Profile};
use ac_golden_traces::trace::SeekableTrace;

use super::{Identity, KeyframeError, KeyframeHeader, decode, frame_of, name_of};
use crate::{Simulation, Simulator};

/// Reaches frames of a scene by the keyframes of its trace.
pub struct Seeker<'a> {
    trace: SeekableTrace<File>,
    simulator: &'a dyn Simulator,
    profile: Profile,
    identity: Identity,
    /// Frames with a keyframe, ascending.
    keyframes: Vec<i32>,
}

/// A frame that was reached.
pub struct Sought {
    /// Stands before the next frame.
    pub simulation: Box<dyn Simulation>,
    /// The keyframe that it went on from; `None`: from the start of the scene.
    pub keyframe: Option<i32>,
    /// Frames that were run to get there.
    pub replayed: u32,
}

impl<'a> Seeker<'a> {
    /// Opens a trace to be run under a profile over the files of `world` (BLAKE3 by name, see
    /// [`hash_world`](ac_golden_traces::import::hash_world)).
    ///
    /// # Errors
    /// When the trace cannot be read by its index.
    pub fn open(
        path: &Path,
        simulator: &'a dyn Simulator,
        profile: Profile,
        world: impl FnOnce(&str) -> Result<std::collections::BTreeMap<String, String>, KeyframeError>,
    ) -> Result<Self, KeyframeError> {
        let trace = SeekableTrace::open(path)?;
        let mut info = trace.info().clone();
        info.world = world(&trace.scene().world)?;
        let identity = Identity::new(&info, trace.scene_text(), &profile);
        let mut keyframes: Vec<i32> = trace.attachments().filter_map(frame_of).collect();
        keyframes.sort_unstable();
        Ok(Self {
            trace,
            simulator,
            profile,
            identity,
            keyframes,
        })
    }

    /// The trace.
    pub fn trace(&mut self) -> &mut SeekableTrace<File> {
        &mut self.trace
    }

    /// What the runs are of.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// The profile they run under.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Frames with a keyframe, ascending.
    pub fn keyframes(&self) -> &[i32] {
        &self.keyframes
    }

    /// Leaves the keyframes out: every frame is reached from the start.
    pub fn ignore_keyframes(&mut self) {
        self.keyframes.clear();
    }

    /// The keyframe after a frame: its header and its snapshot.
    ///
    /// # Errors
    /// When there is none, or it cannot be used here.
    pub fn keyframe(&mut self, frame: i32) -> Result<(KeyframeHeader, Vec<u8>), KeyframeError> {
        let name = name_of(frame);
        let bytes = self.trace.attachment(&name)?;
        let bytes = bytes.ok_or_else(|| KeyframeError::Format(format!("there is no `{name}`")))?;
        let (header, snapshot) = decode(&bytes)?;
        if header.frame != frame {
            return Err(KeyframeError::Damaged(format!(
                "`{name}` holds the state after frame {}",
                header.frame
            )));
        }
        self.identity.accept(&header)?;
        Ok((header, snapshot))
    }

    /// Goes to a frame from the last keyframe before it and writes its records.
    ///
    /// # Errors
    /// When there is no such frame, the keyframe cannot be used, or the client cannot go on.
    pub fn seek(&mut self, frame: i32, states: &mut FrameStates) -> Result<Sought, KeyframeError> {
        let last = i32::try_from(self.trace.scene().frame_count()).unwrap_or(i32::MAX) - 1;
        if !(-1..=last).contains(&frame) {
            return Err(KeyframeError::NoFrame { frame, last });
        }
        let before = self
            .keyframes
            .partition_point(|keyframe| *keyframe <= frame);
        let keyframe = before.checked_sub(1).map(|at| self.keyframes[at]);
        let mut simulation = match keyframe {
            Some(keyframe) => {
                let (_, snapshot) = self.keyframe(keyframe)?;
                let scene = self.trace.scene();
                self.simulator.resume(scene, &self.profile, &snapshot)?
            }
            None => self.simulator.start(self.trace.scene(), &self.profile)?,
        };
        let from = keyframe.unwrap_or(-1);
        match keyframe {
            None if frame == -1 => simulation.frame_minus_one(states)?,
            _ if frame == from => simulation.records(frame, states)?,
            _ => {}
        }
        for next in from + 1..=frame {
            states.clear();
            simulation.step(next.cast_unsigned(), states)?;
        }
        Ok(Sought {
            simulation,
            keyframe,
            replayed: frame.abs_diff(from),
        })
    }
}
