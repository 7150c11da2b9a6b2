//! Keeping near a target (F3): a melee charge.

use crate::math::{EPSILON, Frame, Position, UprightCylinder, Vec3, vector};
use crate::profile::Profile;

/// Gap that is kept between the two cylinders, m.
const GAP: f32 = 0.3;
/// Speed of an object whose motions give none, m/s.
const DEFAULT_SPEED: f32 = 15.0;
/// How long an object sticks, s.
pub(super) const STICKY_TIME: f64 = 1.0;

/// Whom an object sticks to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StickyManager {
    /// GUID; 0 none.
    pub target_id: u32,
    /// Radius of the target, m.
    pub target_radius: f32,
    /// Last known place of the target.
    pub target_position: Position,
    /// The place is known.
    pub initialized: bool,
    /// When it ends, s on the frame clock.
    pub timeout: f64,
}

/// What sticking needs to know of the object.
#[derive(Debug, Clone, Copy)]
pub struct StickyPull<'a> {
    /// Where it is.
    pub position: &'a Position,
    /// Its radius, m.
    pub radius: f32,
    /// Where the target is now; `None` if it is not in the object table.
    pub target_now: Option<&'a Position>,
    /// Maximum speed of its motions, m/s (`spec/08`, 8.18).
    pub max_speed: f32,
    /// s.
    pub quantum: f32,
}

impl StickyManager {
    /// Whether [`StickyManager::adjust_offset`] will act, and so needs the object's speed.
    pub fn is_pulling(&self) -> bool {
        self.target_id != 0 && self.initialized
    }

    /// Sticks to another target; the caller has cleared the former one and sets the target manager's target afterwards. `now` in s.
    pub fn set(&mut self, target_id: u32, target_radius: f32, now: f64) {
        self.target_id = target_id;
        self.target_radius = target_radius;
        self.initialized = false;
        self.timeout = now + STICKY_TIME;
    }

    /// Forgets the target; `false` without one. The caller then clears the target manager's target and cancels move-to.
    pub fn clear(&mut self) -> bool {
        let had = self.target_id != 0;
        self.target_id = 0;
        self.initialized &= !had;
        had
    }

    /// Whether the time is up, at `now` s.
    pub fn is_over(&self, now: f64) -> bool {
        self.target_id != 0 && now > self.timeout
    }

    /// Replaces the offset (the object's own axes, m) of a quantum by a step to the wanted distance, and turns to the target. Answers whether
    /// there is a target.
    pub fn adjust_offset(
        &self,
        offset: &mut Frame,
        object: &StickyPull<'_>,
        profile: &Profile,
    ) -> bool {
        if !self.is_pulling() {
            return false;
        }
        let own = object.position;
        let target = object.target_now.unwrap_or(&self.target_position);
        let mut way = own
            .frame
            .global_to_local_vec(own.offset_to(target), profile);
        way.z = 0.0;
        let cylinder = |radius, position| UprightCylinder {
            radius,
            height: 0.0,
            position,
        };
        let distance =
            cylinder(object.radius, own).distance_no_z(&cylinder(self.target_radius, target)) - GAP;
        let direction = vector::normalize_check_small(way).unwrap_or(Vec3::ZERO);
        let mut speed = 5.0 * object.max_speed;
        if speed < EPSILON {
            speed = DEFAULT_SPEED;
        }
        let mut step = speed * object.quantum;
        if step >= distance.abs() {
            // Too near: backs off. A step shorter than that goes forward all the same.
            step = distance;
        }
        offset.origin = direction * step;
        let mut turn = own.heading_diff(target, profile);
        if turn.abs() < EPSILON {
            turn = 0.0;
        }
        if turn < -EPSILON {
            turn += 360.0;
        }
        offset.set_heading(turn, profile);
        true
    }
}
