//! Setups, part arrays, sequences, motion tables and hooks (`spec/07-animation.md`).
//!
//! A motion command that the motion interpreter has accepted becomes, through the motion table, a list of animations with frame ranges and
//! rates: the [`Sequence`]. Each quantum the sequence is advanced and yields two things: the *offset frame* (root motion in the object's own
//! axes, metres) and the *hooks* of the frames that were crossed. The [`PartArray`] places the parts by the pose of the current frame, and the
//! [`MotionTableManager`] counts ended animations to tell when a motion is done.
//!
//! Nothing here calls back into the object that animates. Hooks are queued into a list of the caller; finished motions are handed out one by
//! one by a [`CompletionRun`], so that what the object does about one of them happens before the next is looked at.

mod completion;
mod error;
mod hooks;
pub mod motion_class;
mod motion_player;
mod motion_state;
mod motion_table_manager;
mod node;
mod sequence;
mod sequence_update;
mod source;

mod part;
mod part_array;
mod placing;
mod simple_setup;

pub use completion::{CompletionRun, MotionNotice};
pub use error::{AnimationError, MotionTableError, PartArrayError};
pub use hooks::{AnimHookQueue, TimedHook, TimedHookKind, TimedValue, is_executed};
pub use motion_state::{MotionEntry, MotionState};
pub use motion_table_manager::{MotionRequest, MotionTableManager, PendingMotion};
pub use node::AnimSequenceNode;
pub use part::PhysicsPart;
pub use part_array::PartArray;
pub use sequence::{Placement, Sequence};
pub(crate) use simple_setup::simple_setup;
pub use source::AnimationSource;

#[cfg(test)]
pub(crate) mod fixtures;
#[cfg(test)]
mod tests;
