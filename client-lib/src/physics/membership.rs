//! Cell membership and shadows of an entity (`spec/06-physics-object.md`, D1, D2).
//!
//! An object is *in* one cell (its home cell lists it) and throws a *shadow* into every cell whose contents must test it. The lists belong to
//! the cells; here is the object's side: which cells, and in which order they are told.

use crate::entity::{Child, Entity};
use crate::math::CellId;
use crate::physics::body::EntityId;
use crate::physics::state::PhysicsState;
use crate::physics::transition::{CellArray, CellArrayEntry};
use crate::profile::LeaveCell;
use crate::world::{CellHandle, World};

/// Children may carry children; a chain longer than this is a cycle and is cut.
pub(crate) const MAX_ATTACHMENT_DEPTH: u32 = 32;

impl Entity {
    /// Runs `f` on every child in order. A child that is taken out at the moment is skipped.
    pub(crate) fn for_each_child(
        &self,
        world: &mut World,
        mut f: impl FnMut(&mut Self, &mut World, &Child),
    ) {
        for index in 0..self.children.len() {
            let child = self.children[index];
            world.with_entity(child.object, |c, world| f(c, world, &child));
        }
    }

    /// Enters a cell with all children (`enter_cell`). An object without a part array stays where it is.
    pub(crate) fn enter_cell(&mut self, cell: CellHandle, world: &mut World) {
        self.enter_cell_at_depth(cell, world, 0);
    }

    fn enter_cell_at_depth(&mut self, cell: CellHandle, world: &mut World, depth: u32) {
        if self.body.part_array.is_none() || depth > MAX_ATTACHMENT_DEPTH {
            return;
        }
        world.land.add_object(cell, self.object_ref());
        self.for_each_child(world, |child, world, _| {
            child.enter_cell_at_depth(cell, world, depth + 1);
        });
        self.set_cell_id(world.land.cell_id(cell));
        self.body.cell = Some(cell);
    }

    /// Leaves the cell with all children (`leave_cell`). While changing cells the old cell is kept as the current one.
    pub(crate) fn leave_cell(&mut self, is_changing: bool, world: &mut World) {
        self.leave_cell_at_depth(is_changing, world, 0);
    }

    fn leave_cell_at_depth(&mut self, is_changing: bool, world: &mut World, depth: u32) {
        let Some(cell) = self.body.cell else { return };
        if depth > MAX_ATTACHMENT_DEPTH {
            return;
        }
        world.land.remove_object(cell, self.object_ref());
        self.for_each_child(world, |child, world, _| {
            child.leave_cell_at_depth(is_changing, world, depth + 1);
        });
        if !is_changing || world.profile.leave_cell == LeaveCell::AlwaysClears {
            self.body.cell = None;
        }
    }

    /// Moves to another cell, or out of all cells (`change_cell`).
    pub(crate) fn change_cell(&mut self, cell: Option<CellHandle>, world: &mut World) {
        if self.body.cell.is_some() {
            self.leave_cell(true, world);
        }
        match cell {
            Some(cell) => self.enter_cell(cell, world),
            None => {
                self.set_cell_id(CellId::NONE);
                self.body.cell = None;
            }
        }
    }

    /// Writes the cell id of the position and, but for particle emitters, of the parts.
    pub(crate) fn set_cell_id(&mut self, id: CellId) {
        self.body.position.cell = id;
        let emitter = self.body.state.contains(PhysicsState::PARTICLE_EMITTER);
        if let Some(parts) = self.body.part_array.as_mut().filter(|_| !emitter) {
            parts.set_cell_id(id);
        }
    }

    /// Takes back all shadows and throws new ones into the cells of a list. Into the same cells again they only go to the end of the lists.
    pub(crate) fn move_shadows_to_cells(&mut self, cells: &CellArray, world: &mut World) {
        let stays = self.children.is_empty()
            && !self.body.state.contains(PhysicsState::PARTICLE_EMITTER)
            && cells.entries().eq(&self.body.shadows);
        if !stays {
            self.remove_shadows_from_cells(world);
            self.add_shadows_to_cells(cells, world);
            return;
        }
        let object = self.object_ref();
        for cell in self.body.shadows.iter().filter_map(|entry| entry.cell) {
            world.land.renew_shadow(cell, object, &world.profile);
        }
    }

    /// Throws one shadow into each cell of the list, children included (`add_shadows_to_cells`).
    pub(crate) fn add_shadows_to_cells(&mut self, cells: &CellArray, world: &mut World) {
        self.add_shadows_at_depth(cells, world, 0);
    }

    fn add_shadows_at_depth(&mut self, cells: &CellArray, world: &mut World, depth: u32) {
        if depth > MAX_ATTACHMENT_DEPTH {
            return;
        }
        if self.body.state.contains(PhysicsState::PARTICLE_EMITTER) {
            if let Some(cell) = self.body.cell {
                self.add_shadow(
                    CellArrayEntry {
                        id: world.land.cell_id(cell),
                        cell: Some(cell),
                    },
                    world,
                );
            }
        } else {
            for entry in cells.entries() {
                self.add_shadow(*entry, world);
            }
        }
        self.for_each_child(world, |child, world, _| {
            child.add_shadows_at_depth(cells, world, depth + 1);
        });
    }

    fn add_shadow(&mut self, entry: CellArrayEntry, world: &mut World) {
        if let Some(cell) = entry.cell {
            world.land.add_shadow(cell, self.object_ref());
        }
        self.body.shadows.push(entry);
    }

    /// Takes every shadow back, children included (`remove_shadows_from_cells`).
    pub(crate) fn remove_shadows_from_cells(&mut self, world: &mut World) {
        self.remove_shadows_at_depth(world, 0);
    }

    fn remove_shadows_at_depth(&mut self, world: &mut World, depth: u32) {
        if depth > MAX_ATTACHMENT_DEPTH {
            return;
        }
        let object = self.object_ref();
        for entry in self.body.shadows.drain(..) {
            if let Some(cell) = entry.cell {
                world.land.remove_shadow(cell, object, &world.profile);
            }
        }
        self.for_each_child(world, |child, world, _| {
            child.remove_shadows_at_depth(world, depth + 1);
        });
    }

    /// Finds the cells this object touches where it is, and throws its shadows there (`calc_cross_cells`).
    pub(crate) fn calc_cross_cells(&mut self, world: &mut World) {
        self.settle_parts(&world.profile);
        let mut cells = std::mem::take(&mut world.scratch.cells);
        world.cells_of_body(&self.body, &mut cells);
        self.remove_shadows_from_cells(world);
        self.add_shadows_to_cells(&cells, world);
        world.scratch.cells = cells;
    }

    /// As [`Entity::calc_cross_cells`], and each child finds its own (`recalc_cross_cells`).
    pub(crate) fn recalc_cross_cells(&mut self, world: &mut World) {
        self.recalc_at_depth(world, 0);
    }

    fn recalc_at_depth(&mut self, world: &mut World, depth: u32) {
        if self.body.part_array.is_none() || depth > MAX_ATTACHMENT_DEPTH {
            return;
        }
        let emitter = self.body.state.contains(PhysicsState::PARTICLE_EMITTER);
        if !self.body.position.cell.is_none() {
            self.calc_cross_cells(world);
        } else if self.examination_object && emitter {
            self.remove_shadows_from_cells(world);
            self.add_shadows_to_cells(&CellArray::default(), world);
        }
        self.for_each_child(world, |child, world, _| {
            child.recalc_at_depth(world, depth + 1)
        });
    }

    /// Puts an object that is in no more than one cell (examination and particle objects) into a cell, or into none: at home there, and one
    /// shadow there (`AddObjectToSingleCell`, `spec/03-cells.md`, 8.21). An object without a part array cannot be in a cell. Which cells draw
    /// its parts is not kept, so [its parts](crate::animation::PartArray::set_parts) need no entering of their own.
    pub fn add_to_single_cell(&mut self, cell: Option<CellHandle>, world: &mut World) {
        if cell.is_some() && self.body.cell == cell {
            return;
        }
        if self.body.cell.is_some() {
            self.remove_from_single_cell(world);
        }
        self.change_cell(cell, world);
        self.remove_shadows_from_cells(world);
        if let Some(cell) = self.body.cell {
            let id = world.land.cell_id(cell);
            self.add_shadow(
                CellArrayEntry {
                    id,
                    cell: Some(cell),
                },
                world,
            );
        }
    }

    /// Takes such an object out of its cell (`RemoveObjectFromSingleCell`).
    pub fn remove_from_single_cell(&mut self, world: &mut World) {
        self.leave_cell(true, world);
        self.set_cell_id(CellId::NONE);
        self.body.cell = None;
        self.remove_shadows_from_cells(world);
    }

    /// Whether the object has a cell and all its shadows are in lists.
    pub fn is_completely_visible(&self) -> bool {
        self.body.cell.is_some()
            && !self.body.shadows.is_empty()
            && self.body.shadows.iter().all(|s| s.cell.is_some())
    }

    /// Writes a cell id to every child, one level deep (C2 step 3).
    pub(crate) fn set_cell_id_of_children(&self, id: CellId, world: &mut World) {
        self.for_each_child(world, |child, _, _| {
            if !child.body.state.contains(PhysicsState::PARTICLE_EMITTER) {
                child.set_cell_id(id);
            }
        });
    }

    /// Handle of the first child with this GUID, if any.
    pub fn child_of_guid(&self, guid: u32, world: &World) -> Option<EntityId> {
        self.children
            .iter()
            .map(|c| c.object)
            .find(|&id| world.entity(id).is_some_and(|c| c.guid() == guid))
    }
}
