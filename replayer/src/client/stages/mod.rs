//! Stages run alone, from recorded inputs (`spec/stage-format.md`).
//!
//! An entity is made as its scene describes it, outside the world; the record's `in` is written into it; the stage's own function runs; its
//! `out` is read off again.

mod adjust;
mod animation;
mod integrate;
mod shapes;
mod transition;

use ac_client::entity::Entity;
use ac_client::physics::body::EntityId;
use ac_golden_traces::scene::{Action, EntitySpec};
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::{SceneRun, entity};
use crate::simulation::SimulationError;

/// What identifies a record.
#[derive(Debug, serde::Deserialize)]
struct Head {
    frame: u32,
    #[serde(with = "ac_golden_traces::number::hex")]
    guid: u32,
    stage: String,
}

/// The `out` of `records[index]` as the client computes it from the record's `in`; `None` for a stage that cannot be run alone.
pub(super) fn run(
    run: &mut SceneRun,
    records: &[Value],
    index: usize,
) -> Result<Option<Value>, SimulationError> {
    let record = records.get(index).ok_or_else(|| bad("there is none"))?;
    let head: Head = read(record)?;
    let input = record.get("in").ok_or_else(|| bad("it has no `in`"))?;
    let out = match head.stage.as_str() {
        "integrate" => integrate::run(&read(input)?, &run.world.profile),
        "animation" => animation::run(run, &read(input)?)?,
        "adjust" => {
            let spec = spec_of(run, head.frame, head.guid)?;
            adjust::run(run, &spec, &read(input)?)?
        }
        "transition" => transition::run(run, &head, &read(input)?)?,
        _ => return Ok(None),
    };
    Ok(Some(out))
}

fn bad(reason: impl Into<String>) -> SimulationError {
    SimulationError::Stage {
        reason: reason.into(),
    }
}

fn read<T: DeserializeOwned>(value: &Value) -> Result<T, SimulationError> {
    T::deserialize(value).map_err(|error| bad(error.to_string()))
}

fn write<T: serde::Serialize>(out: &T) -> Result<Value, SimulationError> {
    serde_json::to_value(out).map_err(|error| bad(error.to_string()))
}

/// How the scene describes an entity in a frame.
fn spec_of(run: &SceneRun, frame: u32, guid: u32) -> Result<EntitySpec, SimulationError> {
    let scene = run.scene();
    let created = scene.script.iter().take_while(|step| step.frame <= frame);
    let created = created.filter_map(|step| match &step.action {
        Action::Create { entity } => Some(entity),
        _ => None,
    });
    created
        .filter(|spec| spec.guid == guid)
        .last()
        .or_else(|| scene.entities.iter().find(|spec| spec.guid == guid))
        .copied()
        .ok_or_else(|| bad(format!("the scene has no entity {guid:#X}")))
}

/// Makes an entity outside the world and object table, lends it to `stage`, and ends its existence.
fn with_stand_in<R>(
    run: &mut SceneRun,
    spec: &EntitySpec,
    stage: impl FnOnce(&mut Entity, &mut ac_client::world::World) -> R,
) -> Result<R, SimulationError> {
    let world = &mut run.world;
    let id: EntityId = world
        .make_object(spec.setup, spec.guid, true)
        .map_err(|error| bad(error.to_string()))?;
    entity::attach_weenie(id, spec, world);
    let result = world.with_entity(id, |entity, world| {
        if spec.motion_table != 0 {
            entity.set_motion_table(spec.motion_table, world);
        }
        entity.set_scale_static(spec.scale);
        stage(entity, world)
    });
    world.entities.remove(id);
    result.ok_or_else(|| bad("the entity is busy"))
}
