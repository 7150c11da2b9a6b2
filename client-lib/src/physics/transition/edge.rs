//! Edges and slopes that are too steep (`spec/05-transition.md`, 10.12 and 10.13).

use super::state::{ObjectInfoState, Transition, TransitionState};
use crate::math::vector::normalize_check_small;
use crate::math::{Plane, Vec3};
use crate::profile::EdgeSlideOrder;

impl Transition<'_> {
    /// Decides what a mover does that has lost its ground and found none below (10.12): walk off the edge, slide along a steep slope or along the
    /// edge, or stop. `height` (m) and `walkable_z` are those of the step down that failed. Answers the state, and whether the insert ends.
    pub(super) fn edge_slide(&mut self, height: f32, walkable_z: f32) -> (TransitionState, bool) {
        let ground = self.info.contact_plane;
        let stays = self.object.state.contains(ObjectInfoState::EDGE_SLIDE);
        if !self.object.on_walkable() || !stays {
            self.path.walkable = None;
            self.back_to_step_start();
            return (TransitionState::Ok, true);
        }
        if ground.valid && ground.plane.n.z < walkable_z {
            return (self.slide_at_cliff(&ground.plane), false);
        }
        if self.path.walkable.is_some() {
            let ts = self.slide_at_precipice();
            return (ts, ts == TransitionState::Collided);
        }
        if ground.valid {
            self.path.walkable = None;
            self.back_to_step_start();
            return (TransitionState::Ok, true);
        }
        self.slide_at_edge_behind(height, walkable_z)
    }

    /// Back to the position saved before the step down, touching nothing.
    fn back_to_step_start(&mut self) {
        self.restore_check_pos();
        self.path.cell_array_valid = true;
        self.info.void_contact_plane();
    }

    /// T-05: profile `ace` slides first and restores then, which undoes the move; the state and the normals stay.
    fn slide_at_cliff(&mut self, plane: &Plane) -> TransitionState {
        match self.profile().edge_slide_order {
            EdgeSlideOrder::AfterRestore => {
                self.path.walkable = None;
                self.restore_check_pos();
                let ts = self.cliff_slide(plane);
                self.info.void_contact_plane();
                ts
            }
            EdgeSlideOrder::BeforeRestore => {
                let ts = self.cliff_slide(plane);
                self.path.walkable = None;
                self.restore_check_pos();
                self.info.void_contact_plane();
                ts
            }
        }
    }

    /// As [`slide_at_cliff`](Self::slide_at_cliff), at the edge of the polygon that the mover stands on.
    fn slide_at_precipice(&mut self) -> TransitionState {
        match self.profile().edge_slide_order {
            EdgeSlideOrder::AfterRestore => {
                self.restore_check_pos();
                self.info.void_contact_plane();
                self.precipice_slide()
            }
            EdgeSlideOrder::BeforeRestore => {
                let ts = self.precipice_slide();
                self.restore_check_pos();
                self.info.void_contact_plane();
                ts
            }
        }
    }

    /// Nothing is known about the ground: looks for it under the old position, and slides along the edge of what is there.
    fn slide_at_edge_behind(&mut self, height: f32, walkable_z: f32) -> (TransitionState, bool) {
        // No block offset here, in either reference.
        let back = self.path.global_curr_center[0] - self.path.global_sphere[0].center;
        self.add_offset_to_check_pos(back);
        self.step_down(height, walkable_z);
        self.info.void_contact_plane();
        self.restore_check_pos();
        if self.path.walkable.is_none() {
            self.path.cell_array_valid = true;
            return (TransitionState::Collided, true);
        }
        let (position, scale) = (self.path.walkable_pos, self.path.walkable_scale);
        self.cache_localspace_sphere(&position, scale);
        self.path.walkable_check_pos = self.path.localspace_sphere[0];
        let ts = self.precipice_slide();
        (ts, ts == TransitionState::Collided)
    }

    /// Slides along a slope that is too steep (10.13). `plane` is the slope's; only its normal counts.
    ///
    /// Quirk: running into the slope doubles the part of the move that goes into it instead of removing it. The step is then taken back; what
    /// lasts is the collision normal, along which the following steps glide.
    fn cliff_slide(&mut self, plane: &Plane) -> TransitionState {
        let mut c = plane.n.cross(self.info.last_known_contact_plane.plane.n);
        c.z = 0.0;
        let side = Vec3::new(c.z - c.y, c.x - c.z, 0.0);
        let Some(normal) = normalize_check_small(side) else {
            return TransitionState::Ok;
        };
        let k = normal.dot(self.check_displacement());
        if k <= 0.0 {
            self.add_offset_to_check_pos(normal * k);
            self.set_collision_normal(normal);
        } else {
            self.add_offset_to_check_pos(normal * -k);
            self.set_collision_normal(-normal);
        }
        TransitionState::Adjusted
    }
}
