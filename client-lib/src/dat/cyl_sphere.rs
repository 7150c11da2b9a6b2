//! An upright cylinder as collision shape. Source: `spec/11-dat-files.md, 4`, `spec/04-collision-primitives.md, 3.2`.

use serde::Serialize;

use crate::math::Vec3;

/// An upright cylinder; metres, in the owner's space. Its axis is the world's +Z whatever the orientation of the owner.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct CylSphere {
    /// Centre of the bottom disc.
    pub low: Vec3,
    /// Radius.
    pub radius: f32,
    /// Height above `low`.
    pub height: f32,
}
