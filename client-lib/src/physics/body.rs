//! The part of an object that others collide with: entities and the static objects of the dat files alike.

use crate::animation::PartArray;
use crate::math::Position;
use crate::physics::state::PhysicsState;
use crate::physics::transition::CellArrayEntry;
use crate::world::CellHandle;

/// Handle of an entity in its [`World`](crate::world::World). Handles are never reused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct EntityId(pub u32);

/// Handle of a static object of the dat files (building shell, landblock static, indoor static, scenery).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StaticId(pub u32);

/// An object that a cell's shadow list, a collision record or a parent link names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ObjectRef {
    /// A dynamic object.
    Entity(EntityId),
    /// A static object.
    Static(StaticId),
}

/// What the collision code may ask about the game-logic companion of an object; all `false` without one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WeenieFlags {
    /// There is a weenie.
    pub present: bool,
    /// Is a player.
    pub player: bool,
    /// Is a creature (players included).
    pub creature: bool,
    /// Is a player killer.
    pub pk: bool,
    /// Is a player-killer lite.
    pub pk_lite: bool,
    /// Is impenetrable: a player whose status is "free".
    pub impenetrable: bool,
    /// May enter barred house cells.
    pub bypasses_restrictions: bool,
    /// Is a storage container (collision exemption of its owner's missiles).
    pub storage: bool,
}

/// Place, shape and state of an object, as seen by others. Retail: the matching fields of `CPhysicsObj`.
#[derive(Debug, Clone)]
pub struct Body {
    /// Instance id; 0 for objects of the dat files.
    pub guid: u32,
    /// Place; the origin is local to the landblock of the position's cell id.
    pub position: Position,
    /// Current cell; `None` outside the world.
    pub cell: Option<CellHandle>,
    /// Physics state word.
    pub state: PhysicsState,
    /// Scale of the object; 1 is natural size.
    pub scale: f32,
    /// Skeleton and parts with their collision shapes; `None` for an object without a setup.
    pub part_array: Option<PartArray>,
    /// What the weenie answers to the collision code.
    pub weenie: WeenieFlags,
    /// Physics target of a missile: GUID or 0.
    pub target: u32,
    /// The object that carries this one.
    pub parent: Option<ObjectRef>,
    /// Its shadows, in order: one per cell that must test it. The shadow of a cell that is not there is in no list.
    pub shadows: Vec<CellArrayEntry>,
}
