//! Dat files: the client's data on disk.
//!
//! A *dat file* is a small database of *records* addressed by a 32-bit id. Records are parsed into plain immutable data, one file of this
//! module per record type; what the data means is the business of the modules that use it. Lengths are metres, floats are kept bit for
//! bit, quaternions are stored w, x, y, z. Every reader is bounded: bad bytes give a [`DatError`] that names file, record, offset, what was
//! wrong and what to do.
//!
//! Source: `spec/11-dat-files.md`.

mod anim_frame;
mod animation;
mod any;
mod bsp;
mod container;
mod cyl_sphere;
mod degrade_info;
mod env_cell;
mod environment;
mod error;
mod frame;
#[doc(hidden)]
pub mod fuzzing;
mod gfx_obj;
mod hook;
mod iteration;
mod json;
mod keyed;
mod kind;
mod landblock;
mod landblock_info;
pub mod lint;
mod motion_data;
mod motion_table;
mod palette;
mod particle_emitter;
mod physics_script;
mod polygon;
mod portal_tree;
mod reader;
mod record;
mod region;
mod scene;
mod set;
mod setup;
mod sky;
mod sound_table;
mod stab;
mod surface;
mod texture;
mod vertex;
mod wave;
pub mod worldgen;
mod writer;

pub use anim_frame::AnimFrame;
pub use animation::{AnimFrameRef, Animation, AnimationFlags};
pub use any::AnyRecord;
pub use bsp::{
    BspPortal, BspTag, BspTree, CellBsp, CellInner, CellLeaf, CellNode, DrawingBsp, DrawingInner,
    DrawingNode, MAX_DEPTH, NodeId, PhysicsBsp, PhysicsInner, PhysicsLeaf, PhysicsNode, PoolRange,
};
pub use container::{
    BlockCounts, ContainerReport, DatBuilder, DatFile, Entry, HEADER_AT, HEADER_END, Header, MAGIC,
    MAX_EXPANDED, MAX_LEVELS, MAX_RECORD, NODE_BRANCHES, NODE_ENTRIES, NODE_LEAST, NODE_SIZE,
    Placement, ReadAt, ReadCounts,
};
pub use cyl_sphere::CylSphere;
pub use degrade_info::{DegradeInfo, DegradeLevel};
pub use env_cell::{CellPortal, EnvCell, EnvCellFlags, PortalFlags};
pub use environment::{CellStruct, Environment};
pub use error::{DatError, Problem, data_set_name};
pub use frame::StoredFrame;
pub use gfx_obj::{DrawingShape, GfxObj, GfxObjFlags, PhysicsShape};
pub use hook::{AnimationHook, AttackCone, CreateParticle, HookAction, HookDirection, Ramp};
pub use iteration::Iteration;
pub use keyed::KeyedList;
pub use kind::{DataSet, ITERATION_ID, REGION_ID, RecordKind};
pub use landblock::{Landblock, TerrainWord, VERTICES};
pub use landblock_info::{Building, BuildingPortal, LandblockInfo, LandblockInfoMask, MAX_ROOMS};
pub use motion_data::{AnimRange, MotionBits, MotionData, MotionDataFlags};
pub use motion_table::{MotionTable, motion_key};
pub use palette::{Palette, PaletteSet};
pub use particle_emitter::{ParticleEmitterInfo, VectorRange};
pub use physics_script::{PhysicsScript, PhysicsScriptTable, ScriptChoice, ScriptEntry};
pub use polygon::{Polygon, PolygonSet, Sides, Stippling};
pub use reader::{Note, Read, Reader, Strictness};
pub use record::Record;
pub use region::{
    AmbientSound, AmbientSounds, Calendar, LandSurface, MapGrid, PaletteShift, Region, RegionMisc,
    RegionParts, SceneType, TerrainTexture, TerrainType, TextureMerge, TimeOfDay,
};
pub use scene::{Scene, SceneObject};
pub use set::{CELL_FILE, DatSet, Kept, PORTAL_FILE};
pub use setup::{Light, Location, Setup, SetupFlags};
pub use sky::{DayGroup, Sky, SkyObject, SkyReplacement, SkyTime};
pub use sound_table::{SoundChoice, SoundSlot, SoundTable};
pub use stab::Stab;
pub use surface::{Surface, SurfaceFill, SurfaceFlags};
pub use texture::{PixelFormat, RenderSurface, SurfaceTexture};
pub use vertex::{Vertex, VertexArray};
pub use wave::Wave;
pub use writer::Writer;

#[cfg(test)]
mod tests;
