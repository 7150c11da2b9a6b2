//! The dat files as the source of a world.

use std::sync::Arc;

use super::source::{Lookup, WorldSource};
use crate::dat::{
    Animation, DatSet, DegradeInfo, EnvCell, Environment, GfxObj, Landblock, LandblockInfo,
    MotionTable, Region, Scene, Setup,
};
use crate::math::CellId;

impl WorldSource for DatSet {
    fn region(&self) -> Option<Arc<Region>> {
        Some(Arc::clone(Self::region(self)))
    }

    fn has_cell_record(&self, id: u32) -> bool {
        // A directory that cannot be read shows itself when the record is asked for.
        self.cell().contains(id).unwrap_or(true)
    }

    fn landblock(&self, cell: CellId) -> Lookup<Landblock> {
        self.landblock_of(cell.0)
    }

    fn landblock_info(&self, cell: CellId) -> Lookup<LandblockInfo> {
        self.landblock_info_of(cell.0)
    }

    fn env_cell(&self, id: CellId) -> Lookup<EnvCell> {
        Self::env_cell(self, id.0)
    }

    fn environment(&self, id: u32) -> Lookup<Environment> {
        Self::environment(self, id)
    }

    fn gfx_obj(&self, id: u32) -> Lookup<GfxObj> {
        Self::gfx_obj(self, id)
    }

    fn degrade_info(&self, id: u32) -> Lookup<DegradeInfo> {
        Self::degrade_info(self, id)
    }

    fn setup(&self, id: u32) -> Lookup<Setup> {
        Self::setup(self, id)
    }

    fn scene(&self, id: u32) -> Lookup<Scene> {
        Self::scene(self, id)
    }

    fn animation(&self, id: u32) -> Lookup<Animation> {
        Self::animation(self, id)
    }

    fn motion_table(&self, id: u32) -> Lookup<MotionTable> {
        Self::motion_table(self, id)
    }
}
