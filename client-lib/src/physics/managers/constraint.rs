//! The constraint: an object may leave a place only so far (F4).

use crate::math::{Frame, Position};
use crate::profile::{ConstraintCounts, Profile};

/// Slows an object that has gone a way of more than `start` metres since it was constrained, and holds it at `max`.
///
/// The way counts, not the distance: it never relaxes by itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ConstraintManager {
    /// The constraint is on.
    pub constrained: bool,
    /// Way gone, m.
    pub pos_offset: f32,
    /// Way from which the object is slowed, m.
    pub start: f32,
    /// Way at which it is held, m.
    pub max: f32,
}

impl ConstraintManager {
    /// Constrains an object at `own` to the surroundings of `place`; the distance between the two counts as gone already.
    pub fn constrain_to(&mut self, place: &Position, start: f32, max: f32, own: &Position) {
        *self = Self {
            constrained: true,
            pos_offset: place.distance(own),
            start,
            max,
        };
    }

    /// Lifts the constraint.
    pub fn unconstrain(&mut self) {
        self.constrained = false;
    }

    /// Whether nine tenths of the way are used up; also true of a constraint that was lifted.
    pub fn is_fully_constrained(&self, profile: &Profile) -> bool {
        match profile.constraint_counts {
            ConstraintCounts::PathLength => f64::from(self.max) * 0.9 < f64::from(self.pos_offset),
            ConstraintCounts::LastStep => self.max * 0.9 < self.pos_offset,
        }
    }

    /// Shortens the offset (m, the object's own axes) of a quantum. Answers whether the constraint is on.
    pub fn adjust_offset(&mut self, offset: &mut Frame, contact: bool, profile: &Profile) -> bool {
        if !self.constrained {
            return false;
        }
        if contact {
            if self.pos_offset < self.max {
                if self.pos_offset > self.start {
                    offset.origin *= (self.max - self.pos_offset) / (self.max - self.start);
                }
            } else {
                offset.origin = crate::math::Vec3::ZERO;
            }
        }
        let length = offset.origin.length();
        match profile.constraint_counts {
            ConstraintCounts::PathLength => self.pos_offset += length,
            ConstraintCounts::LastStep => self.pos_offset = length,
        }
        true
    }
}
