//! Cell ids and the landblock grid (`spec/01`, section 10; retail name `LandDefs`).

use core::fmt;

use super::Vec3;
use super::round::floor;
use super::vector::EPSILON;
use crate::profile::{OffMap, Profile};

/// Side of an outdoor cell, m.
pub const CELL_LENGTH: f32 = 24.0;
/// Side of a landblock, m.
pub const BLOCK_LENGTH: f32 = 192.0;
/// Outdoor cells along one side of the map.
pub const LAND_CELLS: i32 = 2040;
/// Cell part of the id of a landblock record, and of the block as such.
pub const BLOCK_CELL_ID: u32 = 0xFFFF;
/// Cell part of the id of a landblock-info record.
pub const LANDBLOCK_INFO_ID: u32 = 0xFFFE;

/// Id of a cell: landblock x in bits 31..24, landblock y in bits 23..16, cell in the low 16 bits. 0 is "no cell".
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct CellId(pub u32);

/// Global coordinates of an outdoor cell ("lcoord"): cells from the south-west corner of the map, each in 0..2040 on the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LandCoord {
    /// Eastwards.
    pub x: i32,
    /// Northwards.
    pub y: i32,
}

/// Where a block lies as seen from another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Direction {
    Inside = 0,
    North = 1,
    South = 2,
    East = 3,
    West = 4,
    NorthWest = 5,
    SouthWest = 6,
    NorthEast = 7,
    SouthEast = 8,
    Unknown = 9,
}

impl LandCoord {
    /// Whether the cell is on the map.
    #[inline]
    pub const fn in_bounds(self) -> bool {
        self.x >= 0 && self.y >= 0 && self.x < LAND_CELLS && self.y < LAND_CELLS
    }

    /// Id of the outdoor cell; [`CellId::NONE`] off the map (`lcoord_to_gid`).
    #[inline]
    pub const fn cell_id(self) -> CellId {
        if !self.in_bounds() {
            return CellId::NONE;
        }
        let block = ((self.x >> 3) << 8) | (self.y >> 3);
        let cell = 1 + ((self.x & 7) << 3) + (self.y & 7);
        CellId(((block << 16) | cell) as u32)
    }

    /// Id of the block that the cell lies in, with cell part 0xFFFF; [`CellId::NONE`] off the map (`get_block_gid`).
    pub const fn block_id(self) -> CellId {
        match self.cell_id() {
            CellId::NONE => CellId::NONE,
            id => CellId(id.0 | BLOCK_CELL_ID),
        }
    }
}

impl CellId {
    /// No cell.
    pub const NONE: Self = Self(0);

    /// Whether this is no cell at all.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// The cell part.
    #[inline]
    pub const fn low(self) -> u32 {
        self.0 & 0xFFFF
    }

    /// The landblock part, shifted down: x in the high byte, y in the low byte.
    #[inline]
    pub const fn block(self) -> u16 {
        (self.0 >> 16) as u16
    }

    /// Landblock column, from the west.
    #[inline]
    pub const fn block_x(self) -> i32 {
        (self.0 >> 24) as i32
    }

    /// Landblock row, from the south.
    #[inline]
    pub const fn block_y(self) -> i32 {
        ((self.0 >> 16) & 0xFF) as i32
    }

    /// The id with another cell part.
    #[inline]
    pub const fn with_low(self, low: u32) -> Self {
        Self((self.0 & 0xFFFF_0000) | low)
    }

    /// Whether both ids name the same landblock.
    #[inline]
    pub const fn same_block(self, rhs: Self) -> bool {
        self.block() == rhs.block()
    }

    /// Whether the cell part is that of an indoor cell; 0xFFFF counts (`spec/01`, 10.1).
    #[inline]
    pub const fn is_indoor(self) -> bool {
        self.low() >= 0x100
    }

    /// Whether the cell part is one that exists.
    #[inline]
    pub const fn cell_in_range(self) -> bool {
        matches!(self.low(), 1..=0x40 | 0x100..=0xFFFD | 0xFFFF)
    }

    /// Coordinates of the block's first cell, also off the map.
    #[inline]
    pub const fn block_corner(self) -> LandCoord {
        LandCoord {
            x: self.block_x() * 8,
            y: self.block_y() * 8,
        }
    }

    /// Coordinates of the block's first cell (`blockid_to_lcoord`); `None` off the map.
    #[inline]
    pub const fn block_coord(self) -> Option<LandCoord> {
        let c = self.block_corner();
        if c.x >= LAND_CELLS || c.y >= LAND_CELLS {
            None
        } else {
            Some(c)
        }
    }

    /// Whether the cell part is in range and the block's column is on the map. The row is not checked, as in the retail client.
    pub const fn is_inbound_valid(self) -> bool {
        self.cell_in_range() && self.block_x() * 8 < LAND_CELLS
    }

    /// Coordinates of an outdoor cell (`gid_to_lcoord`); `None` for indoor ids and off the map.
    #[inline]
    pub const fn land_coord(self) -> Option<LandCoord> {
        if !self.is_inbound_valid() || self.is_indoor() {
            return None;
        }
        let c = self.low() as i32 - 1;
        let coord = LandCoord {
            x: self.block_x() * 8 + (c >> 3),
            y: self.block_y() * 8 + (c & 7),
        };
        if coord.in_bounds() { Some(coord) } else { None }
    }

    /// Coordinates of the outdoor cell at a landblock-local point (m) of this id's block, also for indoor ids (`get_outside_lcoord`).
    ///
    /// A block off the map fails, except where the profile computes on and the point may come back in range (`01:L3`).
    pub fn outside_coord(self, x: f32, y: f32, profile: &Profile) -> Option<LandCoord> {
        if !self.cell_in_range() {
            return None;
        }
        let base = match profile.off_map {
            OffMap::ComputesOn => self.block_corner(),
            OffMap::None | OffMap::Fails => self.block_coord()?,
        };
        let (cx, cy) = (floor(x / CELL_LENGTH), floor(y / CELL_LENGTH));
        // NaN and points beyond the map's size fail before they become integers.
        let limit = LAND_CELLS as f32;
        if !(cx.abs() <= limit && cy.abs() <= limit) {
            return None;
        }
        let coord = LandCoord {
            x: base.x + cx as i32,
            y: base.y + cy as i32,
        };
        coord.in_bounds().then_some(coord)
    }

    /// The outdoor cell at a landblock-local point that may have left its block, with the point re-based to the new block
    /// (`adjust_to_outside`, 10.4). On failure the id is [`CellId::NONE`] and the point keeps only the snap to zero.
    pub fn adjust_to_outside(self, loc: Vec3, profile: &Profile) -> (Self, Vec3) {
        if !self.cell_in_range() {
            return (Self::NONE, loc);
        }
        let mut loc = loc;
        if loc.x.abs() < EPSILON {
            loc.x = 0.0;
        }
        if loc.y.abs() < EPSILON {
            loc.y = 0.0;
        }
        let Some(coord) = self.outside_coord(loc.x, loc.y, profile) else {
            return (Self::NONE, loc);
        };
        loc.x -= floor(loc.x / BLOCK_LENGTH) * BLOCK_LENGTH;
        loc.y -= floor(loc.y / BLOCK_LENGTH) * BLOCK_LENGTH;
        (coord.cell_id(), loc)
    }

    /// [`block_offset`] as a profile answers it: `None` where the reference throws (`04:A6`, `01:L1`), which it does for different blocks one of
    /// which is off the map (column or row 0xFF). Cells that are loaded are on the map, so movement never asks for such an offset.
    pub fn block_offset_to(self, to: Self, profile: &Profile) -> Option<Vec3> {
        let on_map = self.block_coord().is_some() && to.block_coord().is_some();
        let fails = profile.off_map == OffMap::Fails && !self.same_block(to) && !on_map;
        (!fails).then(|| block_offset(self, to))
    }

    /// Direction of another block as seen from this one, by the signs of the block differences.
    pub const fn direction_to(self, other: Self) -> Direction {
        let (dx, dy) = (
            other.block_x() - self.block_x(),
            other.block_y() - self.block_y(),
        );
        match (dx.signum(), dy.signum()) {
            (0, 0) => Direction::Inside,
            (0, 1) => Direction::North,
            (0, -1) => Direction::South,
            (1, 0) => Direction::East,
            (-1, 0) => Direction::West,
            (-1, 1) => Direction::NorthWest,
            (-1, -1) => Direction::SouthWest,
            (1, 1) => Direction::NorthEast,
            (1, -1) => Direction::SouthEast,
            _ => Direction::Unknown,
        }
    }
}

impl fmt::Debug for CellId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:08X}", self.0)
    }
}

impl fmt::Display for CellId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// Vector (m) from the south-west corner of `from`'s block to that of `to`'s block; no bounds check (10.5).
///
/// Profile `ace` fails for a block off the map: see [`CellId::block_offset_to`].
#[inline]
pub fn block_offset(from: CellId, to: CellId) -> Vec3 {
    if from.same_block(to) {
        return Vec3::ZERO;
    }
    let cells = |d: i32| (d * 8) as f32 * CELL_LENGTH;
    Vec3::new(
        cells(to.block_x() - from.block_x()),
        cells(to.block_y() - from.block_y()),
        0.0,
    )
}
