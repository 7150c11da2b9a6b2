//! Leaving the ground, coming back, jumping, and states that the server sends (`spec/08-motion.md`, 8.19, 8.20, 8.24 to 8.28).

use super::interp::motion_allows_jump;
use super::{
    Command, InterpretedMotionState, MotionCallbacks, MotionError, MotionInterp, MotionResult,
    MovementFlags, MovementParameters, Mover,
};
use crate::entity::Entity;
use crate::profile::{JumpCharge, NoWeenie, PendingJumpError, Profile};
use crate::world::World;

impl Entity {
    /// Launches the object with its state velocity and lets it fall (8.19).
    pub(super) fn interp_leave_ground(&mut self, world: &mut World) {
        let mover = self.mover(world);
        if !mover.leaves_ground() {
            return;
        }
        let Some(interp) = self.interp() else {
            return;
        };
        let frame = &self.body.position.frame;
        let launch = interp.leave_ground_velocity(&mover, frame, self.kin.velocity);
        self.set_local_velocity(launch, world);
        if let Some(interp) = self.interp_mut() {
            interp.standing_longjump = false;
            interp.jump_extent = 0.0;
        }
        self.remove_link_animations(world);
        self.apply_current_movement(true, world);
    }

    /// Takes up on the ground what the input wants by now (8.20).
    pub(super) fn interp_hit_ground(&mut self, world: &mut World) {
        if self.interp().is_none() || !self.mover(world).leaves_ground() {
            return;
        }
        self.remove_link_animations(world);
        self.apply_current_movement(true, world);
    }

    /// Jumps with an extent in 0..=1 (8.24); the stamina cost is the answer.
    ///
    /// # Errors
    /// Why the object cannot jump.
    pub fn jump(&mut self, extent: f32, world: &mut World) -> Result<i32, MotionError> {
        self.cancel_moveto(world);
        let allowed = self.jump_is_allowed(extent, world);
        let Some(interp) = self.interp_mut() else {
            return Err(MotionError::NoPhysicsObject);
        };
        match allowed {
            Ok(_) => {
                interp.jump_extent = extent;
                self.set_on_walkable(false, world);
            }
            Err(_) => interp.standing_longjump = false,
        }
        allowed
    }

    /// Whether a jump is possible now, and what it would cost in stamina (8.24; `D12`, `D13`).
    ///
    /// # Errors
    /// Why not.
    pub fn jump_is_allowed(&self, extent: f32, world: &World) -> Result<i32, MotionError> {
        let mover = self.mover(world);
        let interp = self.interp().ok_or(MotionError::NoPhysicsObject)?;
        let always_grounded = mover.weenie.is_none() && mover.profile.no_weenie == NoWeenie::Always;
        if !always_grounded && mover.leaves_ground() && !mover.on_ground() {
            return Err(MotionError::NoContact);
        }
        if self.is_fully_constrained(world) {
            return Err(MotionError::GeneralMovementFailure);
        }
        interp.pending_jump_error(mover.profile)?;
        interp.jump_charge_is_allowed(&mover)?;
        if !motion_allows_jump(interp.interpreted.forward_command, mover.profile) {
            return Err(MotionError::CantJumpPosition);
        }
        match mover.weenie {
            None => Ok(0),
            Some(weenie) => weenie
                .jump_stamina_cost(extent, mover.profile)
                .ok_or(MotionError::GeneralMovementFailure),
        }
    }

    /// Starts charging a jump; from a standstill the body then stands still until the jump (8.24; `D14`).
    ///
    /// # Errors
    /// Why a jump cannot be charged.
    pub fn charge_jump(&mut self, world: &World) -> MotionResult {
        let mover = self.mover(world);
        let interp = self.interp().ok_or(MotionError::NoPhysicsObject)?;
        interp.charge_is_allowed(&mover)?;
        let still = interp.is_standing_still(&mover);
        if still && let Some(interp) = self.interp_mut() {
            interp.standing_longjump = true;
        }
        Ok(())
    }

    /// The run rate has changed: speeds are computed again (8.27; `D15`).
    pub fn report_exhaustion(&mut self, world: &mut World) {
        let initted = self.interp().is_some_and(|interp| interp.initted);
        if !initted || world.profile.jump_charge == JumpCharge::None {
            return;
        }
        let raw =
            self.weenie.is_none() || self.body.weenie.creature && self.kin.last_move_was_autonomous;
        if raw {
            self.apply_raw_movement(false, world);
        } else {
            self.apply_interpreted_movement(false, world);
        }
    }

    /// Applies a state that came from the server (8.26). The autonomous flag of the object must be the message's already.
    pub fn move_to_interpreted_state(&mut self, state: &InterpretedMotionState, world: &mut World) {
        self.get_interp(world).raw.style = state.style;
        self.cancel_moveto(world);
        let Some(interp) = self.interp_mut() else {
            return;
        };
        let allow_jump = motion_allows_jump(interp.interpreted.forward_command, &world.profile);
        interp.interpreted.copy_movement_from(state);
        self.apply_current_movement(allow_jump, world);
        let mut params = MovementParameters::new(&world.profile);
        for action in state.actions.iter() {
            let creature = self.weenie.is_some() && self.body.weenie.creature;
            let Some(interp) = self.interp_mut() else {
                return;
            };
            let newer = stamp_is_newer(action.stamp, interp.server_action_stamp);
            if newer && (creature || action.autonomous) {
                interp.server_action_stamp = action.stamp;
                params.speed = action.speed;
                params
                    .flags
                    .set(MovementFlags::AUTONOMOUS, action.autonomous);
                // A refused action is lost.
                let _ = self.interp_do_interpreted_motion(action.command, &params, world);
            }
        }
    }

    /// Stance (`InqStyle`).
    pub fn style(&self) -> Option<Command> {
        self.interp().map(|interp| interp.interpreted.style)
    }
}

impl MotionInterp {
    /// The jump error of the oldest pending motion (`D13`).
    fn pending_jump_error(&self, profile: &Profile) -> MotionResult {
        let counts = match profile.pending_jump_error {
            PendingJumpError::Oldest => true,
            PendingJumpError::MoreThanOne => self.pending.len() > 1,
        };
        match self.pending.front() {
            Some(oldest) if counts && oldest.forbids_jump => Err(MotionError::CantJumpPosition),
            _ => Ok(()),
        }
    }

    fn jump_charge_is_allowed(&self, mover: &Mover<'_>) -> MotionResult {
        self.load_allows_jump(mover)?;
        let forward = self.interpreted.forward_command;
        if forward == Command::FALLEN || forward.within(0x4100_0012, 0x4100_0014) {
            return Err(MotionError::CantJumpPosition);
        }
        Ok(())
    }

    fn load_allows_jump(&self, mover: &Mover<'_>) -> MotionResult {
        match mover.weenie {
            Some(weenie) if !weenie.can_jump(self.jump_extent, mover.profile) => {
                Err(MotionError::CantJumpLoad)
            }
            _ => Ok(()),
        }
    }

    /// The test at the start of a charge (`D14`).
    fn charge_is_allowed(&self, mover: &Mover<'_>) -> MotionResult {
        let forward = self.interpreted.forward_command;
        match mover.profile.jump_charge {
            JumpCharge::Full => self.jump_charge_is_allowed(mover),
            JumpCharge::Ranges => {
                self.load_allows_jump(mover)?;
                if forward == Command::FALLING || forward.within(0x4100_0012, 0x4100_0013) {
                    return Err(MotionError::CantJumpPosition);
                }
                Ok(())
            }
            JumpCharge::None => Ok(()),
        }
    }
}

/// Whether a 15-bit serial number comes after another: a distance of 0x3FFF forward is newer, 0x4000 is older.
pub(super) fn stamp_is_newer(stamp: u32, than: u32) -> bool {
    let (a, s) = (stamp & 0x7FFF, than & 0x7FFF);
    if a.abs_diff(s) <= 0x3FFF {
        s < a
    } else {
        a < s
    }
}
