//! Numbers of the motion layer (`spec/08-motion.md`, 3.1). Speeds in m/s, headings in degrees, times in seconds.

/// Walking backwards is this fraction of walking forward.
pub const BACKWARDS_FACTOR: f32 = 0.65;
/// Nominal speed of the walk cycle.
pub const WALK_ANIM_SPEED: f32 = 3.12;
/// Nominal speed of the run cycle; a run rate of 1 is this speed.
pub const RUN_ANIM_SPEED: f32 = 4.0;
/// Nominal speed of the sidestep cycle.
pub const SIDESTEP_ANIM_SPEED: f32 = 1.25;
/// Sidestepping covers this fraction of the walking speed.
pub const SIDESTEP_FACTOR: f32 = 0.5;
/// Factor of the sidestep cycle that makes it cover [`SIDESTEP_FACTOR`] of the walking speed.
pub const SIDESTEP_RATE: f32 = SIDESTEP_FACTOR * (WALK_ANIM_SPEED / SIDESTEP_ANIM_SPEED);
/// Fastest sidestep cycle.
pub const MAX_SIDESTEP_ANIM_RATE: f32 = 3.0;
/// Turning with the run key held is this much faster.
pub const RUN_TURN_FACTOR: f32 = 1.5;
/// Vertical launch speed of an object without a weenie.
pub const DEFAULT_JUMP_VELOCITY: f32 = 10.0;
/// A move-to steers when the bearing is off by more than this.
pub const AUX_TURN_BAND: f32 = 20.0;
/// A move-to must progress by this speed.
pub const MIN_PROGRESS: f64 = 0.25;
/// Progress is judged over more than this time.
pub const PROGRESS_INTERVAL: f64 = 1.0;
/// Radius within which a tracked target may move without telling, m.
pub const TARGET_RADIUS: f32 = 0.5;
/// Slowest speed from which the target's extrapolation is computed.
pub const TARGET_QUANTUM_MIN_SPEED: f32 = 0.1;
/// Smallest change of the target's extrapolation that is announced.
pub const TARGET_QUANTUM_MIN_CHANGE: f64 = 1.0;
/// Actions that may wait.
pub const MAX_ACTIONS: usize = 6;
/// A player that moves reports its position this often.
pub const POSITION_EVENT_INTERVAL: f64 = 1.0;
/// Smallest extent of a charged jump.
pub const MIN_JUMP_EXTENT: f32 = 0.001;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_have_the_bits_of_the_specification() {
        for (value, bits) in [
            (BACKWARDS_FACTOR, 0x3F26_6666),
            (WALK_ANIM_SPEED, 0x4047_AE14),
            (SIDESTEP_RATE, 0x3F9F_BE76),
            (MIN_JUMP_EXTENT, 0x3A83_126F),
            (crate::math::EPSILON, 0x3951_B717),
        ] {
            assert_eq!(value.to_bits(), bits);
        }
    }
}
