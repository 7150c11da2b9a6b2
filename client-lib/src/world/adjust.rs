//! The right cell for a place (`spec/03-cells.md`, 8.20; retail `AdjustPosition`).

use super::cell::CellRef;
use super::landscape::{Landscape, Missing};
use super::{CellHandle, World};
use crate::math::{CellId, Position, Vec3};
use crate::profile::Profile;

/// First and last number of an indoor cell.
const ROOMS: std::ops::RangeInclusive<u32> = 0x100..=0xFFFD;

impl Landscape {
    /// Finds the cell of a position and corrects its id: outdoors by place, indoors by containment of `low_point` (m, the object's own space;
    /// callers pass the first sphere's centre). `search` looks through the cells visible from there instead of the neighbours only. `None` if
    /// there is no such cell; the position may have been moved out into the open then.
    pub fn adjust_position(
        &self,
        position: &mut Position,
        low_point: Vec3,
        search: bool,
        profile: &Profile,
        missing: &mut Missing,
    ) -> Option<CellHandle> {
        if !position.cell.cell_in_range() {
            return None;
        }
        if !position.cell.is_indoor() {
            position.adjust_to_outside(profile);
            return self.visible(position.cell, false, missing);
        }
        let start = self.visible(position.cell, false, missing)?;
        let point = position.frame.local_to_global(low_point, profile);
        let found = self
            .find_visible_child_cell(start, point, search, profile, missing)
            .or_else(|| self.search_block(position.cell, point, profile, missing));
        if let Some(cell) = found {
            position.cell = self.cell_id(cell);
            return found;
        }
        if !self.env_cell(start)?.seen_outside {
            return None;
        }
        position.adjust_to_outside(profile);
        self.visible(position.cell, false, missing)
    }

    /// `C-25`: one reference looks through all indoor cells of the block.
    fn search_block(
        &self,
        block: CellId,
        point: Vec3,
        profile: &Profile,
        missing: &mut Missing,
    ) -> Option<CellHandle> {
        if !profile.search_block_for_cell {
            return None;
        }
        ROOMS
            .map(|low| block.with_low(low))
            .take_while(|id| self.source.has_cell_record(id.0))
            .filter_map(|id| self.visible(id, false, missing))
            .find(|&handle| {
                self.env_cell(handle)
                    .is_some_and(|env| self.point_in_cell(CellRef::Env(env), point, profile))
            })
    }

    /// Height of the terrain (m) below or above a place; `None` if the block is not loaded.
    pub fn terrain_height(&self, position: &Position, profile: &Profile) -> Option<f32> {
        let (cell, origin) = position
            .cell
            .adjust_to_outside(position.frame.origin, profile);
        self.block(cell)?.terrain.height_at(origin, profile)
    }
}

impl World {
    /// As [`Landscape::adjust_position`], loading what it needs.
    pub fn adjust_position(
        &mut self,
        position: &mut Position,
        low_point: Vec3,
        search: bool,
    ) -> Option<CellHandle> {
        let given = *position;
        self.with_loading(|land, profile, missing| {
            *position = given;
            land.adjust_position(position, low_point, search, profile, missing)
        })
    }
}
