//! Collision primitives: polygons, spheres, cylinder-spheres and BSP trees, and the shapes that own them
//! (`spec/04-collision-primitives.md`).
//!
//! Tests of polygons, nodes and boxes are pure. What an obstacle does to a mover is written to the records of the running
//! [`Transition`](crate::physics::transition::Transition). No primitive allocates; searches of trees are bounded by [`MAX_TREE_DEPTH`].

mod cell_tree;
mod cyl_sphere;
mod from_dat;
mod physics_tree;
mod polygon;
mod polygon_list;
mod shape;
mod sphere;
mod tree_collision;

pub use crate::dat::CylSphere;
pub use cell_tree::{BoundingType, CellTree};
pub use cyl_sphere::CylinderNormal;
pub use physics_tree::{
    MAX_TREE_DEPTH, PhysicsTree, PolygonIndex, SolidSearch, SourceNode, TouchedPolygon, TreeError,
    WalkableSearch,
};
pub use polygon::{PlacementSolidity, Polygon, make_plane};
pub use polygon_list::PolygonList;
pub use shape::{CellShape, GfxShape, PlacedPart, find_part_collisions};
pub use sphere::{LANDING_Z, collides_with_sphere, find_time_of_collision};
