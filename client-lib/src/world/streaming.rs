//! Streaming: landblocks and indoor cells come and go around the load point (`spec/03-cells.md`, 15 to 17; `spec/02-terrain.md`, 13).
//!
//! The [`LandscapeWindow`] says which blocks are shown. Real cells, with collisions, buildings and static objects, exist only in those of full
//! detail: the load point's own block and its eight neighbours. Indoor cells are there while something near sees them. Whoever is at home in
//! what goes leaves visibility and waits, and re-enters when the cell is back.

use std::collections::BTreeSet;

use super::landscape::Demand;
use super::terrain::DetailScale;
use super::window::{LandscapeWindow, LoadPlan};
use super::{StaticKind, World};
use crate::math::CellId;
use crate::physics::body::{EntityId, StaticId};

/// What the client keeps loaded around its load point.
#[derive(Debug, Clone, Default)]
pub struct Streaming {
    pub(crate) window: LandscapeWindow,
    /// The table of visible indoor cells, as it was asked for: also cells that do not exist.
    pub(crate) rooms: BTreeSet<CellId>,
}

impl Streaming {
    /// Streaming with a window of `radius` blocks around the load point's own, at least 1; the client's is 5.
    pub fn with_radius(radius: i32) -> Self {
        let mut streaming = Self::default();
        streaming.window.set_radius(radius);
        streaming
    }

    /// Blocks that are shown, and how finely.
    pub const fn window(&self) -> &LandscapeWindow {
        &self.window
    }

    /// Indoor cells that are kept, by id; also such as do not exist.
    pub fn visible_rooms(&self) -> impl Iterator<Item = CellId> {
        self.rooms.iter().copied()
    }

    /// Centres everything on the local player's place; without a player nothing changes.
    pub fn follow_player(&mut self, world: &mut World) -> LoadPlan {
        let player = world.local_player.and_then(|id| world.entity(id));
        match player.map(|player| player.body.position.cell) {
            Some(cell) => self.follow(cell, world),
            None => LoadPlan::default(),
        }
    }

    /// Centres everything on a cell, or releases everything for [`CellId::NONE`]; answers what changed in the window.
    pub fn follow(&mut self, cell: CellId, world: &mut World) -> LoadPlan {
        let plan = self.window.update_load_point(cell);
        let blocks_change = plan != LoadPlan::default();
        if blocks_change {
            self.stream_blocks(world);
        }
        let rooms = self.rooms_around(cell, world);
        let rooms_change = rooms != self.rooms;
        if rooms_change {
            self.stream_rooms(rooms, world);
        }
        if blocks_change || rooms_change {
            world.init_objects();
            world.readmit_lost();
        }
        plan
    }

    /// Blocks of full detail, in window order.
    fn full_blocks(&self) -> impl Iterator<Item = CellId> {
        let full = |block: &&super::window::WindowBlock| block.detail.scale == DetailScale::Full;
        self.window.blocks().filter(full).map(|block| block.id)
    }

    /// Blocks without full detail have no cells (17.1).
    fn stream_blocks(&self, world: &mut World) {
        let wanted: Vec<CellId> = self.full_blocks().collect();
        let loaded = world.land.blocks().map(|block| block.id);
        let gone: Vec<CellId> = loaded.filter(|id| !wanted.contains(id)).collect();
        for block in gone {
            world.unload_block(block);
        }
        for block in wanted {
            if world.land.block(block).is_none() {
                world.load(Demand {
                    cell: block.with_low(1),
                    without_statics: false,
                });
            }
        }
    }

    /// The cell itself and what is seen from it, and what the buildings of the loaded blocks let see (15).
    fn rooms_around(&self, cell: CellId, world: &mut World) -> BTreeSet<CellId> {
        let mut rooms = BTreeSet::new();
        for id in self.full_blocks() {
            if let Some(block) = world.land.block(id) {
                rooms.extend(&block.stab_list);
            }
        }
        if !cell.is_indoor() || cell.low() == 0xFFFF {
            return rooms;
        }
        rooms.insert(cell);
        load_room(cell, true, world);
        let own = world.land.loaded(cell).and_then(|h| world.land.env_cell(h));
        rooms.extend(own.into_iter().flat_map(|env| &env.stab_list));
        rooms
    }

    fn stream_rooms(&mut self, rooms: BTreeSet<CellId>, world: &mut World) {
        for &gone in self.rooms.difference(&rooms) {
            world.unload_room(gone);
        }
        for &cell in &rooms {
            load_room(cell, false, world);
        }
        self.rooms = rooms;
    }
}

/// Ids come from records and messages: what does not exist is not asked for.
fn load_room(cell: CellId, without_statics: bool, world: &mut World) {
    if world.land.source().has_cell_record(cell.0) {
        world.load(Demand {
            cell,
            without_statics,
        });
    }
}

impl World {
    /// After cells have come: objects of loaded cells that are not completely visible find their shadows anew (8.18; 14).
    fn init_objects(&mut self) {
        for id in self.incomplete_statics() {
            self.calc_cross_cells_static(id);
        }
        for id in self.incomplete_entities() {
            self.with_entity(id, |entity, world| entity.recalc_cross_cells(world));
        }
    }

    fn incomplete_statics(&self) -> Vec<StaticId> {
        // The shell of a building has no shadows.
        let incomplete = |id: &StaticId| {
            let object = self.land.static_object(*id);
            object.is_some_and(|o| o.kind != StaticKind::Building && !o.is_completely_visible())
        };
        let slots = 0..self.land.static_slots();
        slots
            .map(|slot| StaticId(slot as u32))
            .filter(incomplete)
            .collect()
    }

    fn incomplete_entities(&self) -> Vec<EntityId> {
        let at_home = |id: &&EntityId| {
            let entity = self.entity(**id);
            entity.is_some_and(|e| {
                e.body.parent.is_none() && e.body.cell.is_some() && !e.is_completely_visible()
            })
        };
        self.entities
            .table()
            .iter()
            .filter(at_home)
            .copied()
            .collect()
    }
}
