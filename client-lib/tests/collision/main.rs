//! Collision primitives: worked examples, invariants and hard cases of `spec/04-collision-primitives.md`, sections 16, 17 and 19.

mod examples;
mod hard_cases;
mod obstacles;
mod polygons;
mod records;
mod smoke;
mod soup;
mod stiff_cases;
mod support;
mod trees;
mod volumes;
