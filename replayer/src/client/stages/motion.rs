//! Stage `motion`: targets, move-to, completed motions, position managers.

use ac_client::entity::Entity;
use ac_client::world::{Clock, World};
use ac_golden_traces::number;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::adjust::Managers;
use super::hooks::take_sequence;
use super::motion_state::MotionSide;
use super::shapes::{events, sequence};
use super::{read, with_motion, write};
use crate::simulation::SimulationError;

#[derive(Debug, Deserialize)]
struct Input {
    now: f64,
    sim_time: f64,
    #[serde(with = "number::floats")]
    cached_velocity: [f32; 3],
}

#[derive(Debug, Serialize)]
struct Output {
    #[serde(with = "number::hex_list")]
    sequence: Vec<u32>,
    events: Vec<String>,
}

/// Runs the managers of a record; `animation` is the `out` of the quantum's animation, if nothing has changed the sequence since.
pub(super) fn run(
    entity: &mut Entity,
    world: &mut World,
    input: &Value,
    animation: Option<&Value>,
) -> Result<Value, SimulationError> {
    let motion: MotionSide = read(input)?;
    let managers: Managers = read(input)?;
    let input: Input = read(input)?;
    world.clock = Clock {
        now: input.now,
        sim_time: input.sim_time,
    };
    motion.apply(entity, world);
    take_sequence(entity, animation, world)?;
    managers.apply(&mut entity.position_manager);
    entity.kin.cached_velocity = input.cached_velocity.into();
    entity.run_managers(world);
    let output = write(&Output {
        sequence: sequence(entity),
        events: events(entity),
    })?;
    with_motion(output, entity)
}
