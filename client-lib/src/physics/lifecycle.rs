//! Creation, entering and leaving the world, destruction (`spec/06-physics-object.md`, G1 to G4, G7).

use crate::animation::{PartArray, PartArrayError};
use crate::entity::{Ending, Entity};
use crate::math::{CellId, Position};
use crate::motion::MotionError;
use crate::physics::attachment::LEAVING_MASK;
use crate::physics::body::EntityId;
use crate::physics::managers::TargetStatus;
use crate::physics::placement::{PlacementFlags, SetPosition, SetPositionError};
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::DestroyOrder;
use crate::world::World;

/// Placement frame that every new object gets: resting.
pub(super) const RESTING: i32 = 0x65;

impl World {
    /// Makes an object from a data id, under a GUID, outside the world and not yet in the object table (`makeObject`; N-20 with a movement
    /// manager: [`Entity::set_motion_table`]).
    ///
    /// `data_id`: 0x01...... a shape, 0x02...... a setup, 0x00...... a setup shown translucent and passable.
    ///
    /// # Errors
    /// The shape or setup cannot be had. Profile `ace` keeps such an object, without parts (O-44).
    pub fn make_object(
        &mut self,
        data_id: u32,
        guid: u32,
        dynamic: bool,
    ) -> Result<EntityId, PartArrayError> {
        let mut entity = self.entities.create(guid, self.clock.now);
        entity.body.state.set(PhysicsState::STATIC, !dynamic);
        entity.unposed = self.plan.as_ref().is_some_and(|p| p.omits_pose(guid));
        let id = entity.id;
        match entity.init_part_array(data_id, self) {
            Err(error) if !self.profile.failed_creation_kept => return Err(error),
            _ => {}
        }
        entity.set_placement_frame(RESTING, self);
        self.entities.put(entity);
        Ok(id)
    }

    /// Ends an entity's life in the world (`DestroyObject`, G4; O-51). The object goes on existing outside world and object table. One that
    /// is taken out, because something is being done to it, leaves the object table now and the rest when it is put back.
    pub fn destroy_entity(&mut self, id: EntityId) {
        if self.entities.is_out(id) {
            self.forget(id);
            self.entities.end_later(id, Ending::Destroyed);
            return;
        }
        let order = self.profile.destroy_order;
        self.with_entity(id, |entity, world| match order {
            DestroyOrder::LeaveThenExit => {
                entity.leave_cell(false, world);
                entity.remove_shadows_from_cells(world);
                entity.leave_world(world);
                entity.exit_world(world);
            }
            DestroyOrder::ExitThenLeave => entity.leave_for_good(world),
        });
        self.forget(id);
    }

    /// Takes an entity out of the object table and of all maintenance lists.
    pub fn forget(&mut self, id: EntityId) {
        self.entities.unregister(id);
        self.static_animations.retain(|&e| e != id);
        self.lost.remove(id);
        self.doomed.remove(id);
        if self.local_player == Some(id) {
            self.local_player = None;
        }
    }

    /// Ends an entity's life and existence: it lets go of its parent and children, is [destroyed](World::destroy_entity), and is gone.
    pub fn delete_entity(&mut self, id: EntityId) {
        if self.entities.is_out(id) {
            self.forget(id);
            self.entities.end_later(id, Ending::Deleted);
            return;
        }
        self.with_entity(id, |entity, world| {
            entity.unset_parent(world);
            entity.unparent_children(world);
        });
        self.destroy_entity(id);
        self.entities.remove(id);
    }

    /// Lost entities whose cell was loaded meanwhile re-enter (G7), in the order in which the cells came. One that finds no room keeps its
    /// place outside all cells.
    pub fn readmit_lost(&mut self) {
        for id in self.lost.take_arrived() {
            self.with_entity(id, |entity, world| entity.reenter_visibility(world));
        }
    }

    /// The entities that are due for deletion without a message: out of sight for 25 s (G7).
    pub fn due_for_destruction(&mut self) -> Vec<EntityId> {
        self.doomed.due(self.clock.now)
    }
}

impl Entity {
    /// Gives the object its parts (`InitPartArrayObject`).
    pub(super) fn init_part_array(
        &mut self,
        data_id: u32,
        world: &mut World,
    ) -> Result<(), PartArrayError> {
        let (resources, profile) = (&mut world.resources, &world.profile);
        let shown_only = data_id >> 24 == 0 && data_id != 0;
        let parts = match data_id >> 24 {
            0x01 => PartArray::mesh(data_id, resources),
            0x00 if shown_only => PartArray::with_setup(0x0200_0000 | data_id, resources, profile),
            0x02 => PartArray::with_setup(data_id, resources, profile),
            _ => Err(PartArrayError::MissingSetup(data_id)),
        }?;
        self.init_defaults(&parts, world);
        self.body.part_array = Some(parts);
        self.cache_has_physics_bsp();
        if shown_only {
            self.set_ethereal(true, world);
            self.set_translucency(0.25);
            self.body.state.insert(PhysicsState::IGNORE_COLLISIONS);
        }
        Ok(())
    }

    /// The setup's defaults (`InitDefaults`). The parts are not attached yet, so the setup's motion table is not taken: a new object has
    /// none until somebody assigns one.
    fn init_defaults(&mut self, parts: &PartArray, world: &mut World) {
        let Some(setup) = parts.setup() else { return };
        self.default_script = setup.default_script;
        if !self.body.state.contains(PhysicsState::STATIC) {
            return;
        }
        let (animated, scripted) = (setup.default_animation != 0, setup.default_script != 0);
        if animated {
            self.body.state.insert(PhysicsState::HAS_DEFAULT_ANIM);
        }
        if scripted {
            self.body.state.insert(PhysicsState::HAS_DEFAULT_SCRIPT);
        }
        if (animated || scripted) && !world.static_animations.contains(&self.id) {
            world.static_animations.push(self.id);
        }
    }

    /// Enters the world at a position (`enter_world`); `false` when there is no room.
    pub fn enter_world_at(&mut self, position: &Position, slide: bool, world: &mut World) -> bool {
        self.store_position(position, world);
        self.enter_world(slide, world) == Ok(())
    }

    /// Enters the world at the stored position (`enter_world`). Also true when the object ended in the lost cell.
    ///
    /// # Errors
    /// Why it could not be placed; a carried object answers [`SetPositionError::GeneralFailure`]. The object then keeps its stored position
    /// and stays active until its next update.
    pub fn enter_world(&mut self, slide: bool, world: &mut World) -> Result<(), SetPositionError> {
        if self.body.parent.is_some() {
            return Err(SetPositionError::GeneralFailure);
        }
        self.kin.update_time = world.clock.now;
        let mut flags = PlacementFlags::PLACEMENT;
        flags.set(PlacementFlags::SLIDE, slide);
        let error = self.set_position(&SetPosition::new(self.body.position, flags), world);
        if error != SetPositionError::Ok {
            return Err(error);
        }
        self.set_active(true, world);
        self.remove_link_animations(world);
        Ok(())
    }

    /// The object is about to be placed (`prepare_to_enter_world`).
    pub(crate) fn prepare_to_enter_world(&mut self, world: &mut World) {
        self.kin.update_time = world.clock.now;
        world.lost.remove(self.id);
        world.doomed.remove(self.id);
        for child in &self.children {
            world.doomed.remove(child.object);
        }
        self.set_active(true, world);
    }

    /// The object is about to be out of sight (`prepare_to_leave_visibility`).
    pub(crate) fn prepare_to_leave_visibility(&mut self, world: &mut World) {
        self.remove_shadows_from_cells(world);
        world.lost.remove(self.id);
        self.leave_cell(false, world);
        let now = world.clock.now;
        world.doomed.insert(self.id, now);
        for child in &self.children {
            world.doomed.insert(child.object, now);
        }
    }

    /// The object's cell was unloaded (`leave_visibility`).
    pub fn leave_visibility(&mut self, world: &mut World) {
        let place = self.body.position;
        self.become_lost(&place, world);
    }

    /// The cell of a lost object was loaded (`reenter_visibility`).
    pub fn reenter_visibility(&mut self, world: &mut World) -> bool {
        self.prepare_to_enter_world(world);
        let flags = PlacementFlags::PLACEMENT | PlacementFlags::SEND_POSITION_EVENT;
        let place = SetPosition::new(self.body.position, flags);
        self.set_position(&place, world) == SetPositionError::Ok
    }

    /// Leaves cell and shadows; contact and activity end (`leave_world`).
    pub fn leave_world(&mut self, world: &mut World) {
        self.report_collision_end(true, world);
        world.lost.remove(self.id);
        world.doomed.remove(self.id);
        self.kin.transient.remove(TransientState::ACTIVE);
        self.remove_shadows_from_cells(world);
        self.leave_cell(false, world);
        self.set_cell_id(CellId::NONE);
        self.kin.transient.remove(TransientState::CONTACT);
        self.kin.calc_acceleration(self.body.state, &world.profile);
        let was_walkable = self.kin.transient.contains(TransientState::ON_WALKABLE);
        self.kin
            .transient
            .remove(TransientState::WATER_CONTACT | TransientState::ON_WALKABLE);
        if was_walkable {
            self.leave_ground(world);
        }
        self.kin.calc_acceleration(self.body.state, &world.profile);
        self.kin.transient.remove(LEAVING_MASK);
    }

    /// Ends motions, moves, sticking and watching (`exit_world`).
    pub fn exit_world(&mut self, world: &mut World) {
        self.exit_animations(world);
        if self.movement.is_some() {
            self.movement_exit_world(world);
        }
        self.unstick_from_object(world);
        self.leave_targets(TargetStatus::ExitWorld, world);
        self.report_collision_end(true, world);
    }

    /// What a scene's destroy step does, up to the object table: `exit_world`, detached from parent and children, `leave_world`.
    pub fn leave_for_good(&mut self, world: &mut World) {
        self.exit_world(world);
        self.unset_parent(world);
        self.unparent_children(world);
        self.leave_world(world);
    }

    /// A teleport ends what the object was doing (`teleport_hook`).
    pub fn teleport_hook(&mut self, world: &mut World) {
        self.cancel_moveto_with(MotionError::Teleported, world);
        self.unstick_from_object(world);
        self.stop_interpolating();
        self.unconstrain();
        self.leave_targets(TargetStatus::Teleported, world);
        self.report_collision_end(true, world);
    }

    /// Ends watching, and tells those who watch this object (F5).
    fn leave_targets(&mut self, status: TargetStatus, world: &mut World) {
        if self.target_manager.is_some() {
            self.clear_target(world);
            self.notify_voyeurs(status, world);
        }
    }
}
