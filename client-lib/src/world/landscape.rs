//! The loaded part of the map: blocks, cells and static objects, found by id (`spec/03-cells.md`, sections 6 and 7).
//!
//! Lookups never load: they are asked while the world is read-only. One that meets something that exists but is not loaded notes it in
//! [`Missing`], and the caller discards what it has, loads that one thing, and starts again. So results do not depend on what happened to be
//! loaded, and things come to be in the order in which they are first needed, as in a world that loads on demand.

use std::sync::Arc;

use super::CellHandle;
use super::cell::{CellBase, CellRef, EnvCell, LandCell, LandCellRef};
use super::source::{MemorySource, WorldSource};
use super::statics::StaticObject;
use super::terrain::{CELLS, HeightTable, TerrainBlock};
use crate::dat;
use crate::math::CellId;
use crate::physics::body::{Body, ObjectRef, StaticId};

/// Bit of a handle that marks indoor cells.
const INDOOR: u32 = 0x8000_0000;
/// Entry of the block tables: nobody asked yet.
const UNKNOWN: u32 = 0;
/// Entry of the block tables: there is no such block, or it cannot be read.
pub(crate) const ABSENT: u32 = 1;
/// Entries from here on are slots.
pub(crate) const FIRST_SLOT: u32 = 2;
/// Entry of a block's indoor list: there is no such cell, or its record cannot be read.
pub(crate) const BROKEN: u32 = u32::MAX;
/// Indoor cells that are noted as absent.
const MAX_ABSENT_ROOMS: u32 = 1 << 16;
/// Number of the first indoor cell of a block.
const FIRST_ROOM: usize = 0x100;
/// Blocks of the largest possible id space, existing or not.
const BLOCK_NUMBERS: usize = 1 << 16;

/// Something that was looked up and must be loaded first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Demand {
    /// An outdoor cell (its block is wanted) or an indoor cell.
    pub cell: CellId,
    /// The static objects of an indoor cell are not needed.
    pub without_statics: bool,
}

/// The first thing that a read-only computation found not to be loaded; its result means nothing then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Missing(pub Option<Demand>);

impl Missing {
    fn note(&mut self, demand: Demand) {
        self.0.get_or_insert(demand);
    }
}

/// One loaded landblock: terrain, its 64 outdoor cells, buildings and static objects.
#[derive(Debug, Clone)]
pub struct LandBlock {
    /// Id with cell part 0xFFFF.
    pub id: CellId,
    /// Terrain at full detail.
    pub terrain: TerrainBlock,
    /// The outdoor cells, by cell number minus one.
    pub cells: Vec<LandCell>,
    /// Buildings in file order; not all stand in a cell of their own.
    pub buildings: Vec<StaticId>,
    /// Static objects: those of the info record, then scenery.
    pub statics: Vec<StaticId>,
    /// How many of `statics` come from the info record.
    pub info_statics: usize,
    /// Indoor cells visible through the buildings' portals, without duplicates, in order of appearance.
    pub stab_list: Vec<CellId>,
    /// The info record, if there is one.
    pub info: Option<Arc<dat::LandblockInfo>>,
}

/// Indoor cells of one block that are loaded, ordered by cell number.
type Rooms = Vec<(u16, u32)>;

/// Blocks, cells and static objects that are loaded.
#[derive(Debug, Clone)]
pub struct Landscape {
    pub(crate) source: Arc<dyn WorldSource>,
    pub(crate) heights: HeightTable,
    /// By block number: slot in `blocks`.
    pub(crate) block_table: Box<[u32]>,
    pub(crate) blocks: Vec<Option<Box<LandBlock>>>,
    pub(crate) free_blocks: Vec<u32>,
    /// By block number: slot in `rooms`.
    pub(crate) room_table: Box<[u32]>,
    pub(crate) rooms: Vec<Rooms>,
    pub(crate) env_cells: Vec<Option<Box<EnvCell>>>,
    pub(crate) free_env_cells: Vec<u32>,
    pub(crate) statics: Vec<Option<Box<StaticObject>>>,
    pub(crate) free_statics: Vec<u32>,
    pub(crate) absent_rooms: u32,
    /// Static objects with a default animation, in order of creation.
    pub(crate) animated_statics: Vec<StaticId>,
    /// Some shadow records may name cells of released blocks.
    pub(crate) has_unlinked: bool,
    /// Only what was loaded on purpose is there: lookups find nothing missing.
    pub(crate) window_only: bool,
}

impl Default for Landscape {
    fn default() -> Self {
        Self::new(Arc::new(MemorySource::default()))
    }
}

impl Landscape {
    /// A map of which nothing is loaded yet.
    pub fn new(source: Arc<dyn WorldSource>) -> Self {
        let heights = source
            .region()
            .and_then(|region| HeightTable::new(&region.height_table))
            .unwrap_or_default();
        Self {
            source,
            heights,
            block_table: vec![UNKNOWN; BLOCK_NUMBERS].into_boxed_slice(),
            blocks: Vec::new(),
            free_blocks: Vec::new(),
            room_table: vec![UNKNOWN; BLOCK_NUMBERS].into_boxed_slice(),
            rooms: Vec::new(),
            env_cells: Vec::new(),
            free_env_cells: Vec::new(),
            statics: Vec::new(),
            free_statics: Vec::new(),
            absent_rooms: 0,
            animated_statics: Vec::new(),
            has_unlinked: false,
            window_only: false,
        }
    }

    /// Where cells come from (`spec/03-cells.md`, 7): everything is there, loaded when it is first needed (the default, and what the
    /// reconstructions do), or, `only` the window: what nobody has [loaded](super::World::load) is not there.
    pub fn set_window_only(&mut self, only: bool) {
        self.window_only = only;
        // Records of cells that come later are to be linked then.
        self.has_unlinked |= only;
    }

    /// The records that the map is loaded from.
    pub fn source(&self) -> &Arc<dyn WorldSource> {
        &self.source
    }

    /// Heights of the height indices.
    pub fn height_table(&self) -> &HeightTable {
        &self.heights
    }

    /// The cell of an id (`get_visible`); `None` if there is none, or, noted in `missing`, if it is not loaded. An indoor cell counts as
    /// loaded when its static objects have been made, unless `without_statics`.
    pub fn visible(
        &self,
        id: CellId,
        without_statics: bool,
        missing: &mut Missing,
    ) -> Option<CellHandle> {
        if id.is_indoor() {
            self.visible_env_cell(id, without_statics, missing)
        } else {
            self.visible_land_cell(id, missing)
        }
    }

    #[inline]
    pub(super) fn visible_land_cell(
        &self,
        id: CellId,
        missing: &mut Missing,
    ) -> Option<CellHandle> {
        let index = id.low().wrapping_sub(1);
        if index >= CELLS as u32 {
            return None;
        }
        match self.block_table[usize::from(id.block())] {
            ABSENT => None,
            UNKNOWN if self.window_only => None,
            UNKNOWN => {
                // Also for blocks without a record: the loader notes that they are absent, and they are not asked for again.
                if id.block_coord().is_some() {
                    missing.note(Demand {
                        cell: id,
                        without_statics: false,
                    });
                }
                None
            }
            slot => Some(CellHandle((slot - FIRST_SLOT) * CELLS as u32 + index)),
        }
    }

    fn visible_env_cell(
        &self,
        id: CellId,
        without_statics: bool,
        missing: &mut Missing,
    ) -> Option<CellHandle> {
        let demand = Demand {
            cell: id,
            without_statics,
        };
        match self.env_slot(id) {
            Some(BROKEN) => None,
            Some(slot) => {
                let cell = self.env_cells.get(slot as usize)?.as_deref()?;
                if !cell.statics_made && !without_statics && !self.window_only {
                    missing.note(demand);
                }
                Some(CellHandle(slot | INDOOR))
            }
            None => {
                if id.low() <= 0xFFFD && !self.window_only && self.may_exist(id) {
                    missing.note(demand);
                }
                None
            }
        }
    }

    /// Whether it is worth trying to load an indoor cell. Ids come from strangers too: only so many are noted as absent, the rest is asked for
    /// every time.
    fn may_exist(&self, id: CellId) -> bool {
        self.absent_rooms < MAX_ABSENT_ROOMS || self.source.has_cell_record(id.0)
    }

    fn env_slot(&self, id: CellId) -> Option<u32> {
        let entry = self.room_table[usize::from(id.block())];
        let rooms = self.rooms.get(entry.checked_sub(FIRST_SLOT)? as usize)?;
        let low = id.low() as u16;
        // Where it is if all rooms before it are loaded, which is the rule.
        let guess = usize::from(low).wrapping_sub(FIRST_ROOM);
        if let Some(&(there, slot)) = rooms.get(guess)
            && there == low
        {
            return Some(slot);
        }
        let at = rooms.binary_search_by_key(&low, |&(low, _)| low).ok()?;
        Some(rooms[at].1)
    }

    /// The cell of an id if it is loaded, with or without its static objects.
    pub fn loaded(&self, id: CellId) -> Option<CellHandle> {
        self.visible(id, true, &mut Missing::default())
    }

    /// Whether looking the id up would try to load something.
    pub fn is_missing(&self, id: CellId) -> bool {
        let mut missing = Missing::default();
        self.visible(id, false, &mut missing);
        missing.0.is_some()
    }

    /// A loaded cell; `None` for a handle whose cell was released.
    pub fn cell(&self, handle: CellHandle) -> Option<CellRef<'_>> {
        if handle.0 & INDOOR != 0 {
            return Some(CellRef::Env(self.env_cell(handle)?));
        }
        Some(CellRef::Land(self.land_cell(handle)?))
    }

    /// A loaded outdoor cell.
    pub fn land_cell(&self, handle: CellHandle) -> Option<LandCellRef<'_>> {
        let (slot, index) = (handle.0 as usize / CELLS, handle.0 as usize % CELLS);
        let block = self.blocks.get(slot)?.as_deref()?;
        Some(LandCellRef {
            block,
            index,
            cell: block.cells.get(index)?,
        })
    }

    /// A loaded indoor cell.
    pub fn env_cell(&self, handle: CellHandle) -> Option<&EnvCell> {
        if handle.0 & INDOOR == 0 {
            return None;
        }
        self.env_cells
            .get((handle.0 & !INDOOR) as usize)?
            .as_deref()
    }

    pub(super) fn env_cell_mut(&mut self, handle: CellHandle) -> Option<&mut EnvCell> {
        if handle.0 & INDOOR == 0 {
            return None;
        }
        self.env_cells
            .get_mut((handle.0 & !INDOOR) as usize)?
            .as_deref_mut()
    }

    pub(super) fn land_cell_mut(&mut self, handle: CellHandle) -> Option<&mut LandCell> {
        let (slot, index) = (handle.0 as usize / CELLS, handle.0 as usize % CELLS);
        self.blocks.get_mut(slot)?.as_mut()?.cells.get_mut(index)
    }

    /// Identity and contents of a loaded cell, to change.
    pub fn base_mut(&mut self, handle: CellHandle) -> Option<&mut CellBase> {
        if handle.0 & INDOOR != 0 {
            return Some(&mut self.env_cell_mut(handle)?.base);
        }
        Some(&mut self.land_cell_mut(handle)?.base)
    }

    /// Id of a loaded cell; [`CellId::NONE`] for a handle whose cell was released.
    pub fn cell_id(&self, handle: CellHandle) -> CellId {
        self.cell(handle).map_or(CellId::NONE, CellRef::id)
    }

    /// The loaded block of an id.
    pub fn block(&self, id: CellId) -> Option<&LandBlock> {
        let slot = self.block_table[usize::from(id.block())].checked_sub(FIRST_SLOT)?;
        self.blocks.get(slot as usize)?.as_deref()
    }

    pub(super) fn block_mut(&mut self, id: CellId) -> Option<&mut LandBlock> {
        let slot = self.block_table[usize::from(id.block())].checked_sub(FIRST_SLOT)?;
        self.blocks.get_mut(slot as usize)?.as_deref_mut()
    }

    /// Loaded blocks, by slot.
    pub fn blocks(&self) -> impl Iterator<Item = &LandBlock> {
        self.blocks.iter().filter_map(Option::as_deref)
    }

    /// Handles of the loaded indoor cells of a block, by cell number.
    pub fn loaded_rooms(&self, id: CellId) -> impl Iterator<Item = CellHandle> {
        let entry = self.room_table[usize::from(id.block())];
        entry
            .checked_sub(FIRST_SLOT)
            .and_then(|slot| self.rooms.get(slot as usize))
            .into_iter()
            .flatten()
            .filter(|&&(_, slot)| slot != BROKEN)
            .map(|&(_, slot)| CellHandle(slot | INDOOR))
    }

    /// Blocks (0xXXYYFFFF) and indoor cells that are loaded, in no order.
    pub(crate) fn loaded_members(&self) -> impl Iterator<Item = u32> {
        let rooms = self.env_cells.iter().filter_map(Option::as_deref);
        self.blocks()
            .map(|block| block.id.0)
            .chain(rooms.map(|room| room.base.id.0))
    }

    /// Whether something of a block, by the upper half of its id, was asked for already.
    pub(crate) fn has_loaded(&self, block: u16) -> bool {
        let block = usize::from(block);
        self.block_table[block] != UNKNOWN || self.room_table[block] != UNKNOWN
    }

    /// A loaded static object.
    pub fn static_object(&self, id: StaticId) -> Option<&StaticObject> {
        self.statics.get(id.0 as usize)?.as_deref()
    }

    pub(crate) fn static_object_mut(&mut self, id: StaticId) -> Option<&mut StaticObject> {
        self.statics.get_mut(id.0 as usize)?.as_deref_mut()
    }

    /// Loaded static objects with a default animation, in order of creation.
    pub fn animated_statics(&self) -> &[StaticId] {
        &self.animated_statics
    }

    /// Place, shape and state of a loaded static object, to animate it. It must not be moved.
    pub fn static_body_mut(&mut self, id: StaticId) -> Option<&mut Body> {
        Some(&mut self.static_object_mut(id)?.body)
    }

    /// Place, shape and state of a loaded static object.
    pub fn static_body(&self, id: StaticId) -> Option<&Body> {
        Some(&self.static_object(id)?.body)
    }

    /// Appends an object to the list of objects at home in a cell (8.1).
    pub fn add_object(&mut self, cell: CellHandle, object: ObjectRef) {
        if let Some(base) = self.base_mut(cell) {
            base.objects.push(object);
        }
    }

    /// Takes an object from that list; the last entry takes its place (8.2).
    pub fn remove_object(&mut self, cell: CellHandle, object: ObjectRef) {
        if let Some(base) = self.base_mut(cell)
            && let Some(at) = base.objects.iter().position(|&o| o == object)
        {
            base.objects.swap_remove(at);
        }
    }

    /// Appends an object to the list of those that are tested in a cell (8.4).
    pub fn add_shadow(&mut self, cell: CellHandle, object: ObjectRef) {
        if let Some(base) = self.base_mut(cell) {
            base.shadows.push(object);
        }
    }
}

/// Slots.
impl Landscape {
    pub(super) fn insert_block(&mut self, block: LandBlock) {
        let number = usize::from(block.id.block());
        let slot = match self.free_blocks.pop() {
            Some(slot) => {
                self.blocks[slot as usize] = Some(Box::new(block));
                slot
            }
            None => {
                self.blocks.push(Some(Box::new(block)));
                self.blocks.len() as u32 - 1
            }
        };
        self.block_table[number] = slot + FIRST_SLOT;
    }

    /// Notes that a block cannot be had.
    pub(super) fn mark_block_absent(&mut self, id: CellId) {
        self.block_table[usize::from(id.block())] = ABSENT;
    }

    pub(super) fn take_block(&mut self, id: CellId) -> Option<Box<LandBlock>> {
        let number = usize::from(id.block());
        let slot = self.block_table[number].checked_sub(FIRST_SLOT)?;
        let block = self.blocks.get_mut(slot as usize)?.take()?;
        self.block_table[number] = UNKNOWN;
        self.free_blocks.push(slot);
        Some(block)
    }

    /// Enters an indoor cell, or notes that it cannot be read.
    pub(super) fn insert_env_cell(
        &mut self,
        id: CellId,
        cell: Option<EnvCell>,
    ) -> Option<CellHandle> {
        let slot = match cell {
            None => {
                self.absent_rooms += 1;
                BROKEN
            }
            Some(cell) => match self.free_env_cells.pop() {
                Some(slot) => {
                    self.env_cells[slot as usize] = Some(Box::new(cell));
                    slot
                }
                None => {
                    self.env_cells.push(Some(Box::new(cell)));
                    self.env_cells.len() as u32 - 1
                }
            },
        };
        let number = usize::from(id.block());
        if self.room_table[number] == UNKNOWN {
            self.rooms.push(Rooms::new());
            self.room_table[number] = self.rooms.len() as u32 - 1 + FIRST_SLOT;
        }
        let rooms = self
            .rooms
            .get_mut(self.room_table[number].checked_sub(FIRST_SLOT)? as usize)?;
        let low = id.low() as u16;
        match rooms.binary_search_by_key(&low, |&(l, _)| l) {
            Ok(at) => rooms[at].1 = slot,
            Err(at) => rooms.insert(at, (low, slot)),
        }
        (slot != BROKEN).then_some(CellHandle(slot | INDOOR))
    }

    pub(super) fn take_env_cell(&mut self, handle: CellHandle) -> Option<Box<EnvCell>> {
        let slot = handle.0 & !INDOOR;
        let cell = self.env_cells.get_mut(slot as usize)?.take()?;
        self.free_env_cells.push(slot);
        let entry = self.room_table[usize::from(cell.base.id.block())];
        let rooms = self
            .rooms
            .get_mut(entry.checked_sub(FIRST_SLOT)? as usize)?;
        rooms.retain(|&(_, s)| s != slot);
        Some(cell)
    }

    pub(super) fn insert_static(&mut self, object: StaticObject) -> StaticId {
        match self.free_statics.pop() {
            Some(slot) => {
                self.statics[slot as usize] = Some(Box::new(object));
                StaticId(slot)
            }
            None => {
                self.statics.push(Some(Box::new(object)));
                StaticId(self.statics.len() as u32 - 1)
            }
        }
    }

    pub(super) fn static_slots(&self) -> usize {
        self.statics.len()
    }

    pub(super) fn take_static(&mut self, id: StaticId) -> Option<Box<StaticObject>> {
        let object = self.statics.get_mut(id.0 as usize)?.take()?;
        self.free_statics.push(id.0);
        Some(object)
    }

    /// Lends a static object out, so that it can be worked on together with the map; [`Landscape::put_static`] gives it back.
    pub(super) fn lend_static(&mut self, id: StaticId) -> Option<Box<StaticObject>> {
        self.statics.get_mut(id.0 as usize)?.take()
    }

    pub(super) fn put_static(&mut self, id: StaticId, object: Box<StaticObject>) {
        if let Some(slot) = self.statics.get_mut(id.0 as usize) {
            *slot = Some(object);
        }
    }
}
