//! The transition: takes an object from where it is to where it wants to be, and answers with what it may have
//! (`spec/05-transition.md`). Retail: `CTransition`, `SPHEREPATH`, `COLLISIONINFO`, `OBJECTINFO`.
//!
//! A transition is discrete: the path is cut into steps of at most one sphere radius; every step is *inserted* at its goal, tested against all
//! the cells it touches, and pushed out, lifted, lowered, slid or taken back.
//!
//! Read in this order: [`run`] (how a transition is started and what it gives back), `movement` (the step loop), `insert` (one insertion),
//! `step` and `edge` (stairs, ground, edges), `validate` (accepting a step), `placement`, `object_collision` (one target object),
//! `walkable` (terrain). `records` has the small operations on the records of `state` that all of them and the collision primitives use.
//!
//! "Block coordinates" are metres from the south-west corner of the landblock of the named position; up is +z.

mod edge;
mod init;
mod insert;
mod movement;
mod object_collision;
mod object_info;
mod placement;
mod reach;
mod records;
pub mod run;
mod slots;
mod sphere_path;
mod state;
mod step;
mod validate;
mod walkable;

pub use object_info::is_valid_walkable;
pub use run::{
    ContactSeed, MoverSpheres, Outcome, Path, SphereUse, TransitionInput, TransitionResult,
};
pub(crate) use slots::LeftFields;
pub use slots::{Transit, TransitionSlots};
pub use state::{
    CellArray, CellArrayEntry, CollisionInfo, ContactPlane, InsertType, ObjectInfo,
    ObjectInfoState, Progress, SpherePath, Transition, TransitionState,
};
pub use walkable::TerrainContact;

/// A surface is walkable when the z of its normal is at least this (about 48.38° from flat).
pub const FLOOR_Z: f32 = 0.664_174_14;
/// [`FLOOR_Z`] before it is rounded, for profiles that compare in f64 (`T-12`).
pub const FLOOR_Z_F64: f64 = 0.664_174_146_186_627_5;
/// The looser limit while landing (about 85°).
pub const LANDING_Z: f32 = 0.087_155_7;
/// Step height (m) of a mover that is not on walkable ground.
pub const DEFAULT_STEP_HEIGHT: f32 = 0.04;
/// Attempts of an insert: a movement step or a placement probe.
pub const MOVE_ATTEMPTS: u32 = 3;
/// Attempts of an insert inside a step down.
pub const STEP_DOWN_ATTEMPTS: u32 = 5;
/// Sub-steps of one transition, beyond which it is refused. The references have no limit (or 1000, `T-16`); a simulation step moves an
/// object by some metres, so that only nonsense gets here, and the transition always ends.
pub const MAX_SUB_STEPS: u32 = 1_000_000;
/// Probes of one placement search, beyond which it fails. Spheres of 0.125 m and more need at most 270; a sphere with a radius below
/// about 1 cm would need more than this.
pub const MAX_PLACEMENT_PROBES: u32 = 200_000;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod walk_tests;
