//! Motion: from commands to the two motion states, to requested animations, to steering, and to what the server is told.
//!
//! *Raw* motions come from keys, from the server or from scripts; [`MotionInterp`] normalises them into the *interpreted* state and asks
//! the animation layer for motions; [`MoveToManager`] steers to places and objects by requesting motions itself. Both belong to the
//! [`MovementManager`] of an object, and everything that acts on the object is a method of [`Entity`](crate::entity::Entity), because the
//! parts call each other back. [`CommandInterpreter`] turns keys and mouse into raw motions of the player and says what to send.
//!
//! Commands are 32-bit numbers ([`Command`]), speeds factors of an animation's rate, headings compass degrees, distances metres.
//!
//! Source: `spec/08-motion.md`.

mod action;
mod command;
mod command_interpreter;
mod command_table;
pub mod constants;
mod error;
#[cfg(test)]
mod fixtures;
pub mod formulas;
mod ground;
mod heading;
mod hold_key;
mod inbound;
mod interp;
#[cfg(test)]
mod interp_tests;
mod interpreted_state;
mod move_to;
mod move_to_start;
#[cfg(test)]
mod move_to_tests;
mod move_to_tick;
mod movement_manager;
mod params;
mod raw_state;
mod requests;
#[cfg(test)]
mod tests;
mod weenie;
pub mod wire;
#[cfg(test)]
mod wire_tests;

pub use action::{Action, Actions};
pub use command::{ACTION, CHAT_EMOTE, Command, MAPPABLE, MODIFIER, STYLE, SUB_STATE, TOGGLE, UI};
pub use command_interpreter::{
    AutonomyLevel, CommandEntry, CommandInterpreter, CommandList, InputOptions, Outgoing, Scene,
    SequenceStamps,
};
pub use error::{MotionError, MotionResult, code_of};
pub use heading::{heading_diff, heading_greater};
pub use hold_key::HoldKey;
pub use inbound::{MovementHeader, MovementUpdate, UpdateKind};
pub use interp::{
    Motion, MotionInterp, Mover, PendingMotion, contact_allows_move, motion_allows_jump,
};
pub use interpreted_state::InterpretedMotionState;
pub use move_to::{DistanceSample, MoveToKind, MoveToManager, MoveToNode};
pub use movement_manager::{MoveTarget, Movement, MovementManager};
pub use params::{Approach, MovementFlags, MovementParameters, desired_heading};
pub use raw_state::{RawAxis, RawMotionState};
pub use weenie::{Character, MotionCallbacks};
