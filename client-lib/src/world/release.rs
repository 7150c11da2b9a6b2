//! Releasing loaded blocks (`spec/02-terrain.md`, 12.7; `spec/03-cells.md`, 8.17 and 16).
//!
//! What leaves memory can be loaded again when a lookup needs it. Shadow records that named its cells stay with their objects, unlinked, and
//! are linked again when the cell is back.

use super::landscape::Landscape;
use super::{CellHandle, World};
use crate::math::CellId;
use crate::physics::body::{Body, EntityId, ObjectRef, StaticId};

impl World {
    /// Releases a landblock with its indoor cells and static objects. Entities at home there are appended to `lost`, in cell order: the caller
    /// makes them leave visibility (8.19); their current cell is gone already. Nothing happens if the block is not loaded.
    pub fn release_block(&mut self, block: CellId, lost: &mut Vec<EntityId>) {
        let rooms: Vec<CellHandle> = self.land.loaded_rooms(block).collect();
        let mut released: Vec<CellHandle> = (1..=64)
            .filter_map(|low| self.land.loaded(block.with_low(low)))
            .collect();
        released.extend(&rooms);
        for &cell in &released {
            self.release_objects(cell, lost);
        }
        let mut statics: Vec<StaticId> = Vec::new();
        for &room in &rooms {
            if let Some(env) = self.land.env_cell(room) {
                statics.extend(&env.statics);
            }
        }
        if let Some(block) = self.land.block(block) {
            statics.extend(block.statics.iter().chain(&block.buildings));
        }
        for id in statics {
            self.destroy_static(id);
        }
        for room in rooms {
            self.land.take_env_cell(room);
        }
        self.land.take_block(block);
        if !released.is_empty() {
            self.land.has_unlinked = true;
        }
    }

    /// Releases a landblock whose place nobody sees any more: entities at home in its cells leave visibility first (8.17, 8.19). They wait for
    /// their cell and are due for deletion 25 s from now.
    pub fn unload_block(&mut self, block: CellId) {
        let rooms: Vec<CellHandle> = self.land.loaded_rooms(block).collect();
        let outdoors = (1..=64).filter_map(|low| self.land.loaded(block.with_low(low)));
        let cells: Vec<CellHandle> = outdoors.chain(rooms).collect();
        for cell in cells {
            self.clear_cell(cell);
        }
        self.release_block(block, &mut Vec::new());
    }

    /// Releases an indoor cell with its static objects; entities at home there leave visibility first. Nothing happens if it is not loaded.
    pub fn unload_room(&mut self, room: CellId) {
        let Some(cell) = self.land.loaded(room).filter(|_| room.is_indoor()) else {
            return;
        };
        self.clear_cell(cell);
        self.release_objects(cell, &mut Vec::new());
        let statics = self.land.env_cell(cell).map(|env| env.statics.clone());
        for id in statics.into_iter().flatten() {
            self.destroy_static(id);
        }
        self.land.take_env_cell(cell);
        self.land.has_unlinked = true;
    }

    /// Every entity at home in a cell leaves visibility, in list order; a carried one goes with its carrier.
    fn clear_cell(&mut self, cell: CellHandle) {
        let at_home = |world: &Self| {
            let objects = &world.land.cell(cell)?.base().objects;
            objects.iter().find_map(|&object| match object {
                ObjectRef::Entity(id) => Some(id),
                ObjectRef::Static(_) => None,
            })
        };
        while let Some(id) = at_home(self) {
            self.with_entity(id, |entity, world| entity.leave_visibility(world));
            // An entity that does not know its cell must not stay in the list.
            self.land.remove_object(cell, ObjectRef::Entity(id));
        }
    }

    /// `release_objects` (8.17) of one cell.
    fn release_objects(&mut self, cell: CellHandle, lost: &mut Vec<EntityId>) {
        let Some(base) = self.land.base_mut(cell) else {
            return;
        };
        let shadows = std::mem::take(&mut base.shadows);
        let objects = std::mem::take(&mut base.objects);
        for object in shadows {
            if let Some(body) = self.body_mut(object) {
                for entry in body.shadows.iter_mut().filter(|e| e.cell == Some(cell)) {
                    entry.cell = None;
                }
            }
        }
        for object in objects {
            if let ObjectRef::Entity(id) = object {
                lost.push(id);
                if let Some(body) = self.body_mut(object) {
                    body.cell = None;
                }
            }
        }
    }

    fn destroy_static(&mut self, id: StaticId) {
        if let Some(mut object) = self.land.lend_static(id) {
            let own = ObjectRef::Static(id);
            self.land
                .remove_shadows(own, &mut object.body, &self.profile);
            self.land.put_static(id, object);
        }
        self.land.animated_statics.retain(|&s| s != id);
        self.land.take_static(id);
    }

    fn body_mut(&mut self, object: ObjectRef) -> Option<&mut Body> {
        match object {
            ObjectRef::Entity(id) => Some(&mut self.entity_mut(id)?.body),
            ObjectRef::Static(id) => self.land.static_body_mut(id),
        }
    }

    /// Links the shadow records of loaded objects that name cells of a block which has been loaded again.
    pub(super) fn relink_shadows(&mut self, cell: CellId) {
        if !self.land.has_unlinked {
            return;
        }
        let statics = self.land.static_ids();
        let entities = self.entities.table().iter().map(|&e| ObjectRef::Entity(e));
        let objects: Vec<ObjectRef> = statics.map(ObjectRef::Static).chain(entities).collect();
        for object in objects {
            let Some(body) = self.body(object) else {
                continue;
            };
            let unlinked = |at: usize| {
                let entry = body.shadows[at];
                entry.cell.is_none() && belongs(entry.id, cell)
            };
            let found: Vec<usize> = (0..body.shadows.len()).filter(|&at| unlinked(at)).collect();
            for at in found {
                self.relink(object, at);
            }
        }
    }

    fn relink(&mut self, object: ObjectRef, at: usize) {
        let Some(id) = self.body(object).map(|body| body.shadows[at].id) else {
            return;
        };
        let Some(cell) = self.land.loaded(id) else {
            return;
        };
        self.land.add_shadow(cell, object);
        if let Some(body) = self.body_mut(object) {
            body.shadows[at].cell = Some(cell);
        }
    }
}

/// Whether loading `loaded` (an outdoor cell stands for its block) brings `id`.
fn belongs(id: CellId, loaded: CellId) -> bool {
    id == loaded
        || (id.same_block(loaded)
            && !id.is_indoor()
            && (!loaded.is_indoor() || loaded.low() == 0xFFFF))
}

impl Landscape {
    /// Ids of the loaded static objects, by slot.
    fn static_ids(&self) -> impl Iterator<Item = StaticId> + '_ {
        (0..self.static_slots())
            .map(|slot| StaticId(slot as u32))
            .filter(|&id| self.static_object(id).is_some())
    }
}
