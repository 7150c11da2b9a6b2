//! Operations on the path that need cells or polygons (`spec/05-transition.md`, section 8).

use super::state::{Transition, TransitionState};
use crate::math::{CellId, Position, Sphere, Vec3, block_offset};
use crate::world::CellHandle;

impl Transition<'_> {
    /// Puts the state under test at `position` in `cell` and computes its spheres.
    pub fn set_check_pos(&mut self, position: Position, cell: Option<CellHandle>) {
        let profile = self.profile();
        self.path.check_pos = position;
        self.path.check_cell = cell;
        self.path.cell_array_valid = false;
        self.path.cache_global_sphere(profile);
    }

    /// Puts the state under test back to the last accepted one.
    pub(super) fn check_pos_to_curr_pos(&mut self) {
        self.set_check_pos(self.path.curr_pos, self.path.curr_cell);
    }

    /// Accepts the state under test.
    pub(super) fn accept_check_pos(&mut self) {
        let profile = self.profile();
        self.path.curr_pos = self.path.check_pos;
        self.path.curr_cell = self.path.check_cell;
        self.path.cache_global_curr_center(profile);
    }

    /// As [`check_pos_to_curr_pos`](Self::check_pos_to_curr_pos), directly after the state under test was accepted: both positions are the same,
    /// and so are the centres of the spheres.
    pub(super) fn begin_at_accepted_pos(&mut self) {
        let profile = self.profile();
        let path = &mut self.path;
        path.cell_array_valid = false;
        for i in 0..path.num_sphere.min(2) {
            path.global_sphere[i] =
                Sphere::new(path.global_curr_center[i], path.local_sphere[i].radius);
        }
        let low = path.local_low_point;
        path.global_low_point = path.check_pos.frame.local_to_global(low, profile);
    }

    /// Saves the state under test in its single backup.
    pub(super) fn save_check_pos(&mut self) {
        self.path.backup_cell = self.path.check_cell;
        self.path.backup_check_pos = self.path.check_pos;
    }

    /// Puts the state under test back to its backup.
    pub(super) fn restore_check_pos(&mut self) {
        self.set_check_pos(self.path.backup_check_pos, self.path.backup_cell);
    }

    /// Expresses the state under test in the block of cell `id`: the same point. For indoor ids the numbers stay.
    pub(super) fn adjust_check_pos(&mut self, id: CellId) {
        if !id.is_indoor() {
            let offset = block_offset(id, self.path.check_pos.cell);
            self.path.shift_global_sphere(offset);
            self.path.check_pos.frame.origin += offset;
        }
        self.path.check_pos.cell = id;
    }

    /// Whether the polygon last used as ground still carries a sphere of half the radius there; also without such a polygon.
    ///
    /// The halving stays: a third check in one transition uses an eighth of the radius (`T-07`: on a copy in profile `ace`).
    pub(super) fn check_walkables(&mut self) -> bool {
        let profile = self.profile();
        let Some(polygon) = self.path.walkable else {
            return true;
        };
        let mut sphere = self.path.walkable_check_pos;
        sphere.radius *= 0.5;
        if !profile.walkable_halving_on_copy {
            self.path.walkable_check_pos = sphere;
        }
        polygon.check_walkable(&sphere, self.path.walkable_up, profile)
    }

    /// Slides along the edge of the polygon that the mover stands on; the polygon is forgotten. Collided when the sphere's centre is not
    /// beyond any edge, or there is no such polygon.
    pub(super) fn precipice_slide(&mut self) -> TransitionState {
        let Some(polygon) = self.path.walkable.take() else {
            return TransitionState::Collided;
        };
        let profile = self.profile();
        let (sphere, up) = (self.path.walkable_check_pos, self.path.walkable_up);
        let edge = polygon.find_crossed_edge(&sphere, up);
        let Some(inward) = edge else {
            return TransitionState::Collided;
        };
        self.path.step_up = false;
        let frame = &self.path.walkable_pos.frame;
        let mut normal = frame.local_to_global_vec(inward, profile);
        // The normal opposes the move.
        if normal.dot(self.check_displacement()) > 0.0 {
            normal = -normal;
        }
        self.slide_first_sphere(&mut normal)
    }

    /// How far the first sphere is from where it is at the current position, m.
    pub(super) fn check_displacement(&self) -> Vec3 {
        (self.path.global_sphere[0].center - self.path.global_curr_center[0])
            + self.path.curr_to_check_block_offset()
    }

    /// Slides the first sphere along a surface with that normal (04, 8.9).
    pub(super) fn slide_first_sphere(&mut self, normal: &mut Vec3) -> TransitionState {
        let center = self.path.global_sphere[0].center;
        self.slide_sphere(center, normal, self.path.global_curr_center[0])
    }
}
