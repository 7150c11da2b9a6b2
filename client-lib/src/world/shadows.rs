//! Shadows: which objects must be tested in which cell (`spec/03-cells.md`, 8.4 and 8.9 to 8.15).

use super::landscape::Landscape;
use super::{CellHandle, World};
use crate::physics::body::{Body, ObjectRef, StaticId};
use crate::physics::transition::CellArray;
use crate::profile::{ListRemoval, Profile};

impl Landscape {
    /// Takes an object from the list of those that are tested in a cell (8.4). `C-05`: the last entry takes its place, or the order stays.
    pub fn remove_shadow(&mut self, cell: CellHandle, object: ObjectRef, profile: &Profile) {
        let Some(base) = self.base_mut(cell) else {
            return;
        };
        let Some(at) = base.shadows.iter().position(|&o| o == object) else {
            return;
        };
        if profile.list_removal == ListRemoval::SlotsReused {
            base.shadows.remove(at);
        } else {
            base.shadows.swap_remove(at);
        }
    }

    /// As [`remove_shadow`](Self::remove_shadow) and then [`add_shadow`](Self::add_shadow).
    pub fn renew_shadow(&mut self, cell: CellHandle, object: ObjectRef, profile: &Profile) {
        let Some(base) = self.base_mut(cell) else {
            return;
        };
        let shadows = &mut base.shadows;
        let Some(at) = shadows.iter().position(|&o| o == object) else {
            shadows.push(object);
            return;
        };
        if profile.list_removal == ListRemoval::SlotsReused {
            shadows[at..].rotate_left(1);
        } else {
            let last = shadows.len() - 1;
            shadows.swap(at, last);
        }
    }

    /// Takes back every shadow of an object (8.13, without children).
    pub fn remove_shadows(&mut self, object: ObjectRef, body: &mut Body, profile: &Profile) {
        for entry in body.shadows.drain(..) {
            if let Some(cell) = entry.cell {
                self.remove_shadow(cell, object, profile);
            }
        }
    }

    /// Throws a shadow into each cell of a list (8.12, without children). A cell that is not there gets a record that is in no list.
    pub fn add_shadows(&mut self, object: ObjectRef, body: &mut Body, cells: &CellArray) {
        for &entry in cells.entries() {
            if let Some(cell) = entry.cell {
                self.add_shadow(cell, object);
            }
            body.shadows.push(entry);
        }
    }

    /// The shadows of a static object become those of a list.
    pub(super) fn replace_static_shadows(
        &mut self,
        id: StaticId,
        cells: &CellArray,
        profile: &Profile,
    ) {
        let Some(mut object) = self.lend_static(id) else {
            return;
        };
        let own = ObjectRef::Static(id);
        self.remove_shadows(own, &mut object.body, profile);
        self.add_shadows(own, &mut object.body, cells);
        self.put_static(id, object);
    }
}

impl World {
    /// Finds the cells that a static object touches and throws its shadows there (`calc_cross_cells_static`, 8.10).
    pub(super) fn calc_cross_cells_static(&mut self, id: StaticId) {
        let Some(body) = self.land.static_body(id).cloned() else {
            return;
        };
        let mut cells = std::mem::take(&mut self.scratch.cells);
        self.with_loading(|land, profile, missing| {
            *missing = land.find_cells_of_body(&body, true, &mut cells, profile);
        });
        self.land.replace_static_shadows(id, &cells, &self.profile);
        self.scratch.cells = cells;
    }

    /// Cells that an object touches where it is, loading what is needed (`calc_cross_cells`, 8.9; the caller changes the shadows).
    pub fn cells_of_body(&mut self, body: &Body, cells: &mut CellArray) {
        self.with_loading(|land, profile, missing| {
            cells.cells.clear();
            cells.free_slots.clear();
            if !profile.cell_array_emptied {
                // C-01: the array of an object is never emptied; its shadows are what was in it last.
                cells.cells.extend(body.shadows.iter().copied());
            }
            *missing = land.find_cells_of_body(body, false, cells, profile);
        });
    }
}
