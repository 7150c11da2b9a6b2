//! The stage `transition` alone.

use ac_client::math::{CellId, Frame, Position};
use ac_client::physics::body::{EntityId, ObjectRef};
use ac_client::physics::state::PhysicsState;
use ac_client::physics::transition::{
    CellArrayEntry, ContactSeed, MoverSpheres, ObjectInfo, ObjectInfoState, Path, TransitionInput,
    TransitionResult,
};
use ac_client::world::{CellHandle, World};
use ac_golden_traces::number;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::StageError;
use super::json::{Hex, PlaneJson, PositionJson, Rotation, SphereJson, Vector};

const STAGE: &str = "transition";

/// Bits that the weenie gives the mover; records leave them out.
const WEENIE_BITS: ObjectInfoState = ObjectInfoState::IS_PLAYER
    .union(ObjectInfoState::IS_IMPENETRABLE)
    .union(ObjectInfoState::IS_PK)
    .union(ObjectInfoState::IS_PK_LITE);

#[derive(Deserialize)]
struct Input {
    begin: PositionJson,
    begin_cell: Hex,
    end: PositionJson,
    object_info: Hex,
    state: Hex,
    velocity: Vector,
    #[serde(with = "number::f32")]
    step_up_height: f32,
    #[serde(with = "number::f32")]
    step_down_height: f32,
    step_down: bool,
    is_player: bool,
    spheres: Vec<SphereJson>,
    #[serde(with = "number::f32")]
    scale: f32,
    contact_plane: PlaneJson,
    last_known_contact_plane: PlaneJson,
    sliding_normal: Option<Vector>,
    frames_stationary_fall: u32,
    others: Vec<Other>,
}

/// Another entity, where it stands.
#[derive(Deserialize)]
struct Other {
    guid: Hex,
    state: Hex,
    #[serde(with = "number::f32")]
    scale: f32,
    cell: Hex,
    origin: Vector,
    rotation: Rotation,
    /// Cell and index in its shadow list.
    shadow_cells: Vec<(Hex, usize)>,
    /// Pose of the parts of an entity with a physics BSP.
    pose_origin: Option<Vector>,
    pose_rotation: Option<Rotation>,
}

#[derive(Serialize)]
struct Output {
    valid: bool,
    outcome: &'static str,
    position: PositionJson,
    cell: Hex,
    object_info: Hex,
    contact_plane: PlaneJson,
    last_known_contact_plane: PlaneJson,
    sliding_normal: Option<Vector>,
    collision_normal: Option<Vector>,
    frames_stationary_fall: u32,
    collided: Vec<Hex>,
    environment: bool,
    velocity: Vector,
    sub_steps: u32,
    sub_steps_planned: u32,
    cell_array: Vec<Hex>,
}

/// Runs the transition of entity `guid` from a record's `input` and answers the record's `out`.
///
/// All entities that the record names must exist in the world; those beside the mover are put where the record says, and stay there.
///
/// # Errors
/// See [`StageError`].
pub fn run_transition_stage(
    world: &mut World,
    guid: u32,
    input: &Value,
) -> Result<Value, StageError> {
    let input = Input::deserialize(input).map_err(|error| malformed(&error))?;
    let mover = entity(world, guid)?;
    place_others(world, &input.others)?;
    let begin_cell = world.visible_cell(CellId(input.begin_cell.0));
    let transition = input.transition(guid, mover, begin_cell, world);
    let mut transit = (world.slots)
        .make(&world.profile)
        .ok_or(StageError::NoTransition)?;
    world.run_transition(&mut transit, &transition);
    world.slots.cleanup();
    let output = Output::new(&transit.result, input.velocity, world);
    world.slots.recycle(transit);
    serde_json::to_value(output).map_err(|error| malformed(&error))
}

fn malformed(error: &serde_json::Error) -> StageError {
    StageError::Malformed {
        stage: STAGE,
        path: "in".into(),
        reason: error.to_string(),
    }
}

fn entity(world: &World, guid: u32) -> Result<EntityId, StageError> {
    world
        .entity_of_guid(guid)
        .ok_or(StageError::NoSuchEntity { stage: STAGE, guid })
}

impl Input {
    fn transition(
        &self,
        guid: u32,
        mover: EntityId,
        begin_cell: Option<CellHandle>,
        world: &World,
    ) -> TransitionInput {
        let mut state = ObjectInfoState::from_bits_retain(self.object_info.0);
        state.set(ObjectInfoState::IS_PLAYER, self.is_player);
        let physics_state = PhysicsState::from_bits_retain(self.state.0);
        let spheres: Vec<_> = self.spheres.iter().map(|&s| s.into()).collect();
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
                bypasses_restrictions: body.is_some_and(|b| b.weenie.bypasses_restrictions),
                barrier_passed: false,
                velocity_killed: false,
            },
            spheres: MoverSpheres::of_scaled(&spheres),
            begin_cell,
            path: Path::Move {
                begin: self.begin.into(),
                end: self.end.into(),
            },
            contact: ContactSeed::Recorded {
                contact: self.contact_plane.into(),
                last_known: self.last_known_contact_plane.into(),
            },
            sliding_normal: self.sliding_normal.map(Into::into),
            frames_stationary_fall: self.frames_stationary_fall,
        }
    }
}

impl Output {
    fn new(result: &TransitionResult, velocity: Vector, world: &World) -> Self {
        let guid = |&object: &ObjectRef| match object {
            ObjectRef::Entity(id) => world.entity(id).map(|e| Hex(e.guid())),
            ObjectRef::Static(_) => None,
        };
        let info = &result.info;
        Self {
            valid: result.valid,
            outcome: result.outcome.name(),
            position: (&result.position).into(),
            cell: Hex(result.cell.map_or(0, |c| world.land.cell_id(c).0)),
            object_info: Hex(result.object_info.difference(WEENIE_BITS).bits()),
            contact_plane: (&info.contact_plane).into(),
            last_known_contact_plane: (&info.last_known_contact_plane).into(),
            sliding_normal: info
                .sliding_normal_valid
                .then(|| info.sliding_normal.into()),
            collision_normal: info
                .collision_normal_valid
                .then(|| info.collision_normal.into()),
            frames_stationary_fall: info.frames_stationary_fall,
            collided: info.collide_object.iter().filter_map(guid).collect(),
            environment: info.collided_with_environment,
            velocity: if result.velocity_killed {
                Vector([0.0; 3])
            } else {
                velocity
            },
            sub_steps: result.progress.done,
            sub_steps_planned: result.progress.planned,
            cell_array: result.cells.entries().map(|e| Hex(e.id.0)).collect(),
        }
    }
}

/// Puts the other entities, and nobody else, where the record says, and into the shadow lists at the places it names.
fn place_others(world: &mut World, others: &[Other]) -> Result<(), StageError> {
    clear_shadows(world);
    let mut shadows = Vec::new();
    for other in others {
        let id = entity(world, other.guid.0)?;
        place_other(world, id, other);
        for &(cell, index) in &other.shadow_cells {
            let cell = CellId(cell.0);
            let handle = world.visible_cell(cell);
            if let Some(handle) = handle {
                shadows.push((handle, index, id));
            }
            if let Some(entity) = world.entity_mut(id) {
                entity.body.shadows.push(CellArrayEntry {
                    id: cell,
                    cell: handle,
                });
            }
        }
    }
    // In the order of the lists, so that each finds the place that the record names: dat objects come first in their order, and the mover,
    // which is never tested, is left out.
    shadows.sort_by_key(|&(cell, index, _)| (cell, index));
    for (cell, index, id) in shadows {
        if let Some(base) = world.land.base_mut(cell) {
            let at = index.min(base.shadows.len());
            base.shadows.insert(at, ObjectRef::Entity(id));
        }
    }
    Ok(())
}

fn place_other(world: &mut World, id: EntityId, other: &Other) {
    let profile = world.profile.clone();
    let cell = world.visible_cell(CellId(other.cell.0));
    let Some(entity) = world.entity_mut(id) else {
        return;
    };
    let position = Position::new(
        CellId(other.cell.0),
        other.origin.into(),
        other.rotation.into(),
    );
    let body = &mut entity.body;
    body.position = position;
    body.cell = cell;
    body.state = PhysicsState::from_bits_retain(other.state.0);
    body.scale = other.scale;
    let pose = match (other.pose_origin, other.pose_rotation) {
        (Some(origin), Some(rotation)) => Frame::new(origin.into(), rotation.into()),
        _ => position.frame,
    };
    if let Some(parts) = &mut body.part_array {
        parts.set_scale(ac_client::math::Vec3::splat(other.scale));
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
