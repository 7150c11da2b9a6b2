//! Terrain of one landblock: vertices, triangles, water and roads (`spec/02-terrain.md`, sections 4 to 11 and 14).
//!
//! A landblock is 192 m square. Its record gives 9 x 9 vertices, each with an index into the region's height table and a terrain word; every
//! 24 m square is cut into two triangles along one diagonal that a hash of its place decides. Heights are those of the triangle's plane:
//! there is no interpolation anywhere.
//!
//! Arrays of 81 entries use index `9 i + j`, i eastwards, j northwards; cells use `8 x + y`, which is the cell number of the id minus one.
//! All coordinates are metres in the landblock's own space.

mod block;
mod detail;
mod height_table;
mod road;
pub mod scenery;
mod split;
mod water;

pub use block::{TerrainBlock, TerrainVertices, Triangle};
pub use detail::{Detail, DetailScale};
pub use height_table::HeightTable;
pub use road::on_road;
pub use split::is_sw_to_ne_cut;
pub use water::{WaterDepth, WaterType};

/// Vertices along one side of a landblock at full detail.
pub const VERTICES_PER_SIDE: usize = 9;
/// Vertices of a landblock at full detail.
pub const VERTICES: usize = VERTICES_PER_SIDE * VERTICES_PER_SIDE;
/// Outdoor cells along one side of a landblock.
pub const CELLS_PER_SIDE: usize = 8;
/// Outdoor cells of a landblock.
pub const CELLS: usize = CELLS_PER_SIDE * CELLS_PER_SIDE;

/// Terrain type 0..=31 of a terrain word (3.2).
pub const fn terrain_type(word: u16) -> u8 {
    (word >> 2 & 0x1F) as u8
}

/// Scene type index 0..=31 of a terrain word, within its terrain type (3.2).
pub const fn scene_type(word: u16) -> u8 {
    (word >> 11) as u8
}

/// Whether a terrain word has a road at its vertex (3.2).
pub const fn is_road(word: u16) -> bool {
    word & 0x3 != 0
}
