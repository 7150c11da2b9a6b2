//! Collision polygons (`spec/04-collision-primitives.md`, 3.1 and 7).

use crate::math::{Plane, Vec3};

/// A convex, flat polygon in the space of its owner.
#[derive(Debug, Clone)]
pub struct Polygon {
    /// Plane of the polygon.
    pub plane: Plane,
    /// Corners in order.
    pub vertices: Vec<Vec3>,
}
