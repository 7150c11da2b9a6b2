//! Stage `transition`.
//!
//! The other entities are put where the record says, and into the shadow lists at the places it names; they stay there for the next record.

use ac_client::math::{CellId, Frame, Plane, Position, Sphere, Vec3};
use ac_client::physics::body::{EntityId, ObjectRef};
use ac_client::physics::state::PhysicsState;
use ac_client::physics::transition::{
    CellArrayEntry, ContactPlane, ContactSeed, MoverSpheres, ObjectInfo, ObjectInfoState, Path,
    TransitionInput, TransitionResult,
};
use ac_client::world::{CellHandle, World};
use ac_golden_traces::number;
use ac_golden_traces::scene::PositionSpec;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::super::entity::{self, position, quat};
use super::shapes::position_spec;
use super::{Head, SceneRun, bad, spec_of, write};
use crate::simulation::SimulationError;

/// Bits that the weenie gives the mover; records leave them out.
const WEENIE_BITS: ObjectInfoState = ObjectInfoState::IS_PLAYER
    .union(ObjectInfoState::IS_IMPENETRABLE)
    .union(ObjectInfoState::IS_PK)
    .union(ObjectInfoState::IS_PK_LITE);

#[derive(Debug, Deserialize, Serialize)]
struct Hex(#[serde(with = "number::hex")] u32);

#[derive(Debug, Deserialize, Serialize)]
struct Vector(#[serde(with = "number::floats")] [f32; 3]);

#[derive(Debug, Deserialize)]
struct Rotation(#[serde(with = "number::floats")] [f32; 4]);

#[derive(Debug, Deserialize)]
struct SphereRecord {
    #[serde(with = "number::floats")]
    center: [f32; 3],
    #[serde(with = "number::f32")]
    radius: f32,
}

#[derive(Debug, Deserialize, Serialize)]
struct PlaneRecord {
    valid: bool,
    #[serde(with = "number::floats")]
    n: [f32; 3],
    #[serde(with = "number::f32")]
    d: f32,
    #[serde(with = "number::hex")]
    cell: u32,
    water: bool,
}

#[derive(Debug, Deserialize)]
pub(super) struct Input {
    begin: PositionSpec,
    #[serde(with = "number::hex")]
    begin_cell: u32,
    end: PositionSpec,
    #[serde(with = "number::hex")]
    object_info: u32,
    #[serde(with = "number::hex")]
    state: u32,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    #[serde(with = "number::f32")]
    step_up_height: f32,
    #[serde(with = "number::f32")]
    step_down_height: f32,
    step_down: bool,
    is_player: bool,
    spheres: Vec<SphereRecord>,
    #[serde(with = "number::f32")]
    scale: f32,
    contact_plane: PlaneRecord,
    last_known_contact_plane: PlaneRecord,
    sliding_normal: Option<Vector>,
    frames_stationary_fall: u32,
    others: Vec<Other>,
}

/// Another entity, where it stands.
#[derive(Debug, Deserialize)]
struct Other {
    #[serde(with = "number::hex")]
    guid: u32,
    #[serde(with = "number::hex")]
    state: u32,
    #[serde(with = "number::f32")]
    scale: f32,
    #[serde(with = "number::hex")]
    cell: u32,
    #[serde(with = "number::floats")]
    origin: [f32; 3],
    #[serde(with = "number::floats")]
    rotation: [f32; 4],
    /// Cell and index in its shadow list.
    shadow_cells: Vec<(Hex, usize)>,
    /// Pose of the parts of an entity with a physics BSP.
    #[serde(default, with = "number::opt_vec3")]
    pose_origin: Option<[f32; 3]>,
    pose_rotation: Option<Rotation>,
}

#[derive(Debug, Serialize)]
struct Output {
    valid: bool,
    outcome: &'static str,
    position: PositionSpec,
    #[serde(with = "number::hex")]
    cell: u32,
    #[serde(with = "number::hex")]
    object_info: u32,
    contact_plane: PlaneRecord,
    last_known_contact_plane: PlaneRecord,
    sliding_normal: Option<Vector>,
    collision_normal: Option<Vector>,
    frames_stationary_fall: u32,
    #[serde(with = "number::hex_list")]
    collided: Vec<u32>,
    environment: bool,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    sub_steps: u32,
    sub_steps_planned: u32,
    #[serde(with = "number::hex_list")]
    cell_array: Vec<u32>,
}

/// Runs the transition of a record.
pub(super) fn run(
    run: &mut SceneRun,
    head: &Head,
    input: &Input,
) -> Result<Value, SimulationError> {
    let mover = entity_of(run, head.frame, head.guid)?;
    place_others(run, head.frame, &input.others)?;
    let world = &mut run.world;
    let begin_cell = world.visible_cell(CellId(input.begin_cell));
    let transition = input.transition(head.guid, mover, begin_cell, world);
    let mut transit = (world.slots)
        .make(&world.profile)
        .ok_or_else(|| bad("no transition is free"))?;
    world.run_transition(&mut transit, &transition);
    world.slots.cleanup();
    let output = Output::new(&transit.result, input.velocity, world);
    world.slots.recycle(transit);
    write(&output)
}

/// The entity of a GUID; one that a step of the script creates is made now.
fn entity_of(run: &mut SceneRun, frame: u32, guid: u32) -> Result<EntityId, SimulationError> {
    if let Some(id) = run.world.entity_of_guid(guid) {
        return Ok(id);
    }
    let spec = spec_of(run, frame, guid)?;
    let world = &mut run.world;
    let id = world
        .make_object(spec.setup, guid, true)
        .map_err(|error| bad(error.to_string()))?;
    entity::attach_weenie(id, &spec, world);
    world.entities.register(id, guid);
    Ok(id)
}

impl From<&PlaneRecord> for ContactPlane {
    fn from(p: &PlaneRecord) -> Self {
        Self {
            valid: p.valid,
            plane: Plane {
                n: p.n.into(),
                d: p.d,
            },
            cell_id: CellId(p.cell),
            is_water: p.water,
        }
    }
}

impl From<&ContactPlane> for PlaneRecord {
    fn from(p: &ContactPlane) -> Self {
        Self {
            valid: p.valid,
            n: p.plane.n.into(),
            d: p.plane.d,
            cell: p.cell_id.0,
            water: p.is_water,
        }
    }
}

impl Input {
    fn transition(
        &self,
        guid: u32,
        mover: EntityId,
        begin_cell: Option<CellHandle>,
        world: &World,
    ) -> TransitionInput {
        let mut state = ObjectInfoState::from_bits_retain(self.object_info);
        state.set(ObjectInfoState::IS_PLAYER, self.is_player);
        let physics_state = PhysicsState::from_bits_retain(self.state);
        let sphere = |s: &SphereRecord| Sphere::new(s.center.into(), s.radius);
        let spheres: Vec<_> = self.spheres.iter().map(sphere).collect();
        let body = world.body(ObjectRef::Entity(mover));
        TransitionInput {
            mover: ObjectInfo {
                object: Some(ObjectRef::Entity(mover)),
                guid,
                state,
                physics_state,
                scale: self.scale,
                step_up_height: self.step_up_height,
                step_down_height: self.step_down_height,
                ethereal: physics_state.contains(PhysicsState::ETHEREAL),
                step_down: self.step_down,
                target_id: body.map_or(0, |b| b.target),
                creature: body.is_some_and(|b| b.weenie.creature),
                bypasses_restrictions: false,
                barrier_passed: false,
                velocity_killed: false,
            },
            spheres: MoverSpheres::of_scaled(&spheres),
            begin_cell,
            path: Path::Move {
                begin: position(&self.begin),
                end: position(&self.end),
            },
            contact: ContactSeed::Recorded {
                contact: (&self.contact_plane).into(),
                last_known: (&self.last_known_contact_plane).into(),
            },
            sliding_normal: self.sliding_normal.as_ref().map(|v| v.0.into()),
            frames_stationary_fall: self.frames_stationary_fall,
        }
    }
}

impl Output {
    fn new(result: &TransitionResult, velocity: [f32; 3], world: &World) -> Self {
        let guid = |&object: &ObjectRef| match object {
            ObjectRef::Entity(id) => world.entity(id).map(|e| e.guid()),
            ObjectRef::Static(_) => None,
        };
        let info = &result.info;
        Self {
            valid: result.valid,
            outcome: result.outcome.name(),
            position: position_spec(&result.position),
            cell: result.cell.map_or(0, |c| world.cell_id(c).0),
            object_info: result.object_info.difference(WEENIE_BITS).bits(),
            contact_plane: (&info.contact_plane).into(),
            last_known_contact_plane: (&info.last_known_contact_plane).into(),
            sliding_normal: info
                .sliding_normal_valid
                .then(|| Vector(info.sliding_normal.into())),
            collision_normal: info
                .collision_normal_valid
                .then(|| Vector(info.collision_normal.into())),
            frames_stationary_fall: info.frames_stationary_fall,
            collided: info.collide_object.iter().filter_map(guid).collect(),
            environment: info.collided_with_environment,
            velocity: if result.velocity_killed {
                [0.0; 3]
            } else {
                velocity
            },
            sub_steps: result.progress.done,
            sub_steps_planned: result.progress.planned,
            cell_array: result.cells.entries().map(|e| e.id.0).collect(),
        }
    }
}

/// Puts the other entities, and nobody else, where the record says.
fn place_others(run: &mut SceneRun, frame: u32, others: &[Other]) -> Result<(), SimulationError> {
    clear_shadows(&mut run.world);
    let mut shadows = Vec::new();
    for other in others {
        let id = entity_of(run, frame, other.guid)?;
        place_other(&mut run.world, id, other);
        for &(Hex(cell), index) in &other.shadow_cells {
            let entry = CellArrayEntry {
                id: CellId(cell),
                cell: run.world.visible_cell(CellId(cell)),
            };
            shadows.extend(entry.cell.map(|handle| (handle, index, id)));
            if let Some(entity) = run.world.entity_mut(id) {
                entity.body.shadows.push(entry);
            }
        }
    }
    // In the order of the lists, so that each finds the place that the record names. The mover, which is never tested, is left out.
    shadows.sort_by_key(|&(cell, index, _)| (cell, index));
    for (cell, index, id) in shadows {
        if let Some(base) = run.world.land.base_mut(cell) {
            let at = index.min(base.shadows.len());
            base.shadows.insert(at, ObjectRef::Entity(id));
        }
    }
    Ok(())
}

fn place_other(world: &mut World, id: EntityId, other: &Other) {
    let profile = world.profile.clone();
    let cell = world.visible_cell(CellId(other.cell));
    let Some(entity) = world.entity_mut(id) else {
        return;
    };
    let position = Position::new(
        CellId(other.cell),
        other.origin.into(),
        quat(other.rotation),
    );
    let body = &mut entity.body;
    body.position = position;
    body.cell = cell;
    body.state = PhysicsState::from_bits_retain(other.state);
    body.scale = other.scale;
    let pose = match (other.pose_origin, &other.pose_rotation) {
        (Some(origin), Some(Rotation(rotation))) => Frame::new(origin.into(), quat(*rotation)),
        _ => position.frame,
    };
    if let Some(parts) = &mut body.part_array {
        parts.set_scale(Vec3::splat(other.scale));
        parts.set_cell_id(position.cell);
        parts.update_parts(&pose, &profile);
    }
}

/// Takes all entities out of the shadow lists.
fn clear_shadows(world: &mut World) {
    for index in 0..world.entities.table().len() {
        let id = world.entities.table()[index];
        let Some(entity) = world.entity_mut(id) else {
            continue;
        };
        let shadows = std::mem::take(&mut entity.body.shadows);
        for cell in shadows.iter().filter_map(|shadow| shadow.cell) {
            if let Some(base) = world.land.base_mut(cell) {
                base.shadows.retain(|&o| o != ObjectRef::Entity(id));
            }
        }
    }
}
