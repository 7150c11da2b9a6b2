//! The stage `animation` alone: a record names everything it needs.

use ac_client::animation::{AnimHookQueue, AnimSequenceNode, AnimationSource, Sequence};
use ac_client::math::Frame;
use ac_client::physics::state::TransientState;
use ac_client::world::World;
use ac_golden_traces::number;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::StageError;
use super::json::{FrameJson, Hex, Vector};

const STAGE: &str = "animation";

#[derive(Deserialize)]
struct Input {
    #[serde(with = "number::f32")]
    quantum: f32,
    #[serde(with = "number::f32")]
    scale: f32,
    transient: Hex,
    #[serde(flatten)]
    sequence: SequenceJson,
}

/// A playing list.
#[derive(Deserialize, Serialize)]
struct SequenceJson {
    sequence: Vec<NodeJson>,
    current: i64,
    first_cyclic: i64,
    frame_number: f64,
    velocity: Vector,
    omega: Vector,
}

#[derive(Deserialize, Serialize)]
struct NodeJson {
    anim: Hex,
    low: i32,
    high: i32,
    #[serde(with = "number::f32")]
    framerate: f32,
}

#[derive(Serialize)]
struct Output {
    offset: FrameJson,
    #[serde(flatten)]
    sequence: SequenceJson,
    hooks: Vec<u32>,
}

/// Advances the sequence of a record's `input` and answers the record's `out`. The world gives the animations; no entity is looked at.
///
/// # Errors
/// See [`StageError`].
pub fn run_animation_stage(world: &mut World, input: &Value) -> Result<Value, StageError> {
    let input = Input::deserialize(input).map_err(|e| StageError::malformed(STAGE, "in", &e))?;
    let mut sequence = input.sequence.load(world)?;
    let mut offset = Frame::IDENTITY;
    let mut hooks = AnimHookQueue::new();
    let quantum = f64::from(input.quantum);
    sequence
        .update(quantum, Some(&mut offset), &mut hooks, &world.profile)
        .map_err(|e| StageError::malformed(STAGE, "in.sequence", &e))?;
    let walks =
        TransientState::from_bits_retain(input.transient.0).contains(TransientState::ON_WALKABLE);
    offset.origin *= if walks { input.scale } else { 0.0 };
    let output = Output {
        offset: (&offset).into(),
        sequence: (&sequence).into(),
        hooks: hooks.iter().map(|hook| hook.kind()).collect(),
    };
    serde_json::to_value(output).map_err(|e| StageError::malformed(STAGE, "out", &e))
}

impl SequenceJson {
    fn load(&self, world: &mut World) -> Result<Sequence, StageError> {
        let nodes: Result<Vec<_>, _> = self.sequence.iter().map(|n| n.load(world)).collect();
        Ok(Sequence::from_state(
            nodes?,
            usize::try_from(self.current).ok(),
            self.frame_number,
            self.velocity.into(),
            self.omega.into(),
        ))
    }
}

impl NodeJson {
    fn load(&self, world: &mut World) -> Result<AnimSequenceNode, StageError> {
        let animation = world.resources.animation(self.anim.0);
        let animation = animation.ok_or(StageError::NoSuchAnimation {
            stage: STAGE,
            animation: self.anim.0,
        })?;
        Ok(AnimSequenceNode::from_state(
            animation,
            self.low,
            self.high,
            self.framerate,
        ))
    }
}

impl From<&Sequence> for SequenceJson {
    fn from(s: &Sequence) -> Self {
        let index = |i: Option<usize>| i.map_or(-1, |i| i as i64);
        let node = |n: &AnimSequenceNode| NodeJson {
            anim: Hex(n.animation_id()),
            low: n.low,
            high: n.high,
            framerate: n.rate,
        };
        Self {
            sequence: s.nodes().map(node).collect(),
            current: index(s.current_index()),
            first_cyclic: index(s.first_cyclic_index()),
            frame_number: s.frame_number(),
            velocity: s.velocity.into(),
            omega: s.omega.into(),
        }
    }
}
