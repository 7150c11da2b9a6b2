//! What a record does not say: the same scene, run beside the records.
//!
//! A *scout* runs the scene freely. At the moment before a stage it is looked at: who exists, in which state, what time it is. A stage runs on
//! a *bench*, a world of the same map where that moment is set up again and the record's `in` is written over it. The scout never sees what
//! the bench does, so that each record starts from a scene that no other record has touched; and the outputs come from the bench alone.

use std::sync::Arc;

use ac_client::dat::DatSet;
use ac_client::entity::Entity;
use ac_client::frame::probe::{Probe, StageView, TickStage};
use ac_client::math::CellId;
use ac_client::physics::body::{EntityId, ObjectRef};
use ac_client::physics::maintenance::LostCells;
use ac_client::profile::Profile;
use ac_client::world::{Clock, World, WorldSource};
use ac_golden_traces::Scene;

use super::super::SceneRun;
use crate::simulation::SimulationError;

/// The scene beside the records.
#[derive(Debug)]
pub(in crate::client) struct Companion {
    scout: SceneRun,
    /// The frame that the scout runs next.
    next_frame: u32,
    /// What was seen in the last frame.
    moments: Vec<Moment>,
    bench: World,
}

/// Who exists before a stage.
#[derive(Debug)]
struct Moment {
    stage: TickStage,
    guid: u32,
    quantum: usize,
    id: EntityId,
    clock: Clock,
    /// Those of the object table in its order, then the others.
    standing: Vec<Standing>,
}

#[derive(Debug)]
struct Standing {
    entity: Entity,
    registered: bool,
    /// Id of the cell that it is in.
    cell: CellId,
}

/// Looks at the stages that run on the bench.
struct Watch<'a>(&'a mut Vec<Moment>);

impl Probe for Watch<'_> {
    fn before(&mut self, view: StageView<'_>) {
        let on_bench = matches!(
            view.stage,
            TickStage::Hooks | TickStage::Commit | TickStage::Motion
        );
        if on_bench {
            self.0.push(Moment::of(&view));
        }
    }
}

impl Moment {
    fn of(view: &StageView<'_>) -> Self {
        let (mover, world) = (view.entity, view.world);
        let table = world.entities.table().iter();
        let table = table.filter_map(|&id| {
            if id == mover.id {
                Some(mover)
            } else {
                world.entity(id)
            }
        });
        let others = world
            .entities
            .iter()
            .filter(|entity| !world.entities.is_registered(entity.id));
        let standing = table.chain(others).map(|entity| Standing {
            entity: entity.clone(),
            registered: world.entities.is_registered(entity.id),
            cell: entity
                .body
                .cell
                .map_or(CellId::NONE, |cell| world.cell_id(cell)),
        });
        Self {
            stage: view.stage,
            guid: mover.guid(),
            quantum: mover.steps.len(),
            id: mover.id,
            clock: world.clock,
            standing: standing.collect(),
        }
    }
}

impl Companion {
    pub(in crate::client) fn new(
        scene: &Scene,
        source: &Arc<DatSet>,
        profile: &Profile,
    ) -> Result<Self, SimulationError> {
        let map: Arc<dyn WorldSource> = Arc::clone(source) as _;
        Ok(Self {
            scout: SceneRun::new(scene, Arc::clone(source), profile)?,
            next_frame: 0,
            moments: Vec::new(),
            bench: World::with_source(profile.clone(), scene.start_time, map),
        })
    }

    /// Whether the scout has passed a frame: its moments are gone.
    pub(in crate::client) const fn has_passed(&self, frame: u32) -> bool {
        frame.saturating_add(1) < self.next_frame
    }

    /// Runs the scout to the end of a frame.
    pub(in crate::client) fn advance_to(&mut self, frame: u32) {
        while self.next_frame <= frame {
            self.moments.clear();
            self.scout
                .run_frame(self.next_frame, &mut Watch(&mut self.moments));
            self.next_frame += 1;
        }
    }

    /// Sets the moment before a stage up on the bench and lends the entity to `stage`. `None` if the scout has not come by there.
    pub(in crate::client) fn at<R>(
        &mut self,
        (stage, guid, quantum): (TickStage, u32, usize),
        run: impl FnOnce(&mut Entity, &mut World) -> R,
    ) -> Option<R> {
        let moment = self
            .moments
            .iter()
            .find(|m| m.stage == stage && m.guid == guid && m.quantum == quantum)?;
        set_up(&mut self.bench, moment);
        self.bench.with_entity(moment.id, |entity, world| {
            entity.begin_frame();
            run(entity, world)
        })
    }
}

/// Puts those of a moment, and nobody else, where they stood.
fn set_up(world: &mut World, moment: &Moment) {
    clear(world);
    world.clock = moment.clock;
    for standing in &moment.standing {
        let mut entity = Box::new(standing.entity.clone());
        let object = entity.object_ref();
        entity.body.cell = match standing.cell {
            CellId::NONE => None,
            id => world.visible_cell(id),
        };
        if let Some(cell) = entity.body.cell {
            world.land.add_object(cell, object);
        }
        for shadow in &mut entity.body.shadows {
            // Handles are those of another world.
            shadow.cell = shadow.cell.and_then(|_| world.visible_cell(shadow.id));
            if let Some(cell) = shadow.cell {
                world.land.add_shadow(cell, object);
            }
        }
        world.entities.adopt(entity, standing.registered);
    }
}

/// Takes all entities out of the world.
fn clear(world: &mut World) {
    let World { entities, land, .. } = world;
    for entity in entities.iter() {
        let object = ObjectRef::Entity(entity.id);
        if let Some(base) = entity.body.cell.and_then(|cell| land.base_mut(cell)) {
            base.objects.retain(|&o| o != object);
        }
        for cell in entity.body.shadows.iter().filter_map(|shadow| shadow.cell) {
            if let Some(base) = land.base_mut(cell) {
                base.shadows.retain(|&o| o != object);
            }
        }
    }
    entities.clear();
    world.lost = LostCells::default();
}
