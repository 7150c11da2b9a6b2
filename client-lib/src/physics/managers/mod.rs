//! Managers of an object's position and targets (`spec/06-physics-object.md`, part F).

mod position;
mod target;

pub use position::PositionManager;
pub use target::TargetManager;
