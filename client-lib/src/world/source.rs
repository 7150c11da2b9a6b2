//! Where the records of a world come from.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use crate::dat::{
    Animation, DatError, DegradeInfo, EnvCell, Environment, GfxObj, Landblock, LandblockInfo,
    MotionTable, Region, Scene, Setup,
};
use crate::math::CellId;

/// What looking up a record answers: `Ok(None)` if there is none.
pub type Lookup<T> = Result<Option<Arc<T>>, DatError>;

/// Typed records by id. The same id always gives the same value.
///
/// Implemented by the dat files, and by [`MemorySource`] for worlds that are put together in memory.
pub trait WorldSource: fmt::Debug + Send + Sync {
    /// The region record, if there is one.
    fn region(&self) -> Option<Arc<Region>>;
    /// Whether there is a record of this id (0xXXYYFFFF for a landblock, or an indoor cell) in the cell file. Cheap: asked again and again
    /// while something looks beyond what is loaded.
    fn has_cell_record(&self, id: u32) -> bool;
    /// Landblock record of the block of any cell id.
    ///
    /// # Errors
    /// A damaged file or record; so for all lookups.
    fn landblock(&self, cell: CellId) -> Lookup<Landblock>;
    /// Landblock-info record of the block of any cell id.
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn landblock_info(&self, cell: CellId) -> Lookup<LandblockInfo>;
    /// An indoor cell.
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn env_cell(&self, id: CellId) -> Lookup<EnvCell>;
    /// An environment, 0x0D......
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn environment(&self, id: u32) -> Lookup<Environment>;
    /// A shape, 0x01......
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn gfx_obj(&self, id: u32) -> Lookup<GfxObj>;
    /// A degrade info, 0x11......
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn degrade_info(&self, id: u32) -> Lookup<DegradeInfo>;
    /// A setup, 0x02......
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn setup(&self, id: u32) -> Lookup<Setup>;
    /// A scene, 0x12......
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn scene(&self, id: u32) -> Lookup<Scene>;
    /// An animation, 0x03......
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn animation(&self, id: u32) -> Lookup<Animation>;
    /// A motion table, 0x09......
    ///
    /// # Errors
    /// As [`WorldSource::landblock`].
    fn motion_table(&self, id: u32) -> Lookup<MotionTable>;
}

/// A world in memory. Empty, it is a world without any land.
#[derive(Debug, Clone, Default)]
#[allow(missing_docs, reason = "maps of the record types by id")]
pub struct MemorySource {
    pub region: Option<Arc<Region>>,
    /// By id 0xXXYYFFFF.
    pub landblocks: BTreeMap<u32, Arc<Landblock>>,
    /// By id 0xXXYYFFFE.
    pub landblock_infos: BTreeMap<u32, Arc<LandblockInfo>>,
    pub env_cells: BTreeMap<u32, Arc<EnvCell>>,
    pub environments: BTreeMap<u32, Arc<Environment>>,
    pub gfx_objs: BTreeMap<u32, Arc<GfxObj>>,
    pub degrade_infos: BTreeMap<u32, Arc<DegradeInfo>>,
    pub setups: BTreeMap<u32, Arc<Setup>>,
    pub scenes: BTreeMap<u32, Arc<Scene>>,
    pub animations: BTreeMap<u32, Arc<Animation>>,
    pub motion_tables: BTreeMap<u32, Arc<MotionTable>>,
}

impl WorldSource for MemorySource {
    fn region(&self) -> Option<Arc<Region>> {
        self.region.clone()
    }

    fn has_cell_record(&self, id: u32) -> bool {
        self.landblocks.contains_key(&id) || self.env_cells.contains_key(&id)
    }

    fn landblock(&self, cell: CellId) -> Lookup<Landblock> {
        Ok(self.landblocks.get(&(cell.0 | 0xFFFF)).cloned())
    }

    fn landblock_info(&self, cell: CellId) -> Lookup<LandblockInfo> {
        Ok(self
            .landblock_infos
            .get(&(cell.0 & 0xFFFF_0000 | 0xFFFE))
            .cloned())
    }

    fn env_cell(&self, id: CellId) -> Lookup<EnvCell> {
        Ok(self.env_cells.get(&id.0).cloned())
    }

    fn environment(&self, id: u32) -> Lookup<Environment> {
        Ok(self.environments.get(&id).cloned())
    }

    fn gfx_obj(&self, id: u32) -> Lookup<GfxObj> {
        Ok(self.gfx_objs.get(&id).cloned())
    }

    fn degrade_info(&self, id: u32) -> Lookup<DegradeInfo> {
        Ok(self.degrade_infos.get(&id).cloned())
    }

    fn setup(&self, id: u32) -> Lookup<Setup> {
        Ok(self.setups.get(&id).cloned())
    }

    fn scene(&self, id: u32) -> Lookup<Scene> {
        Ok(self.scenes.get(&id).cloned())
    }

    fn animation(&self, id: u32) -> Lookup<Animation> {
        Ok(self.animations.get(&id).cloned())
    }

    fn motion_table(&self, id: u32) -> Lookup<MotionTable> {
        Ok(self.motion_tables.get(&id).cloned())
    }
}
