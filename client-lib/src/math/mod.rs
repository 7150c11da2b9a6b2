//! Mathematics of the client: vectors, quaternions, frames, headings, planes, boxes, cell ids and positions.
//!
//! Everything is `f32`, rounded per operation, left to right, without fused multiply-add. Trigonometric functions are the `f64` function of
//! one pure-Rust library, rounded once, so that results are the same on every platform. Lengths are metres, headings are compass degrees,
//! rotations are radians. Axes: +X east, +Y north, +Z up; an object's forward direction is its local +Y.
//!
//! Source: `spec/01-math-and-positions.md`.

mod bounds;
mod cell_id;
mod frame;
mod heading;
mod plane;
mod position;
mod quat;
mod round;
pub mod trig;
pub mod vector;

pub use bounds::BoundingBox;
pub use cell_id::{
    BLOCK_CELL_ID, BLOCK_LENGTH, CELL_LENGTH, CellId, Direction, LAND_CELLS, LANDBLOCK_INFO_ID,
    LandCoord, block_offset,
};
pub use frame::Frame;
pub use glam::{Vec2, Vec3};
pub use heading::{heading_of_position_offset, heading_of_vector};
pub use plane::{Plane, Ray, Sidedness, Sphere};
pub use position::{Position, UprightCylinder};
pub use quat::Quat;
pub use round::{floor, floor64};
pub use vector::EPSILON;
