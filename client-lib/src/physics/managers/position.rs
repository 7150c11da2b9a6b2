//! The position manager (F1).

/// Interpolation, sticky and constraint managers of one object.
#[derive(Debug, Clone, Default)]
pub struct PositionManager {}
