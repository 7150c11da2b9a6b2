//! The tick of one object: time, quanta, and the stages of a quantum (`spec/06-physics-object.md`, B2 to B5).
//!
//! `now` is the frame clock, `sim_time` the time inside the quantum being executed. An object is simulated up to its own `update_time`; a
//! gap of at most 1/30 s waits, one above 2 s is dropped, and a long one is cut into quanta of at most 0.2 s.

use crate::entity::Entity;
use crate::frame::probe::{Probe, StageData, StageView, TickStage};
use crate::frame::state::{Outcome, Step};
use crate::math::vector::{self, EPSILON};
use crate::math::{BLOCK_LENGTH, Frame, Position, Vec3, heading_of_position_offset};
use crate::physics::body::EntityId;
use crate::physics::state::{PhysicsState, TransientState};
use crate::physics::transition::{self, TransitionResult, TransitionState};
use crate::profile::{Profile, Remainder, Unmoved};
use crate::world::World;

/// A gap longer than this, s, is dropped.
const HUGE_QUANTUM: f64 = 2.0;
/// Objects farther than this from the local player, m, rest.
const CULL_DISTANCE: f32 = 96.0;

/// What a quantum commits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommitKind {
    /// The result of a transition.
    Transition,
    /// No valid position: the origin stays, the rotation is taken.
    Failed,
    /// No move: the origin stays exactly, the rotation is taken.
    Still,
    /// An object without spheres does not move by itself.
    NoSpheres,
}

/// Length of a quantum: in f64 as the clock has it, and as the physics use it (O-04).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantum {
    /// For position managers, s.
    pub wide: f64,
    /// For everything else, s.
    pub narrow: f32,
}

impl Quantum {
    /// A quantum of a length in s.
    pub fn new(seconds: f64, profile: &Profile) -> Self {
        let narrow = seconds as f32;
        Self {
            wide: if profile.quantum_narrowed_late {
                seconds
            } else {
                f64::from(narrow)
            },
            narrow,
        }
    }
}

impl World {
    /// Advances one entity to the present frame time (`update_object`, B3).
    pub fn update_entity<P: Probe>(&mut self, id: EntityId, probe: &mut P) {
        if !self.is_put_off(id) {
            self.advance(id, probe);
        }
    }

    /// Advances one entity to the present frame time, whatever the plan says.
    pub(crate) fn advance<P: Probe>(&mut self, id: EntityId, probe: &mut P) {
        if let Some(clock) = self.entities.resting_since(id)
            && self.goes_on_resting(id, clock)
        {
            self.note_rest(clock);
            let clock = self.pass_time(clock);
            self.entities.rest(id, clock);
            return;
        }
        let Some(mut entity) = self.entities.take_for_tick(id) else {
            return;
        };
        self.note_tick(&entity);
        let before = self.stance(&entity);
        entity.update_object(self, probe);
        if let Some(before) = before {
            self.consider_idle(&entity, before);
        }
        let (rests, clock) = (entity.rests(), entity.kin.update_time);
        self.entities.put(entity);
        if rests {
            self.entities.rest(id, clock);
        }
        self.end_what_waits();
    }

    /// Whether nothing wakes a resting object up. Without culling nothing does; with it, only an object out of the player's reach, or a
    /// static one, goes on resting, and its distance is kept up to date (B3 step 2).
    #[inline]
    fn goes_on_resting(&mut self, id: EntityId, clock: f64) -> bool {
        let Some(player) = self.culling_player() else {
            return true;
        };
        let dropped = self.profile.tiny_gap_dropped && self.clock.now - clock < f64::from(EPSILON);
        if dropped {
            // The update ends before it comes to culling.
            return true;
        }
        let Some(own) = self.entities.get(id) else {
            return false;
        };
        let vector = self.vector_from_player(player, id, &own.body.position);
        let distance = vector.length();
        let is_static = own.body.state.contains(PhysicsState::STATIC);
        let rests = is_static || self.is_culled(distance);
        if rests {
            self.entities.see_from_player(id, vector, distance);
        }
        rests
    }

    /// The player from whom objects are culled, if they are at all.
    #[inline]
    fn culling_player(&self) -> Option<EntityId> {
        self.local_player.filter(|_| self.profile.distance_culling)
    }

    fn is_culled(&self, distance: f32) -> bool {
        distance > CULL_DISTANCE && self.culling_enabled
    }

    /// Vector, m, from the player to an object at a place; zero for the player itself and without one.
    fn vector_from_player(&self, player: EntityId, id: EntityId, place: &Position) -> Vec3 {
        if player == id {
            return Vec3::ZERO;
        }
        self.entity(player)
            .map_or(Vec3::ZERO, |p| p.body.position.offset_to(place))
    }

    /// What the update of an object does to its clock, s, while no quantum does anything (B3 steps 1 and 3 to 7).
    fn pass_time(&mut self, clock: f64) -> f64 {
        let (now, profile) = (self.clock.now, &self.profile);
        if profile.tiny_gap_dropped && now - clock < f64::from(EPSILON) {
            return now;
        }
        self.clock.sim_time = clock;
        let mut gap = now - clock;
        if gap <= profile.min_quantum {
            return clock;
        }
        if gap > HUGE_QUANTUM {
            return now;
        }
        while gap > profile.max_quantum {
            self.clock.sim_time += profile.max_quantum;
            gap -= profile.max_quantum;
        }
        if gap > profile.min_quantum {
            self.clock.sim_time += gap;
        }
        match profile.remainder {
            Remainder::Kept => self.clock.sim_time,
            Remainder::Dropped => now,
        }
    }
}

impl Entity {
    /// Advances the object to the present frame time (`update_object`, B3).
    pub fn update_object<P: Probe>(&mut self, world: &mut World, probe: &mut P) {
        if self.body.parent.is_some()
            || self.body.cell.is_none()
            || self.body.state.contains(PhysicsState::FROZEN)
        {
            self.kin.transient.remove(TransientState::ACTIVE);
            return;
        }
        let now = world.clock.now;
        if world.profile.tiny_gap_dropped && now - self.kin.update_time < f64::from(EPSILON) {
            self.kin.update_time = now;
            return;
        }
        self.cull_by_distance(world);
        world.clock.sim_time = self.kin.update_time;
        let gap = now - self.kin.update_time;
        if gap <= world.profile.min_quantum {
            return;
        }
        if gap > HUGE_QUANTUM {
            self.kin.update_time = now;
            return;
        }
        self.run_quanta(gap, world, probe);
        if self.is_broken() {
            return;
        }
        self.kin.update_time = match world.profile.remainder {
            Remainder::Kept => world.clock.sim_time,
            Remainder::Dropped => now,
        };
    }

    /// Whether an update, until somebody changes the object, does nothing but advance its clock.
    fn rests(&self) -> bool {
        !self.kin.transient.contains(TransientState::ACTIVE)
            && self.body.parent.is_none()
            && self.body.cell.is_some()
            && !self.body.state.contains(PhysicsState::FROZEN)
            && !self.is_broken()
    }

    fn run_quanta<P: Probe>(&mut self, mut gap: f64, world: &mut World, probe: &mut P) {
        let (longest, shortest) = (world.profile.max_quantum, world.profile.min_quantum);
        while gap > longest {
            world.clock.sim_time += longest;
            self.run_quantum(longest, world, probe);
            if self.is_broken() {
                return;
            }
            gap -= longest;
        }
        if gap > shortest {
            world.clock.sim_time += gap;
            self.run_quantum(gap, world, probe);
        }
    }

    /// Objects far from the local player rest, near ones wake up (B3 step 2; O-52).
    fn cull_by_distance(&mut self, world: &World) {
        let Some(player) = world.culling_player() else {
            return;
        };
        self.player_vector = world.vector_from_player(player, self.id, &self.body.position);
        self.player_distance = self.player_vector.length();
        if world.is_culled(self.player_distance) {
            self.kin.transient.remove(TransientState::ACTIVE);
        } else {
            self.set_active(true, world);
        }
    }

    /// One quantum (`UpdateObjectInternal`, B4).
    fn run_quantum<P: Probe>(&mut self, seconds: f64, world: &mut World, probe: &mut P) {
        if !self.kin.transient.contains(TransientState::ACTIVE) || self.body.cell.is_none() {
            return;
        }
        let quantum = Quantum::new(seconds, &world.profile);
        if self.kin.transient.contains(TransientState::CHECK_ETHEREAL) {
            self.set_ethereal(false, world);
        }
        self.kin.jumped_this_frame = false;
        if self.is_broken() {
            self.break_off(quantum, &world.profile);
            return;
        }
        let stood = !P::OBSERVES && self.end_stand();
        if stood && self.stand(quantum, world) {
            self.note_stand(true);
            return;
        }
        let (before, calm) = (self.body.position.frame, self.kin.is_calm());
        let mut offset = Frame::IDENTITY;
        if !stood {
            self.animation_stage(&mut offset, quantum, world, probe);
        }
        let wanted = self.integrate_stage(&mut offset, quantum, world, probe);
        let Some(outcome) = self.move_to_wanted(wanted, quantum.narrow, world, probe) else {
            return;
        };
        self.motion_stage(quantum, world, probe);
        self.steps.push(Step {
            dt: quantum.narrow,
            outcome,
        });
        let stands =
            calm && outcome == Outcome::None && self.comes_to_stand(&before, &offset, world);
        self.note_stand(stands);
    }

    /// Whether the profile's interpolation has broken this object (O-38): its update ends in every quantum where the offset is adjusted.
    fn is_broken(&self) -> bool {
        self.position_manager
            .as_ref()
            .is_some_and(|m| m.is_broken())
    }

    /// What a broken object still does: its animation goes on, and the quantum is listed. The clock stays, so quanta grow to the longest.
    fn break_off(&mut self, quantum: Quantum, profile: &Profile) {
        if !self.body.state.contains(PhysicsState::HIDDEN) {
            let mut offset = Frame::IDENTITY;
            self.animate(&mut offset, quantum.narrow, profile);
        }
        if let Some(parts) = &mut self.body.part_array {
            // Nobody will execute them.
            parts.hooks.clear();
        }
        self.steps.push(Step {
            dt: quantum.narrow,
            outcome: Outcome::None,
        });
    }

    /// Root motion, managers, integration and hooks (`UpdatePositionInternal`, B5): the frame the object wants to have.
    pub(crate) fn update_position<P: Probe>(
        &mut self,
        quantum: Quantum,
        world: &mut World,
        probe: &mut P,
    ) -> Frame {
        let mut offset = Frame::IDENTITY;
        self.animation_stage(&mut offset, quantum, world, probe);
        self.integrate_stage(&mut offset, quantum, world, probe)
    }

    /// Root motion (B5 step 2), added to `offset`.
    fn animation_stage<P: Probe>(
        &mut self,
        offset: &mut Frame,
        quantum: Quantum,
        world: &mut World,
        probe: &mut P,
    ) {
        if !self.body.state.contains(PhysicsState::HIDDEN) {
            let stage = (TickStage::Animation, quantum.narrow);
            self.staged_offset(stage, offset, world, probe, |e, offset, world| {
                e.animate(offset, quantum.narrow, &world.profile);
            });
        }
    }

    /// Managers, integration and hooks (B5 steps 3 to 6): the frame the object wants to have.
    fn integrate_stage<P: Probe>(
        &mut self,
        offset: &mut Frame,
        quantum: Quantum,
        world: &mut World,
        probe: &mut P,
    ) -> Frame {
        let hidden = self.body.state.contains(PhysicsState::HIDDEN);
        if self.position_manager.is_some() {
            let stage = (TickStage::Adjust, quantum.narrow);
            self.staged_offset(stage, offset, world, probe, |e, offset, world| {
                e.adjust_offset(offset, quantum.wide, world);
            });
        }
        let mut frame = self.body.position.frame.combine(offset, &world.profile);
        if !hidden {
            let data = StageData::Integrate {
                offset,
                frame: &frame,
            };
            observe(
                self,
                world,
                probe,
                TickStage::Integrate,
                quantum.narrow,
                data,
                Side::Before,
            );
            self.kin.update_physics(
                &mut frame,
                quantum.narrow,
                self.body.state,
                self.movement.is_some(),
                &world.profile,
            );
            let data = StageData::Integrate {
                offset,
                frame: &frame,
            };
            observe(
                self,
                world,
                probe,
                TickStage::Integrate,
                quantum.narrow,
                data,
                Side::After,
            );
        }
        if self.has_hooks() {
            let stage = (TickStage::Hooks, quantum.narrow);
            self.staged(stage, StageData::None, world, probe, Self::process_hooks);
        }
        frame
    }

    /// Runs a stage of a quantum between the looks of a probe; the same passes through before and after.
    #[inline(always)]
    fn staged<P: Probe>(
        &mut self,
        (stage, quantum): (TickStage, f32),
        data: StageData<'_>,
        world: &mut World,
        probe: &mut P,
        work: impl FnOnce(&mut Self, &mut World),
    ) {
        observe(self, world, probe, stage, quantum, data, Side::Before);
        work(self, world);
        observe(self, world, probe, stage, quantum, data, Side::After);
    }

    /// As [`Entity::staged`], for stages that change the offset.
    #[inline(always)]
    fn staged_offset<P: Probe>(
        &mut self,
        (stage, quantum): (TickStage, f32),
        offset: &mut Frame,
        world: &mut World,
        probe: &mut P,
        work: impl FnOnce(&mut Self, &mut Frame, &mut World),
    ) {
        let data = StageData::Offset(offset);
        observe(self, world, probe, stage, quantum, data, Side::Before);
        work(self, offset, world);
        let data = StageData::Offset(offset);
        observe(self, world, probe, stage, quantum, data, Side::After);
    }

    /// Advances the animation; its root motion counts on walkable ground only (B5 step 2).
    pub(crate) fn animate(&mut self, offset: &mut Frame, quantum: f32, profile: &Profile) {
        self.advance_animation(Some(offset), quantum, profile);
        // A multiplication: root motion that is not a number stays one.
        offset.origin *= if self.kin.transient.contains(TransientState::ON_WALKABLE) {
            self.body.scale
        } else {
            0.0
        };
    }

    /// Plays on for `quantum` s.
    pub(crate) fn advance_animation(
        &mut self,
        offset: Option<&mut Frame>,
        quantum: f32,
        profile: &Profile,
    ) {
        if let Some(parts) = &mut self.body.part_array
            && let Err(error) = parts.update(f64::from(quantum), offset, profile)
        {
            tracing::warn!(guid = self.body.guid, %error, "animation stopped");
        }
    }

    /// Moves to the wanted frame as far as the world lets it (B4 steps 6 and 7). `None`: the rest of the quantum does not run.
    fn move_to_wanted<P: Probe>(
        &mut self,
        mut frame: Frame,
        quantum: f32,
        world: &mut World,
        probe: &mut P,
    ) -> Option<Outcome> {
        let has_spheres = self
            .body
            .part_array
            .as_ref()
            .is_some_and(|p| !p.spheres().is_empty());
        let old = self.body.position.frame;
        if !has_spheres {
            self.stay(frame, CommitKind::NoSpheres, quantum, world, probe);
            return Some(Outcome::None);
        }
        if frame.is_vector_equal(&old, &world.profile) {
            self.stay(frame, CommitKind::Still, quantum, world, probe);
            return Some(Outcome::None);
        }
        if world.profile.block_limit && leaves_block(old.origin, frame.origin) {
            return None;
        }
        self.turn_along_path(&mut frame, &old, &world.profile);
        let goal = Position {
            cell: self.body.position.cell,
            frame,
        };
        let transit = self.transition(&goal, quantum, world, probe);
        let Some(transit) = transit else {
            self.stay(frame, CommitKind::Failed, quantum, world, probe);
            return Some(Outcome::Failed);
        };
        let outcome = if transit.result.cell.is_none() && world.profile.no_cell_fails {
            self.stay(frame, CommitKind::Failed, quantum, world, probe);
            Outcome::Failed
        } else {
            self.commit_transit(&transit.result, &frame, quantum, world, probe);
            outcome_of(transit.result.outcome)
        };
        world.slots.recycle(transit);
        Some(outcome)
    }

    /// Heading along the path (missiles) or along the velocity (sleds) (B4 step 6b).
    fn turn_along_path(&self, frame: &mut Frame, old: &Frame, profile: &Profile) {
        let velocity = self.kin.velocity;
        if self.body.state.contains(PhysicsState::ALIGN_PATH) {
            let direction = vector::normalize(frame.origin - old.origin, profile);
            frame.set_vector_heading(direction, profile);
        } else if self.body.state.contains(PhysicsState::SLEDDING) {
            if profile.sledding_full_vector {
                if velocity != Vec3::ZERO {
                    frame.set_vector_heading(vector::normalize(velocity, profile), profile);
                }
            } else if !vector::is_zero(velocity) {
                frame.set_heading(heading_of_position_offset(velocity, profile), profile);
            }
        }
    }

    /// Commits the result of a transition (B4 step 6b).
    fn commit_transit<P: Probe>(
        &mut self,
        result: &TransitionResult,
        wanted: &Frame,
        quantum: f32,
        world: &mut World,
        probe: &mut P,
    ) {
        let data = StageData::Commit {
            kind: CommitKind::Transition,
            frame: wanted,
        };
        let stage = (TickStage::Commit, quantum);
        self.staged(stage, data, world, probe, |e, world| {
            e.take_transit(result, quantum, world);
        });
    }

    /// Moves to where a transition of `quantum` s ended (B4 step 6b; C2).
    pub fn take_transit(&mut self, result: &TransitionResult, quantum: f32, world: &mut World) {
        let moved = self.body.position.offset_to(&result.position);
        self.kin.cached_velocity =
            Vec3::new(moved.x / quantum, moved.y / quantum, moved.z / quantum);
        self.set_position_internal(result, world);
    }

    /// Keeps the origin and takes the rotation.
    fn stay<P: Probe>(
        &mut self,
        wanted: Frame,
        kind: CommitKind,
        quantum: f32,
        world: &mut World,
        probe: &mut P,
    ) {
        let data = StageData::Commit {
            kind,
            frame: &wanted,
        };
        let stage = (TickStage::Commit, quantum);
        self.staged(stage, data, world, probe, |e, world| {
            e.keep_place(wanted, kind, world);
        });
    }

    /// Keeps the origin and takes the rotation of the wanted frame: every kind of commit but that of a transition (B4 steps 6 and 7).
    pub fn keep_place(&mut self, wanted: Frame, kind: CommitKind, world: &mut World) {
        let mut frame = wanted;
        // Profile `ace` keeps the tiny displacement of an object that "has not moved" (O-05).
        let keeps_displacement =
            kind == CommitKind::Still && world.profile.unmoved == Unmoved::Inclusive;
        if !keeps_displacement {
            frame.origin = self.body.position.frame.origin;
        }
        let rests = kind == CommitKind::NoSpheres
            && self.movement.is_none()
            && self.kin.transient.contains(TransientState::ON_WALKABLE);
        if rests {
            self.kin.transient.remove(TransientState::ACTIVE);
        }
        if kind == CommitKind::Failed {
            self.set_initial_frame(frame, world);
        } else {
            self.set_frame(frame, world);
        }
        self.kin.cached_velocity = Vec3::ZERO;
    }

    /// Targets, move-to, completed motions, position managers (B4 steps 9 to 12).
    fn motion_stage<P: Probe>(&mut self, quantum: Quantum, world: &mut World, probe: &mut P) {
        let has_motion_table = self
            .body
            .part_array
            .as_ref()
            .is_some_and(|p| p.motion_table.is_some());
        let runs = self.movement.is_some()
            || has_motion_table
            || self.target_manager.is_some()
            || self.position_manager.is_some();
        if !runs {
            return;
        }
        let stage = (TickStage::Motion, quantum.narrow);
        self.staged(stage, StageData::None, world, probe, Self::run_managers);
    }

    /// The managers of one quantum, in the client's order.
    pub fn run_managers(&mut self, world: &mut World) {
        if self.target_manager.is_some() {
            self.handle_targetting(world);
        }
        if self.movement.is_some() {
            self.movement_use_time(world);
        }
        self.check_for_completed_motions(world);
        if self.position_manager.is_some() {
            self.position_manager_use_time(world);
        }
    }
}

fn leaves_block(from: Vec3, to: Vec3) -> bool {
    let moved = (to - from).abs();
    moved.x > BLOCK_LENGTH || moved.y > BLOCK_LENGTH
}

/// Which side of a stage is shown to a probe.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Before,
    After,
}

#[inline(always)]
pub(crate) fn observe<P: Probe>(
    entity: &Entity,
    world: &World,
    probe: &mut P,
    stage: TickStage,
    quantum: f32,
    data: StageData<'_>,
    side: Side,
) {
    let view = StageView {
        stage,
        quantum,
        entity,
        world,
        data,
    };
    match side {
        Side::Before => probe.before(view),
        Side::After => probe.after(view),
    }
}

fn outcome_of(outcome: transition::Outcome) -> Outcome {
    match outcome {
        transition::Outcome::Step(TransitionState::Ok) => Outcome::Ok,
        transition::Outcome::Step(TransitionState::Collided) => Outcome::Collided,
        transition::Outcome::Step(TransitionState::Adjusted) => Outcome::Adjusted,
        transition::Outcome::Step(TransitionState::Slid) => Outcome::Slid,
        transition::Outcome::Failed => Outcome::Failed,
        transition::Outcome::None | transition::Outcome::Step(TransitionState::Invalid) => {
            Outcome::None
        }
    }
}
