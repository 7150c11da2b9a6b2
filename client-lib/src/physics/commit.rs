//! Committing the result of a transition (`spec/06-physics-object.md`, C2) and standing on ground (B7).

use crate::entity::Entity;
use crate::math::Position;
use crate::physics::state::{PhysicsState, TransientState};
use crate::physics::transition::{TransitionResult, is_valid_walkable};
use crate::world::World;

impl Entity {
    /// Takes over cell, frame, contact and collisions of a transition (`SetPositionInternal`).
    pub(crate) fn set_position_internal(&mut self, result: &TransitionResult, world: &mut World) {
        let was_walkable = self.kin.transient.contains(TransientState::ON_WALKABLE);
        let was_contact = self.kin.transient.contains(TransientState::CONTACT);
        let Some(cell) = result.cell else {
            self.become_lost(&result.position, world);
            return;
        };
        if world.profile.frame_before_cell {
            self.set_frame(result.position.frame, world);
        }
        if self.body.cell == Some(cell) {
            self.set_cell_id(result.position.cell);
            self.set_cell_id_of_children(result.position.cell, world);
        } else {
            self.change_cell(Some(cell), world);
        }
        if !world.profile.frame_before_cell {
            self.set_frame(result.position.frame, world);
        }
        self.take_contact(result, world);
        self.kin.sliding_normal = result.info.sliding_normal;
        self.kin
            .transient
            .set(TransientState::SLIDING, result.info.sliding_normal_valid);
        self.handle_all_collisions(&result.info, was_contact, was_walkable, world);
        if self.body.cell.is_none() {
            return;
        }
        if self.body.state.contains(PhysicsState::HAS_PHYSICS_BSP) {
            self.calc_cross_cells(world);
        } else if result.cells.entries().next().is_some() {
            self.move_shadows_to_cells(&result.cells, world);
        }
    }

    /// Contact plane, water, ground (C2 steps 5 to 8).
    fn take_contact(&mut self, result: &TransitionResult, world: &mut World) {
        let plane = &result.info.contact_plane;
        // Copied whether or not it is valid.
        self.kin.contact_plane = plane.plane;
        self.kin.contact_plane_cell_id = plane.cell_id;
        self.kin.transient.set(TransientState::CONTACT, plane.valid);
        self.kin.calc_acceleration(self.body.state, &world.profile);
        self.kin
            .transient
            .set(TransientState::WATER_CONTACT, plane.is_water);
        if plane.valid {
            let walkable = is_valid_walkable(plane.plane.n, &world.profile);
            self.set_on_walkable(walkable, world);
            return;
        }
        let was_walkable = self.kin.transient.contains(TransientState::ON_WALKABLE);
        self.kin.transient.remove(TransientState::ON_WALKABLE);
        if was_walkable {
            self.leave_ground(world);
        }
        self.kin.calc_acceleration(self.body.state, &world.profile);
    }

    /// Stands on walkable ground, or no longer (`set_on_walkable`, B7); the movement manager is told of a change.
    pub fn set_on_walkable(&mut self, walkable: bool, world: &mut World) {
        let was = self.kin.transient.contains(TransientState::ON_WALKABLE);
        self.kin
            .transient
            .set(TransientState::ON_WALKABLE, walkable);
        if was && !walkable {
            self.leave_ground(world);
        } else if !was && walkable {
            self.hit_ground(world);
        }
        self.kin.calc_acceleration(self.body.state, &world.profile);
    }

    /// Leaves all cells and waits, inactive, until the cell of `position` is there (C2 step 2; G7).
    pub(crate) fn become_lost(&mut self, position: &Position, world: &mut World) {
        self.prepare_to_leave_visibility(world);
        self.store_position(position, world);
        world.lost.insert(self.body.position.cell, self.id);
        self.kin.transient.remove(TransientState::ACTIVE);
    }
}
