//! [`World`] owns everything; entities, statics and cells are handles into it.

use std::sync::Arc;

use super::random::Random;
use super::scratch::Scratch;
use super::{Landscape, Resources, WorldSource};
use crate::entity::Entities;
use crate::frame::plan::ActivePlan;
use crate::math::CellId;
use crate::physics::body::EntityId;
use crate::physics::maintenance::{DestructionQueue, LostCells};
use crate::physics::transition::{CellArray, TransitionSlots};
use crate::profile::Profile;

/// Handle of a loaded cell (outdoor or indoor) of a [`World`]. Cells stay loaded under a handle until their landblock is released.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellHandle(pub u32);

/// Everything that exists: landscape, static objects, entities, clocks and the behaviour profile.
///
/// Iteration order is creation order: the same inputs always give the same bits.
#[derive(Debug)]
pub struct World {
    /// Behaviour at every numbered point of difference.
    pub profile: Profile,
    /// Clocks.
    pub clock: Clock,
    /// What is loaded of the map: terrain, cells, static objects.
    pub land: Landscape,
    /// Shapes and other immutable resources.
    pub resources: Resources,
    /// The dynamic objects.
    pub entities: Entities,
    /// The pool of transitions.
    pub slots: TransitionSlots,
    /// The only source of chance (`spec/06-physics-object.md`, C3).
    pub random: Random,
    /// The local player, if there is one.
    pub local_player: Option<EntityId>,
    /// Objects far from the local player rest.
    pub culling_enabled: bool,
    /// Entities whose animation is advanced although they are static.
    pub static_animations: Vec<EntityId>,
    /// Entities whose cell is not there.
    pub lost: LostCells,
    /// Entities out of sight.
    pub doomed: DestructionQueue,
    /// What is left out of the work, if anything is; see [`World::set_plan`].
    pub plan: Option<Box<ActivePlan>>,
    /// Memory that is reused.
    pub scratch: Scratch,
    /// Scratch of the loader.
    pub(crate) loading_cells: CellArray,
}

/// The two clocks of the simulation (`spec/06-physics-object.md`, B2), seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Frame clock: constant during a frame.
    pub now: f64,
    /// Simulation clock: the time inside the step being executed; keeps its last value between frames.
    pub sim_time: f64,
}

impl Clock {
    /// Both clocks at a time in s.
    pub const fn at(now: f64) -> Self {
        Self { now, sim_time: now }
    }
}

impl World {
    /// An empty world whose clocks stand at `now`, s.
    pub fn new(profile: Profile, now: f64) -> Self {
        Self {
            resources: Resources::default(),
            land: Landscape::default(),
            loading_cells: CellArray::default(),
            profile,
            clock: Clock::at(now),
            entities: Entities::default(),
            slots: TransitionSlots::default(),
            random: Random::Middle,
            local_player: None,
            culling_enabled: true,
            static_animations: Vec::new(),
            lost: LostCells::default(),
            doomed: DestructionQueue::default(),
            plan: None,
            scratch: Scratch::default(),
        }
    }

    /// A world without objects, whose map comes from `source`, and whose clocks stand at `now`, s. Nothing is loaded yet.
    pub fn with_source(profile: Profile, now: f64, source: Arc<dyn WorldSource>) -> Self {
        let land = Landscape::new(Arc::clone(&source));
        let resources = Resources::new(source, profile.clone());
        Self {
            land,
            resources,
            ..Self::new(profile, now)
        }
    }

    /// Id of a loaded cell; [`CellId::NONE`] for a handle whose cell was released.
    pub fn cell_id(&self, cell: CellHandle) -> CellId {
        self.land.cell_id(cell)
    }
}
