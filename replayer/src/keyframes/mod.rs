//! Keyframes: all state of a run, written into its trace every so many frames, so that a frame is reached by running at most that many.
//!
//! A trace that `ac-replay run --keyframes N` writes has one after each frame N−1, 2N−1, …, each an attachment of the container with a name
//! like `keyframe/119`: the state between frame 119 and frame 120. The container's index says where it is, so that [`Seeker`] reads the head
//! of the file, its index and one keyframe, whatever the length of the file, and the client goes on from there. Frames that follow are bit for
//! bit those of the run that wrote the trace.
//!
//! A keyframe begins with a [header](KeyframeHeader) in JSON, which says what it belongs to: versions, scene, world, profile. A keyframe of
//! another scene, world or profile, or of another version, is refused with a message that says what to do. What follows is the
//! [snapshot](crate::Simulation::snapshot), compressed. `docs/keyframes.md` describes both.

mod cli;
mod encode;
#[doc(hidden)]
pub mod fuzzing;
mod header;
mod seek;

use ac_golden_traces::GoldenError;

pub use cli::{KeyframesArgs, SeekArgs, list, seek};
pub(crate) use cli::{open, profile_for, worlds};
pub use encode::{MAX_SNAPSHOT, decode, encode};
pub use header::{Identity, KeyframeHeader, Versions};
pub use seek::{Seeker, Sought};

use crate::SimulationError;

/// Names of the attachments begin with this; the number of the frame follows.
pub const PREFIX: &str = "keyframe/";
/// Media type of the attachments.
pub const MEDIA_TYPE: &str = "application/x-ac-keyframe";

/// Name of the attachment with the state after a frame.
pub fn name_of(frame: i32) -> String {
    format!("{PREFIX}{frame}")
}

/// The frame after which the keyframe of this name was taken.
pub fn frame_of(name: &str) -> Option<i32> {
    let number = name.strip_prefix(PREFIX)?;
    let frame = number.parse().ok()?;
    (name_of(frame) == name).then_some(frame)
}

/// Why a keyframe cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum KeyframeError {
    /// The bytes are no keyframe.
    #[error("not a keyframe: {0}")]
    Format(String),
    /// It was written by a program with other forms.
    #[error(
        "the keyframe has version {found} of its {what}, this program reads {known}; write the trace again with `ac-replay run --keyframes`, or run it from the start with `--from-start`"
    )]
    Version {
        /// What the version is of: keyframe, scene or world.
        what: &'static str,
        /// Version of the keyframe.
        found: u32,
        /// The version that is read.
        known: u32,
    },
    /// It belongs to another scene, world or profile.
    #[error("the keyframe belongs to another {what}: it has {found}, this is {wanted}")]
    Other {
        /// What is another one.
        what: String,
        /// What the keyframe says.
        found: String,
        /// What was asked for.
        wanted: String,
    },
    /// Its bytes are not those that were written.
    #[error("the keyframe is damaged: {0}")]
    Damaged(String),
    /// The trace says that it ends before the frame.
    #[error("frame {frame} is not in the scene, which has the frames -1 to {last}")]
    NoFrame {
        /// The frame asked for.
        frame: i32,
        /// The last one.
        last: i32,
    },
    /// No profile has this name.
    #[error("no profile is called `{0}`; profiles: retail, ace, gdle, gdle-repaired")]
    Profile(String),
    /// The trace cannot be read.
    #[error(transparent)]
    Trace(#[from] GoldenError),
    /// The client cannot go on from it.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

#[cfg(test)]
mod tests;
