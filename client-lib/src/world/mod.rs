//! The world: landblocks, terrain, cells, static objects, and the entities in them.

pub mod terrain;
#[allow(
    clippy::module_inception,
    reason = "the type World lives in the file of its name"
)]
mod world;

pub use world::{CellHandle, Clock, World};
