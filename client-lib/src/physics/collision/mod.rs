//! Collision primitives: polygons, spheres, cylinder-spheres and BSP trees (`spec/04-collision-primitives.md`).

mod polygon;
mod shape;

pub use polygon::Polygon;
pub use shape::GfxShape;
