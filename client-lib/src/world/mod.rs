//! The world: landblocks, terrain, cells, static objects, and the entities in them.
//!
//! A [`Landscape`] holds what is loaded of the map. Outdoor cells come 64 at a time with their landblock, indoor cells one by one; both are
//! named by a [`CellHandle`] while they are loaded, and found by id without hashing. Reading never loads: see [`landscape`].
//!
//! Source: `spec/02-terrain.md`, `spec/03-cells.md`.

mod adjust;
mod cell;
mod cell_array;
mod cell_collision;
mod cell_list;
mod cell_list_memo;
mod dat_source;
#[doc(hidden)]
pub mod fuzzing;
pub mod landscape;
mod loading;
mod random;
mod release;
mod resources;
mod room_volume;
mod scratch;
mod shadows;
mod source;
mod statics;
mod streaming;
pub mod terrain;
pub mod window;
#[allow(
    clippy::module_inception,
    reason = "the type World lives in the file of its name"
)]
mod world;

pub use cell::{
    BuildingPortal, CellBase, CellPortal, CellRef, EnvCell, LandCell, LandCellRef, PortalTarget,
};
pub use cell_list::{CellListOutcome, SpheresAt};
pub use cell_list_memo::CellListMemo;
pub use landscape::{Demand, LandBlock, Landscape, Missing};
pub use random::Random;
pub use resources::{LoadError, Resources};
pub use room_volume::{Quick, RoomVolume};
pub use scratch::Scratch;
pub use source::{Lookup, MemorySource, WorldSource};
pub use statics::{StaticKind, StaticObject};
pub use streaming::Streaming;
pub use world::{CellHandle, Clock, World};

#[cfg(test)]
mod tests;
