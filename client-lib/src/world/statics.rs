//! Static objects: what the dat files place in the world (`spec/03-cells.md`, sections 12 and 14; `spec/06-physics-object.md`, G1).
//!
//! They collide, never move, have no GUID, and are reported as environment.

use super::cell::BuildingPortal;
use super::resources::Resources;
use crate::animation::PartArray;
use crate::dat::StoredFrame;
use crate::entity::Entity;
use crate::math::{Frame, Position};
use crate::physics::body::{Body, WeenieFlags};
use crate::physics::state::PhysicsState;
use crate::profile::Profile;

/// What placed a static object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StaticKind {
    /// The shell of a building; it is in no object list and casts no shadow.
    Building,
    /// The landblock info.
    Landblock,
    /// An indoor cell.
    Room,
    /// The scenery generator.
    Scenery,
}

/// An object of the dat files.
#[derive(Debug, Clone)]
pub struct StaticObject {
    /// Place, shape and state.
    pub body: Body,
    /// What placed it.
    pub kind: StaticKind,
    /// Shape or setup.
    pub model: u32,
    /// Openings of a building.
    pub portals: Vec<BuildingPortal>,
    /// Leaves of a building's drawing tree.
    pub leaf_count: u32,
}

/// Frame of a dat record.
pub(super) fn frame_of(stored: &StoredFrame) -> Frame {
    Frame::new(stored.origin, stored.rotation)
}

impl StaticObject {
    /// A static object of a shape (0x01......) or setup (0x02......), nowhere yet (`makeObject`). `None` if it cannot be made.
    pub(super) fn make(
        model: u32,
        kind: StaticKind,
        resources: &mut Resources,
        profile: &Profile,
    ) -> Option<Self> {
        const SETUP: u32 = 0x0200_0000;
        let mut state =
            PhysicsState::from_bits_retain(Entity::DEFAULT_STATE) | PhysicsState::STATIC;
        let parts = match model >> 24 {
            _ if model == 0 => return None,
            0x01 => PartArray::mesh(model, resources),
            0x02 => PartArray::with_setup(model, resources, profile),
            0x00 => {
                state |= PhysicsState::ETHEREAL | PhysicsState::IGNORE_COLLISIONS;
                PartArray::with_setup(SETUP | model, resources, profile)
            }
            _ => return None,
        };
        let parts = parts.ok()?;
        if let Some(setup) = parts.setup() {
            let defaults = [
                (setup.default_animation, PhysicsState::HAS_DEFAULT_ANIM),
                (setup.default_script, PhysicsState::HAS_DEFAULT_SCRIPT),
            ];
            for (id, bit) in defaults {
                state.set(bit, id != 0);
            }
        }
        state.set(PhysicsState::HAS_PHYSICS_BSP, parts.has_physics_bsp());
        Some(Self {
            body: Body {
                guid: 0,
                position: Position::default(),
                cell: None,
                state,
                scale: 1.0,
                part_array: Some(parts),
                weenie: WeenieFlags::default(),
                target: 0,
                parent: None,
                shadows: Vec::new(),
            },
            kind,
            model,
            portals: Vec::new(),
            leaf_count: 0,
        })
    }

    /// Puts the object at a frame of its cell's block, parts included.
    pub(super) fn place(&mut self, at: Position, profile: &Profile) {
        self.body.position = at;
        if let Some(parts) = &mut self.body.part_array {
            parts.set_cell_id(at.cell);
            parts.update_parts(&at.frame, profile);
        }
    }

    /// Whether the object has a cell and all its shadows are in lists.
    pub fn is_completely_visible(&self) -> bool {
        self.body.cell.is_some()
            && !self.body.shadows.is_empty()
            && self.body.shadows.iter().all(|s| s.cell.is_some())
    }
}
