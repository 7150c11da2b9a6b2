//! The pool of transitions (`spec/05-transition.md`, 6.1): how many may be nested, and what a new one finds of the last one in its slot.
//!
//! The retail client reuses a transition object per nesting level, and some fields survive. What survives is all that a slot keeps here
//! (`T-14`, `T-25`); profiles without such memory start from zero. The slots belong to the world and are shared by all objects, in the order in
//! which transitions happen.

use super::run::TransitionResult;
use super::state::CollisionInfo;
use crate::math::{CellId, Plane, Vec3};
use crate::profile::Profile;

/// Fields of collision info that a new transition in the same slot finds as they were left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LeftFields {
    pub contact_plane: Plane,
    pub contact_plane_is_water: bool,
    pub last_known_contact_plane: Plane,
    pub last_known_contact_plane_is_water: bool,
    pub last_known_cell_id: CellId,
    pub sliding_normal: Vec3,
    pub collision_normal: Vec3,
}

impl LeftFields {
    /// At program start.
    pub(super) const ZERO: Self = Self {
        contact_plane: Plane::ZERO,
        contact_plane_is_water: false,
        last_known_contact_plane: Plane::ZERO,
        last_known_contact_plane_is_water: false,
        last_known_cell_id: CellId::NONE,
        sliding_normal: Vec3::ZERO,
        collision_normal: Vec3::ZERO,
    };

    fn of(info: &CollisionInfo) -> Self {
        Self {
            contact_plane: info.contact_plane.plane,
            contact_plane_is_water: info.contact_plane.is_water,
            last_known_contact_plane: info.last_known_contact_plane.plane,
            last_known_contact_plane_is_water: info.last_known_contact_plane.is_water,
            last_known_cell_id: info.last_known_contact_plane.cell_id,
            sliding_normal: info.sliding_normal,
            collision_normal: info.collision_normal,
        }
    }
}

/// A transition that was taken from the pool: its nesting level, and its result once it has run.
#[derive(Debug)]
pub struct Transit {
    level: usize,
    /// What the last run gave; nothing before.
    pub result: TransitionResult,
}

/// The pool of transitions of a world.
#[derive(Debug, Default)]
pub struct TransitionSlots {
    pub(crate) level: usize,
    pub(crate) left: Vec<LeftFields>,
    #[allow(
        clippy::vec_box,
        reason = "a transit is handed out and back as a box: the pointer moves, not the records"
    )]
    pub(crate) spare: Vec<Box<Transit>>,
}

impl TransitionSlots {
    /// Takes a transition (`makeTransition`); `None` if as many as the profile allows are nested already (`T-20`), which the caller treats as
    /// a failed operation. Every transition taken must be given back with [`cleanup`](Self::cleanup).
    pub fn make(&mut self, profile: &Profile) -> Option<Box<Transit>> {
        if self.level >= profile.nested_transitions as usize {
            return None;
        }
        let mut transit = self.spare.pop().unwrap_or_else(|| {
            Box::new(Transit {
                level: 0,
                result: TransitionResult::default(),
            })
        });
        transit.level = self.level;
        transit.result.reset();
        self.level += 1;
        Some(transit)
    }

    /// Ends the nesting of the innermost transition (`cleanupTransition`). The result stays readable until [`recycle`](Self::recycle).
    pub fn cleanup(&mut self) {
        self.level = self.level.saturating_sub(1);
    }

    /// Keeps the memory of a transition that nobody reads any more.
    pub fn recycle(&mut self, transit: Box<Transit>) {
        self.spare.push(transit);
    }

    /// What the last use of the transition's slot left.
    pub(super) fn left_fields(&self, transit: &Transit) -> LeftFields {
        self.left
            .get(transit.level)
            .copied()
            .unwrap_or(LeftFields::ZERO)
    }

    /// Remembers what a finished run leaves in its slot.
    pub(super) fn keep_left_fields(&mut self, transit: &Transit) {
        if self.left.len() <= transit.level {
            self.left.resize(transit.level + 1, LeftFields::ZERO);
        }
        self.left[transit.level] = LeftFields::of(&transit.result.info);
    }
}
