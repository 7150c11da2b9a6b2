//! The part array: skeleton, parts with their collision shapes, and the animation that moves them (`spec/07-animation.md`, 6).

/// Skeleton and parts of one object.
#[derive(Debug, Clone)]
pub struct PartArray {}
