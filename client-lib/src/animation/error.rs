//! What can go wrong in the animation layer.

use thiserror::Error;

/// A sequence that cannot be advanced. The references hang or run out of memory here (`spec/07-animation.md`, 8.10 and 16).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum AnimationError {
    /// One update took more passes than any sane rate and time need.
    #[error(
        "animation 0x{animation:08X} did not come to an end within one update (rate or time is infinite or far too large)"
    )]
    Endless {
        /// Animation of the current node; 0 without one.
        animation: u32,
    },
    /// One update queued more hooks than any sane animation has.
    #[error("animation 0x{animation:08X} queued more than {limit} hooks within one update")]
    TooManyHooks {
        /// Animation of the current node.
        animation: u32,
        /// The limit.
        limit: usize,
    },
}

/// Why a motion was refused by the motion table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum MotionTableError {
    /// The object has no motion table.
    #[error("the object has no motion table")]
    NoAnimationTable,
    /// The table has nothing for this motion in this state.
    #[error("the motion table has no such motion in the present state")]
    NoMotionData,
    /// The table's modifiers install each other without end; the references overflow their stack (`spec/07-animation.md`, 10.6).
    #[error(
        "motion table 0x{table:08X}: modifiers that are substates install each other without end"
    )]
    Endless {
        /// The table.
        table: u32,
    },
}

impl MotionTableError {
    /// The client's error code. An endless table has none of its own and answers as a missing motion does.
    pub const fn code(self) -> u32 {
        match self {
            Self::NoAnimationTable => 0x07,
            Self::NoMotionData | Self::Endless { .. } => 0x43,
        }
    }
}

/// Why a part array could not be made or changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PartArrayError {
    /// An id of 0 names nothing.
    #[error("id 0 names no setup and no shape")]
    NullId,
    /// The setup does not exist.
    #[error("setup 0x{0:08X} does not exist")]
    MissingSetup(u32),
    /// The setup has no parts.
    #[error("setup 0x{0:08X} has no parts")]
    NoParts(u32),
    /// The shape of a part does not exist.
    #[error("shape 0x{shape:08X} of part {part} does not exist")]
    MissingShape {
        /// Part number.
        part: usize,
        /// The shape.
        shape: u32,
    },
    /// More parts than a particle object can have.
    #[error("{0} particle parts are more than the limit")]
    TooManyParts(usize),
}
