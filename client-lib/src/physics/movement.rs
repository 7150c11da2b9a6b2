//! What motion code asks of the physics object: the wrappers around part array and movement manager
//! (`spec/06-physics-object.md`, E7; `spec/07-animation.md`, 12; `spec/08-motion.md`, 10.11).
//!
//! A finished motion is reported the moment it is found, so that what the object does about it happens before the next one is looked at.

use crate::animation::{CompletionRun, MotionRequest};
use crate::entity::Entity;
use crate::frame::state::FrameEvent;
use crate::math::Vec3;
use crate::physics::managers::PositionManager;
use crate::profile::ManagerActivation;
use crate::world::World;

/// Error of a motion command on an object without parts: general movement failure.
pub const GENERAL_MOVEMENT_FAILURE: u32 = 0x47;

impl Entity {
    /// Starts a motion of the motion table (`DoInterpretedMotion`); 0, or the client's error code.
    pub fn do_interpreted_motion(&mut self, motion: u32, speed: f32, world: &mut World) -> u32 {
        self.perform_table_motion(MotionRequest::Do { motion, speed }, world)
    }

    /// Stops a motion of the motion table (`StopInterpretedMotion`); 0, or the client's error code.
    pub fn stop_interpreted_motion(&mut self, motion: u32, world: &mut World) -> u32 {
        self.perform_table_motion(MotionRequest::Stop { motion }, world)
    }

    /// Stops all motions of the motion table (`StopCompletely_Internal`); 0, or the client's error code.
    pub fn stop_completely_internal(&mut self, world: &mut World) -> u32 {
        self.perform_table_motion(MotionRequest::StopCompletely, world)
    }

    fn perform_table_motion(&mut self, request: MotionRequest, world: &mut World) -> u32 {
        let Some(parts) = &mut self.body.part_array else {
            return GENERAL_MOVEMENT_FAILURE;
        };
        match parts.perform_motion(request, &mut world.resources, &world.profile) {
            Ok(()) => 0,
            Err(error) => error.code(),
        }
    }

    /// Starts the default motion of the motion table (`InitializeMotionTables`).
    pub fn initialize_motion_tables(&mut self, world: &mut World) {
        if let Some(parts) = &mut self.body.part_array {
            parts.initialize_motion_tables(&mut world.resources, &world.profile);
        }
    }

    /// Reports what needs no more animations (`CheckForCompletedMotions`, `HandleMovement`).
    pub fn check_for_completed_motions(&mut self, world: &mut World) {
        let Some(parts) = &mut self.body.part_array else {
            return;
        };
        let run = parts.check_for_completed_motions();
        self.report_completions(run, world);
    }

    /// Drops the playing links and completes all motions unsuccessfully (`RemoveLinkAnimations`; the part array's `HandleEnterWorld`).
    pub fn remove_link_animations(&mut self, world: &mut World) {
        let Some(parts) = &mut self.body.part_array else {
            return;
        };
        let run = parts.handle_enter_world();
        self.report_completions(run, world);
    }

    /// Completes all motions unsuccessfully (the part array's `HandleExitWorld`).
    pub(crate) fn exit_animations(&mut self, world: &mut World) {
        let Some(parts) = &mut self.body.part_array else {
            return;
        };
        let run = parts.handle_exit_world();
        self.report_completions(run, world);
    }

    /// An animation ended (`Hook_AnimDone`).
    pub(crate) fn hook_animation_done(&mut self, world: &mut World) {
        let Some(parts) = &mut self.body.part_array else {
            return;
        };
        let run = parts.animation_done(true);
        self.report_completions(run, world);
    }

    fn report_completions(&mut self, mut run: CompletionRun, world: &mut World) {
        while let Some(notice) = self
            .body
            .part_array
            .as_mut()
            .and_then(|parts| parts.next_completion(&mut run))
        {
            self.motion_done(notice.motion, notice.success, world);
        }
    }

    /// A motion is done (`MotionDone`): the movement manager is told.
    fn motion_done(&mut self, motion: u32, success: bool, world: &mut World) {
        self.events.push(FrameEvent::MotionDone(motion));
        self.movement_motion_done(motion, success, world);
    }

    /// Tells the movement manager, if there is one, that the object landed (`HitGround`).
    pub(crate) fn hit_ground(&mut self, world: &mut World) {
        if self.movement.is_some() {
            self.events.push(FrameEvent::HitGround);
            self.movement_hit_ground(world);
        }
    }

    /// Tells the movement manager, if there is one, that the object left the ground (`LeaveGround`).
    pub(crate) fn leave_ground(&mut self, world: &mut World) {
        if self.movement.is_some() {
            self.events.push(FrameEvent::LeaveGround);
            self.movement_leave_ground(world);
        }
    }

    /// Makes the movement manager if there is none, in its default state if `enter_default_state`, and activates the object
    /// (`MakeMovementManager`; O-36).
    pub fn make_movement_manager(&mut self, enter_default_state: bool, world: &mut World) {
        if self.movement.is_some() {
            return;
        }
        self.movement = Some(Box::default());
        if enter_default_state {
            self.movement_enter_default_state(world);
        }
        self.set_active(true, world);
    }

    /// Assigns a motion table (`SetMotionTableID`): the movement manager is made anew in its default state. `false` without a part array.
    pub fn set_motion_table(&mut self, id: u32, world: &mut World) -> bool {
        let Some(parts) = &mut self.body.part_array else {
            return false;
        };
        parts.set_motion_table(id, &mut world.resources, &world.profile);
        self.movement = None;
        if id != 0 {
            self.make_movement_manager(true, world);
        }
        true
    }

    /// The position manager, made if missing, which activates the object (O-36).
    pub fn make_position_manager(&mut self, world: &mut World) -> &mut PositionManager {
        let every_request =
            world.profile.manager_activation == ManagerActivation::PositionEveryRequest;
        if self.position_manager.is_none() || every_request {
            self.set_active(true, world);
        }
        self.position_manager.get_or_insert_default()
    }

    /// Activates or deactivates the object (`set_active`); `false` when a static object was to be activated.
    pub fn set_active(&mut self, active: bool, world: &World) -> bool {
        self.kin
            .set_active(active, self.body.state, world.clock.now)
    }

    /// Takes a velocity, m/s in world axes (`set_velocity`).
    pub fn set_velocity(&mut self, velocity: Vec3, world: &World) {
        self.kin
            .set_velocity(velocity, self.body.state, world.clock.now, &world.profile);
    }

    /// Takes a velocity in the object's own axes, m/s (`set_local_velocity`).
    pub fn set_local_velocity(&mut self, velocity: Vec3, world: &World) {
        let velocity = self
            .body
            .position
            .frame
            .local_to_global_vec(velocity, &world.profile);
        self.set_velocity(velocity, world);
    }

    /// The velocity in the object's own axes, m/s (`get_local_physics_velocity`).
    pub fn local_velocity(&self, world: &World) -> Vec3 {
        self.body
            .position
            .frame
            .global_to_local_vec(self.kin.velocity, &world.profile)
    }

    /// Scaled radius of the setup, m; 0 without parts.
    pub fn radius(&self) -> f32 {
        self.body.part_array.as_ref().map_or(0.0, |p| p.radius())
    }

    /// Scaled height of the setup, m; 0 without parts.
    pub fn height(&self) -> f32 {
        self.body.part_array.as_ref().map_or(0.0, |p| p.height())
    }

    /// Compass heading, degrees.
    pub fn heading(&self, world: &World) -> f32 {
        self.body.position.frame.heading(&world.profile)
    }
}
