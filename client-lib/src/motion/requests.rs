//! Requests of motions: from commands to the animation layer and the two motion states (`spec/08-motion.md`, 8.2 to 8.15, 8.21 to 8.23).

use super::interp::{contact_allows_move, motion_allows_jump};
use super::{
    Command, HoldKey, InterpretedMotionState, Motion, MotionError, MotionInterp, MotionResult,
    MovementFlags, MovementParameters, RawMotionState,
};
use crate::entity::Entity;
use crate::profile::{DefaultState, Profile};
use crate::world::World;

/// Whether a jump that is being charged from a standstill keeps `command` from being animated: it is only remembered.
fn held_back_by_long_jump(command: Command) -> bool {
    matches!(
        command,
        Command::WALK_FORWARD | Command::RUN_FORWARD | Command::SIDE_STEP_RIGHT
    )
}

/// The error of a command that a combat stance forbids.
fn combat_error(command: Command) -> MotionResult {
    match command {
        Command::CROUCH => Err(MotionError::CantCrouchInCombat),
        Command::SITTING => Err(MotionError::CantSitInCombat),
        Command::SLEEPING => Err(MotionError::CantLieDownInCombat),
        _ if command.has(super::CHAT_EMOTE) => Err(MotionError::CantChatEmoteInCombat),
        _ => Ok(()),
    }
}

impl MovementParameters {
    /// The copy that DoMotion and StopMotion pass on (`D5`).
    fn passed_on(&self, profile: &Profile) -> Self {
        if !profile.do_motion_loses_fields {
            return *self;
        }
        let lost = MovementFlags::FAIL_WALK
            | MovementFlags::USE_FINAL_HEADING
            | MovementFlags::STICKY
            | MovementFlags::MOVE_AWAY
            | MovementFlags::AUTONOMOUS
            | MovementFlags::DISABLE_JUMP_DURING_LINK;
        Self {
            flags: self.flags.difference(lost),
            desired_heading: 0.0,
            context_id: 0,
            action_stamp: 0,
            ..*self
        }
    }
}

impl Entity {
    /// Puts the interpreter into its default state, the animation layer included (8.2).
    pub(super) fn enter_default_state(&mut self, world: &mut World) {
        let Some(interp) = self.interp_mut() else {
            return;
        };
        interp.raw = RawMotionState::default();
        interp.interpreted = InterpretedMotionState::default();
        self.initialize_motion_tables(world);
        let keeps_queue = world.profile.default_state == DefaultState::Twice;
        if let Some(interp) = self.interp_mut() {
            if !keeps_queue {
                interp.pending.clear();
            }
            interp.add_to_queue(0, Command::READY, false);
            interp.initted = true;
        }
        self.interp_leave_ground(world);
    }

    /// A raw motion (8.4).
    pub(super) fn interp_do_motion(
        &mut self,
        command: Command,
        params: &MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        let mut adjusted = params.passed_on(&world.profile);
        let cancel_moveto = params.has(MovementFlags::CANCEL_MOVETO);
        if cancel_moveto {
            self.cancel_moveto(world);
        }
        if params.has(MovementFlags::SET_HOLD_KEY) {
            self.set_hold_key(params.hold_key, world);
        }
        let motion = self.adjusted(command, &mut adjusted, params.hold_key, world);
        let interp = self.interp().ok_or(MotionError::NoPhysicsObject)?;
        if interp.interpreted.style != Command::NON_COMBAT {
            combat_error(command)?;
        }
        if command.is_action() && interp.interpreted.actions.len() >= super::constants::MAX_ACTIONS
        {
            return Err(MotionError::TooManyActions);
        }
        self.interp_do_interpreted_motion(motion, &adjusted, world)?;
        if params.has(MovementFlags::MODIFY_RAW_STATE)
            && let Some(interp) = self.interp_mut()
        {
            interp.raw.apply_motion(command, params);
        }
        Ok(())
    }

    /// The end of a raw motion (8.12).
    pub(super) fn interp_stop_motion(
        &mut self,
        command: Command,
        params: &MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        if params.has(MovementFlags::CANCEL_MOVETO) {
            self.cancel_moveto(world);
        }
        let mut adjusted = params.passed_on(&world.profile);
        let motion = self.adjusted(command, &mut adjusted, params.hold_key, world);
        self.interp_stop_interpreted_motion(motion, &adjusted, world)?;
        if params.has(MovementFlags::MODIFY_RAW_STATE)
            && let Some(interp) = self.interp_mut()
        {
            interp.raw.remove_motion(command);
        }
        Ok(())
    }

    /// The normalised command; the speed of `params` is changed with it.
    pub(super) fn adjusted(
        &self,
        command: Command,
        params: &mut MovementParameters,
        hold_key: HoldKey,
        world: &World,
    ) -> Command {
        let speed = params.speed;
        let motion = self.interp().map_or(Motion { command, speed }, |interp| {
            interp.adjust_motion(Motion { command, speed }, hold_key, &self.mover(world))
        });
        params.speed = motion.speed;
        motion.command
    }

    /// A normalised motion (8.7).
    pub(super) fn interp_do_interpreted_motion(
        &mut self,
        command: Command,
        params: &MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        let result = self.request_motion(command, params, world);
        if self.body.cell.is_none() {
            self.remove_link_animations(world);
        }
        result
    }

    fn request_motion(
        &mut self,
        command: Command,
        params: &MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        let long_jump = self.interp().is_some_and(|interp| interp.standing_longjump);
        let mut queued = false;
        if contact_allows_move(command, &self.mover(world)) {
            if !(long_jump && held_back_by_long_jump(command)) {
                if command == Command::DEAD {
                    self.remove_link_animations(world);
                }
                animated(self.do_interpreted_motion(command.0, params.speed, world))?;
                queued = true;
            }
        } else if command.is_action() {
            return Err(MotionError::NoContact);
        }
        let Some(interp) = self.interp_mut() else {
            return Ok(());
        };
        if queued {
            let forbids = forbids_jump(interp, command, params, &world.profile);
            interp.add_to_queue(params.context_id, command, forbids);
        }
        if params.has(MovementFlags::MODIFY_INTERPRETED_STATE) {
            interp.interpreted.apply_motion(command, params);
        }
        Ok(())
    }

    /// The end of a normalised motion; the speed is not looked at (8.8).
    pub(super) fn interp_stop_interpreted_motion(
        &mut self,
        command: Command,
        params: &MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        let result = self.request_stop(command, params, world);
        if self.body.cell.is_none() {
            self.remove_link_animations(world);
        }
        result
    }

    fn request_stop(
        &mut self,
        command: Command,
        params: &MovementParameters,
        world: &mut World,
    ) -> MotionResult {
        let long_jump = self.interp().is_some_and(|interp| interp.standing_longjump);
        let animates = contact_allows_move(command, &self.mover(world))
            && !(long_jump && held_back_by_long_jump(command));
        if animates {
            animated(self.stop_interpreted_motion(command.0, world))?;
        }
        if let Some(interp) = self.interp_mut() {
            if animates {
                interp.add_to_queue(params.context_id, Command::READY, false);
            }
            if params.has(MovementFlags::MODIFY_INTERPRETED_STATE) {
                interp.interpreted.remove_motion(command);
            }
        }
        Ok(())
    }

    /// The end of everything (8.13). Never fails.
    pub(super) fn interp_stop_completely(&mut self, world: &mut World) -> MotionResult {
        self.cancel_moveto(world);
        let mut forbids_jump = false;
        if let Some(interp) = self.interp_mut() {
            forbids_jump = !motion_allows_jump(interp.interpreted.forward_command, &world.profile);
            interp.raw.stop_completely();
            interp.interpreted.stop_completely();
        }
        // Queued even if the animation layer refuses.
        self.stop_completely_internal(world);
        if let Some(interp) = self.interp_mut() {
            interp.add_to_queue(0, Command::READY, forbids_jump);
        }
        if self.body.cell.is_none() {
            self.remove_link_animations(world);
        }
        Ok(())
    }

    /// Takes a hold key given with a motion: only from Run to None (8.14).
    fn set_hold_key(&mut self, key: HoldKey, world: &mut World) {
        let Some(interp) = self.interp_mut() else {
            return;
        };
        if key == HoldKey::None && interp.raw.current_hold_key == HoldKey::Run {
            interp.raw.current_hold_key = HoldKey::None;
            self.apply_current_movement(true, world);
        }
    }

    /// The run key is pressed or released (8.15). Whether a move-to is cancelled makes no difference, so it is not asked.
    pub fn set_hold_run(&mut self, run: bool, world: &mut World) {
        let Some(interp) = self.interp_mut() else {
            return;
        };
        if run != (interp.raw.current_hold_key == HoldKey::Run) {
            interp.raw.current_hold_key = HoldKey::running(run);
            self.apply_current_movement(true, world);
        }
    }

    /// Requests the present motions again (8.9).
    pub(crate) fn apply_current_movement(&mut self, allow_jump: bool, world: &mut World) {
        if !self.interp().is_some_and(|interp| interp.initted) {
            return;
        }
        if self.mover(world).is_creature() && self.kin.last_move_was_autonomous {
            self.apply_raw_movement(allow_jump, world);
        } else {
            self.apply_interpreted_movement(allow_jump, world);
        }
    }

    /// Makes the interpreted state from the raw one and requests it (8.10).
    pub(super) fn apply_raw_movement(&mut self, allow_jump: bool, world: &mut World) {
        let Some(interp) = self.interp() else {
            return;
        };
        let (mover, raw) = (self.mover(world), &interp.raw);
        let style = raw.style;
        let [forward, sidestep, turn] = [raw.forward, raw.sidestep, raw.turn].map(|axis| {
            let Motion { command, speed } = interp.adjust_motion(
                Motion {
                    command: axis.command,
                    speed: axis.speed,
                },
                axis.hold_key,
                &mover,
            );
            (command, speed)
        });
        if let Some(interp) = self.interp_mut() {
            let state = &mut interp.interpreted;
            state.style = style;
            (state.forward_command, state.forward_speed) = forward;
            (state.sidestep_command, state.sidestep_speed) = sidestep;
            (state.turn_command, state.turn_speed) = turn;
        }
        self.apply_interpreted_movement(allow_jump, world);
    }

    /// Requests the interpreted state from the animation layer; the state itself stays (8.11). Answers are dropped.
    pub(super) fn apply_interpreted_movement(&mut self, allow_jump: bool, world: &mut World) {
        let Some(interp) = self.interp_mut() else {
            return;
        };
        let state = &interp.interpreted;
        let style = state.style;
        let forward = (state.forward_command, state.forward_speed);
        if forward.0 == Command::RUN_FORWARD {
            interp.my_run_rate = forward.1;
        }
        let mut params = MovementParameters::new(&world.profile)
            .with(MovementFlags::SET_HOLD_KEY, false)
            .with(MovementFlags::MODIFY_INTERPRETED_STATE, false)
            .with(MovementFlags::DISABLE_JUMP_DURING_LINK, !allow_jump);
        self.repeat_motion(style, 1.0, &mut params, world);
        if contact_allows_move(forward.0, &self.mover(world)) {
            self.repeat_walking(forward, &mut params, world);
        } else {
            self.repeat_motion(Command::FALLING, 1.0, &mut params, world);
        }
        let turn = self.interp().map_or((Command::NONE, 1.0), |interp| {
            let state = &interp.interpreted;
            (state.turn_command, state.turn_speed)
        });
        self.repeat_or_stop(turn, Command::TURN_RIGHT, &mut params, world);
    }

    /// Step 4 of 8.11 on walkable ground.
    fn repeat_walking(
        &mut self,
        (forward, speed): (Command, f32),
        params: &mut MovementParameters,
        world: &mut World,
    ) {
        let Some(interp) = self.interp() else {
            return;
        };
        let state = &interp.interpreted;
        let sidestep = (state.sidestep_command, state.sidestep_speed);
        if interp.standing_longjump {
            self.repeat_motion(Command::READY, 1.0, params, world);
            self.repeat_or_stop(
                (Command::NONE, 1.0),
                Command::SIDE_STEP_RIGHT,
                params,
                world,
            );
        } else {
            self.repeat_motion(forward, speed, params, world);
            self.repeat_or_stop(sidestep, Command::SIDE_STEP_RIGHT, params, world);
        }
    }

    fn repeat_motion(
        &mut self,
        command: Command,
        speed: f32,
        params: &mut MovementParameters,
        world: &mut World,
    ) {
        params.speed = speed;
        let _ = self.interp_do_interpreted_motion(command, params, world);
    }

    /// Requests an axis, or its end if it is empty.
    fn repeat_or_stop(
        &mut self,
        (command, speed): (Command, f32),
        stopped_by: Command,
        params: &mut MovementParameters,
        world: &mut World,
    ) {
        if command == Command::NONE {
            let _ = self.interp_stop_interpreted_motion(stopped_by, params, world);
        } else {
            self.repeat_motion(command, speed, params, world);
        }
    }

    /// The weenie was replaced: the movement is requested again (8.1).
    pub fn movement_weenie_changed(&mut self, world: &mut World) {
        self.apply_current_movement(true, world);
    }

    /// The oldest motion is done, whichever the animation layer named (8.22).
    pub(super) fn interp_motion_done(&mut self, world: &mut World) {
        let oldest = self.interp().and_then(|interp| interp.pending.front());
        let Some(oldest) = oldest.copied() else {
            return;
        };
        if oldest.command.is_action() {
            self.finish_action(world);
        }
        if let Some(interp) = self.interp_mut() {
            interp.pending.pop_front();
        }
    }

    fn finish_action(&mut self, world: &mut World) {
        self.unstick_from_object(world);
        if let Some(interp) = self.interp_mut() {
            interp.interpreted.actions.remove();
            interp.raw.actions.remove();
        }
    }

    /// All waiting motions end (8.23).
    pub(super) fn interp_exit_world(&mut self, world: &mut World) {
        let mut index = 0;
        while let Some(pending) = self.interp().and_then(|interp| interp.pending.get(index)) {
            if pending.command.is_action() {
                self.finish_action(world);
            }
            index += 1;
        }
        if let Some(interp) = self.interp_mut() {
            interp.pending.clear();
        }
    }
}

/// The animation layer's answer.
fn animated(code: u32) -> MotionResult {
    match code {
        0 => Ok(()),
        code => Err(MotionError::from_code(code).unwrap_or(MotionError::GeneralMovementFailure)),
    }
}

/// Whether a motion that was just accepted forbids jumping while it is the oldest pending one (8.7, 1b).
fn forbids_jump(
    interp: &MotionInterp,
    command: Command,
    params: &MovementParameters,
    profile: &Profile,
) -> bool {
    params.has(MovementFlags::DISABLE_JUMP_DURING_LINK)
        || !motion_allows_jump(command, profile)
        || !command.is_action() && !motion_allows_jump(interp.interpreted.forward_command, profile)
}
