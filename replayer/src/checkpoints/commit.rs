//! Stage `commit`: cell, frame, contact, collisions, shadows.

use ac_client::entity::Entity;
use ac_client::frame::{StageData, StageView};
use ac_client::physics::state::TransientState;
use ac_client::physics::update::CommitKind;
use ac_client::world::World;
use serde_json::{Value, json};

use super::motion::interpreted;
use super::shapes::{
    cell_id, cells, events, frame, hex, hexes, number, optional_vector, place, position, vector,
};

pub(super) fn input(view: &StageView<'_>) -> Value {
    let entity = view.entity;
    let (kind, wanted) = match view.data {
        StageData::Commit { kind, frame } => (kind_name(kind), Some(frame)),
        _ => ("", None),
    };
    let mut record = json!({
        "quantum": number(view.quantum),
        "kind": kind,
        "frame": wanted.map(frame),
        "position": position(&entity.body.position),
    });
    put_kinetics(entity, &mut record);
    record["elasticity"] = number(entity.kin.elasticity);
    put_contacts(entity, &mut record);
    record["interpreted"] = interpreted(entity.interp());
    record
}

/// `cell_before` is the id of the cell object before the stage.
pub(super) fn output(view: &StageView<'_>, cell_before: u32, events_before: usize) -> Value {
    let (entity, kin) = (view.entity, &view.entity.kin);
    let cell = cell_of(entity, view.world);
    let mut record = json!({"position": place(cell, &entity.body.position.frame)});
    put_kinetics(entity, &mut record);
    let has = |bit| kin.transient.contains(bit);
    record["contact_plane"] = if has(TransientState::CONTACT) {
        json!({
            "n": vector(kin.contact_plane.n),
            "d": number(kin.contact_plane.d),
            "cell": hex(kin.contact_plane_cell_id.0),
        })
    } else {
        Value::Null
    };
    let sliding = has(TransientState::SLIDING).then_some(kin.sliding_normal);
    record["sliding_normal"] = optional_vector(sliding);
    record["cached_velocity"] = vector(kin.cached_velocity);
    record["cell_change"] = if cell == cell_before {
        Value::Null
    } else {
        hexes([cell_before, cell])
    };
    record["shadow_cells"] = cells(&entity.body.shadows);
    put_contacts(entity, &mut record);
    record["events"] = events(entity, events_before);
    record
}

/// Id of the cell that an entity is in.
pub(super) fn cell_of(entity: &Entity, world: &World) -> u32 {
    cell_id(entity.body.cell, world)
}

const fn kind_name(kind: CommitKind) -> &'static str {
    match kind {
        CommitKind::Transition => "transition",
        CommitKind::Failed => "failed",
        CommitKind::Still => "still",
        CommitKind::NoSpheres => "no-spheres",
    }
}

fn put_kinetics(entity: &Entity, record: &mut Value) {
    let kin = &entity.kin;
    record["velocity"] = vector(kin.velocity);
    record["acceleration"] = vector(kin.acceleration);
    record["omega"] = vector(kin.omega);
    record["state"] = hex(entity.body.state.bits());
    record["transient"] = hex(kin.transient.bits());
}

fn put_contacts(entity: &Entity, record: &mut Value) {
    record["collided_with_environment"] = entity.kin.colliding_with_environment.into();
    record["collision_table"] = hexes(entity.collision_table.iter().map(|c| c.guid));
}
