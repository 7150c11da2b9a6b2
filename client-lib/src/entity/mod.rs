//! Entities: the dynamic objects of the world, and the store that owns them.

#[allow(
    clippy::module_inception,
    reason = "the type Entity lives in the file of its name"
)]
mod entity;
mod frame_state;
mod store;
mod weenie;

pub use entity::{Child, CollisionRecord, CollisionTable, Entity, Kinetics, Timestamps};
pub(crate) use store::Ending;
pub use store::Entities;
pub use weenie::{
    AttackReport, CollisionProfile, CollisionReport, EnvironmentReport, HouseAccess, ObjectReport,
    Weenie,
};
