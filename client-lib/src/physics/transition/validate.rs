//! Accepting or taking back one step (`spec/05-transition.md`, 10.14).

use super::object_info::is_valid_walkable;
use super::state::{ObjectInfoState, Transition, TransitionState};
use crate::math::{EPSILON, Plane, Vec3};
use crate::physics::state::PhysicsState;

impl Transition<'_> {
    /// Accepts the state under test, or takes the step back and says why, by the answer `inserted` of its insert.
    ///
    /// Collided, Adjusted and Slid become OK: a blocked step is a successful one that ends where it began. Afterwards the mover's contact bits
    /// say what the contact plane says.
    pub(super) fn validate_transition(&mut self, inserted: TransitionState) -> TransitionState {
        let profile = self.profile();
        let moved = !self.path.check_pos.is_equal(&self.path.curr_pos, profile);
        let mut progress = inserted == TransitionState::Ok && moved;
        let ts = match inserted {
            TransitionState::Ok => {
                self.accept_check_pos();
                self.begin_at_accepted_pos();
                TransitionState::Ok
            }
            TransitionState::Invalid => TransitionState::Invalid,
            _ => {
                progress |= self.take_step_back();
                TransitionState::Ok
            }
        };
        if self.info.collision_normal_valid {
            self.set_sliding_normal(self.info.collision_normal);
        }
        let falls = self.object.physics_state.contains(PhysicsState::GRAVITY);
        if falls && !self.object.is_viewer() {
            self.count_stationary_fall(progress);
        }
        self.update_contact();
        ts
    }

    /// Returns to the last accepted position (2a to 2d). True if the mover still stands on the ground it knew, which counts as progress.
    fn take_step_back(&mut self) -> bool {
        let stands = self.stand_on_last_known_plane();
        if !self.info.collision_normal_valid {
            self.set_collision_normal(Vec3::Z);
        }
        self.check_pos_to_curr_pos();
        // The caller turns this list into shadows: it is the one of the accepted position.
        self.build_cell_array(None);
        stands
    }

    /// A blocked mover that knew ground loses its velocity, and touches that ground again if it is close. No block offset is applied, in either
    /// reference.
    fn stand_on_last_known_plane(&mut self) -> bool {
        let known = self.info.last_known_contact_plane;
        if !known.valid {
            return false;
        }
        self.object.kill_velocity();
        let distance = known.plane.distance(self.path.global_curr_center[0]);
        if self.path.global_sphere[0].radius + EPSILON <= distance.abs() || distance.is_nan() {
            return false;
        }
        self.set_contact_plane(known.plane, known.is_water);
        self.info.contact_plane.cell_id = known.cell_id;
        self.object.on_walkable()
    }

    /// Counts steps without progress of a mover with gravity; at the third ground is invented below it.
    fn count_stationary_fall(&mut self, progress: bool) {
        let before = self.info.frames_stationary_fall;
        self.info.frames_stationary_fall = match (progress, before) {
            (true, _) => 0,
            (false, 0) => 1,
            (false, 1) => 2,
            (false, _) => 3,
        };
        if progress || before < 2 {
            return;
        }
        let sphere = self.path.global_sphere[0];
        let plane = Plane {
            n: Vec3::Z,
            d: sphere.radius - sphere.center.z,
        };
        self.set_contact_plane(plane, false);
        self.info.contact_plane.cell_id = self.path.check_pos.cell;
        if !self.object.in_contact() {
            self.set_collision_normal(Vec3::Z);
            self.info.collided_with_environment = true;
        }
    }

    /// The contact plane becomes the last known one and gives the mover its contact bits.
    fn update_contact(&mut self) {
        let profile = self.profile();
        let ground = self.info.contact_plane;
        if ground.valid {
            self.info.last_known_contact_plane = ground;
        } else {
            self.info.last_known_contact_plane.valid = false;
        }
        let walkable = ground.valid && is_valid_walkable(ground.plane.n, profile);
        let state = &mut self.object.state;
        state.set(ObjectInfoState::CONTACT, ground.valid);
        state.set(ObjectInfoState::ON_WALKABLE, walkable);
    }
}
