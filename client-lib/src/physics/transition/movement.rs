//! The step loop (`spec/05-transition.md`, 10.1 to 10.4).

use super::state::{InsertType, ObjectInfoState, Transition, TransitionState};
use super::{MAX_SUB_STEPS, MOVE_ATTEMPTS};
use crate::math::vector::{self, normalize_check_small};
use crate::math::{EPSILON, Vec3, block_offset};

/// How a path is cut into steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepPlan {
    /// The whole way, m.
    pub offset: Vec3,
    /// One step, m: at most one sphere radius long.
    pub per_step: Vec3,
    /// Number of steps; saturates.
    pub steps: u32,
}

impl Transition<'_> {
    /// Runs the transition: true if the mover has a valid position, which is then `path.curr_pos` and `path.curr_cell`.
    ///
    /// A movement that is blocked at once is a success that ends where it began. A movement fails without a begin cell, with NaN in begin or
    /// end, with an absurd number of steps, or when its first step comes to nothing.
    pub fn find_valid_position(&mut self) -> bool {
        if self.path.insert_type == InsertType::Transition {
            self.find_transitional_position()
        } else {
            self.find_placement_position()
        }
    }

    /// Cuts the way from begin to end into steps (10.2). Viewers take steps of exactly one radius and a remainder.
    pub fn calc_num_steps(&self) -> StepPlan {
        let Some(begin) = &self.path.begin_pos else {
            return StepPlan {
                offset: Vec3::ZERO,
                per_step: Vec3::ZERO,
                steps: 1,
            };
        };
        let offset = begin.offset_to(&self.path.end_pos);
        let length = offset.length();
        let q = length / self.path.local_sphere[0].radius;
        let plan = |per_step, steps| StepPlan {
            offset,
            per_step,
            steps,
        };
        if self.object.is_viewer() {
            if length <= EPSILON {
                return plan(Vec3::ZERO, 0);
            }
            return plan(offset * (1.0 / q), (q.floor() as u32).saturating_add(1));
        }
        if q > 1.0 {
            let k = q.ceil();
            plan(offset * (1.0 / k), k as u32)
        } else if offset != Vec3::ZERO {
            plan(offset, 1)
        } else {
            plan(Vec3::ZERO, 0)
        }
    }

    /// Projects the wanted step (m) onto what is known about wall and ground (10.3).
    ///
    /// Quirks: the check position is raised here, before the step is added, if the mover has sunk into its contact plane; a step that moves up
    /// off the plane keeps its horizontal length, one into the plane is shortened.
    pub fn adjust_offset(&mut self, mut offset: Vec3) -> Vec3 {
        let profile = self.profile();
        let sliding = self.info.sliding_normal;
        let mut wall = false;
        if self.info.sliding_normal_valid {
            wall = offset.dot(sliding) < 0.0;
            self.info.sliding_normal_valid = wall;
        }
        let ground = self.info.contact_plane;
        if !ground.valid {
            if wall {
                offset -= sliding * offset.dot(sliding);
            }
            return offset;
        }
        let n = ground.plane.n;
        let along_normal = offset.dot(n);
        if wall {
            let crease = normalize_check_small(n.cross(sliding));
            offset = crease.map_or(Vec3::ZERO, |a| a * a.dot(offset));
        } else if along_normal <= 0.0 {
            offset -= n * along_normal;
        } else {
            ground.plane.snap_to_plane(&mut offset, profile);
        }
        if !ground.cell_id.is_none() && !ground.is_water {
            self.rise_to_contact_plane();
        }
        offset
    }

    /// Lifts a sphere that has sunk into the contact plane, vertically, by less than its radius (10.3, steps 6 and 7).
    fn rise_to_contact_plane(&mut self) {
        let ground = self.info.contact_plane;
        let sphere = self.path.global_sphere[0];
        let b = block_offset(self.path.check_pos.cell, ground.cell_id);
        let distance = ground.plane.distance(sphere.center - b);
        if distance >= sphere.radius - EPSILON {
            return;
        }
        let z = (sphere.radius - distance) / ground.plane.n.z;
        if sphere.radius > z.abs() {
            self.add_offset_to_check_pos(Vec3::new(0.0, 0.0, z));
        }
    }

    /// Moves along the path (10.4).
    pub(super) fn find_transitional_position(&mut self) -> bool {
        if self.path.begin_cell.is_none() || !self.path_is_a_number() {
            return false;
        }
        let plan = self.calc_num_steps();
        self.progress.planned = plan.steps;
        // T-16: ACE protects its server.
        let limit = if self.profile().substep_limit {
            1000
        } else {
            MAX_SUB_STEPS
        };
        if plan.steps > limit {
            return false;
        }
        let profile = self.profile();
        let end_rotation = self.path.end_pos.frame.rotation();
        if self.rotates_freely() {
            (self.path.curr_pos.frame).set_rotation(end_rotation, profile);
        }
        self.check_pos_to_curr_pos();
        if plan.steps > 0 {
            return self.take_steps(&plan);
        }
        self.turn_in_place();
        true
    }

    fn rotates_freely(&self) -> bool {
        self.object.state.contains(ObjectInfoState::FREE_ROTATE)
    }

    /// The specification refuses NaN before the transition (section 15); profile `gdle` lets it in, and its records show what comes of it:
    /// one step, which the terrain takes back.
    fn path_is_a_number(&self) -> bool {
        if !self.profile().nan_goal_refused {
            return true;
        }
        let begin = self.path.begin_pos.as_ref();
        vector::is_valid(self.path.end_pos.frame.origin)
            && begin.is_none_or(|p| vector::is_valid(p.frame.origin))
    }

    /// A pure rotation always succeeds and does not test anything; the cell list is made anew.
    fn turn_in_place(&mut self) {
        let profile = self.profile();
        if !self.rotates_freely() {
            let rotation = self.path.end_pos.frame.rotation();
            self.path.curr_pos.frame.set_rotation(rotation, profile);
        }
        // T-15: profile `ace` keeps the check position as it was before the turn.
        if profile.zero_substeps_reset {
            self.check_pos_to_curr_pos();
        }
        self.build_cell_array(None);
    }

    fn take_steps(&mut self, plan: &StepPlan) -> bool {
        let mut ts = TransitionState::Ok;
        for i in 0..plan.steps {
            if self.missing.is_some() {
                return false;
            }
            let wanted = self.wanted_step(plan, i);
            let offset = self.adjust_offset(wanted);
            self.path.global_offset = offset;
            if !self.object.is_viewer() && offset.length_squared() < EPSILON * EPSILON {
                return i != 0 && ts == TransitionState::Ok;
            }
            if !self.rotates_freely() {
                self.turn_for_step((i + 1) as f32 / plan.steps as f32);
            }
            self.info.sliding_normal_valid = false;
            self.info.void_contact_plane();
            if self.path.insert_type == InsertType::Transition {
                ts = self.take_step(offset);
                if self.info.frames_stationary_fall != 0 {
                    break;
                }
            } else {
                // A landing left the mode at Placement (13.4).
                let inserted = self.transitional_insert(MOVE_ATTEMPTS);
                self.note_sub_step(inserted);
                ts = self.validate_placement_transition(inserted);
                if ts == TransitionState::Ok {
                    return true;
                }
                if !self.path.placement_allows_sliding {
                    return false;
                }
                self.add_offset_to_check_pos(offset);
            }
            let clipped = self.object.state.contains(ObjectInfoState::PATH_CLIPPED);
            if self.info.collision_normal_valid && clipped {
                break;
            }
        }
        ts == TransitionState::Ok
    }

    /// The step as planned; a viewer's last one is what is left of the way.
    fn wanted_step(&self, plan: &StepPlan, i: u32) -> Vec3 {
        let length = plan.offset.length();
        if self.object.is_viewer() && i + 1 == plan.steps && length > EPSILON {
            let done = self.path.local_sphere[0].radius * (plan.steps - 1) as f32;
            plan.offset * (length - done) / length
        } else {
            plan.per_step
        }
    }

    /// Turns the state under test to where it is at share `t` of the way. Its spheres are not computed anew.
    fn turn_for_step(&mut self, t: f32) {
        let profile = self.profile();
        if let Some(begin) = self.path.begin_pos {
            let end = self.path.end_pos.frame;
            (self.path.check_pos.frame).interpolate_rotation(&begin.frame, &end, t, profile);
        }
    }

    fn take_step(&mut self, offset: Vec3) -> TransitionState {
        self.add_offset_to_check_pos(offset);
        let inserted = self.transitional_insert(MOVE_ATTEMPTS);
        self.note_sub_step(inserted);
        self.validate_transition(inserted)
    }

    fn note_sub_step(&mut self, inserted: TransitionState) {
        self.progress.done += 1;
        self.progress.last_insert = Some(inserted);
    }
}
