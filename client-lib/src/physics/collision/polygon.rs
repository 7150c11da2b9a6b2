//! Collision polygons (`spec/04-collision-primitives.md`, 3.1 and 7).
//!
//! A [`Polygon`] is a view: the plane by value, the corners borrowed from whoever owns them (a shape's pool, a terrain triangle). Everything is
//! in the owner's space, metres. Polygons are one-sided by movement, not by their sides type: see [`Polygon::pos_hits_sphere`].

use crate::math::{Plane, Vec3};

/// A convex, flat polygon in the space of its owner.
#[derive(Debug, Clone, Copy)]
pub struct Polygon<'a> {
    /// Plane of the polygon, as [`make_plane`] gives it; NaN for a degenerate polygon, which nothing ever hits.
    pub plane: Plane,
    /// Corners, counter-clockwise seen from the side that the normal points to.
    pub vertices: &'a [Vec3],
    /// Rays from behind pass (sides type 0).
    pub single_sided: bool,
}
