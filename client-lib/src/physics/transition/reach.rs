//! What is surely out of the mover's reach: a cheap test before the exact ones, which changes no result.
//!
//! An obstacle whose every point lies within a known distance of its own origin cannot touch a mover whose spheres are farther away. The test
//! leaves a margin that is far wider than the rounding of the exact tests, and answers "not sure" for everything unusual: not a number,
//! rotations that are not of length 1, huge obstacles.

use super::state::Transition;
use crate::math::{Position, block_offset};
use crate::physics::body::Body;
use crate::physics::state::PhysicsState;

/// Distance, m, that is added to what would touch.
const MARGIN: f32 = 0.2;
/// Obstacles that reach farther, m, are always tested.
const LARGEST_REACH: f32 = 500.0;
/// How far the squared length of a rotation may be from 1.
const UNIT_TOLERANCE: f32 = 0.01;

impl Transition<'_> {
    /// Whether the mover at the check position is surely farther than `reach` m from the origin of `place`, counting its radius twice.
    ///
    /// Twice, because cylinders are tested in plan and in height separately.
    #[inline]
    pub fn is_apart(&self, place: &Position, reach: f32) -> bool {
        let q = place.frame.rotation();
        let is_turn = (q.dot(q) - 1.0).abs() <= UNIT_TOLERANCE;
        if !is_turn || reach > LARGEST_REACH {
            return false;
        }
        let [lower, upper] = &self.path.global_sphere;
        let origin = block_offset(self.path.check_pos.cell, place.cell) + place.frame.origin;
        let radius = lower.radius.abs().max(upper.radius.abs());
        let limit = reach + radius * 2.0 + MARGIN;
        let square = limit * limit;
        // Not a number is not apart.
        (lower.center - origin).length_squared() > square
            && (self.path.num_sphere < 2 || (upper.center - origin).length_squared() > square)
    }

    /// Whether a test against `body` surely answers OK and changes nothing: the mover cannot touch its spheres and cylinders.
    ///
    /// Landing is left out: it may count without a touch. So is an obstacle inside the test of a passable one: its test ends that one's.
    #[inline]
    pub fn is_out_of_reach(&self, body: &Body) -> bool {
        if self.path.collide
            || self.path.obstruction_ethereal
            || body.state.contains(PhysicsState::HAS_PHYSICS_BSP)
        {
            return false;
        }
        body.part_array.as_ref().is_some_and(|parts| {
            self.is_apart(&body.position, parts.obstacle_reach() * body.scale.abs())
        })
    }
}
