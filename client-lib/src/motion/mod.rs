//! Motion: commands, motion states, motion interpreter, move-to (`spec/08-motion.md`).

mod movement_manager;

pub use movement_manager::MovementManager;
