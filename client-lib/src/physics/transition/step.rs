//! Stepping up and down (`spec/05-transition.md`, 10.9 to 10.11).

use super::STEP_DOWN_ATTEMPTS;
use super::state::{ObjectInfoState, Transition, TransitionState};
use crate::math::Vec3;

impl Transition<'_> {
    /// Tries to climb an obstacle whose surface has that normal, block coordinates (10.9): true if the mover now stands on something, false if
    /// it is where it was.
    ///
    /// Nothing is raised here: with `step_up` set, `step_down` does not lower the mover first, so that its search runs from the
    /// position under test upward, and the geometry lifts the sphere to the surface it finds.
    pub fn step_up(&mut self, normal: Vec3) -> bool {
        self.info.void_contact_plane();
        self.path.step_up = true;
        self.path.step_up_normal = normal;
        let (walkable_z, height) = self.object.walking_limits(self.object.step_up_height);
        self.path.walkable_allowance = walkable_z;
        self.save_check_pos();
        let climbed = self.step_down(height, walkable_z);
        self.path.step_up = false;
        self.path.walkable = None;
        if !climbed {
            self.restore_check_pos();
        }
        climbed
    }

    /// Looks for ground whose normal has at least z `walkable_z`, within `height` metres (10.10).
    ///
    /// Nothing is restored: on failure the check position is wherever the attempt left it, and a contact plane found stays set.
    pub(super) fn step_down(&mut self, height: f32, walkable_z: f32) -> bool {
        self.path.neg_poly_hit = false;
        self.path.step_down = true;
        self.path.step_down_amt = height;
        self.path.walk_interp = 1.0;
        if !self.path.step_up {
            self.path.cell_array_valid = false;
            self.path.check_pos.frame.origin.z -= height;
            self.path.shift_global_sphere(Vec3::new(0.0, 0.0, -height));
        }
        let ts = self.transitional_insert(STEP_DOWN_ATTEMPTS);
        self.path.step_down = false;
        let edge_slides = self.object.state.contains(ObjectInfoState::EDGE_SLIDE);
        ts == TransitionState::Ok
            && self.info.contact_plane.valid
            && self.info.contact_plane.plane.n.z >= walkable_z
            && (!edge_slides || self.path.step_up || self.check_walkable(walkable_z))
            && self.fits_here(1)
    }

    /// Looks for ground within `height` metres: at once, or for more than two radii in up to `halves` steps of half the height, each from where
    /// the one before left off (10.5 D, 12.1). Answers the height of one step, and whether ground was found.
    pub(super) fn step_down_in_parts(
        &mut self,
        mut height: f32,
        walkable_z: f32,
        halves: u32,
    ) -> (f32, bool) {
        let radius = self.path.global_sphere[0].radius;
        if self.path.num_sphere < 2 && radius * 2.0 < height {
            height = radius * 0.5;
        }
        if radius * 2.0 >= height {
            return (height, self.step_down(height, walkable_z));
        }
        height *= 0.5;
        let found = (0..halves).any(|_| self.step_down(height, walkable_z));
        (height, found)
    }

    /// Whether there is still ground under the middle of the sphere (10.11). Hitting something below is the good answer.
    pub(super) fn check_walkable(&mut self, walkable_z: f32) -> bool {
        if !self.object.on_walkable() || self.check_walkables() {
            return true;
        }
        // T-06: profile `ace` uses the shared backup, so that a later restore goes to the stepped-down position.
        let shared = self.profile().check_walkable_shared_backup;
        let (position, cell) = (self.path.check_pos, self.path.check_cell);
        if shared {
            self.save_check_pos();
        }
        self.path.walkable_allowance = walkable_z;
        self.path.check_walkable = true;
        let mut height = self.object.step_down_height;
        let radius = self.path.global_sphere[0].radius;
        if self.path.num_sphere < 2 && height > radius * 2.0 {
            height = radius * 0.5;
        }
        if height > radius * 2.0 {
            height *= 0.5;
        }
        self.add_offset_to_check_pos(Vec3::new(0.0, 0.0, -height));
        let ts = self.transitional_insert(1);
        self.path.check_walkable = false;
        if shared {
            self.restore_check_pos();
        } else {
            self.set_check_pos(position, cell);
        }
        ts != TransitionState::Ok
    }
}
