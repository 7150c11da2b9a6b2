//! The integrator: friction, rest, translation, rotation (`spec/06-physics-object.md`, B6 to B8).
//!
//! Runs once per quantum, after root motion and before the transition. Velocities are m/s and rad/s in world axes, quanta seconds.
//! Translation uses the velocity after friction and after the rest rule plus half the acceleration; the velocity follows. A body that falls
//! from rest therefore does not move in its first step, and a throw loses up to 0.25 m/s at its top: both are the client's.

use crate::entity::Kinetics;
use crate::math::vector::{self, EPSILON};
use crate::math::{Frame, Vec3};
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::{Profile, Sledding, Width};

/// Acceleration of gravity along z, m/s².
pub const GRAVITY: f32 = -9.8;
/// Speed limit, m/s.
pub const MAX_VELOCITY: f32 = 50.0;
/// Square of the speed limit.
const MAX_VELOCITY_SQUARED: f32 = 2500.0;
/// Square of the speed below which an object rests, m²/s².
const SMALL_VELOCITY_SQUARED: f32 = 0.0625;
/// Speed away from the ground from which on there is no friction, m/s.
const FRICTION_DOT_LIMIT: f32 = 0.25;
/// Square of the speed below which a sled stops, m²/s².
const SLED_SLOW_SQUARED: f32 = 1.5625;
/// Square of the speed from which on a sled glides, m²/s².
const SLED_FAST_SQUARED: f32 = 6.25;
/// Cosine of 10 degrees.
const SLED_SLOPE_Z: f64 = 0.984_807_753_012_208;
/// Limit of profile `ace`: nearly flat.
const SLED_FLAT_Z: f32 = 0.999_995_36;
/// Friction of a gliding sled.
const SLED_FRICTION: f64 = 0.2;

impl Kinetics {
    /// Advances `frame` by one quantum (`UpdatePhysicsInternal`, B6). A resting object without a movement manager becomes inactive.
    pub fn update_physics(
        &mut self,
        frame: &mut Frame,
        quantum: f32,
        state: PhysicsState,
        has_movement_manager: bool,
        profile: &Profile,
    ) {
        let mut speed_squared = self.velocity.dot(self.velocity);
        if speed_squared <= 0.0 {
            // No translation in this step, even if acceleration is not zero.
            if !has_movement_manager && self.transient.contains(TransientState::ON_WALKABLE) {
                self.transient.remove(TransientState::ACTIVE);
            }
        } else {
            if speed_squared > MAX_VELOCITY_SQUARED {
                self.velocity = vector::normalize(self.velocity, profile) * MAX_VELOCITY;
                speed_squared = MAX_VELOCITY_SQUARED;
            }
            self.apply_friction(quantum, speed_squared, state, profile);
            // Judged by the speed before friction.
            if speed_squared - SMALL_VELOCITY_SQUARED < EPSILON {
                self.velocity = Vec3::ZERO;
            }
            frame.origin += self.acceleration * 0.5 * quantum * quantum + self.velocity * quantum;
        }
        self.velocity += self.acceleration * quantum;
        frame.grotate(self.omega * quantum, profile);
    }

    /// Slows an object on walkable ground (`calc_friction`). `speed_squared` is the squared speed before, m²/s².
    pub fn apply_friction(
        &mut self,
        quantum: f32,
        speed_squared: f32,
        state: PhysicsState,
        profile: &Profile,
    ) {
        if !self.transient.contains(TransientState::ON_WALKABLE) {
            return;
        }
        let n = self.contact_plane.n;
        let p = self.velocity.dot(n);
        if p >= FRICTION_DOT_LIMIT {
            return;
        }
        self.velocity -= n * p;
        let friction = if state.contains(PhysicsState::SLEDDING) {
            self.sled_friction(speed_squared, n.z, profile)
        } else {
            f64::from(self.friction)
        };
        let kept = match profile.friction_base {
            Width::F64 => 1.0 - friction,
            Width::F32 => f64::from(1.0 - friction as f32),
        };
        self.velocity *= libm::pow(kept, f64::from(quantum)) as f32;
    }

    fn sled_friction(&self, speed_squared: f32, normal_z: f32, profile: &Profile) -> f64 {
        let glides = match profile.sledding {
            Sledding::Steep => f64::from(normal_z) < SLED_SLOPE_Z,
            Sledding::Flat => normal_z > SLED_FLAT_Z,
        };
        if speed_squared < SLED_SLOW_SQUARED {
            1.0
        } else if speed_squared >= SLED_FAST_SQUARED && glides {
            SLED_FRICTION
        } else {
            f64::from(self.friction)
        }
    }

    /// Derives the acceleration from contact and gravity; ground stops the spin (B7).
    pub fn calc_acceleration(&mut self, state: PhysicsState, profile: &Profile) {
        let on_ground = self
            .transient
            .contains(TransientState::CONTACT | TransientState::ON_WALKABLE);
        let sleds = state.contains(PhysicsState::SLEDDING) && profile.sledding == Sledding::Steep;
        if on_ground && !sleds {
            self.acceleration = Vec3::ZERO;
            self.omega = Vec3::ZERO;
        } else if state.contains(PhysicsState::GRAVITY) {
            self.acceleration = Vec3::new(0.0, 0.0, GRAVITY);
        } else {
            self.acceleration = Vec3::ZERO;
        }
    }

    /// Takes a velocity (m/s, world axes), at most [`MAX_VELOCITY`] long, and activates the object (`set_velocity`, B8). `now` in s.
    pub fn set_velocity(
        &mut self,
        velocity: Vec3,
        state: PhysicsState,
        now: f64,
        profile: &Profile,
    ) {
        let unchanged = if profile.set_velocity_tolerant {
            vector::is_equal(velocity, self.velocity, profile)
        } else {
            velocity == self.velocity
        };
        if !unchanged {
            self.velocity = velocity;
            if velocity.length() > MAX_VELOCITY {
                self.velocity = vector::normalize(velocity, profile) * MAX_VELOCITY;
            }
        }
        // Profile `gdle` leaves the mark alone when nothing changes.
        self.jumped_this_frame |= !(unchanged && profile.set_velocity_tolerant);
        self.set_active(true, state, now);
    }

    /// Activates or deactivates the object; activating resets its clock to `now`, s. `false` when a static object was to be activated.
    pub fn set_active(&mut self, active: bool, state: PhysicsState, now: f64) -> bool {
        if !active {
            self.transient.remove(TransientState::ACTIVE);
            return true;
        }
        if state.contains(PhysicsState::STATIC) {
            return false;
        }
        if !self.transient.contains(TransientState::ACTIVE) {
            self.update_time = now;
            self.transient.insert(TransientState::ACTIVE);
        }
        true
    }

    /// Takes a bounce factor, kept within 0 and 0.1; NaN gives 0.1 (`set_elasticity`). Profile `gdle` stores it as it is (O-57).
    pub fn set_elasticity(&mut self, elasticity: f32, profile: &Profile) {
        const MAX_ELASTICITY: f32 = 0.1;
        self.elasticity = if !profile.elasticity_clamped {
            elasticity
        } else if elasticity < 0.0 {
            0.0
        } else if elasticity < MAX_ELASTICITY {
            elasticity
        } else {
            MAX_ELASTICITY
        };
    }

    /// Whether the object keeps its contact: `false` when it moves off its plane, else `contact` (`check_contact`, C1).
    pub fn check_contact(&self, contact: bool) -> bool {
        let leaves = self.transient.contains(TransientState::CONTACT)
            && self.velocity.dot(self.contact_plane.n) > EPSILON;
        !leaves && contact
    }

    /// Whether the object stands: CONTACT and ON_WALKABLE.
    pub const fn on_ground(&self) -> bool {
        self.transient
            .contains(TransientState::CONTACT.union(TransientState::ON_WALKABLE))
    }
}
