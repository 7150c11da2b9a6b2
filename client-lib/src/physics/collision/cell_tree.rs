//! The volume of an indoor cell (`spec/04-collision-primitives.md`, 10.8).
//!
//! A cell tree is a list of planes whose front sides bound a convex volume: the positive children from the root on. Negative children are
//! never visited and not kept; a leaf at the end counts as the zero plane.

use crate::math::{BoundingBox, EPSILON, Plane, Sidedness, Sphere, Vec3};

/// How much wider than its radius a sphere counts, m.
const CELL_MARGIN: f32 = 0.01;

/// How much of something is inside a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum BoundingType {
    /// Nothing.
    Outside = 0,
    /// Some of it.
    PartiallyInside = 1,
    /// All of it. A tree that ends in a leaf never answers so.
    EntirelyInside = 2,
}

/// Planes that bound the volume of a cell, in cell space; their normals point inwards.
#[derive(Debug, Clone, Default)]
pub struct CellTree {
    planes: Vec<Plane>,
}

impl CellTree {
    /// The volume in front of all `planes`; no planes bound nothing. `ends_in_leaf`: the chain ends in a leaf, not in a missing child.
    pub fn new(planes: impl IntoIterator<Item = Plane>, ends_in_leaf: bool) -> Self {
        let leaf = ends_in_leaf.then_some(Plane::ZERO);
        Self {
            planes: planes.into_iter().chain(leaf).collect(),
        }
    }

    /// The planes, and the zero plane for a leaf at the end.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Whether a point is inside (`point_inside_cell_bsp`); up to ε behind a plane still is.
    pub fn contains(&self, point: Vec3) -> bool {
        !self
            .planes
            .iter()
            .any(|p| p.which_side(point, EPSILON) == Sidedness::Negative)
    }

    /// How much of a sphere, grown by 1 cm, is inside (`sphere_intersects_cell_bsp`).
    pub fn intersects_sphere(&self, sphere: &Sphere) -> BoundingType {
        let reach = sphere.radius + CELL_MARGIN;
        let mut answer = BoundingType::EntirelyInside;
        for plane in &self.planes {
            let h = plane.distance(sphere.center);
            if h <= -reach {
                return BoundingType::Outside;
            }
            // NaN is partly inside.
            let inside = h >= reach;
            if !inside {
                answer = BoundingType::PartiallyInside;
            }
        }
        answer
    }

    /// Whether a box may reach inside (`box_intersects_cell_bsp`): no plane has all its corners behind.
    pub fn intersects_box(&self, bounds: &BoundingBox) -> bool {
        let corners = bounds.corners();
        !self.planes.iter().any(|plane| {
            corners
                .iter()
                .all(|&c| plane.which_side(c, EPSILON) == Sidedness::Negative)
        })
    }
}
