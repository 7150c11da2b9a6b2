//! Water of cells and blocks, and how deep a mover stands in it (`spec/02-terrain.md`, section 11).

use super::{TerrainBlock, VERTICES_PER_SIDE, terrain_type};
use crate::math::{CELL_LENGTH, CellId, Vec3};
use crate::profile::Profile;

/// How much of a cell or block is water.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
#[repr(u8)]
pub enum WaterType {
    /// No vertex.
    #[default]
    None = 0,
    /// Some vertices.
    Partial = 1,
    /// All vertices.
    Entire = 2,
}

/// How far below the triangle a mover stands: one of four depths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaterDepth {
    /// Dry cell.
    Zero,
    /// Dry part of a cell that has water.
    Damp,
    /// Flooded part of a cell that has dry land.
    Wading,
    /// Entirely flooded cell.
    Deep,
}

impl WaterDepth {
    /// Depth in metres.
    pub const fn metres(self) -> f32 {
        self.literal() as f32
    }

    /// The f64 literal that [`WaterDepth::metres`] is rounded from: one reference answers it before its callers narrow it (`02:B21`).
    pub const fn literal(self) -> f64 {
        match self {
            Self::Zero => 0.0,
            Self::Damp => 0.1,
            Self::Wading => 0.449_999_99,
            Self::Deep => 0.899_999_98,
        }
    }
}

/// Whether a terrain word's type is one of the five waters.
pub(super) const fn is_water(word: u16) -> bool {
    matches!(terrain_type(word), 16..=20)
}

impl WaterType {
    /// Water of a cell with these corner words.
    pub fn of_corners(corners: [u16; 4]) -> Self {
        match corners.iter().filter(|&&word| is_water(word)).count() {
            0 => Self::None,
            4 => Self::Entire,
            _ => Self::Partial,
        }
    }

    /// Water of a block with these cells.
    pub fn of_cells(cells: &[Self]) -> Self {
        if cells.iter().all(|&cell| cell == Self::None) {
            Self::None
        } else if cells.iter().all(|&cell| cell == Self::Entire) {
            Self::Entire
        } else {
            Self::Partial
        }
    }
}

impl TerrainBlock {
    /// Depth of the water in outdoor cell `index` (0..64) at a point (m, block space) (11.2).
    pub fn water_depth(&self, index: usize, point: Vec3, profile: &Profile) -> WaterDepth {
        match self.cell_water(index) {
            WaterType::None => WaterDepth::Zero,
            WaterType::Entire => WaterDepth::Deep,
            WaterType::Partial => self.nearest_vertex_depth(index, point, profile),
        }
    }

    /// `calc_water_depth`: the vertex nearest to the point decides. A point west or south of the block counts as nearer to the cell's own
    /// corner: the remainder is negative.
    fn nearest_vertex_depth(&self, index: usize, point: Vec3, profile: &Profile) -> WaterDepth {
        let half = CELL_LENGTH / 2.0;
        let beyond = |v: f32| {
            let rest = v % CELL_LENGTH;
            // C-16: exactly on the middle line.
            usize::from(if profile.water_middle_inclusive {
                rest >= half
            } else {
                rest > half
            })
        };
        let (column, row) = (index / 8 + beyond(point.x), index % 8 + beyond(point.y));
        let word = self.words().get(column * VERTICES_PER_SIDE + row);
        if word.is_some_and(|&word| is_water(word)) {
            WaterDepth::Wading
        } else {
            WaterDepth::Damp
        }
    }
}

/// Index of an outdoor cell in its block's arrays; `None` for ids that are no outdoor cell.
pub(super) const fn cell_index(id: CellId) -> Option<usize> {
    match id.low() {
        low @ 1..=64 => Some(low as usize - 1),
        _ => None,
    }
}
