//! The movement manager (`spec/08-motion.md`, section 10).

/// Owns the motion interpreter and the move-to manager of one object.
#[derive(Debug, Clone, Default)]
pub struct MovementManager {}
