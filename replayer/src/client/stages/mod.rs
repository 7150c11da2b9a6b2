//! Stages run alone, from recorded inputs (`spec/stage-format.md`).
//!
//! The record's `in` is written into an entity, the stage's own function runs, and its `out` is read off again. The first four stages need
//! nothing but the record: their entity is made as the scene describes it. `hooks`, `commit` and `motion` also depend on state that is not
//! recorded; it comes from the scene as it runs beside the records ([`companion`]), and what is recorded is written over it.

mod adjust;
mod animation;
mod commit;
mod companion;
mod hooks;
mod integrate;
mod motion;
mod motion_state;
mod shapes;
mod transition;

use ac_client::entity::Entity;
use ac_client::frame::probe::TickStage;
use ac_client::physics::body::EntityId;
use ac_golden_traces::scene::{Action, EntitySpec};
use serde::de::DeserializeOwned;
use serde_json::Value;

pub(super) use companion::Companion;

use super::{SceneRun, entity};
use crate::simulation::SimulationError;

/// What identifies a record.
#[derive(Debug, serde::Deserialize)]
struct Head {
    frame: u32,
    #[serde(with = "ac_golden_traces::number::hex")]
    guid: u32,
    quantum: usize,
    stage: String,
}

/// The `out` of `records[index]` as the client computes it from the record's `in`; `None` for an unknown stage, and where the
/// scene beside the records has not come by the stage.
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
        "animation" => animation::run(run, input)?,
        "adjust" => {
            let spec = spec_of(run, head.frame, head.guid)?;
            adjust::run(run, &spec, input)?
        }
        "transition" => transition::run(run, &head, &read(input)?)?,
        "hooks" | "commit" | "motion" => return beside(run, &head, input, &records[..index]),
        _ => return Ok(None),
    };
    Ok(Some(out))
}

/// Runs a stage that depends on what is not recorded. `earlier` are the records of the frame before this one.
fn beside(
    run: &mut SceneRun,
    head: &Head,
    input: &Value,
    earlier: &[Value],
) -> Result<Option<Value>, SimulationError> {
    let before = |stage: &str| {
        let same = |record: &&Value| {
            read::<Head>(record).is_ok_and(|other| {
                (other.guid, other.quantum, other.stage.as_str())
                    == (head.guid, head.quantum, stage)
            })
        };
        earlier.iter().rev().find(same)
    };
    let animation = before("animation").and_then(|record| record.get("out"));
    let stage = match head.stage.as_str() {
        "hooks" => TickStage::Hooks,
        "commit" => TickStage::Commit,
        _ => TickStage::Motion,
    };
    let companion = run.companion(head.frame)?;
    let out = companion.at(
        (stage, head.guid, head.quantum),
        |entity, world| match stage {
            TickStage::Hooks => hooks::run(entity, world, input, animation),
            TickStage::Commit => commit::run(entity, world, &read(input)?, before("transition")),
            _ => {
                // Hooks, landing and leaving the ground change what is played.
                let untouched = before("hooks").is_none() && before("commit").is_none_or(is_calm);
                motion::run(entity, world, input, animation.filter(|_| untouched))
            }
        },
    );
    out.transpose()
}

/// Whether nothing happened in a stage.
fn is_calm(record: &Value) -> bool {
    let events = record.pointer("/out/events").and_then(Value::as_array);
    events.is_some_and(Vec::is_empty)
}

/// Adds an entity's motion state to an output.
fn with_motion(mut output: Value, entity: &Entity) -> Result<Value, SimulationError> {
    let motion = write(&motion_state::MotionSide::of(entity))?;
    if let (Value::Object(output), Value::Object(motion)) = (&mut output, motion) {
        output.extend(motion);
    }
    Ok(output)
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
