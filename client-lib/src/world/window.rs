//! The window of landblocks around the player that the client shows (`spec/02-terrain.md`, 13; `spec/03-cells.md`, 17; retail `LScape`).
//!
//! The window decides what is drawn at which level of detail, and what is brought in and released as the player moves. It is a plan only:
//! physics loads what it needs whatever the window says, so no result depends on it.

use super::terrain::Detail;
use crate::math::CellId;

/// Blocks from the middle to the border of the window.
const DEFAULT_RADIUS: i32 = 5;
/// Blocks along one side of the map.
const MAP_BLOCKS: i32 = 255;

/// A block of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WindowBlock {
    /// Id with cell part 0xFFFF.
    pub id: CellId,
    /// How finely its terrain is to be drawn.
    pub detail: Detail,
}

/// What a new load point asks for; lists are in window order, columns from the west, each from the south.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LoadPlan {
    /// Blocks that entered the window.
    pub enter: Vec<CellId>,
    /// Blocks that left it.
    pub leave: Vec<CellId>,
    /// Blocks whose level of detail is new, those that entered included.
    pub detail: Vec<WindowBlock>,
}

/// Landblocks around the load point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LandscapeWindow {
    pub(crate) radius: i32,
    /// Index `x * width + y`, x eastwards; empty off the map. No entries: no window.
    pub(crate) slots: Vec<Option<WindowBlock>>,
    pub(crate) load_point: CellId,
}

impl Default for LandscapeWindow {
    fn default() -> Self {
        Self {
            radius: DEFAULT_RADIUS,
            slots: Vec::new(),
            load_point: CellId::NONE,
        }
    }
}

impl LandscapeWindow {
    /// Sets the radius in blocks, at least 1; refused while there are blocks.
    pub fn set_radius(&mut self, radius: i32) -> bool {
        if !(1..MAP_BLOCKS).contains(&radius) || !self.slots.is_empty() {
            return false;
        }
        self.radius = radius;
        true
    }

    /// Blocks along one side.
    pub fn width(&self) -> i32 {
        2 * self.radius + 1
    }

    /// The cell that the window is centred on.
    pub fn load_point(&self) -> CellId {
        self.load_point
    }

    /// Blocks of the window in its order.
    pub fn blocks(&self) -> impl Iterator<Item = &WindowBlock> {
        self.slots.iter().flatten()
    }

    /// The block of any of its cells, if it is in the window.
    pub fn block(&self, cell: CellId) -> Option<&WindowBlock> {
        if self.slots.is_empty() {
            return None;
        }
        let x = cell.block_x() - self.load_point.block_x() + self.radius;
        let y = cell.block_y() - self.load_point.block_y() + self.radius;
        let inside = 0..self.width();
        if !inside.contains(&x) || !inside.contains(&y) {
            return None;
        }
        self.slots.get((x * self.width() + y) as usize)?.as_ref()
    }

    /// Centres the window on a cell, or closes it for [`CellId::NONE`] (13.2, 13.3).
    pub fn update_load_point(&mut self, cell: CellId) -> LoadPlan {
        let before = Self {
            radius: self.radius,
            slots: std::mem::take(&mut self.slots),
            load_point: self.load_point,
        };
        self.load_point = cell;
        if !cell.is_none() {
            self.slots = self.centred();
        }
        let mut plan = LoadPlan::default();
        for block in self.blocks() {
            let old = before.block(block.id);
            if old.is_none() {
                plan.enter.push(block.id);
            }
            if old.map(|old| old.detail) != Some(block.detail) {
                plan.detail.push(*block);
            }
        }
        let gone = before.blocks().filter(|b| self.block(b.id).is_none());
        plan.leave.extend(gone.map(|b| b.id));
        plan
    }

    fn centred(&self) -> Vec<Option<WindowBlock>> {
        let r = self.radius;
        let mut slots = Vec::with_capacity((self.width() * self.width()) as usize);
        for dx in -r..=r {
            for dy in -r..=r {
                let (x, y) = (
                    self.load_point.block_x() + dx,
                    self.load_point.block_y() + dy,
                );
                let on_map = (0..MAP_BLOCKS).contains(&x) && (0..MAP_BLOCKS).contains(&y);
                slots.push(on_map.then(|| WindowBlock {
                    id: CellId(((x << 24) | (y << 16) | 0xFFFF) as u32),
                    detail: Detail::at_offset(dx, dy),
                }));
            }
        }
        slots
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cell(x: u32, y: u32) -> CellId {
        CellId(x << 24 | y << 16 | 1)
    }

    #[test]
    fn a_step_brings_one_row() {
        let mut window = LandscapeWindow::default();
        assert_eq!(window.update_load_point(cell(100, 100)).enter.len(), 121);
        assert!(!window.set_radius(3), "refused while there are blocks");
        let plan = window.update_load_point(cell(101, 100));
        assert_eq!((plan.enter.len(), plan.leave.len()), (11, 11));
        assert!(plan.enter.iter().all(|b| b.block_x() == 106));
        assert_eq!(
            window.update_load_point(cell(101, 100)),
            LoadPlan::default()
        );
        let full = window.blocks().filter(|b| b.detail.scale.cells() == 1);
        assert_eq!(full.count(), 9);
        assert_eq!(window.update_load_point(CellId::NONE).leave.len(), 121);
        assert!(window.set_radius(1));
    }

    #[test]
    fn slots_off_the_map_are_empty() {
        let mut window = LandscapeWindow::default();
        assert_eq!(window.update_load_point(cell(0, 254)).enter.len(), 36);
        assert!(window.block(cell(250, 254)).is_none());
    }

    proptest! {
        /// A window does not depend on how it got where it is.
        #[test]
        fn history_leaves_no_trace(points in prop::collection::vec((0_u32..255, 0_u32..255), 1..8)) {
            let mut moved = LandscapeWindow::default();
            for &(x, y) in &points {
                moved.update_load_point(cell(x, y));
            }
            let mut fresh = LandscapeWindow::default();
            let &(x, y) = points.last().unwrap();
            fresh.update_load_point(cell(x, y));
            prop_assert_eq!(moved, fresh);
        }
    }
}
