//! Objects that stand still: their quanta change nothing but the frame number of what they play.
//!
//! A quantum is a function of the object and of little else. One that was run from a state without any motion and gave the same bits back will
//! do so again, until somebody changes the object; the [store](crate::entity::Entities) knows when somebody may have. Until then only the
//! playing list is advanced, without root motion, and the quantum is listed. A hook ends the shortcut: the rest of its quantum runs as always.

use crate::entity::{Entity, Kinetics};
use crate::frame::state::{Outcome, Step};
use crate::math::{Frame, Vec3};
use crate::physics::state::{PhysicsState, TransientState};
use crate::physics::update::Quantum;
use crate::world::World;

/// Whether all bits are zero: plus zero in every component.
#[inline]
fn is_zero(v: Vec3) -> bool {
    v.x.to_bits() | v.y.to_bits() | v.z.to_bits() == 0
}

impl Kinetics {
    /// Whether nothing moves the object by itself.
    #[inline]
    pub(crate) fn is_calm(&self) -> bool {
        is_zero(self.velocity)
            && is_zero(self.acceleration)
            && is_zero(self.omega)
            && is_zero(self.cached_velocity)
    }
}

impl Entity {
    /// Whether the quantum that has just run from `before`, with `offset` as root motion, was the first of many that change nothing. It began
    /// without motion, too.
    pub(crate) fn comes_to_stand(&self, before: &Frame, offset: &Frame, world: &World) -> bool {
        self.kin.is_calm()
            && world.profile.grotate_skips_tiny
            && self.nobody_moves_it()
            && !self.has_hooks()
            && offset.bits() == Frame::IDENTITY.bits()
            && self.body.position.frame.bits() == before.bits()
            && self.keeps_playing_in_place()
    }

    /// Notes whether the object stands still.
    #[inline]
    pub(crate) fn note_stand(&mut self, stands: bool) {
        if let Some(parts) = &mut self.body.part_array {
            parts.stands_still = stands;
        }
    }

    /// Whether it has stood still; it no longer counts as doing so.
    #[inline]
    pub(crate) fn end_stand(&mut self) -> bool {
        let parts = self.body.part_array.as_mut();
        parts.is_some_and(|parts| std::mem::take(&mut parts.stands_still))
    }

    /// Nothing that may act in a quantum is there.
    fn nobody_moves_it(&self) -> bool {
        let acts = PhysicsState::HIDDEN | PhysicsState::ALIGN_PATH | PhysicsState::SLEDDING;
        let transient = self.kin.transient;
        self.movement.is_some()
            && self.move_to().is_none_or(|m| m.is_idle())
            && self.position_manager.is_none()
            && self.target_manager.is_none()
            && self.children.is_empty()
            && !self.kin.jumped_this_frame
            && !self.body.state.intersects(acts)
            && transient.contains(TransientState::ACTIVE)
            && !transient.contains(TransientState::CHECK_ETHEREAL)
    }

    /// Nothing in the playing list moves the object.
    fn keeps_playing_in_place(&self) -> bool {
        let Some(parts) = &self.body.part_array else {
            return false;
        };
        let sequence = &parts.sequence;
        is_zero(sequence.velocity)
            && is_zero(sequence.omega)
            && sequence.nodes().all(|node| !node.has_root_motion())
    }

    /// Plays on in place. Whether that was all that this quantum does; if not, the animation is done and the rest is to be run.
    pub(crate) fn stand(&mut self, quantum: Quantum, world: &World) -> bool {
        self.advance_animation(None, quantum.narrow, &world.profile);
        if self.has_hooks() {
            return false;
        }
        self.update_parts(world);
        self.steps.push(Step {
            dt: quantum.narrow,
            outcome: Outcome::None,
        });
        true
    }
}
