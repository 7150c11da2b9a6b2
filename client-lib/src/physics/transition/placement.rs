//! Placing an object where it is not yet (`spec/05-transition.md`, section 12).

use super::state::{InsertType, Transition, TransitionState};
use super::{LANDING_Z, MAX_PLACEMENT_PROBES, MOVE_ATTEMPTS};
use crate::math::vector;
use crate::math::{EPSILON, Frame, Vec3};
use crate::profile::PlacementReset;

/// Search range (m) around the wanted place; half of it for small spheres.
const SEARCH_RANGE: f32 = 4.0;
/// Radius (m) below which a sphere is small.
const SMALL_RADIUS: f32 = 0.125;
/// Least radius (m) that decides how dense the search is, for spheres that are not small.
const SEARCH_RADIUS: f32 = 0.48;

/// Rings around the wanted place (12.5, steps 3 and 4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rings {
    /// Number of rings.
    pub count: u32,
    /// Distance from one to the next, m.
    pub spacing: f32,
    /// What is added per ring to the running sum that gives half the number of probes, rad.
    pub density: f32,
}

impl Rings {
    /// The rings for a sphere of that radius (m); none if it is too large to search for.
    ///
    /// `T-19`: profile `gdle` computes the count in f64 and the density in f32.
    pub(super) fn around(radius: f32, wide_count: bool) -> Option<Self> {
        let small = radius < SMALL_RADIUS;
        let range = if small {
            SEARCH_RANGE * 0.5
        } else {
            SEARCH_RANGE
        };
        let rho = if small || radius >= SEARCH_RADIUS {
            radius
        } else {
            SEARCH_RADIUS
        };
        let share = if small { 0.5 } else { 1.0 };
        let count = if wide_count {
            let q = f64::from(SEARCH_RANGE) / f64::from(rho) * f64::from(share);
            if q > 1.0 { q.ceil() as u32 } else { 0 }
        } else {
            let q = SEARCH_RANGE / rho * share;
            if q > 1.0 { q.ceil() as u32 } else { 0 }
        };
        if count == 0 {
            return None;
        }
        let spacing = range / count as f32;
        let density = if wide_count {
            core::f32::consts::PI * spacing / rho
        } else {
            (core::f64::consts::PI * f64::from(spacing) / f64::from(rho)) as f32
        };
        Some(Self {
            count,
            spacing,
            density,
        })
    }
}

impl Transition<'_> {
    /// Finds a place for the mover at or around the end position, and lets it down onto the ground (12.1).
    pub(super) fn find_placement_position(&mut self) -> bool {
        if !self.placement_is_a_number() {
            return false;
        }
        self.check_pos_to_curr_pos();
        self.path.insert_type = InsertType::InitialPlacement;
        let ts = self.placement_insert();
        if self.validate_placement(ts, true) != TransitionState::Ok {
            return false;
        }
        self.path.insert_type = InsertType::Placement;
        if !self.find_placement_pos() {
            return false;
        }
        if self.object.step_down {
            self.settle_onto_ground();
        }
        self.validate_placement(TransitionState::Ok, true) == TransitionState::Ok
    }

    fn placement_is_a_number(&self) -> bool {
        !self.profile().nan_goal_refused || vector::is_valid(self.path.end_pos.frame.origin)
    }

    /// Lowers the mover by at most its step-down height, or leaves it where it is (12.1, step 5).
    fn settle_onto_ground(&mut self) {
        self.path.walkable_allowance = LANDING_Z;
        self.save_check_pos();
        self.path.backup = self.path.insert_type;
        self.path.insert_type = InsertType::Transition;
        let (_, found) = self.step_down_in_parts(self.object.step_down_height, LANDING_Z, 2);
        if !found {
            self.restore_check_pos();
            self.info.void_contact_plane();
        }
        self.path.insert_type = self.path.backup;
        self.path.walkable = None;
    }

    /// Accepts the state under test if the insert said OK; if it was moved, tries once more when `again` allows (12.2).
    fn validate_placement(&mut self, ts: TransitionState, again: bool) -> TransitionState {
        if self.path.check_cell.is_none() {
            return TransitionState::Collided;
        }
        match ts {
            TransitionState::Ok => {
                self.accept_check_pos();
                ts
            }
            TransitionState::Adjusted | TransitionState::Slid if again => {
                let ts = self.placement_insert();
                self.validate_placement(ts, false)
            }
            _ => ts,
        }
    }

    /// Inserts the mover once, cell by cell (12.3).
    fn placement_insert(&mut self) -> TransitionState {
        let cell = self.path.check_cell;
        if cell.is_none() {
            return TransitionState::Collided;
        }
        match self.insert_into_cell(cell, MOVE_ATTEMPTS) {
            TransitionState::Ok => self.check_other_cells(cell),
            ts => ts,
        }
    }

    /// Accepts a probe, or forgets what it touched so that the next can be tried (12.4).
    ///
    /// `T-13`: profile `ace` forgets only the objects, and only of movers without a target.
    pub(super) fn validate_placement_transition(&mut self, ts: TransitionState) -> TransitionState {
        if self.path.check_cell.is_none() {
            return TransitionState::Collided;
        }
        match ts {
            TransitionState::Ok => self.accept_check_pos(),
            TransitionState::Invalid => {}
            _ if !self.path.placement_allows_sliding => {}
            _ => match self.profile().placement_reset {
                PlacementReset::AllInfo => self.info.reset(),
                PlacementReset::ObjectList if self.object.target_id == 0 => {
                    self.info.collide_object.clear();
                }
                PlacementReset::ObjectList => {}
            },
        }
        ts
    }

    /// Tries the current position, then places on rings around it, from the inside out (12.5).
    fn find_placement_pos(&mut self) -> bool {
        self.check_pos_to_curr_pos();
        if self.probe_placement() == TransitionState::Ok {
            return true;
        }
        if !self.path.placement_allows_sliding {
            return false;
        }
        let wide = self.profile().placement_rings_f64;
        let Some(rings) = Rings::around(self.path.local_sphere[0].radius, wide) else {
            return false;
        };
        let (mut distance, mut turn, mut probes) = (0.0_f32, 0.0_f32, 0_u32);
        for _ in 0..rings.count {
            distance += rings.spacing;
            turn += rings.density;
            let count = (turn.ceil() as u32).saturating_mul(2);
            probes = probes.saturating_add(count);
            if probes > MAX_PLACEMENT_PROBES || self.missing.is_some() {
                return false;
            }
            if self.search_ring(distance, count) {
                return true;
            }
        }
        false
    }

    /// Probes `count` places at `distance` m around the current position: north first, then clockwise seen from above.
    fn search_ring(&mut self, distance: f32, count: u32) -> bool {
        let profile = self.profile();
        let step = 360.0 / count as f32;
        let mut frame = Frame::IDENTITY;
        (0..count).any(|j| {
            self.check_pos_to_curr_pos();
            frame.set_heading(j as f32 * step, profile);
            let offset = self.adjust_offset(frame.forward(profile) * distance);
            self.path.global_offset = offset;
            if self.too_short_to_probe(offset) {
                return false;
            }
            self.add_offset_to_check_pos(offset);
            self.probe_placement() == TransitionState::Ok
        })
    }

    fn too_short_to_probe(&self, offset: Vec3) -> bool {
        // T-24
        if self.profile().placement_rings_f64 {
            offset.length_squared() < EPSILON * EPSILON
        } else {
            offset.length() < EPSILON
        }
    }

    fn probe_placement(&mut self) -> TransitionState {
        self.info.sliding_normal_valid = false;
        self.info.void_contact_plane();
        let ts = self.transitional_insert(MOVE_ATTEMPTS);
        self.validate_placement_transition(ts)
    }
}
