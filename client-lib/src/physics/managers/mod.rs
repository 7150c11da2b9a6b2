//! Managers of an object's position and targets (`spec/06-physics-object.md`, part F).
//!
//! The position manager changes the offset of a quantum after the animation and before the integration: interpolation towards positions the
//! server sent, then sticking to a target, then the constraint. Its three parts are plain data and functions of explicit inputs; what they
//! need of the world is gathered by methods of [`Entity`](crate::entity::Entity).

mod constraint;
mod interpolation;
mod object;
mod position;
mod sticky;
mod target;

pub use constraint::ConstraintManager;
pub use interpolation::{
    Blip, Follow, InterpolateOutcome, InterpolationManager, InterpolationNode, NodeKind,
};
pub use position::PositionManager;
pub use sticky::{StickyManager, StickyPull};
pub use target::{TargetInfo, TargetManager, TargetStatus, Voyeur};

#[cfg(test)]
mod tests;
