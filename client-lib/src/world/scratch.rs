//! Memory that is reused from tick to tick, so that a tick does not allocate.

use crate::entity::Entity;
use crate::physics::attack::AttackHit;
use crate::physics::transition::CellArray;

/// Buffers of the tick. What is in them means nothing between two uses.
#[derive(Debug, Default)]
pub struct Scratch {
    /// GUIDs of contacts that end.
    pub(crate) guids: Vec<u32>,
    /// Whom an attack reaches.
    pub(crate) hits: Vec<AttackHit>,
    /// Cells that an object touches.
    pub(crate) cells: CellArray,
    /// Stand-in of an entity that is lent to the world.
    pub(crate) spare_entity: Option<Box<Entity>>,
}
