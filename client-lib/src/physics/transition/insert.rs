//! One insertion: the state under test against the geometry of all the cells it touches (`spec/05-transition.md`, 10.5 to 10.8).

use super::LANDING_Z;
use super::state::{InsertType, Transition, TransitionState};
use crate::math::CellId;
use crate::profile::MissingCells;
use crate::world::CellHandle;

/// How an attempt goes on.
enum Attempt {
    /// The insert answers this.
    Done(TransitionState),
    /// The next attempt follows, if there is one left; else the insert answers this.
    Again(TransitionState),
}

/// The cell of id 0 that profile `ace` starts its search for the current cell with (`T-22`): present, and nowhere.
pub(super) const DUMMY_CELL: CellHandle = CellHandle(u32::MAX);

impl Transition<'_> {
    /// Inserts the mover at the check position, in at most `attempts` attempts (10.5).
    ///
    /// Every attempt ends in one of: blocked; moved, so try again; or no contact with geometry, and then a landing is decided, a touch from
    /// behind is handled, or ground is looked for below a mover that has lost it.
    pub fn transitional_insert(&mut self, attempts: u32) -> TransitionState {
        if self.path.check_cell.is_none() {
            return TransitionState::Ok;
        }
        let mut ts = TransitionState::Invalid;
        for _ in 0..attempts {
            ts = self.insert_geometry(attempts);
            match ts {
                TransitionState::Ok => {}
                TransitionState::Collided => return ts,
                _ => continue,
            }
            let attempt = if self.path.collide {
                Attempt::Done(self.decide_landing(attempts))
            } else if self.path.neg_poly_hit && !self.path.step_down && !self.path.step_up {
                Attempt::Again(self.handle_touch_from_behind())
            } else {
                self.keep_ground()
            };
            match attempt {
                Attempt::Done(state) => return state,
                Attempt::Again(state) => ts = state,
            }
        }
        ts
    }

    /// Branch A: all cells, the current one first.
    fn insert_geometry(&mut self, attempts: u32) -> TransitionState {
        let current = self.path.check_cell;
        let mut ts = self.insert_into_cell(current, attempts);
        match ts {
            TransitionState::Ok => {
                ts = self.check_other_cells(current);
                if ts != TransitionState::Ok {
                    self.path.neg_poly_hit = false;
                }
            }
            TransitionState::Adjusted => self.path.neg_poly_hit = false,
            TransitionState::Slid => {
                self.info.void_contact_plane();
                self.path.neg_poly_hit = false;
            }
            TransitionState::Collided | TransitionState::Invalid => {}
        }
        ts
    }

    /// Branch B: an airborne hit waits for a decision. Lands if ground was found and the mover fits there, else goes back to the hit.
    fn decide_landing(&mut self, attempts: u32) -> TransitionState {
        self.path.collide = false;
        let landed = self.info.contact_plane.valid
            && self.check_walkable(LANDING_Z)
            && self.fits_here(attempts);
        self.path.walkable = None;
        if landed {
            return TransitionState::Ok;
        }
        self.restore_check_pos();
        self.info.void_contact_plane();
        if self.info.last_known_contact_plane.valid {
            self.info.last_known_contact_plane.valid = false;
            self.object.kill_velocity();
        } else {
            self.set_collision_normal(self.path.step_up_normal);
        }
        TransitionState::Collided
    }

    /// Whether the mover overlaps nothing solid at the check position. Overwrites the single backup of the mode.
    pub(super) fn fits_here(&mut self, attempts: u32) -> bool {
        self.path.backup = self.path.insert_type;
        self.path.insert_type = InsertType::Placement;
        let ts = self.transitional_insert(attempts);
        self.path.insert_type = self.path.backup;
        ts == TransitionState::Ok
    }

    /// Branch C: a polygon was touched although the move does not go against its normal.
    fn handle_touch_from_behind(&mut self) -> TransitionState {
        self.path.neg_poly_hit = false;
        let mut normal = self.path.neg_collision_normal;
        if self.path.neg_step_up {
            if self.step_up(normal) {
                TransitionState::Ok
            } else {
                self.step_up_slide()
            }
        } else {
            let ts = self.slide_first_sphere(&mut normal);
            self.path.neg_collision_normal = normal;
            ts
        }
    }

    /// Branch D: nothing in the way. A mover that has lost its ground looks for it below.
    fn keep_ground(&mut self) -> Attempt {
        let has_ground_or_needs_none = self.info.contact_plane.valid
            || !self.object.in_contact()
            || self.path.step_down
            || self.path.check_cell.is_none()
            || !self.object.step_down;
        if has_ground_or_needs_none {
            return Attempt::Done(TransitionState::Ok);
        }
        let (walkable_z, height) = self.object.walking_limits(self.object.step_down_height);
        self.path.walkable_allowance = walkable_z;
        self.save_check_pos();
        let (height, found) =
            self.step_down_in_parts(height, walkable_z, self.profile().half_step_downs);
        if found {
            self.path.walkable = None;
            return Attempt::Done(TransitionState::Ok);
        }
        let (ts, stop) = self.edge_slide(height, walkable_z);
        if stop {
            Attempt::Done(ts)
        } else {
            Attempt::Again(ts)
        }
    }

    /// Tests the mover against one cell until the answer is final, in at most `attempts` tests (10.6).
    pub(super) fn insert_into_cell(
        &mut self,
        cell: Option<CellHandle>,
        attempts: u32,
    ) -> TransitionState {
        let Some(cell) = cell else {
            return TransitionState::Collided;
        };
        let mut ts = TransitionState::Ok;
        for _ in 0..attempts {
            ts = self.test_cell(cell);
            match ts {
                TransitionState::Ok | TransitionState::Collided => return ts,
                TransitionState::Slid => self.info.void_contact_plane(),
                TransitionState::Adjusted | TransitionState::Invalid => {}
            }
        }
        ts
    }

    fn test_cell(&mut self, cell: CellHandle) -> TransitionState {
        if cell == DUMMY_CELL {
            return TransitionState::Invalid;
        }
        self.find_cell_collisions(cell)
    }

    /// Tests all cells that the mover touches but the `current` one, and finds the cell that it is in (10.7).
    pub(super) fn check_other_cells(&mut self, current: Option<CellHandle>) -> TransitionState {
        let profile = self.profile();
        // T-22
        let mut new_cell = (profile.missing_cells == MissingCells::LeftOut).then_some(DUMMY_CELL);
        self.build_cell_array(Some(&mut new_cell));
        // Tests may make the list anew (a step up inside them does): it is read as it is at each turn.
        let mut i = 0;
        while let Some(entry) = self.cells.cells.get(i) {
            i += 1;
            let Some(cell) = entry.cell.filter(|&c| Some(c) != current) else {
                continue;
            };
            match self.find_cell_collisions(cell) {
                TransitionState::Ok => {}
                TransitionState::Slid => {
                    self.info.void_contact_plane();
                    return TransitionState::Slid;
                }
                TransitionState::Invalid => {}
                ts => return ts,
            }
        }
        self.path.check_cell = new_cell;
        match new_cell {
            Some(cell) => {
                self.adjust_check_pos(self.id_of_cell(cell));
                TransitionState::Ok
            }
            None => self.leave_all_cells(),
        }
    }

    fn id_of_cell(&self, cell: CellHandle) -> CellId {
        if cell == DUMMY_CELL {
            CellId::NONE
        } else {
            self.world.cell_id(cell)
        }
    }

    /// No cell contains the first sphere's centre: the mover will be lost, or is off the map.
    fn leave_all_cells(&mut self) -> TransitionState {
        if self.path.step_down {
            return TransitionState::Collided;
        }
        let mut position = self.path.check_pos;
        if !position.cell.is_indoor() {
            position.adjust_to_outside(self.profile());
        }
        if position.cell.is_none() {
            return TransitionState::Collided;
        }
        self.set_check_pos(position, None);
        self.path.cell_array_valid = true;
        TransitionState::Ok
    }

    /// Lists the cells that the check position's spheres touch (10.8). `current` takes the one that contains the first centre; it stays as it is
    /// if there is no start cell.
    pub(super) fn build_cell_array(&mut self, current: Option<&mut Option<CellHandle>>) {
        self.path.cell_array_valid = true;
        self.path.hits_interior_cell = false;
        self.find_cell_list(current);
    }
}
