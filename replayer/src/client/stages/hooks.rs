//! Stage `hooks`: the hooks of the frames crossed are executed.

use ac_client::dat::HookAction;
use ac_client::entity::Entity;
use ac_client::physics::state::PhysicsState;
use ac_client::world::World;
use ac_golden_traces::number;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::animation::Played;
use super::motion_state::MotionSide;
use super::shapes::{events, sequence};
use super::{bad, read, with_motion, write};
use crate::simulation::SimulationError;

#[derive(Debug, Deserialize)]
struct Input {
    hooks: Vec<Hook>,
    #[serde(with = "number::floats")]
    omega: [f32; 3],
    #[serde(with = "number::hex")]
    state: u32,
}

#[derive(Debug, Deserialize)]
struct Hook {
    #[serde(rename = "type")]
    kind: u32,
}

#[derive(Debug, Serialize)]
struct Output {
    #[serde(with = "number::floats")]
    omega: [f32; 3],
    #[serde(with = "number::hex")]
    state: u32,
    #[serde(with = "number::hex_list")]
    sequence: Vec<u32>,
    events: Vec<String>,
}

/// Runs the hooks of a record; `animation` is the `out` of the quantum's animation, if there was one.
pub(super) fn run(
    entity: &mut Entity,
    world: &mut World,
    input: &Value,
    animation: Option<&Value>,
) -> Result<Value, SimulationError> {
    let motion: MotionSide = read(input)?;
    let input: Input = read(input)?;
    motion.apply(entity, world);
    take_sequence(entity, animation, world)?;
    entity.kin.omega = input.omega.into();
    entity.body.state = PhysicsState::from_bits_retain(input.state);
    if let Some(parts) = entity.part_array_mut() {
        parts.hooks = queue(&input.hooks, &parts.hooks)?;
    }
    entity.process_hooks(world);
    let output = write(&Output {
        omega: entity.kin.omega.into(),
        state: entity.body.state.bits(),
        sequence: sequence(entity),
        events: events(entity),
    })?;
    with_motion(output, entity)
}

/// Has the entity play what the animation left, if it is known.
pub(super) fn take_sequence(
    entity: &mut Entity,
    animation: Option<&Value>,
    world: &mut World,
) -> Result<(), SimulationError> {
    let (Some(parts), Some(out)) = (entity.part_array_mut(), animation) else {
        return Ok(());
    };
    let mut sequence = read::<Played>(out)?.sequence(world)?;
    sequence.placement = parts.sequence.placement;
    parts.sequence = sequence;
    Ok(())
}

/// The hooks of the recorded types. Records give no arguments that matter but those of a few types; they are those that wait.
fn queue(recorded: &[Hook], waiting: &[HookAction]) -> Result<Vec<HookAction>, SimulationError> {
    let hook = |(index, hook): (usize, &Hook)| {
        let same = waiting.get(index).filter(|w| w.kind() == hook.kind);
        match (same, hook.kind) {
            (Some(same), _) => Ok(*same),
            (None, 4) => Ok(HookAction::AnimationDone),
            (None, 2) => Ok(HookAction::SoundTable { sound: 0 }),
            (None, kind) => Err(bad(format!("no hook of type {kind} waits"))),
        }
    };
    recorded.iter().enumerate().map(hook).collect()
}
