//! A plan while it is carried out: what was put off, and how it is made up for.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;
use std::sync::Arc;

use super::index::{WorldIndex, cell_of, member_of};
use super::{Part, Plan};
use crate::animation::is_executed;
use crate::dat::HookAction;
use crate::entity::Entity;
use crate::math::{CellId, Frame, Vec3};
use crate::physics::body::{EntityId, StaticId};
use crate::physics::state::PhysicsState;
use crate::profile::Profile;
use crate::world::window::LandscapeWindow;
use crate::world::{Clock, Demand, StaticObject, World};

/// Most indoor cells of a block: ids 0x0100 to 0xFFFD.
const MAX_ROOMS: u32 = 0xFFFD - 0x0100 + 1;

/// An object whose creation is put off until its surroundings are loaded.
pub trait Latent: Debug + Send + Sync {
    /// Creates the object, as it would have been created when it was put off: the clock stands where it stood then. `None` if there is none.
    fn create(&self, world: &mut World) -> Option<EntityId>;
}

/// Where a latent object is going to be.
#[derive(Debug, Clone)]
pub struct LatentPlace {
    /// Its GUID.
    pub guid: u32,
    /// Blocks that it, or its search for a place, can touch: upper halves of their ids.
    pub blocks: BTreeSet<u16>,
}

#[derive(Debug)]
struct LatentObject {
    place: LatentPlace,
    /// When it should have been created.
    time: usize,
    /// The first handle of those that should have been created after it.
    after: EntityId,
    maker: Arc<dyn Latent>,
}

/// How often the plan of a run was extended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Extended {
    /// Entities that were created late.
    pub entities: u64,
    /// Times that idle entities were brought up to date.
    pub awakenings: u64,
    /// Frames of entities that were not played, so far.
    pub frames_put_off: u64,
}

/// The state of a plan in a running world; see [`World::set_plan`].
#[derive(Debug)]
pub struct ActivePlan {
    plan: Arc<Plan>,
    index: Arc<WorldIndex>,
    /// GUID of the entity that the window of landblocks follows.
    load_point: Option<u32>,
    window: LandscapeWindow,
    /// When the window was centred where: number of a time, and the cell.
    centres: Vec<(usize, CellId)>,
    /// The frame clock of frame -1, 0, 1, …, s.
    pub(super) times: Vec<f64>,
    /// Static objects have been animated through this time.
    animated_through: usize,
    /// The entities are being advanced.
    pub(super) in_tick: bool,
    /// In a run without a plan some animated static object would be there by now.
    animates: bool,
    latent: Vec<Option<LatentObject>>,
    latent_in: BTreeMap<u16, Vec<usize>>,
    born: Vec<(u32, EntityId)>,
    /// Those that were created late.
    late: BTreeSet<EntityId>,
    /// GUID of the entity after all that are created late, whose tick leaves the simulation clock as if they had been there.
    anchor: Option<u32>,
    pub(super) idle: super::idle::IdleTable,
    /// How often the plan was extended.
    pub extended: Extended,
}

impl ActivePlan {
    /// A plan for a world of that index. The window of landblocks follows the entity `load_point`, if there is one.
    pub fn new(plan: Arc<Plan>, index: Arc<WorldIndex>, load_point: Option<u32>) -> Self {
        let idle = super::idle::IdleTable::new(plan.ids(Part::IdleTicks));
        Self {
            plan,
            index,
            load_point,
            window: LandscapeWindow::default(),
            centres: Vec::new(),
            times: Vec::new(),
            animated_through: 0,
            in_tick: false,
            animates: false,
            latent: Vec::new(),
            latent_in: BTreeMap::new(),
            born: Vec::new(),
            late: BTreeSet::new(),
            anchor: None,
            idle,
            extended: Extended::default(),
        }
    }

    /// The same with the entity behind all those whose creation may be put off: the simulation clock stands where its tick leaves it. If it
    /// ever has no tick, nothing is put off any more.
    #[must_use]
    pub fn with_anchor(self, anchor: Option<u32>) -> Self {
        Self { anchor, ..self }
    }

    /// What is left out.
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// The number of the present time.
    pub(super) fn now(&self) -> usize {
        self.times.len().saturating_sub(1)
    }

    /// Objects that were created late since this was last asked: GUID and handle.
    pub fn take_born(&mut self) -> Vec<(u32, EntityId)> {
        std::mem::take(&mut self.born)
    }

    /// Whether an entity's parts are not placed.
    pub fn omits_pose(&self, guid: u32) -> bool {
        self.plan.ids(Part::Poses).binary_search(&guid).is_ok()
    }

    /// Whether an entity's creation may be put off.
    pub fn omits_entity(&self, guid: u32) -> bool {
        self.plan.ids(Part::Entities).binary_search(&guid).is_ok()
    }

    /// When a run without a plan has loaded the group of a block or room ahead of any need: number of the time.
    fn loaded_ahead(&self, member: u32) -> Option<usize> {
        let alone = [member];
        let group = self.index.group(member).unwrap_or(&alone);
        let entered = |&member: &u32| {
            let block = CellId(member);
            let within = |&&(_, centre): &&(usize, CellId)| in_window(centre, block);
            self.centres.iter().find(within).map(|&(time, _)| time)
        };
        group.iter().filter_map(entered).min()
    }

    /// Takes the load point, and answers the blocks that the full client loads now.
    fn move_window(&mut self, cell: CellId) -> Vec<CellId> {
        let before = self.centres.last().map(|&(_, centre)| centre.block());
        if before == Some(cell.block()) {
            return Vec::new();
        }
        self.centres.push((self.now(), cell));
        let seen = |&member: &u32| self.loaded_ahead(member).is_some();
        self.animates = self.animates || self.index.animated().iter().any(seen);
        if self.plan.leaves_out(Part::Streaming) {
            return Vec::new();
        }
        let mut blocks = self.window.update_load_point(cell).enter;
        let omitted = self.plan.ids(Part::Landblocks);
        blocks.retain(|block| omitted.binary_search(&block.0).is_err());
        blocks
    }
}

/// Whether a window around `centre` holds the block of `cell`.
fn in_window(centre: CellId, cell: CellId) -> bool {
    let radius = (LandscapeWindow::default().width() - 1) / 2;
    (centre.block_x() - cell.block_x()).abs() <= radius
        && (centre.block_y() - cell.block_y()).abs() <= radius
}

impl World {
    /// Carries out a plan from now on. `load_point` is where the entity that the window follows is going to enter the world; a plan that
    /// keeps the window loads it now. Call it on a world in which nothing is loaded yet.
    pub fn set_plan(&mut self, plan: ActivePlan, load_point: Option<CellId>) {
        let mut plan = Box::new(plan);
        plan.times.push(self.clock.now);
        self.plan = Some(plan);
        if let Some(cell) = load_point {
            self.follow(cell);
        }
    }

    /// The entities are about to be advanced, or have been.
    pub(crate) fn set_in_tick(&mut self, in_tick: bool) {
        if let Some(plan) = &mut self.plan {
            plan.in_tick = in_tick;
            self.end_tail(!in_tick);
        }
    }

    /// Begins a frame of the clock under a plan: the window follows its entity.
    pub(crate) fn begin_planned_frame(&mut self) {
        let now = self.clock.now;
        let Some(plan) = &mut self.plan else { return };
        plan.times.push(now);
        let guid = plan.load_point;
        self.check_anchor();
        let place = guid
            .and_then(|guid| self.entity_of_guid(guid))
            .and_then(|id| self.entity(id))
            .filter(|entity| entity.body.cell.is_some())
            .map(|entity| entity.body.position.cell);
        if let Some(cell) = place {
            self.follow(cell);
        }
    }

    /// The window is centred on a cell; what a client without a plan brings in then is loaded.
    fn follow(&mut self, cell: CellId) {
        let Some(plan) = &mut self.plan else { return };
        let blocks = plan.move_window(cell);
        let plan = Arc::clone(&plan.plan);
        for block in blocks {
            self.load_if_missing(cell_of(block.0));
            if plan.ids(Part::Rooms).binary_search(&block.0).is_ok() {
                continue;
            }
            let info = self.land.block(block).and_then(|b| b.info.as_ref());
            let rooms = info.map_or(0, |info| info.room_count.min(MAX_ROOMS));
            for room in 0..rooms {
                self.load_if_missing(block.with_low(0x0100 + room));
            }
        }
    }

    fn load_if_missing(&mut self, cell: CellId) {
        if self.land.is_missing(cell) {
            self.load(Demand {
                cell,
                without_statics: false,
            });
        }
    }

    /// Loads a block or room with its group and, if they were put off, the objects that are there.
    pub(crate) fn load_planned(&mut self, demand: Demand) {
        let Some(plan) = &self.plan else { return };
        let index = Arc::clone(&plan.index);
        let first_new = self.land.animated_statics().len();
        let member = member_of(demand.cell);
        let alone = [member];
        let group = index.group(member).unwrap_or(&alone);
        for &member in group {
            let cell = if group.len() == 1 {
                demand.cell
            } else {
                cell_of(member)
            };
            if self.land.is_missing(cell) {
                self.load_alone(Demand {
                    cell,
                    without_statics: false,
                });
            }
        }
        self.make_up_animations(first_new);
        self.create_latent(group.iter().map(|&member| CellId(member).block()));
    }
}

/// Static objects.
impl World {
    /// Whether an animated static object is left alone because it is only drawn: nobody can tell how far its animation is.
    pub(crate) fn leaves_still(&mut self, object: &StaticObject) -> bool {
        let profile = &self.profile;
        let Some(plan) = &mut self.plan else {
            return false;
        };
        let still = plan.plan.leaves_out(Part::StaticAnimations) && is_only_drawn(object, profile);
        plan.animates = true;
        still
    }

    /// Static objects from `first` on, which were loaded just now, play what a full client, which has loaded them ahead, has played by now.
    fn make_up_animations(&mut self, first: usize) {
        let Some(plan) = &self.plan else { return };
        let late: Vec<(StaticId, usize)> = self.land.animated_statics()[first..]
            .iter()
            .filter_map(|&id| {
                let home = self.land.static_body(id)?.position.cell;
                let ahead = plan.loaded_ahead(member_of(home))?;
                (ahead < plan.now()).then_some((id, ahead))
            })
            .collect();
        for (id, ahead) in late {
            let (times, through) = (&plan.times, plan.animated_through);
            let Some(object) = self.land.static_object_mut(id) else {
                continue;
            };
            object.update_time = times[ahead];
            // At the time of frame -1 nothing is animated.
            for &time in times.iter().take(through + 1).skip(ahead.max(1)) {
                object.animate(time, &self.profile);
            }
        }
    }

    /// The static objects of this frame have been animated.
    pub(crate) fn end_planned_animations(&mut self) {
        let Some(plan) = &mut self.plan else { return };
        plan.animated_through = plan.now();
        if plan.animates {
            // As if the objects that are left alone had been advanced.
            self.clock.sim_time = self.clock.now;
        }
    }
}

/// Whether the animation of a static object can be seen by no collision test: no part has a physics tree, no hook changes state or
/// rotation, and the rotation by nothing leaves its frame as it is.
fn is_only_drawn(object: &StaticObject, profile: &Profile) -> bool {
    let body = &object.body;
    let Some(parts) = &body.part_array else {
        return true;
    };
    let changes = |action: &HookAction| {
        matches!(
            action,
            HookAction::SetOmega { .. } | HookAction::Ethereal { .. }
        ) && is_executed(action, profile)
    };
    let mut turned: Frame = body.position.frame;
    turned.grotate(Vec3::ZERO, profile);
    let mut rotated: Frame = body.position.frame;
    rotated.rotate(Vec3::ZERO, profile);
    let bits = body.position.frame.bits();
    !body.state.contains(PhysicsState::HAS_PHYSICS_BSP)
        && !parts
            .sequence
            .nodes()
            .any(|node| node.hooks().any(|hook| changes(&hook.action)))
        && turned.bits() == bits
        && rotated.bits() == bits
}

/// Objects that are created late.
impl World {
    /// Puts the creation of an object off. `false` if it must be created now: there is no plan that leaves it out, or something is there
    /// already.
    pub fn put_off(&mut self, place: LatentPlace, maker: Arc<dyn Latent>) -> bool {
        let touched = |&block: &u16| self.land.has_loaded(block);
        let Some(plan) = &self.plan else { return false };
        if !plan.omits_entity(place.guid) || place.blocks.iter().any(touched) {
            return false;
        }
        let Some(plan) = &mut self.plan else {
            return false;
        };
        let number = plan.latent.len();
        for &block in &place.blocks {
            plan.latent_in.entry(block).or_default().push(number);
        }
        let time = plan.now();
        let after = self.entities.next_id();
        plan.latent.push(Some(LatentObject {
            place,
            time,
            after,
            maker,
        }));
        true
    }

    /// Creates what was put off in blocks that are loaded now, and what could touch it, in the order in which it was put off.
    fn create_latent(&mut self, blocks: impl Iterator<Item = u16>) {
        let Some(plan) = &mut self.plan else { return };
        if plan.latent_in.is_empty() {
            return;
        }
        let mut open: Vec<u16> = blocks.collect();
        let mut found = BTreeMap::new();
        while let Some(block) = open.pop() {
            for number in plan.latent_in.remove(&block).unwrap_or_default() {
                if let Some(object) = plan.latent.get_mut(number).and_then(Option::take) {
                    open.extend(&object.place.blocks);
                    found.insert(number, object);
                }
            }
        }
        for object in found.into_values() {
            self.create_late(&object);
        }
    }

    /// Creates all that was put off if the entity that keeps the simulation clock for them is going to have no tick in this frame.
    fn check_anchor(&mut self) {
        let Some(plan) = &self.plan else { return };
        if plan.latent_in.is_empty() {
            return;
        }
        let anchor = plan.anchor.and_then(|guid| self.entity_of_guid(guid));
        if anchor
            .and_then(|id| self.entity(id))
            .is_some_and(Entity::keeps_clock)
        {
            return;
        }
        let blocks: Vec<u16> = plan.latent_in.keys().copied().collect();
        self.create_latent(blocks.into_iter());
    }

    fn create_late(&mut self, object: &LatentObject) {
        let Some(plan) = &mut self.plan else { return };
        let created = plan.times.get(object.time).copied().unwrap_or_default();
        plan.extended.entities += 1;
        // Somebody may be in the middle of a transition: what it uses is set aside.
        let clock = std::mem::replace(&mut self.clock, Clock::at(created));
        let slots = std::mem::take(&mut self.slots);
        let scratch = std::mem::take(&mut self.scratch);
        let made = object.maker.create(self);
        let Some(plan) = &mut self.plan else { return };
        if let Some(id) = made {
            plan.born.push((object.place.guid, id));
            let through = if plan.in_tick {
                plan.now()
            } else {
                plan.now().saturating_sub(1)
            };
            let through = through.max(object.time);
            plan.extended.frames_put_off += (through - object.time) as u64;
            plan.idle.sleep(id, object.time, through);
            plan.late.insert(id);
            let (late, after) = (&plan.late, object.after);
            self.entities
                .move_before(id, |other| other >= after && !late.contains(&other));
            self.catch_up(id);
        }
        self.clock = clock;
        self.slots = slots;
        self.scratch = scratch;
    }
}
