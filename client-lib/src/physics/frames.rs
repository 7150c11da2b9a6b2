//! Frame setters of an object (`spec/06-physics-object.md`, E6). None of them changes cell, shadows, velocity or contact.

use crate::entity::Entity;
use crate::math::{Frame, Position, Quat};
use crate::physics::state::PhysicsState;
use crate::profile::Profile;
use crate::world::World;

impl Entity {
    /// Takes a frame (m, landblock coordinates); parts and children follow (`set_frame`).
    ///
    /// An invalid rotation with a valid origin becomes the zero quaternion, which is no rotation: the client's repair. An invalid origin is
    /// stored as it is.
    pub fn set_frame(&mut self, mut frame: Frame, world: &mut World) {
        if frame.is_valid_except_for_heading(&world.profile) {
            frame.set_rotation_raw(Quat::new(0.0, 0.0, 0.0, 0.0));
        }
        self.set_initial_frame(frame, world);
    }

    /// As [`Entity::set_frame`], without the repair (`set_initial_frame`).
    pub(crate) fn set_initial_frame(&mut self, frame: Frame, world: &mut World) {
        self.body.position.frame = frame;
        self.update_parts(world);
        self.update_children(world);
    }

    /// Gives the parts their places, if they wait for them; see [`PartArray::settle_parts`](crate::animation::PartArray::settle_parts).
    pub fn settle_parts(&mut self, profile: &Profile) {
        if let Some(parts) = &mut self.body.part_array {
            parts.settle_parts(profile);
        }
    }

    /// The parts take the present pose at the present frame (`UpdatePartsInternal`).
    pub(crate) fn update_parts(&mut self, world: &World) {
        let collides = self.body.state.contains(PhysicsState::HAS_PHYSICS_BSP);
        let unseen = self.unposed && !collides && self.children.is_empty();
        if unseen || self.body.state.contains(PhysicsState::PARTICLE_EMITTER) {
            return;
        }
        let Some(parts) = &mut self.body.part_array else {
            return;
        };
        let frame = &self.body.position.frame;
        let asked_for =
            self.body.state.contains(PhysicsState::HAS_PHYSICS_BSP) || !self.children.is_empty();
        if asked_for {
            parts.update_parts(frame, &world.profile);
        } else {
            parts.update_parts_later(frame, &world.profile);
        }
    }

    /// Turns the object to a compass heading, degrees (`set_heading`).
    pub fn set_heading(&mut self, degrees: f32, world: &mut World) {
        let mut frame = self.body.position.frame;
        frame.set_heading(degrees, &world.profile);
        self.set_frame(frame, world);
    }

    /// Stores a place without entering a cell; an outdoor one is put into its right cell first (`store_position`).
    pub fn store_position(&mut self, position: &Position, world: &mut World) {
        let mut place = *position;
        if !place.cell.is_indoor() {
            place.adjust_to_outside(&world.profile);
        }
        self.set_cell_id(place.cell);
        self.set_frame(place.frame, world);
    }
}
