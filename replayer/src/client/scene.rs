//! A scene as it runs (`spec/scene-format.md`).

use std::collections::BTreeMap;
use std::sync::Arc;

use ac_client::dat::DatSet;
use ac_client::frame::plan::{
    ActivePlan, Extended, Latent, LatentPlace, Plan, SceneOutline, WorldIndex,
};
use ac_client::frame::state::Fields;
use ac_client::frame::{FrameState, FrameStates, Host, NoProbe, Pipeline, Probe};
use ac_client::math::CellId;
use ac_client::physics::body::EntityId;
use ac_client::profile::Profile;
use ac_client::world::{World, WorldSource};
use ac_golden_traces::Scene;
use ac_golden_traces::scene::{Action, EntitySpec, ScriptStep};
use serde_json::{Value, value::RawValue};

use super::entity::{self, CreationNote};
use super::{script, stages};
use crate::checkpoints::CheckpointProbe;
use crate::simulation::{Simulation, SimulationError};

/// A scene that runs.
#[derive(Debug)]
pub struct SceneRun {
    /// Everything that exists.
    pub world: World,
    pub(super) scene: Scene,
    pub(super) pipeline: Pipeline,
    /// By GUID: the newest object that was created under it.
    pub(super) objects: BTreeMap<u32, SceneObject>,
    /// The next step of the script.
    pub(super) next_step: usize,
    /// Notes about creations, in order.
    pub(super) notes: Vec<String>,
    pub(super) source: Arc<DatSet>,
    /// The same scene beside stage records; made by the first that needs it.
    pub(super) companion: Option<Box<stages::Companion>>,
}

/// A plan with what is needed to carry it out.
#[derive(Debug, Clone)]
pub struct ScenePlan {
    /// The plan.
    pub plan: Arc<Plan>,
    /// Index of the world under the profile of the run.
    pub index: Arc<WorldIndex>,
    /// The scene, as its planner saw it.
    pub outline: SceneOutline,
}

/// An entity that is created late.
#[derive(Debug)]
struct LateEntity(EntitySpec);

impl Latent for LateEntity {
    fn create(&self, world: &mut World) -> Option<EntityId> {
        entity::create(&self.0, None, world).0
    }
}

/// An entity of the scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct SceneObject {
    pub id: EntityId,
    /// A step has destroyed it: it exists outside world and object table.
    pub destroyed: bool,
}

/// Runs the script steps of a frame as its input stage.
struct ScriptInput<'a> {
    frame: u32,
    scene: &'a Scene,
    objects: &'a mut BTreeMap<u32, SceneObject>,
    next_step: &'a mut usize,
    notes: &'a mut Vec<String>,
}

impl Host for ScriptInput<'_> {
    /// Nothing ends in a scene but by its script: the oracles keep no queue of what is out of sight (`spec/oracles.md`, 2.3).
    fn out_of_sight(&mut self, _id: EntityId, _world: &mut World) {}

    fn input(&mut self, world: &mut World) {
        let scene = self.scene;
        while let Some(step) = scene.script.get(*self.next_step) {
            if step.frame > self.frame {
                break;
            }
            *self.next_step += 1;
            run_step(step, self.objects, self.notes, world);
        }
    }
}

fn run_step(
    step: &ScriptStep,
    objects: &mut BTreeMap<u32, SceneObject>,
    notes: &mut Vec<String>,
    world: &mut World,
) {
    if let Action::Create { entity } = &step.action {
        create(entity, objects, notes, world);
        return;
    }
    let parent = match &step.action {
        Action::SetParent { parent, .. } => objects.get(parent).map(|o| o.id),
        _ => None,
    };
    let Some(object) = objects.get_mut(&step.guid) else {
        // Not created yet.
        return;
    };
    let id = object.id;
    if step.action == Action::Destroy {
        object.destroyed = true;
        world.with_entity(id, |entity, world| entity.leave_for_good(world));
        world.forget(id);
        return;
    }
    world.with_entity(id, |entity, world| {
        script::act(entity, &step.action, parent, world);
    });
}

fn create(
    spec: &EntitySpec,
    objects: &mut BTreeMap<u32, SceneObject>,
    notes: &mut Vec<String>,
    world: &mut World,
) {
    let parent = spec
        .parent
        .and_then(|guid| objects.get(&guid))
        .map(|o| o.id);
    let (id, note) = entity::create(spec, parent, world);
    if let Some(id) = id {
        let object = SceneObject {
            id,
            destroyed: false,
        };
        objects.insert(spec.guid, object);
    }
    let text = match note {
        Some(CreationNote::NoObject) => "was not made: its setup cannot be read",
        Some(CreationNote::DidNotEnter) => "did not enter the world",
        Some(CreationNote::ParentRefused) => "could not be attached to its parent",
        None => return,
    };
    notes.push(format!("entity {:#X} {text}", spec.guid));
}

impl SceneRun {
    /// Sets the scene up under a profile: its world, and the entities that exist before frame 0.
    ///
    /// # Errors
    /// None at present: an entity that cannot be made is noted, as the oracles do.
    pub fn new(
        scene: &Scene,
        source: Arc<DatSet>,
        profile: &Profile,
    ) -> Result<Self, SimulationError> {
        Self::planned(scene, source, profile, None)
    }

    /// As [`SceneRun::new`], under a plan.
    ///
    /// # Errors
    /// As [`SceneRun::new`].
    pub fn planned(
        scene: &Scene,
        source: Arc<DatSet>,
        profile: &Profile,
        plan: Option<ScenePlan>,
    ) -> Result<Self, SimulationError> {
        let map: Arc<dyn WorldSource> = Arc::clone(&source) as _;
        let mut run = Self {
            world: World::with_source(profile.clone(), scene.start_time, map),
            scene: scene.clone(),
            pipeline: Pipeline::default(),
            objects: BTreeMap::new(),
            next_step: 0,
            notes: Vec::new(),
            source,
            companion: None,
        };
        let mut late = plan.map(|plan| run.carry_out(&plan)).unwrap_or_default();
        for spec in &scene.entities {
            let put_off = late
                .remove(&spec.guid)
                .is_some_and(|place| run.world.put_off(place, Arc::new(LateEntity(*spec))));
            if !put_off {
                create(spec, &mut run.objects, &mut run.notes, &mut run.world);
            }
        }
        Ok(run)
    }

    /// Sets the plan; answers the places of entities whose creation can wait, by GUID.
    fn carry_out(&mut self, plan: &ScenePlan) -> BTreeMap<u32, LatentPlace> {
        let ScenePlan {
            plan,
            index,
            outline,
        } = plan;
        let late = outline.latent_places(plan, self.source.as_ref());
        let followed = outline.load_point;
        let start = outline.entities.iter().find(|e| Some(e.guid) == followed);
        let start: Option<CellId> = start.map(|e| e.position.cell);
        let active = ActivePlan::new(Arc::clone(plan), Arc::clone(index), followed);
        let active = active.with_anchor(outline.anchor());
        self.world.set_plan(active, start);
        late
    }

    /// How often the plan was extended so far; nothing without a plan.
    pub fn extended(&self) -> Extended {
        self.world
            .plan
            .as_ref()
            .map(|plan| plan.extended)
            .unwrap_or_default()
    }

    /// Brings everything that a plan has put off up to date, but for entities that are still to be created: for those who want to look at
    /// all of the world between two frames.
    pub fn settle(&mut self) {
        self.world.catch_up_all();
        self.take_born();
    }

    /// Takes the entities that were created late into the table of the scene.
    fn take_born(&mut self) {
        let born = self.world.plan.as_mut().map(|plan| plan.take_born());
        for (guid, id) in born.into_iter().flatten() {
            let object = SceneObject {
                id,
                destroyed: false,
            };
            self.objects.insert(guid, object);
        }
    }

    /// The scene.
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What went otherwise than the scene wanted, in order.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Cuts time otherwise than the retail client from now on. Called before the first frame.
    pub fn set_fidelity(&mut self, fidelity: ac_client::frame::Fidelity) {
        fidelity.apply(&mut self.world.profile);
        self.pipeline.fidelity = fidelity;
    }

    /// The object of a GUID, destroyed or not.
    pub fn object(&self, guid: u32) -> Option<EntityId> {
        self.objects.get(&guid).map(|o| o.id)
    }

    /// Runs a frame under the eyes of a probe: the clock advances, the script's steps run, every entity is advanced.
    pub fn run_frame<P: Probe>(&mut self, frame: u32, probe: &mut P) {
        self.take_born();
        for object in self.objects.values() {
            if self.world.is_idle(object.id) {
                // Nobody asks for its records.
                continue;
            }
            self.world.entities.begin_frame(object.id);
        }
        let now = self.world.clock.now + frame_length(&self.scene, frame);
        let mut input = ScriptInput {
            frame,
            scene: &self.scene,
            objects: &mut self.objects,
            next_step: &mut self.next_step,
            notes: &mut self.notes,
        };
        self.pipeline
            .run_frame_probed(&mut self.world, now, &mut input, probe);
    }

    /// The scene beside stage records, at the end of a frame.
    pub(super) fn companion(
        &mut self,
        frame: u32,
    ) -> Result<&mut stages::Companion, SimulationError> {
        let made = self.companion.take().filter(|c| !c.has_passed(frame));
        let made = match made {
            Some(made) => made,
            None => Box::new(stages::Companion::new(
                &self.scene,
                &self.source,
                &self.world.profile,
            )?),
        };
        let companion = self.companion.insert(made);
        companion.advance_to(frame);
        Ok(companion)
    }

    /// Writes the records of the tracked entities.
    pub fn write_records(&self, frame: i32, out: &mut FrameStates) {
        out.clear();
        let time = self.world.clock.now;
        for &guid in &self.scene.track {
            let record = out.push(frame, time, guid);
            self.write_record(frame, time, guid, record);
        }
    }

    fn write_record(&self, frame: i32, time: f64, guid: u32, record: &mut FrameState) {
        let Some(object) = self.objects.get(&guid) else {
            // Not created yet: not even events.
            record.has = Fields::empty();
            record.anim = None;
            return;
        };
        let Some(entity) = self.world.entity(object.id) else {
            return;
        };
        if object.destroyed {
            record.gone(frame, time, guid, &entity.events);
        } else {
            entity.frame_state(frame, time, record);
        }
    }
}

/// Seconds by which the clock advances before a frame.
fn frame_length(scene: &Scene, frame: u32) -> f64 {
    let mut first = 0;
    for run in &scene.frames {
        first += run.count;
        if frame < first {
            return run.dt;
        }
    }
    0.0
}

impl Simulation for SceneRun {
    fn frame_minus_one(&mut self, out: &mut FrameStates) -> Result<(), SimulationError> {
        self.write_records(-1, out);
        Ok(())
    }

    fn step(&mut self, frame: u32, out: &mut FrameStates) -> Result<(), SimulationError> {
        self.run_frame(frame, &mut NoProbe);
        self.write_records(i32::try_from(frame).unwrap_or(i32::MAX), out);
        Ok(())
    }

    fn step_with_checkpoints(
        &mut self,
        frame: u32,
        out: &mut FrameStates,
        checkpoints: &mut Vec<Box<RawValue>>,
    ) -> Result<(), SimulationError> {
        self.run_frame(frame, &mut CheckpointProbe::new(frame, checkpoints));
        self.write_records(i32::try_from(frame).unwrap_or(i32::MAX), out);
        Ok(())
    }

    fn records(&self, frame: i32, out: &mut FrameStates) -> Result<(), SimulationError> {
        self.write_records(frame, out);
        Ok(())
    }

    fn snapshot(&self) -> Result<Option<Vec<u8>>, SimulationError> {
        self.take_snapshot().map(Some)
    }

    fn load_state(&mut self, expected: &FrameState) -> Result<(), SimulationError> {
        let Some(object) = self.objects.get(&expected.guid) else {
            return Ok(());
        };
        if !object.destroyed {
            self.world.with_entity(object.id, |entity, world| {
                entity.load_frame_state(expected, world);
            });
        }
        Ok(())
    }

    fn run_stage(
        &mut self,
        records: &[Value],
        index: usize,
    ) -> Result<Option<Value>, SimulationError> {
        stages::run(self, records, index)
    }
}
