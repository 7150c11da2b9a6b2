//! Stage `commit`: cell, frame, contact, collisions, shadows.
//!
//! What a transition found comes from the transition record of the same quantum, never from a transition that is run.

use ac_client::entity::{CollisionRecord, Entity};
use ac_client::math::{CellId, Vec3};
use ac_client::physics::body::ObjectRef;
use ac_client::physics::state::{PhysicsState, TransientState};
use ac_client::physics::transition::{CellArray, CollisionInfo, TransitionResult};
use ac_client::physics::update::CommitKind;
use ac_client::world::World;
use ac_golden_traces::number;
use ac_golden_traces::scene::{OffsetSpec, PositionSpec};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::super::entity::position;
use super::motion_state::{Interpreted, place};
use super::shapes::{Hex, VecSpec, events, frame, position_spec};
use super::transition::PlaneRecord;
use super::{bad, read, write};
use crate::simulation::SimulationError;

#[derive(Debug, Deserialize)]
pub(super) struct Input {
    #[serde(with = "number::f32")]
    quantum: f32,
    kind: Kind,
    frame: OffsetSpec,
    position: PositionSpec,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    #[serde(with = "number::floats")]
    acceleration: [f32; 3],
    #[serde(with = "number::floats")]
    omega: [f32; 3],
    #[serde(with = "number::hex")]
    state: u32,
    #[serde(with = "number::hex")]
    transient: u32,
    #[serde(with = "number::f32")]
    elasticity: f32,
    collided_with_environment: bool,
    #[serde(with = "number::hex_list")]
    collision_table: Vec<u32>,
    interpreted: Option<Interpreted>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Transition,
    Failed,
    Still,
    NoSpheres,
}

/// What the transition record before says of the result.
#[derive(Debug, Deserialize)]
struct Result {
    position: PositionSpec,
    #[serde(with = "number::hex")]
    cell: u32,
    contact_plane: PlaneRecord,
    last_known_contact_plane: PlaneRecord,
    sliding_normal: Option<VecSpec>,
    collision_normal: Option<VecSpec>,
    frames_stationary_fall: u32,
    #[serde(with = "number::hex_list")]
    collided: Vec<u32>,
    environment: bool,
    #[serde(with = "number::hex_list")]
    cell_array: Vec<u32>,
}

/// State word of an entity near the mover.
#[derive(Debug, Deserialize)]
struct Other {
    #[serde(with = "number::hex")]
    guid: u32,
    #[serde(with = "number::hex")]
    state: u32,
}

#[derive(Debug, Serialize)]
struct Plane {
    #[serde(with = "number::floats")]
    n: [f32; 3],
    #[serde(with = "number::f32")]
    d: f32,
    #[serde(with = "number::hex")]
    cell: u32,
}

#[derive(Debug, Serialize)]
struct Output {
    position: PositionSpec,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    #[serde(with = "number::floats")]
    acceleration: [f32; 3],
    #[serde(with = "number::floats")]
    omega: [f32; 3],
    #[serde(with = "number::hex")]
    state: u32,
    #[serde(with = "number::hex")]
    transient: u32,
    contact_plane: Option<Plane>,
    sliding_normal: Option<VecSpec>,
    #[serde(with = "number::floats")]
    cached_velocity: [f32; 3],
    cell_change: Option<[Hex; 2]>,
    #[serde(with = "number::hex_list")]
    shadow_cells: Vec<u32>,
    collided_with_environment: bool,
    #[serde(with = "number::hex_list")]
    collision_table: Vec<u32>,
    events: Vec<String>,
}

/// Runs the commit of a record; `transition` is the record of the quantum's transition, if there was one.
pub(super) fn run(
    entity: &mut Entity,
    world: &mut World,
    input: &Input,
    transition: Option<&Value>,
) -> std::result::Result<Value, SimulationError> {
    input.apply(entity, world);
    let wanted = frame(&input.frame);
    let old = cell_of(entity, world);
    if let Some(others) = transition.and_then(|t| t.pointer("/in/others")) {
        set_states(&read::<Vec<Other>>(others)?, world);
    }
    match input.kind {
        Kind::Transition => {
            let out = transition
                .and_then(|t| t.get("out"))
                .ok_or_else(|| bad("no transition record is before it"))?;
            let result = read::<Result>(out)?.result(world);
            entity.take_transit(&result, input.quantum, world);
        }
        Kind::Failed => entity.keep_place(wanted, CommitKind::Failed, world),
        Kind::Still => entity.keep_place(wanted, CommitKind::Still, world),
        Kind::NoSpheres => entity.keep_place(wanted, CommitKind::NoSpheres, world),
    }
    let new = cell_of(entity, world);
    let change = (old != new).then_some([Hex(old.0), Hex(new.0)]);
    write(&Output::of(entity, change))
}

fn cell_of(entity: &Entity, world: &World) -> CellId {
    let cell = entity.body.cell;
    cell.map_or(CellId::NONE, |cell| world.cell_id(cell))
}

fn set_states(others: &[Other], world: &mut World) {
    for other in others {
        let entity = world
            .entity_of_guid(other.guid)
            .and_then(|id| world.entity_mut(id));
        if let Some(entity) = entity {
            entity.body.state = PhysicsState::from_bits_retain(other.state);
        }
    }
}

impl Input {
    fn apply(&self, entity: &mut Entity, world: &mut World) {
        place(entity, &self.position, world);
        entity.body.state = PhysicsState::from_bits_retain(self.state);
        let kin = &mut entity.kin;
        kin.velocity = self.velocity.into();
        kin.acceleration = self.acceleration.into();
        kin.omega = self.omega.into();
        kin.transient = TransientState::from_bits_retain(self.transient);
        kin.elasticity = self.elasticity;
        kin.colliding_with_environment = self.collided_with_environment;
        let known = std::mem::take(&mut entity.collision_table);
        let touched = world.clock.now;
        entity.collision_table = (self.collision_table.iter())
            .map(|&guid| {
                let known = known.iter().find(|record| record.guid == guid);
                known.copied().unwrap_or(CollisionRecord {
                    guid,
                    touched,
                    ethereal: false,
                })
            })
            .collect();
        if let (Some(interp), Some(interpreted)) = (entity.interp_mut(), &self.interpreted) {
            interpreted.apply(&mut interp.interpreted);
        }
    }
}

impl Result {
    fn result(&self, world: &mut World) -> TransitionResult {
        let mut cells = CellArray::default();
        for &id in &self.cell_array {
            let cell = world.visible_cell(CellId(id));
            cells.add_cell(CellId(id), cell);
        }
        let object = |&guid: &u32| world.entity_of_guid(guid).map(ObjectRef::Entity);
        let info = CollisionInfo {
            contact_plane: (&self.contact_plane).into(),
            last_known_contact_plane: (&self.last_known_contact_plane).into(),
            sliding_normal_valid: self.sliding_normal.is_some(),
            sliding_normal: normal(self.sliding_normal),
            collision_normal_valid: self.collision_normal.is_some(),
            collision_normal: normal(self.collision_normal),
            collide_object: self.collided.iter().filter_map(object).collect(),
            collided_with_environment: self.environment,
            frames_stationary_fall: self.frames_stationary_fall,
            ..CollisionInfo::default()
        };
        TransitionResult {
            valid: true,
            position: position(&self.position),
            cell: match self.cell {
                0 => None,
                id => world.visible_cell(CellId(id)),
            },
            info,
            cells,
            ..TransitionResult::default()
        }
    }
}

fn normal(spec: Option<VecSpec>) -> Vec3 {
    spec.map_or(Vec3::ZERO, |n| n.0.into())
}

impl Output {
    fn of(entity: &Entity, cell_change: Option<[Hex; 2]>) -> Self {
        let (body, kin) = (&entity.body, &entity.kin);
        let has = |bit| kin.transient.contains(bit);
        Self {
            position: position_spec(&body.position),
            velocity: kin.velocity.into(),
            acceleration: kin.acceleration.into(),
            omega: kin.omega.into(),
            state: body.state.bits(),
            transient: kin.transient.bits(),
            contact_plane: has(TransientState::CONTACT).then(|| Plane {
                n: kin.contact_plane.n.into(),
                d: kin.contact_plane.d,
                cell: kin.contact_plane_cell_id.0,
            }),
            sliding_normal: has(TransientState::SLIDING)
                .then(|| VecSpec(kin.sliding_normal.into())),
            cached_velocity: kin.cached_velocity.into(),
            cell_change,
            shadow_cells: body.shadows.iter().map(|shadow| shadow.id.0).collect(),
            collided_with_environment: kin.colliding_with_environment,
            collision_table: entity.collision_table.iter().map(|r| r.guid).collect(),
            events: events(entity),
        }
    }
}
