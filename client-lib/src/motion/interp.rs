//! The motion interpreter's state, and what follows from it without touching the object: normalising commands, velocities, permissions.
//!
//! Source: `spec/08-motion.md`, 2.2, 8.5, 8.6, 8.16 to 8.18. What changes the object is in [`super::requests`] and [`super::ground`].

use std::collections::VecDeque;

use super::constants::{
    BACKWARDS_FACTOR, DEFAULT_JUMP_VELOCITY, MAX_SIDESTEP_ANIM_RATE, RUN_ANIM_SPEED,
    RUN_TURN_FACTOR, SIDESTEP_ANIM_SPEED, SIDESTEP_RATE, WALK_ANIM_SPEED,
};
use super::{Command, HoldKey, InterpretedMotionState, MotionCallbacks, RawMotionState};
use crate::entity::Weenie;
use crate::math::vector::{is_zero, normalize};
use crate::math::{EPSILON, Frame, Vec3};
use crate::physics::state::TransientState;
use crate::profile::{JumpPosture, LeaveGroundVelocity, NoWeenie, Profile};

/// A motion that the animation layer has accepted and not yet reported done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PendingMotion {
    /// Context of the movement it belongs to.
    pub context_id: u32,
    /// The motion.
    pub command: Command,
    /// A jump is refused (0x48) while this is the oldest.
    pub forbids_jump: bool,
}

/// Interprets raw motions and requests animations. Retail: `CMotionInterp`.
#[derive(Debug, Clone)]
pub struct MotionInterp {
    /// The default state has been entered.
    pub initted: bool,
    /// What the input wants.
    pub raw: RawMotionState,
    /// What the body does.
    pub interpreted: InterpretedMotionState,
    /// Divisor of the adjusted speed; always 1.
    pub current_speed_factor: f32,
    /// A jump is being charged from a standstill.
    pub standing_longjump: bool,
    /// Extent (0..=1) of the jump in progress, 0 for none.
    pub jump_extent: f32,
    /// Newest action stamp accepted from the server; 15 bits count.
    pub server_action_stamp: u32,
    /// Last known run rate of an object whose weenie does not answer.
    pub my_run_rate: f32,
    /// Accepted motions that are not done, oldest first.
    pub pending: VecDeque<PendingMotion>,
}

impl Default for MotionInterp {
    fn default() -> Self {
        Self {
            initted: false,
            raw: RawMotionState::default(),
            interpreted: InterpretedMotionState::default(),
            current_speed_factor: 1.0,
            standing_longjump: false,
            jump_extent: 0.0,
            server_action_stamp: 0,
            my_run_rate: 1.0,
            pending: VecDeque::new(),
        }
    }
}

/// What the interpreter sees of its object.
#[derive(Debug, Clone, Copy)]
pub struct Mover<'a> {
    /// Behaviour.
    pub profile: &'a Profile,
    /// The companion, if there is one.
    pub weenie: Option<&'a Weenie>,
    /// The companion says that it is a creature; meaningless without one.
    pub creature: bool,
    /// State bit Gravity.
    pub gravity: bool,
    /// Transient state word.
    pub transient: TransientState,
}

impl Mover<'_> {
    /// The creature rule: no weenie, or one of a creature.
    pub fn is_creature(&self) -> bool {
        self.weenie.is_none() || self.creature
    }

    /// Touches walkable ground.
    pub fn on_ground(&self) -> bool {
        self.transient
            .contains(TransientState::CONTACT | TransientState::ON_WALKABLE)
    }

    /// Falls when it leaves the ground, and notices: a creature with gravity.
    pub fn leaves_ground(&self) -> bool {
        self.is_creature() && self.gravity
    }
}

/// A command with its speed factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// What to do.
    pub command: Command,
    /// Factor of the animation's rate.
    pub speed: f32,
}

impl MotionInterp {
    /// Normalises a raw command: no "left", no "backwards", run speeds applied (8.5).
    pub fn adjust_motion(&self, motion: Motion, hold_key: HoldKey, mover: &Mover<'_>) -> Motion {
        if !mover.is_creature() || motion.command == Command::RUN_FORWARD {
            return motion;
        }
        let Motion {
            mut command,
            mut speed,
        } = motion;
        match command {
            Command::WALK_BACKWARDS => {
                command = Command::WALK_FORWARD;
                speed *= -BACKWARDS_FACTOR;
            }
            Command::TURN_LEFT => {
                command = Command::TURN_RIGHT;
                speed = -speed;
            }
            Command::SIDE_STEP_LEFT => {
                command = Command::SIDE_STEP_RIGHT;
                speed = -speed;
            }
            _ => {}
        }
        if command == Command::SIDE_STEP_RIGHT {
            speed *= SIDESTEP_RATE;
        }
        let adjusted = Motion { command, speed };
        let key = match hold_key {
            HoldKey::Invalid => self.raw.current_hold_key,
            key => key,
        };
        if key == HoldKey::Run {
            self.apply_run(adjusted, mover)
        } else {
            adjusted
        }
    }

    /// Makes a normalised motion a running one (8.6).
    fn apply_run(&self, motion: Motion, mover: &Mover<'_>) -> Motion {
        let rate = self.run_rate(mover);
        let Motion { command, speed } = motion;
        match command {
            Command::WALK_FORWARD => Motion {
                command: if speed > 0.0 {
                    Command::RUN_FORWARD
                } else {
                    command
                },
                speed: speed * rate,
            },
            Command::TURN_RIGHT => Motion {
                command,
                speed: speed * RUN_TURN_FACTOR,
            },
            Command::SIDE_STEP_RIGHT => Motion {
                command,
                speed: clamp_sidestep(speed * rate),
            },
            _ => motion,
        }
    }

    /// The run rate: 1 without a weenie, else its answer, else the last known one.
    pub fn run_rate(&self, mover: &Mover<'_>) -> f32 {
        mover.weenie.map_or(1.0, |weenie| {
            weenie.run_rate(mover.profile).unwrap_or(self.my_run_rate)
        })
    }

    /// Nominal velocity (m/s, local axes) of the interpreted state, at most the run speed (8.18).
    pub fn state_velocity(&self, mover: &Mover<'_>) -> Vec3 {
        let state = &self.interpreted;
        let x = if state.sidestep_command == Command::SIDE_STEP_RIGHT {
            SIDESTEP_ANIM_SPEED * state.sidestep_speed
        } else {
            0.0
        };
        let y = match state.forward_command {
            Command::WALK_FORWARD => WALK_ANIM_SPEED * state.forward_speed,
            Command::RUN_FORWARD => RUN_ANIM_SPEED * state.forward_speed,
            _ => 0.0,
        };
        let rate = if mover.weenie.is_none() && mover.profile.no_weenie == NoWeenie::Always {
            self.my_run_rate
        } else {
            self.run_rate(mover)
        };
        let (velocity, limit) = (Vec3::new(x, y, 0.0), RUN_ANIM_SPEED * rate);
        if velocity.length() > limit {
            normalize(velocity, mover.profile) * limit
        } else {
            velocity
        }
    }

    /// Vertical speed (m/s) of the jump in progress, 0 without one.
    pub fn jump_v_z(&self, mover: &Mover<'_>) -> f32 {
        if self.jump_extent < EPSILON {
            return 0.0;
        }
        let extent = if self.jump_extent > 1.0 {
            1.0
        } else {
            self.jump_extent
        };
        mover.weenie.map_or(DEFAULT_JUMP_VELOCITY, |weenie| {
            weenie.jump_velocity(extent, mover.profile).unwrap_or(0.0)
        })
    }

    /// Velocity (m/s, local axes) with which an object of frame `frame` and world velocity `velocity` leaves the ground (8.18; `D11`).
    pub fn leave_ground_velocity(&self, mover: &Mover<'_>, frame: &Frame, velocity: Vec3) -> Vec3 {
        let mut launch = self.state_velocity(mover);
        launch.z = self.jump_v_z(mover);
        match mover.profile.leave_ground_velocity {
            LeaveGroundVelocity::StateFirst if is_zero(launch) => {
                frame.global_to_local_vec(velocity, mover.profile)
            }
            LeaveGroundVelocity::Inverted if !is_zero(launch) => {
                frame.global_to_local_vec(launch, mover.profile)
            }
            _ => launch,
        }
    }

    /// Run speed, m/s.
    pub fn max_speed(&self, mover: &Mover<'_>) -> f32 {
        RUN_ANIM_SPEED * self.run_rate(mover)
    }

    /// Run speed, or the present one while running, m/s; interpolation follows server positions at twice that.
    pub fn adjusted_max_speed(&self, mover: &Mover<'_>) -> f32 {
        let rate = self.run_rate(mover);
        let rate = if self.interpreted.forward_command == Command::RUN_FORWARD {
            self.interpreted.forward_speed / self.current_speed_factor
        } else {
            rate
        };
        rate * RUN_ANIM_SPEED
    }

    /// Whether motions are waiting for the animation layer.
    pub fn motions_pending(&self) -> bool {
        !self.pending.is_empty()
    }

    /// On the ground, not moving, not turning (8.25).
    pub fn is_standing_still(&self, mover: &Mover<'_>) -> bool {
        mover.on_ground() && self.interpreted.is_at_rest()
    }

    pub(super) fn add_to_queue(&mut self, context_id: u32, command: Command, forbids_jump: bool) {
        self.pending.push_back(PendingMotion {
            context_id,
            command,
            forbids_jump,
        });
    }
}

/// ±3 at most; NaN stays NaN.
fn clamp_sidestep(speed: f32) -> f32 {
    if speed.abs() > MAX_SIDESTEP_ANIM_RATE {
        if speed > 0.0 {
            MAX_SIDESTEP_ANIM_RATE
        } else {
            -MAX_SIDESTEP_ANIM_RATE
        }
    } else {
        speed
    }
}

/// Whether the object's contact lets it perform `command` (8.16). Slopes enter only through the walkable bit.
pub fn contact_allows_move(command: Command, mover: &Mover<'_>) -> bool {
    matches!(command, Command::DEAD | Command::FALLING)
        || command.is_turn()
        || !mover.leaves_ground()
        || mover.on_ground()
}

/// Whether the posture of `command` allows a jump; if not, the error is 0x48 (8.17; `D9`).
///
/// The second range was meant for the coloured power-ups and was not moved when the numbering shifted by 3: kept.
pub fn motion_allows_jump(command: Command, profile: &Profile) -> bool {
    let posture = match profile.jump_posture {
        JumpPosture::Fallen => Command::FALLEN,
        JumpPosture::Falling => Command::FALLING,
    };
    let forbidden = command.within(0x4000_0016, 0x4000_0018)
        || command.within(0x1000_0128, 0x1000_0131)
        || command.within(0x1000_006F, 0x1000_0078)
        || command.within(0x4100_0012, 0x4100_0014)
        || command.within(0x4000_001E, 0x4000_0039)
        || command == posture;
    !forbidden
}
