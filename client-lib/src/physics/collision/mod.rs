//! Collision primitives: polygons, spheres, cylinder-spheres and BSP trees (`spec/04-collision-primitives.md`).

mod polygon;

pub use polygon::Polygon;
