//! The world: landblocks, terrain, cells, static objects, and the entities in them.

mod random;
mod resources;
mod scratch;
pub mod terrain;
#[allow(
    clippy::module_inception,
    reason = "the type World lives in the file of its name"
)]
mod world;

pub use random::Random;
pub use resources::Resources;
pub use scratch::Scratch;
pub use world::{CellHandle, Clock, World};
