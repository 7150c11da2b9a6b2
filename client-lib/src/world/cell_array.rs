//! Lists of cells under construction (`spec/03-cells.md`, 6.8).

use crate::math::CellId;
use crate::physics::transition::{CellArray, CellArrayEntry};
use crate::profile::{ListRemoval, Profile};
use crate::world::CellHandle;

/// What stands in a slot whose entry was removed, where slots are reused (`C-03`). No cell has this id.
const FREED: CellArrayEntry = CellArrayEntry {
    id: CellId::NONE,
    cell: None,
};

impl CellArray {
    /// Begins a new list in the same array; the memory stays, and under `C-01` the old entries too.
    pub fn start(&mut self, profile: &Profile) {
        self.added_outside = false;
        if profile.cell_array_emptied {
            self.cells.clear();
            self.free_slots.clear();
        }
    }

    /// Begins the list of a static object: it does not reach what its start cell does not see.
    pub fn reset_static(&mut self, profile: &Profile) {
        self.start(profile);
        self.do_not_load_cells = true;
    }

    /// Begins the list of an object that moves.
    pub fn reset_dynamic(&mut self, profile: &Profile) {
        self.start(profile);
        self.do_not_load_cells = false;
    }

    /// Appends a cell unless its id is there.
    pub fn add_cell(&mut self, id: CellId, cell: Option<CellHandle>) {
        if self.cells.iter().any(|entry| entry.id == id) {
            return;
        }
        let entry = CellArrayEntry { id, cell };
        match self.free_slots.pop() {
            Some(slot) if (slot as usize) < self.cells.len() => self.cells[slot as usize] = entry,
            _ => self.cells.push(entry),
        }
    }

    /// Entries in test order.
    pub fn entries(&self) -> impl Iterator<Item = &CellArrayEntry> {
        self.cells.iter().filter(|entry| !entry.id.is_none())
    }

    /// Keeps the entries that `keep` wants; how the others leave is `C-03`.
    pub(super) fn filter(&mut self, profile: &Profile, keep: impl Fn(CellId) -> bool) {
        match profile.list_removal {
            ListRemoval::StableArrayLastFills => self.cells.retain(|entry| keep(entry.id)),
            ListRemoval::SlotsReused => {
                for (slot, entry) in self.cells.iter_mut().enumerate() {
                    if !entry.id.is_none() && !keep(entry.id) {
                        *entry = FREED;
                        self.free_slots.push(slot as u32);
                    }
                }
            }
            ListRemoval::LastFills => {
                let mut at = 0;
                while at < self.cells.len() {
                    if !keep(self.cells[at].id) {
                        // The entry that fills the hole is not looked at.
                        self.cells.swap_remove(at);
                    }
                    at += 1;
                }
            }
        }
    }
}
