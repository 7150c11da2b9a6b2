//! Stage `animation`: root motion and the hooks of the frames crossed.

use ac_client::animation::{AnimSequenceNode, AnimationSource, Sequence};
use ac_client::math::{Frame, Vec3};
use ac_client::physics::state::TransientState;
use ac_golden_traces::number;
use ac_golden_traces::scene::OffsetSpec;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::shapes::frame_spec;
use super::{SceneRun, bad};
use crate::simulation::SimulationError;

#[derive(Debug, Deserialize, Serialize)]
struct Node {
    #[serde(with = "number::hex")]
    anim: u32,
    low: i32,
    high: i32,
    #[serde(with = "number::f32")]
    framerate: f32,
}

#[derive(Debug, Deserialize)]
pub(super) struct Input {
    #[serde(with = "number::f32")]
    quantum: f32,
    #[serde(with = "number::f32")]
    scale: f32,
    #[serde(with = "number::hex")]
    transient: u32,
    sequence: Vec<Node>,
    current: i64,
    frame_number: f64,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    #[serde(with = "number::floats")]
    omega: [f32; 3],
}

#[derive(Debug, Serialize)]
struct Output {
    offset: OffsetSpec,
    sequence: Vec<Node>,
    current: i64,
    first_cyclic: i64,
    frame_number: f64,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    #[serde(with = "number::floats")]
    omega: [f32; 3],
    hooks: Vec<u32>,
}

pub(super) fn run(run: &mut SceneRun, input: &Input) -> Result<Value, SimulationError> {
    let world = &mut run.world;
    let mut nodes = Vec::with_capacity(input.sequence.len());
    for node in &input.sequence {
        let animation = world
            .resources
            .animation(node.anim)
            .ok_or_else(|| bad(format!("animation {:#X} does not exist", node.anim)))?;
        let node = AnimSequenceNode::from_state(animation, node.low, node.high, node.framerate);
        nodes.push(node);
    }
    let mut sequence = Sequence::from_state(
        nodes,
        usize::try_from(input.current).ok(),
        input.frame_number,
        Vec3::from(input.velocity),
        Vec3::from(input.omega),
    );
    let mut offset = Frame::IDENTITY;
    let mut hooks = Vec::new();
    sequence
        .update(
            f64::from(input.quantum),
            Some(&mut offset),
            &mut hooks,
            &world.profile,
        )
        .map_err(|error| bad(error.to_string()))?;
    let walks =
        TransientState::from_bits_retain(input.transient).contains(TransientState::ON_WALKABLE);
    offset.origin *= if walks { input.scale } else { 0.0 };
    super::write(&Output {
        offset: frame_spec(&offset),
        sequence: sequence.nodes().map(node).collect(),
        current: index(sequence.current_index()),
        first_cyclic: index(sequence.first_cyclic_index()),
        frame_number: sequence.frame_number(),
        velocity: sequence.velocity.into(),
        omega: sequence.omega.into(),
        hooks: hooks.iter().map(|hook| hook.kind()).collect(),
    })
}

fn node(node: &AnimSequenceNode) -> Node {
    Node {
        anim: node.animation_id(),
        low: node.low,
        high: node.high,
        framerate: node.rate,
    }
}

fn index(index: Option<usize>) -> i64 {
    index.and_then(|i| i64::try_from(i).ok()).unwrap_or(-1)
}
