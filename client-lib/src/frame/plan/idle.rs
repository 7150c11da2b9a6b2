//! Entities that stand idle: their ticks are put off until somebody takes hold of them.
//!
//! An entity that stands, does nothing but play an animation without root motion, and watches nobody, changes nothing in a tick that
//! another can see: not its place, cell, shadows or state word. Its ticks need nothing of the world but the clock. So they need not run
//! in the frame they belong to: when somebody takes the entity to change it, it first plays the frames it missed, at their times, and is
//! then, bit for bit, where it would have been.
//!
//! Source: `spec/06-physics-object.md`, H5; `spec/07-animation.md`, 17; `spec/08-motion.md`, 19.

use crate::animation::{PartArray, is_executed};
use crate::dat::HookAction;
use crate::entity::Entity;
use crate::frame::NoProbe;
use crate::frame::state::Outcome;
use crate::math::{EPSILON, Vec3};
use crate::physics::body::EntityId;
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::Profile;
use crate::world::World;

/// An entity whose ticks are put off.
#[derive(Debug, Clone, Copy)]
struct Asleep {
    /// It has been advanced through this time.
    since: u32,
    /// It should have been advanced through this time.
    through: u32,
}

/// Which entities are idle.
#[derive(Debug, Default)]
pub(super) struct IdleTable {
    /// GUIDs that may be idle, ascending.
    allowed: Vec<u32>,
    /// By handle.
    asleep: Vec<Option<Asleep>>,
    /// The last whose tick was put off in this frame, unless another tick has set the simulation clock since.
    tail: Option<EntityId>,
}

impl IdleTable {
    pub(super) fn new(allowed: &[u32]) -> Self {
        Self {
            allowed: allowed.to_vec(),
            asleep: Vec::new(),
            tail: None,
        }
    }

    fn allows(&self, guid: u32) -> bool {
        self.allowed.binary_search(&guid).is_ok()
    }

    fn get_mut(&mut self, id: EntityId) -> Option<&mut Asleep> {
        self.asleep.get_mut(id.0 as usize)?.as_mut()
    }

    fn take(&mut self, id: EntityId) -> Option<Asleep> {
        self.asleep.get_mut(id.0 as usize)?.take()
    }

    /// An entity that has been advanced through time `since`, and should have been through time `through`, is put off from now on.
    pub(super) fn sleep(&mut self, id: EntityId, since: usize, through: usize) {
        let index = id.0 as usize;
        if self.asleep.len() <= index {
            self.asleep.resize(index + 1, None);
        }
        self.asleep[index] = Some(Asleep {
            since: since as u32,
            through: through as u32,
        });
    }
}

/// What of an entity must be the same before and after a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stance {
    frame: [u32; 7],
    cell: u32,
    transient: TransientState,
    state: PhysicsState,
    steps: usize,
}

impl Stance {
    fn of(entity: &Entity) -> Self {
        Self {
            frame: entity.body.position.frame.bits(),
            cell: entity.body.position.cell.0,
            transient: entity.kin.transient,
            state: entity.body.state,
            steps: entity.steps.len(),
        }
    }
}

impl World {
    /// Whether the tick of an entity in this frame is put off.
    #[inline]
    pub(crate) fn is_put_off(&mut self, id: EntityId) -> bool {
        let Some(plan) = &mut self.plan else {
            return false;
        };
        let now = plan.now();
        let Some(asleep) = plan.idle.get_mut(id) else {
            return false;
        };
        let gap = plan.times[now] - plan.times[now.saturating_sub(1)];
        if gap < f64::from(EPSILON) {
            // Whether the tick touches the simulation clock depends on the object's own.
            self.catch_up(id);
            return false;
        }
        asleep.through = now as u32;
        plan.idle.tail = Some(id);
        plan.extended.frames_put_off += 1;
        true
    }

    /// An entity's tick sets the simulation clock: whatever those before it would have left there is gone.
    pub(crate) fn note_tick(&mut self, entity: &Entity) {
        let (now, profile) = (self.clock.now, &self.profile);
        let tiny = profile.tiny_gap_dropped && now - entity.kin.update_time < f64::from(EPSILON);
        let sets = entity.keeps_clock() && !tiny;
        if let Some(plan) = self.plan.as_mut().filter(|_| sets) {
            plan.idle.tail = None;
        }
    }

    /// As [`World::note_tick`], for an object at rest.
    pub(crate) fn note_rest(&mut self, clock: f64) {
        let tiny = self.profile.tiny_gap_dropped && self.clock.now - clock < f64::from(EPSILON);
        if let Some(plan) = self.plan.as_mut().filter(|_| !tiny) {
            plan.idle.tail = None;
        }
    }

    /// If the last tick of the frame was put off, it is played: the simulation clock stays where it leaves it.
    pub(super) fn end_tail(&mut self, play: bool) {
        let Some(plan) = &mut self.plan else { return };
        let tail = plan.idle.tail.take();
        if let Some(sim_time) = tail.filter(|_| play).and_then(|id| self.play_missed(id)) {
            self.clock.sim_time = sim_time;
        }
    }

    /// How an entity stands before its tick, if its ticks may be put off.
    pub(crate) fn stance(&self, entity: &Entity) -> Option<Stance> {
        let allowed = self.plan.as_ref()?.idle.allows(entity.guid());
        (allowed && self.local_player.is_none()).then(|| Stance::of(entity))
    }

    /// After its tick: the entity's next ticks are put off if it stands idle.
    pub(crate) fn consider_idle(&mut self, entity: &Entity, before: Stance) {
        let idle = entity.stands_idle(before, &self.profile);
        if let Some(plan) = self.plan.as_mut().filter(|_| idle) {
            let now = plan.now();
            plan.idle.sleep(entity.id, now, now);
        }
    }

    /// Whether an entity's ticks are being put off.
    pub fn is_idle(&self, id: EntityId) -> bool {
        let plan = self.plan.as_ref();
        plan.is_some_and(|p| matches!(p.idle.asleep.get(id.0 as usize), Some(Some(_))))
    }

    /// Plays the frames that an entity has missed. Nothing happens if it has not missed any.
    pub fn catch_up(&mut self, id: EntityId) {
        self.play_missed(id);
    }

    /// As [`World::catch_up`]; answers where the last of the frames left the simulation clock, s. The clocks of the world stay.
    fn play_missed(&mut self, id: EntityId) -> Option<f64> {
        let plan = self.plan.as_mut()?;
        let Asleep { since, through } = plan.idle.take(id)?;
        plan.extended.awakenings += 1;
        let missed = u64::from(through.saturating_sub(since));
        plan.extended.frames_put_off = plan.extended.frames_put_off.saturating_sub(missed);
        let (clock, tail) = (self.clock, plan.idle.tail);
        for time in since + 1..=through {
            let now = self.plan.as_ref().and_then(|p| p.times.get(time as usize));
            self.clock.now = now.copied().unwrap_or(clock.now);
            if let Some(entity) = self.entities.get_mut(id) {
                entity.begin_frame();
            }
            self.advance(id, &mut NoProbe);
        }
        let left = self.clock.sim_time;
        self.clock = clock;
        let plan = self.plan.as_mut()?;
        plan.idle.tail = tail;
        // It stands as idly as before, but somebody has it in hand.
        plan.idle.take(id);
        let host_skipped_it = plan.now() as u32 != through;
        if host_skipped_it && let Some(entity) = self.entities.get_mut(id) {
            entity.begin_frame();
        }
        (missed > 0).then_some(left)
    }

    /// Brings every entity up to date: for those who want to look at all of the world between two frames.
    pub fn catch_up_all(&mut self) {
        let count = self.plan.as_ref().map_or(0, |plan| plan.idle.asleep.len());
        for index in 0..count {
            self.catch_up(EntityId(index as u32));
        }
    }
}

impl Entity {
    /// Whether the object's ticks set the simulation clock (`spec/06-physics-object.md`, B3, step 1).
    pub(super) fn keeps_clock(&self) -> bool {
        self.body.parent.is_none()
            && self.body.cell.is_some()
            && !self.body.state.contains(PhysicsState::FROZEN)
    }

    /// Whether a tick changed nothing that others can see, and no later tick will, until somebody takes hold of the object.
    fn stands_idle(&self, before: Stance, profile: &Profile) -> bool {
        let after = Stance::of(self);
        let ticked = after.steps > before.steps;
        let still = self
            .steps
            .iter()
            .skip(before.steps)
            .all(|step| step.outcome == Outcome::None);
        let same = Stance {
            steps: before.steps,
            ..after
        } == before;
        let forces = [self.kin.velocity, self.kin.acceleration, self.kin.omega];
        let restless = TransientState::CHECK_ETHEREAL;
        (ticked || !self.kin.transient.contains(TransientState::ACTIVE))
            && still
            && same
            && forces.iter().all(|&force| force == Vec3::ZERO)
            && !self.kin.transient.intersects(restless)
            && self.body.cell.is_some()
            && self.is_alone()
            && self.movement_rests()
            && self
                .body
                .part_array
                .as_ref()
                .is_none_or(|parts| self.pose_is_private(parts, profile))
    }

    /// Nobody is carried, followed or watched, and no value changes over time.
    fn is_alone(&self) -> bool {
        self.body.parent.is_none()
            && self.children.is_empty()
            && self.collision_table.is_empty()
            && self.hooks.is_empty()
            && self.position_manager.is_none()
            && self.target_manager.is_none()
            && !self
                .body
                .state
                .intersects(PhysicsState::FROZEN | PhysicsState::PARTICLE_EMITTER)
    }

    /// No move-to, and no motion that waits for its end.
    fn movement_rests(&self) -> bool {
        let pending = self
            .body
            .part_array
            .as_ref()
            .and_then(|parts| parts.motion_table.as_ref());
        !self.is_moving_to()
            && !self.motions_pending()
            && pending.is_none_or(|table| table.pending().len() == 0)
    }

    /// What is played moves nothing that is collided with, and changes no state.
    fn pose_is_private(&self, parts: &PartArray, profile: &Profile) -> bool {
        let sequence = &parts.sequence;
        let collides = self.body.state.contains(PhysicsState::HAS_PHYSICS_BSP);
        parts.hooks.is_empty()
            && sequence.velocity == Vec3::ZERO
            && sequence.omega == Vec3::ZERO
            && !(collides && sequence.has_animations())
            && sequence.nodes().all(|node| {
                !node.has_root_motion() && !node.hooks().any(|hook| acts(&hook.action, profile))
            })
    }
}

/// Whether a hook changes what others can see.
fn acts(action: &HookAction, profile: &Profile) -> bool {
    is_executed(action, profile)
        && matches!(
            action,
            HookAction::Ethereal { .. }
                | HookAction::Scale { .. }
                | HookAction::NoDraw { .. }
                | HookAction::SetOmega { .. }
                | HookAction::SetLight { .. }
        )
}
