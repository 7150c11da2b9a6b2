//! Forms of the loaded part of the map. Geometry is not stored: blocks and rooms are named by their ids and made again from their records;
//! stored is which of them are loaded under which handle, and who is in them.

use super::form::{Stored, stored};
use super::{Restorer, SnapshotError, inconsistent};
use crate::math::{CellId, Direction, Vec3};
use crate::physics::body::{Body, ObjectRef, StaticId};
use crate::world::landscape::{ABSENT, BROKEN, FIRST_SLOT, LandBlock, Landscape};
use crate::world::terrain::{CELLS, Detail, DetailScale, TerrainBlock};
use crate::world::{BuildingPortal, CellBase, EnvCell, LandCell, StaticKind, StaticObject, World};

#[cfg(test)]
use super::form::{Forms, define};

stored!(
    struct CellBaseForm of CellBase {
        id: CellId,
        objects: Vec<ObjectRef>,
        shadows: Vec<ObjectRef>,
        restriction: u32,
    }
);
stored!(
    struct LandCellForm of LandCell { base: CellBase, building: Option<StaticId> }
);
stored!(
    struct BuildingPortalForm of BuildingPortal {
        exact_match: bool,
        portal_side: bool,
        other_cell: CellId,
        other_portal: u16,
        stab_list: Vec<CellId>,
    }
);
stored!(
    enum StaticKindForm of StaticKind { Building, Landblock, Room, Scenery }
);
stored!(
    struct StaticForm of StaticObject {
        body: Body,
        kind: StaticKind,
        model: u32,
        portals: Vec<BuildingPortal>,
        leaf_count: u32,
        omega: Vec3,
        update_time: f64,
    }
);
stored!(
    enum DetailScaleForm of DetailScale { Full, Half, Quarter, Corners }
);
stored!(
    enum DirectionForm of Direction {
        Inside, North, South, East, West, NorthWest, SouthWest, NorthEast, SouthEast, Unknown,
    }
);
stored!(
    struct DetailForm of Detail { scale: DetailScale, direction: Direction }
);

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BlockForm {
    id: u32,
    detail: DetailForm,
    cells: Vec<LandCellForm>,
    buildings: Vec<u32>,
    statics: Vec<u32>,
    info_statics: u64,
    stab_list: Vec<u32>,
    has_info: bool,
}

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RoomForm {
    base: CellBaseForm,
    statics_made: bool,
    statics: Vec<u32>,
}

/// The rooms of a block: cell number and slot, [`BROKEN`] for one that cannot be read.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RoomsForm {
    block: u16,
    rooms: Vec<(u16, u32)>,
}

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MapForm {
    absent_blocks: Vec<u16>,
    blocks: Vec<Option<Box<BlockForm>>>,
    free_blocks: Vec<u32>,
    rooms: Vec<RoomsForm>,
    env_cells: Vec<Option<Box<RoomForm>>>,
    free_env_cells: Vec<u32>,
    statics: Vec<Option<Box<StaticForm>>>,
    free_statics: Vec<u32>,
    absent_rooms: u32,
    animated_statics: Vec<u32>,
    has_unlinked: bool,
    window_only: bool,
}

pub(super) fn store(land: &Landscape) -> MapForm {
    let Landscape {
        // The files.
        source: _,
        heights: _,
        block_table,
        blocks,
        free_blocks,
        room_table,
        rooms,
        env_cells,
        free_env_cells,
        statics,
        free_statics,
        absent_rooms,
        animated_statics,
        has_unlinked,
        window_only,
    } = land;
    let numbered = |table: &[u32], entry: u32| -> Vec<u16> {
        let numbers = (0..=u16::MAX).zip(table);
        numbers
            .filter(|(_, e)| **e == entry)
            .map(|(number, _)| number)
            .collect()
    };
    let mut owners: Vec<(u32, u16)> = (0..=u16::MAX)
        .zip(room_table)
        .filter_map(|(number, entry)| Some((entry.checked_sub(FIRST_SLOT)?, number)))
        .collect();
    owners.sort_unstable();
    MapForm {
        absent_blocks: numbered(block_table, ABSENT),
        blocks: blocks
            .iter()
            .map(|block| block.as_deref().map(|block| Box::new(store_block(block))))
            .collect(),
        free_blocks: free_blocks.store(),
        rooms: owners
            .into_iter()
            .zip(rooms)
            .map(|((_, block), rooms)| RoomsForm {
                block,
                rooms: rooms.store(),
            })
            .collect(),
        env_cells: env_cells
            .iter()
            .map(|cell| cell.as_deref().map(|cell| Box::new(store_room(cell))))
            .collect(),
        free_env_cells: free_env_cells.store(),
        statics: statics.store(),
        free_statics: free_statics.store(),
        absent_rooms: *absent_rooms,
        animated_statics: animated_statics.store(),
        has_unlinked: *has_unlinked,
        window_only: *window_only,
    }
}

fn store_block(block: &LandBlock) -> BlockForm {
    let LandBlock {
        id,
        terrain,
        cells,
        buildings,
        statics,
        info_statics,
        stab_list,
        info,
    } = block;
    // All of the terrain but its level of detail follows from the record.
    let TerrainBlock {
        block: _,
        source: _,
        detail: _,
        vertices: _,
        triangles: _,
        cuts: _,
        cell_water: _,
        block_water: _,
    } = terrain;
    BlockForm {
        id: id.store(),
        detail: terrain.detail().store(),
        cells: cells.store(),
        buildings: buildings.store(),
        statics: statics.store(),
        info_statics: info_statics.store(),
        stab_list: stab_list.store(),
        has_info: info.is_some(),
    }
}

fn store_room(room: &EnvCell) -> RoomForm {
    let EnvCell {
        base,
        statics_made,
        statics,
        // The record and what is made of it.
        position: _,
        shape: _,
        volume: _,
        portals: _,
        stab_list: _,
        seen_outside: _,
        record: _,
    } = room;
    RoomForm {
        base: base.store(),
        statics_made: *statics_made,
        statics: statics.store(),
    }
}

/// Fills the map of a world over which nothing is loaded yet.
pub(super) fn restore(
    form: MapForm,
    world: &mut World,
    elements: &mut usize,
) -> Result<(), SnapshotError> {
    let MapForm {
        absent_blocks,
        blocks,
        free_blocks,
        rooms,
        env_cells,
        free_env_cells,
        statics,
        free_statics,
        absent_rooms,
        animated_statics,
        has_unlinked,
        window_only,
    } = form;
    let total = absent_blocks.len() + blocks.len() + env_cells.len() + statics.len();
    with_restorer(world, elements, |by| by.spend(total))?;
    restore_blocks(blocks, world, elements)?;
    for number in absent_blocks {
        let entry = &mut world.land.block_table[usize::from(number)];
        if *entry != 0 {
            return Err(inconsistent("a block is loaded and absent"));
        }
        *entry = ABSENT;
    }
    restore_rooms(env_cells, world, elements)?;
    restore_room_table(rooms, &mut world.land)?;
    for object in statics {
        let object = match object {
            Some(form) => Some(Box::new(with_restorer(world, elements, |by| {
                StaticObject::restore(*form, by)
            })?)),
            None => None,
        };
        world.land.statics.push(object);
    }
    let land = &mut world.land;
    check_free(&free_blocks, &land.blocks, "blocks")?;
    check_free(&free_env_cells, &land.env_cells, "rooms")?;
    check_free(&free_statics, &land.statics, "static objects")?;
    land.free_blocks = free_blocks;
    land.free_env_cells = free_env_cells;
    land.free_statics = free_statics;
    land.absent_rooms = absent_rooms;
    land.animated_statics = animated_statics.into_iter().map(StaticId).collect();
    land.has_unlinked = has_unlinked;
    land.window_only = window_only;
    Ok(())
}

/// Runs `f` with what restoring needs of a world.
fn with_restorer<R>(
    world: &mut World,
    elements: &mut usize,
    f: impl FnOnce(&mut Restorer<'_>) -> Result<R, SnapshotError>,
) -> Result<R, SnapshotError> {
    f(&mut Restorer {
        resources: &mut world.resources,
        profile: &world.profile,
        elements,
    })
}

/// Free slots are empty, in range and named once.
fn check_free<T>(free: &[u32], slots: &[Option<T>], what: &str) -> Result<(), SnapshotError> {
    let mut seen = vec![false; slots.len()];
    for &slot in free {
        let index = slot as usize;
        if slots.get(index).is_none_or(Option::is_some) || std::mem::replace(&mut seen[index], true)
        {
            return Err(inconsistent(format!(
                "slot {slot} of the {what} is not free"
            )));
        }
    }
    Ok(())
}

fn restore_blocks(
    blocks: Vec<Option<Box<BlockForm>>>,
    world: &mut World,
    elements: &mut usize,
) -> Result<(), SnapshotError> {
    for (slot, form) in (0_u32..).zip(blocks) {
        let Some(form) = form else {
            world.land.blocks.push(None);
            continue;
        };
        let block = restore_block(*form, world, elements)?;
        let entry = &mut world.land.block_table[usize::from(block.id.block())];
        if *entry != 0 {
            return Err(inconsistent(format!(
                "block {:?} is loaded twice",
                block.id
            )));
        }
        *entry = slot + FIRST_SLOT;
        world.land.blocks.push(Some(Box::new(block)));
    }
    Ok(())
}

fn restore_block(
    form: BlockForm,
    world: &mut World,
    elements: &mut usize,
) -> Result<LandBlock, SnapshotError> {
    let BlockForm {
        id,
        detail,
        cells,
        buildings,
        statics,
        info_statics,
        stab_list,
        has_info,
    } = form;
    let id = CellId(id);
    if id.low() != 0xFFFF || cells.len() != CELLS {
        return Err(inconsistent(format!("{id:?} is no block of {CELLS} cells")));
    }
    let missing = |kind| SnapshotError::MissingRecord { kind, id: id.0 };
    let mut block = world.make_block(id).ok_or(missing("landblock"))?;
    if has_info && block.info.is_none() {
        return Err(missing("info of landblock"));
    }
    if !has_info {
        block.info = None;
    }
    let heights = world.land.heights.clone();
    with_restorer(world, elements, |by| {
        let detail = Detail::restore(detail, by)?;
        block.terrain.generate(detail, &heights, by.profile);
        block.cells = Stored::restore(cells, by)?;
        block.buildings = Stored::restore(buildings, by)?;
        block.statics = Stored::restore(statics, by)?;
        block.info_statics = Stored::restore(info_statics, by)?;
        block.stab_list = Stored::restore(stab_list, by)?;
        Ok(())
    })?;
    Ok(block)
}

fn restore_rooms(
    rooms: Vec<Option<Box<RoomForm>>>,
    world: &mut World,
    elements: &mut usize,
) -> Result<(), SnapshotError> {
    for form in rooms {
        let room = match form {
            Some(form) => Some(Box::new(restore_room(*form, world, elements)?)),
            None => None,
        };
        world.land.env_cells.push(room);
    }
    Ok(())
}

fn restore_room(
    form: RoomForm,
    world: &mut World,
    elements: &mut usize,
) -> Result<EnvCell, SnapshotError> {
    let RoomForm {
        base,
        statics_made,
        statics,
    } = form;
    let base = with_restorer(world, elements, |by| CellBase::restore(base, by))?;
    let mut room = world
        .make_room(base.id)
        .ok_or(SnapshotError::MissingRecord {
            kind: "room",
            id: base.id.0,
        })?;
    room.base = base;
    room.statics_made = statics_made;
    room.statics = with_restorer(world, elements, |by| Stored::restore(statics, by))?;
    Ok(room)
}

fn restore_room_table(rooms: Vec<RoomsForm>, land: &mut Landscape) -> Result<(), SnapshotError> {
    for RoomsForm { block, rooms } in rooms {
        let entry = &mut land.room_table[usize::from(block)];
        if *entry != 0 {
            return Err(inconsistent("the rooms of a block are listed twice"));
        }
        if !rooms.is_sorted_by(|a, b| a.0 < b.0) {
            return Err(inconsistent("the rooms of a block are not in order"));
        }
        for &(low, slot) in &rooms {
            let id = CellId(u32::from(block) << 16 | u32::from(low));
            let room = land.env_cells.get(slot as usize);
            let is_there = room.is_some_and(|r| r.as_ref().is_some_and(|r| r.base.id == id));
            if slot != BROKEN && !is_there {
                return Err(inconsistent(format!("room {id:?} is in no slot")));
            }
        }
        land.rooms.push(rooms);
        *entry = u32::try_from(land.rooms.len() - 1).unwrap_or(0) + FIRST_SLOT;
    }
    Ok(())
}

/// What the map is stored as.
#[cfg(test)]
pub(super) fn describe(forms: &mut Forms) -> String {
    let cells = Vec::<LandCell>::describe(forms);
    let base = CellBase::describe(forms);
    let detail = Detail::describe(forms);
    let statics = Vec::<Option<StaticObject>>::describe(forms);
    define(forms, "BlockForm", |_| {
        format!(
            "\n  id: u32\n  detail: {detail}\n  cells: {cells}\n  buildings: list of u32\n  statics: list of u32\n  \
             info_statics: u64\n  stab_list: list of u32\n  has_info: bool"
        )
    });
    define(forms, "RoomForm", |_| {
        format!("\n  base: {base}\n  statics_made: bool\n  statics: list of u32")
    });
    define(forms, "RoomsForm", |_| {
        "\n  block: u16\n  rooms: list of (u16, u32)".into()
    });
    define(forms, "MapForm", |_| {
        format!(
            "\n  absent_blocks: list of u16\n  blocks: list of optional BlockForm\n  free_blocks: list of u32\n  \
             rooms: list of RoomsForm\n  env_cells: list of optional RoomForm\n  free_env_cells: list of u32\n  \
             statics: {statics}\n  free_statics: list of u32\n  absent_rooms: u32\n  animated_statics: list of u32\n  \
             has_unlinked: bool\n  window_only: bool"
        )
    })
}
