//! Starting a transition and reading its result (`spec/05-transition.md`, 6.9 and 10.15).
//!
//! [`World::run_transition`] runs one from plain data to plain data: the same input and world always give the same result, whatever happened to
//! be loaded. A run that meets something not yet loaded is thrown away, the missing piece loaded, and the run repeated; only the last one counts.

use super::slots::Transit;
use super::state::{
    CellArray, CollisionInfo, ContactPlane, ObjectInfo, ObjectInfoState, Progress, Transition,
    TransitionState,
};
use crate::math::{CellId, Position, Sphere, Vec3};
use crate::physics::body::{Body, ObjectRef};
use crate::profile::{DummySphere, Profile};
use crate::world::{CellHandle, World};

/// What kind of transition asks for the sphere of an object that has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SphereUse {
    /// A movement.
    Move,
    /// A placement.
    Place,
    /// The test against one object ([`World::run_collision_check`]).
    Check,
}

/// At most two spheres of a mover, in its own frame, scaled, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoverSpheres {
    spheres: [Sphere; 2],
    count: usize,
}

impl MoverSpheres {
    /// The first two of a setup's `spheres` times the object's `scale`; without any, the dummy sphere (0, 0, 0.1) of radius 0.1 m.
    ///
    /// `T-29`, `T-30`: profile `gdle` moves with a zero sphere; profile `ace` scales the dummy in checks.
    pub fn new(spheres: &[Sphere], scale: f32, purpose: SphereUse, profile: &Profile) -> Self {
        if spheres.is_empty() {
            let zero = Sphere::default();
            let dummy = Sphere::new(Vec3::new(0.0, 0.0, 0.1), 0.1);
            let one = match (profile.dummy_sphere, purpose) {
                (DummySphere::ZeroInMoves, SphereUse::Move) => zero,
                (DummySphere::ScaledInCheck, SphereUse::Check) => dummy.scaled(scale),
                _ => dummy,
            };
            return Self::of_scaled(&[one]);
        }
        let mut scaled = Self::of_scaled(spheres);
        for sphere in &mut scaled.spheres[..scaled.count] {
            *sphere = sphere.scaled(scale);
        }
        scaled
    }

    /// The first two of spheres that are scaled already.
    pub fn of_scaled(spheres: &[Sphere]) -> Self {
        let mut result = Self {
            spheres: [Sphere::default(); 2],
            count: spheres.len().min(2),
        };
        for (to, from) in result.spheres.iter_mut().zip(spheres) {
            *to = *from;
        }
        result
    }

    /// The spheres.
    pub fn as_slice(&self) -> &[Sphere] {
        &self.spheres[..self.count]
    }
}

/// What the mover knows about the ground at the start (`get_object_info`, 6.9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactSeed {
    /// It touches none.
    None,
    /// It touches this plane.
    Contact(ContactPlane),
    /// It is leaving this plane.
    Leaving(ContactPlane),
    /// Both planes as they are, with everything in them that is not valid: a recorded transition.
    Recorded {
        /// The contact plane.
        contact: ContactPlane,
        /// The last known one.
        last_known: ContactPlane,
    },
}

/// Where the mover wants to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Path {
    /// Moves from one position to another.
    Move {
        /// Start.
        begin: Position,
        /// Goal; its origin may lie outside the landblock of its cell.
        end: Position,
    },
    /// Is placed.
    Place {
        /// Goal.
        at: Position,
        /// May be placed beside it (flag SLIDE).
        slide: bool,
        /// Restricts the cells touched to what the start cell sees (flag 0x20).
        do_not_load_cells: bool,
    },
}

/// Everything that a transition starts from.
#[derive(Debug, Clone, Copy)]
pub struct TransitionInput {
    /// The mover, with its bits (4.3), heights and state.
    pub mover: ObjectInfo,
    /// Its spheres.
    pub spheres: MoverSpheres,
    /// The cell it starts in; without one nothing is tried.
    pub begin_cell: Option<CellHandle>,
    /// The way.
    pub path: Path,
    /// What it knows about the ground.
    pub contact: ContactSeed,
    /// Wall that it slides along, world axes; normalised here unless the contact is a recorded one.
    pub sliding_normal: Option<Vec3>,
    /// Steps without progress so far, 0..=3.
    pub frames_stationary_fall: u32,
}

/// How a transition went, as traces say it (10.14, "Trace outcome").
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outcome {
    /// No step was executed, and the answer was true.
    #[default]
    None,
    /// No valid position.
    Failed,
    /// What the insert of the last step answered before validation.
    Step(TransitionState),
}

impl Outcome {
    /// The word of traces.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Failed => "failed",
            Self::Step(TransitionState::Invalid) => "invalid",
            Self::Step(TransitionState::Ok) => "ok",
            Self::Step(TransitionState::Collided) => "collided",
            Self::Step(TransitionState::Adjusted) => "adjusted",
            Self::Step(TransitionState::Slid) => "slid",
        }
    }
}

/// What a transition gave. Long-lived and reused: its lists keep their memory.
#[derive(Debug, Clone, Default)]
pub struct TransitionResult {
    /// A valid position was found. If not, the mover stays.
    pub valid: bool,
    /// How it went.
    pub outcome: Outcome,
    /// Final position.
    pub position: Position,
    /// Final cell; `None` when the mover has left all cells.
    pub cell: Option<CellHandle>,
    /// The mover's bits at the end.
    pub object_info: ObjectInfoState,
    /// The mover's velocity is to be set to zero (7.2), even if no valid position was found.
    pub velocity_killed: bool,
    /// What was touched.
    pub info: CollisionInfo,
    /// Cells of the last cell list, in order: where the object's shadow goes.
    pub cells: CellArray,
    /// Counters.
    pub progress: Progress,
}

impl TransitionResult {
    /// Empties everything, the memory of the lists apart.
    pub(super) fn reset(&mut self) {
        let mut objects = std::mem::take(&mut self.info.collide_object);
        let mut cells = std::mem::take(&mut self.cells);
        objects.clear();
        cells.cells.clear();
        *self = Self::default();
        self.info.collide_object = objects;
        self.cells.cells = cells.cells;
    }

    fn take_from(&mut self, t: Transition<'_>, valid: bool) {
        self.valid = valid;
        self.outcome = match (valid, t.progress.last_insert) {
            (false, _) => Outcome::Failed,
            (true, None) => Outcome::None,
            (true, Some(state)) => Outcome::Step(state),
        };
        self.position = t.path.curr_pos;
        self.cell = t.path.curr_cell.filter(|&c| c != super::insert::DUMMY_CELL);
        self.object_info = t.object.state;
        self.velocity_killed = t.object.velocity_killed;
        self.info = t.info;
        self.cells = t.cells;
        self.progress = t.progress;
    }
}

impl TransitionInput {
    /// Prepares a fresh transition to run.
    pub(super) fn prepare(&self, t: &mut Transition<'_>) {
        t.init_object(&self.mover);
        t.init_sphere(self.spheres.as_slice(), 1.0);
        self.seed_contact(t);
        match self.path {
            Path::Move { begin, end } => t.init_path(self.begin_cell, Some(begin), end),
            Path::Place {
                at,
                slide,
                do_not_load_cells,
            } => {
                t.init_path(self.begin_cell, None, at);
                t.path.placement_allows_sliding = slide;
                t.cells.do_not_load_cells = do_not_load_cells;
            }
        }
        t.info.frames_stationary_fall = self.frames_stationary_fall;
    }

    fn seed_contact(&self, t: &mut Transition<'_>) {
        let profile = t.profile();
        let info = &mut t.info;
        match self.contact {
            ContactSeed::None => {}
            ContactSeed::Contact(p) => info.init_contact_plane(p.cell_id, p.plane, p.is_water),
            ContactSeed::Leaving(p) => {
                info.init_last_known_contact_plane(p.cell_id, p.plane, p.is_water, profile);
            }
            ContactSeed::Recorded {
                contact,
                last_known,
            } => {
                info.contact_plane = contact;
                info.last_known_contact_plane = last_known;
                info.sliding_normal_valid = self.sliding_normal.is_some();
                info.sliding_normal = self.sliding_normal.unwrap_or(info.sliding_normal);
                return;
            }
        }
        if let Some(normal) = self.sliding_normal {
            info.init_sliding_normal(normal);
        }
    }
}

impl World {
    /// Runs a transition in `transit` and leaves what it gave in `transit.result`. True if it found a valid position.
    ///
    /// Loads what the run turns out to need. The slot's memory changes only by the run that counts.
    pub fn run_transition(&mut self, transit: &mut Transit, input: &TransitionInput) -> bool {
        transit.result.reset();
        self.run(transit, input, None, None)
    }

    /// As [`run_transition`](Self::run_transition), for another try in the same transition: the path begins anew, what was touched before stays
    /// (`SetScatterPositionInternal`, 06 C3).
    pub fn run_transition_again(&mut self, transit: &mut Transit, input: &TransitionInput) -> bool {
        let touched = transit.result.info.clone();
        self.run(transit, input, None, Some(&touched))
    }

    /// Would the mover of `input`, which stands at both ends of its path, touch `target`, whose body is `body`? (`check_collision`, 10.15.)
    /// The body is given because its object may be out of the world. Static movers touch nothing; the caller sorts them out.
    pub fn run_collision_check(
        &mut self,
        transit: &mut Transit,
        input: &TransitionInput,
        target: ObjectRef,
        body: &Body,
    ) -> bool {
        transit.result.reset();
        self.run(transit, input, Some((target, body)), None)
    }

    fn run(
        &mut self,
        transit: &mut Transit,
        input: &TransitionInput,
        target: Option<(ObjectRef, &Body)>,
        touched: Option<&CollisionInfo>,
    ) -> bool {
        loop {
            let missing = self.run_once(transit, input, target, touched.is_some());
            let loaded = missing.is_some_and(|id| self.load_for_transition(id));
            if !loaded {
                self.slots.keep_left_fields(transit);
                return transit.result.valid;
            }
            transit.result.reset();
            if let Some(info) = touched {
                transit.result.info.clone_from(info);
            }
        }
    }

    /// One run on the world as it is. Answers what was missing.
    fn run_once(
        &self,
        transit: &mut Transit,
        input: &TransitionInput,
        target: Option<(ObjectRef, &Body)>,
        again: bool,
    ) -> Option<CellId> {
        let mut t = Transition::new(self);
        t.info = std::mem::take(&mut transit.result.info);
        t.cells = std::mem::take(&mut transit.result.cells);
        if !again {
            t.take_left_fields(&self.slots.left_fields(transit));
        }
        input.prepare(&mut t);
        let valid = match target {
            Some((object, body)) => t.check_collisions(object, body),
            None => t.find_valid_position(),
        };
        let missing = t.missing;
        transit.result.take_from(t, valid);
        missing
    }
}
