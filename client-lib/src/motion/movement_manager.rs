//! The movement manager: owner of the interpreter and the move-to manager of one object, and the object's entries to both.
//!
//! Source: `spec/08-motion.md`, section 10, and `spec/06-physics-object.md`, E7.

use super::{
    Command, InterpretedMotionState, MotionError, MotionInterp, MotionResult, MoveToManager,
    MovementParameters, Mover, RawMotionState,
};
use crate::entity::Entity;
use crate::math::Position;
use crate::physics::managers::TargetInfo;
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::{DefaultState, ManagerActivation};
use crate::world::World;

/// Owns the motion interpreter and the move-to manager of one object. Retail: `MovementManager`.
#[derive(Debug, Clone, Default)]
pub struct MovementManager {
    /// Made on first use.
    pub interp: Option<MotionInterp>,
    /// Made by the first move-to.
    pub move_to: Option<MoveToManager>,
}

/// A request to the movement manager (retail: `MovementStruct`; `spec/08-motion.md`, 2.5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Movement {
    /// Type 1: a command in the input's terms.
    Raw(Command, MovementParameters),
    /// Type 2: a normalised command.
    Interpreted(Command, MovementParameters),
    /// Type 3: the end of a command in the input's terms.
    StopRaw(Command, MovementParameters),
    /// Type 4: the end of a normalised command.
    StopInterpreted(Command, MovementParameters),
    /// Type 5: the end of everything.
    StopCompletely,
    /// Type 6: walk to an object.
    MoveToObject(MoveTarget, MovementParameters),
    /// Type 7: walk to a place.
    MoveToPosition(Position, MovementParameters),
    /// Type 8: turn to an object.
    TurnToObject(MoveTarget, MovementParameters),
    /// Type 9: turn to the desired heading.
    TurnToHeading(MovementParameters),
}

/// The object that a move-to goes to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MoveTarget {
    /// GUID that was asked for.
    pub object_id: u32,
    /// GUID of its carrier if it is carried, else its own: the one whose place counts.
    pub top_level_id: u32,
    /// Radius, m.
    pub radius: f32,
    /// Height, m.
    pub height: f32,
}

/// On whose behalf a movement manager is made (`O-36`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ManagerFor {
    /// A motion.
    Motion,
    /// A question to the interpreter (`get_minterp`).
    Interpreter,
    /// A move-to or a turn.
    MoveTo,
}

impl Entity {
    /// What the interpreter sees of this object.
    pub fn mover<'a>(&'a self, world: &'a World) -> Mover<'a> {
        Mover {
            profile: &world.profile,
            weenie: self.weenie.as_ref(),
            creature: self.body.weenie.creature,
            gravity: self.body.state.contains(PhysicsState::GRAVITY),
            transient: self.kin.transient,
        }
    }

    /// The interpreter, if there is one; nothing is made.
    pub fn interp(&self) -> Option<&MotionInterp> {
        self.movement.as_ref()?.interp.as_ref()
    }

    /// The interpreter, if there is one; nothing is made.
    pub fn interp_mut(&mut self) -> Option<&mut MotionInterp> {
        self.movement.as_mut()?.interp.as_mut()
    }

    /// The move-to manager, if there is one; nothing is made.
    pub fn move_to(&self) -> Option<&MoveToManager> {
        self.movement.as_ref()?.move_to.as_ref()
    }

    pub(super) fn move_to_mut(&mut self) -> Option<&mut MoveToManager> {
        self.movement.as_mut()?.move_to.as_mut()
    }

    /// Makes the movement manager if there is none. Profile `ace` activates the object differently (`O-36`).
    fn require_movement_manager(&mut self, made_for: ManagerFor, world: &mut World) {
        if self.movement.is_some() {
            return;
        }
        let (transient, update_time) = (self.kin.transient, self.kin.update_time);
        let was_active = transient.contains(TransientState::ACTIVE);
        self.make_movement_manager(true, world);
        if world.profile.manager_activation == ManagerActivation::Ace {
            match made_for {
                ManagerFor::MoveTo => self.kin.transient.remove(TransientState::ACTIVE),
                ManagerFor::Interpreter if !was_active => {
                    self.kin.transient.remove(TransientState::ACTIVE);
                    self.kin.update_time = update_time;
                }
                ManagerFor::Interpreter | ManagerFor::Motion => {}
            }
        }
    }

    /// `MovementManager::EnterDefaultState` (10.3; `D8`).
    pub fn movement_enter_default_state(&mut self, world: &mut World) {
        let fresh = self.interp().is_none();
        self.ensure_interp();
        if fresh && world.profile.default_state == DefaultState::Twice {
            self.enter_default_state(world);
        }
        self.enter_default_state(world);
    }

    fn ensure_interp(&mut self) {
        let movement = self.movement.get_or_insert_default();
        movement.interp.get_or_insert_default();
    }

    /// Makes the interpreter, in its default state, if the manager has none (`MovementManager::get_minterp`).
    fn manager_interp(&mut self, world: &mut World) {
        if self.interp().is_none() {
            self.ensure_interp();
            self.enter_default_state(world);
        }
    }

    /// The interpreter; manager and interpreter are made if missing, which activates the object (`get_minterp`).
    pub fn get_interp(&mut self, world: &mut World) -> &mut MotionInterp {
        self.require_movement_manager(ManagerFor::Interpreter, world);
        self.manager_interp(world);
        self.movement
            .get_or_insert_default()
            .interp
            .get_or_insert_default()
    }

    /// Carries a movement out; the manager is made if missing (the generic `PerformMovement` wrapper).
    ///
    /// # Errors
    /// What the interpreter answers. A move-to reports its failures only by ending.
    pub fn perform_movement(&mut self, movement: &Movement, world: &mut World) -> MotionResult {
        let made_for = match movement {
            Movement::MoveToObject(..)
            | Movement::MoveToPosition(..)
            | Movement::TurnToObject(..)
            | Movement::TurnToHeading(..) => ManagerFor::MoveTo,
            _ => ManagerFor::Motion,
        };
        self.require_movement_manager(made_for, world);
        self.set_active(true, world);
        if made_for == ManagerFor::MoveTo {
            if let Some(manager) = &mut self.movement {
                let now = world.clock.now;
                manager
                    .move_to
                    .get_or_insert_with(|| MoveToManager::new(now));
            }
            self.begin_move_to(movement, world);
            return Ok(());
        }
        self.manager_interp(world);
        let result = match movement {
            Movement::Raw(command, params) => self.interp_do_motion(*command, params, world),
            Movement::Interpreted(command, params) => {
                self.interp_do_interpreted_motion(*command, params, world)
            }
            Movement::StopRaw(command, params) => self.interp_stop_motion(*command, params, world),
            Movement::StopInterpreted(command, params) => {
                self.interp_stop_interpreted_motion(*command, params, world)
            }
            _ => self.interp_stop_completely(world),
        };
        self.check_for_completed_motions(world);
        result
    }

    /// A movement on behalf of the local input whose manager is made if missing: what the steps of a scene do (10.12).
    ///
    /// # Errors
    /// As [`Entity::perform_movement`].
    pub fn perform_autonomous_movement(
        &mut self,
        movement: &Movement,
        world: &mut World,
    ) -> MotionResult {
        self.kin.last_move_was_autonomous = true;
        self.perform_movement(movement, world)
    }

    /// A raw motion on behalf of the local input (`DoMotion` wrapper, 10.11).
    ///
    /// # Errors
    /// [`MotionError::NoAnimationTable`] without a movement manager, else the interpreter's answer.
    pub fn do_motion(
        &mut self,
        command: Command,
        params: &MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        self.kin.last_move_was_autonomous = true;
        if self.movement.is_none() {
            return Err(MotionError::NoAnimationTable);
        }
        self.perform_movement(&Movement::Raw(command, *params), world)
    }

    /// The end of a raw motion on behalf of the local input (`StopMotion` wrapper).
    ///
    /// # Errors
    /// [`MotionError::NoAnimationTable`] without a movement manager, else the interpreter's answer.
    pub fn stop_motion(
        &mut self,
        command: Command,
        params: &MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        self.kin.last_move_was_autonomous = true;
        if self.movement.is_none() {
            return Err(MotionError::NoAnimationTable);
        }
        self.perform_movement(&Movement::StopRaw(command, *params), world)
    }

    /// Ends every motion, if there is a movement manager (`StopCompletely` wrapper).
    pub fn stop_completely(&mut self, world: &mut World) {
        if self.movement.is_some() {
            // Type 5 has no failures.
            let _ = self.perform_movement(&Movement::StopCompletely, world);
        }
    }

    /// Walks to the object of a GUID; `false` if there is none (`MoveToObject` wrapper).
    pub fn move_to_object(
        &mut self,
        guid: u32,
        params: &MovementParameters,
        world: &mut World,
    ) -> bool {
        let Some(target) = self.move_target(guid, world) else {
            return false;
        };
        let movement = Movement::MoveToObject(target, *params);
        self.perform_movement(&movement, world).is_ok()
    }

    /// Walks to a place (`MoveToPosition` wrapper).
    pub fn move_to_position(
        &mut self,
        position: &Position,
        params: &MovementParameters,
        world: &mut World,
    ) {
        let movement = Movement::MoveToPosition(*position, *params);
        // Move-to types have no failures here.
        let _ = self.perform_movement(&movement, world);
    }

    /// Turns to the object of a GUID; `false` if there is none (`TurnToObject` wrapper).
    pub fn turn_to_object(
        &mut self,
        guid: u32,
        params: &MovementParameters,
        world: &mut World,
    ) -> bool {
        let Some(target) = self.move_target(guid, world) else {
            return false;
        };
        let movement = Movement::TurnToObject(target, *params);
        self.perform_movement(&movement, world).is_ok()
    }

    /// Turns to the desired heading of `params` (`TurnToHeading` wrapper).
    pub fn turn_to_heading(&mut self, params: &MovementParameters, world: &mut World) {
        // Move-to types have no failures here.
        let _ = self.perform_movement(&Movement::TurnToHeading(*params), world);
    }

    /// Size and carrier of the object of a GUID; `None` if it is not in the object table.
    fn move_target(&self, guid: u32, world: &World) -> Option<MoveTarget> {
        let object = if guid == self.guid() {
            self
        } else {
            world.entity(world.entity_of_guid(guid)?)?
        };
        Some(MoveTarget {
            object_id: guid,
            top_level_id: self.carrier_guid(object, world).unwrap_or(guid),
            radius: object.radius(),
            height: object.height(),
        })
    }

    /// The movement manager's work of one quantum: only the move-to has any (10.4).
    pub fn movement_use_time(&mut self, world: &mut World) {
        self.move_to_use_time(world);
    }

    /// The object stands on walkable ground again (`MovementManager::HitGround`, 10.5).
    pub fn movement_hit_ground(&mut self, world: &mut World) {
        self.interp_hit_ground(world);
        self.move_to_hit_ground(world);
    }

    /// The object has left walkable ground (`MovementManager::LeaveGround`, 10.5).
    pub fn movement_leave_ground(&mut self, world: &mut World) {
        self.interp_leave_ground(world);
    }

    /// Ends all waiting motions because the object leaves the world (10.6).
    pub fn movement_exit_world(&mut self, world: &mut World) {
        self.interp_exit_world(world);
    }

    /// The tracked target of a move-to has moved or gone (10.7).
    pub fn movement_handle_update_target(&mut self, info: &TargetInfo, world: &mut World) {
        self.move_to_handle_update_target(info, world);
    }

    /// The animation layer has finished a motion; which one, and how it ended, is not asked (10.8).
    pub(crate) fn movement_motion_done(&mut self, _motion: u32, _success: bool, world: &mut World) {
        self.interp_motion_done(world);
    }

    /// Ends a running move-to because something else begins (`cancel_moveto`).
    pub fn cancel_moveto(&mut self, world: &mut World) {
        self.cancel_moveto_with(MotionError::ActionCancelled, world);
    }

    /// Whether a move-to is active.
    pub fn is_moving_to(&self) -> bool {
        self.move_to().is_some_and(MoveToManager::is_active)
    }

    /// Whether motions wait for the animation layer.
    pub fn motions_pending(&self) -> bool {
        self.interp().is_some_and(MotionInterp::motions_pending)
    }

    /// The interpreted state; the interpreter is made if missing, the manager is not.
    pub fn inq_interpreted_motion_state(
        &mut self,
        world: &mut World,
    ) -> Option<&InterpretedMotionState> {
        self.movement.as_ref()?;
        self.manager_interp(world);
        self.interp().map(|interp| &interp.interpreted)
    }

    /// The raw state; the interpreter is made if missing, the manager is not.
    pub fn inq_raw_motion_state(&mut self, world: &mut World) -> Option<&RawMotionState> {
        self.movement.as_ref()?;
        self.manager_interp(world);
        self.interp().map(|interp| &interp.raw)
    }

    /// Run speed, m/s; manager and interpreter are made if missing (`get_max_speed`).
    pub fn max_speed(&mut self, world: &mut World) -> f32 {
        self.get_interp(world);
        self.interp()
            .map_or(0.0, |interp| interp.max_speed(&self.mover(world)))
    }

    /// Run speed, or the present one while running, m/s; manager and interpreter are made if missing (`get_adjusted_max_speed`).
    pub fn adjusted_max_speed(&mut self, world: &mut World) -> f32 {
        self.get_interp(world);
        self.interp()
            .map_or(0.0, |interp| interp.adjusted_max_speed(&self.mover(world)))
    }
}

impl Entity {
    /// GUID of the object that carries `object`; `None` if nobody does.
    fn carrier_guid(&self, object: &Self, world: &World) -> Option<u32> {
        let carrier = object.body.parent?;
        if carrier == self.object_ref() {
            Some(self.guid())
        } else {
            world.body(carrier).map(|body| body.guid)
        }
    }
}
