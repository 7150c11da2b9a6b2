//! The stage `adjust` alone: interpolation, sticking and the constraint.

use ac_client::math::{Frame, Position};
use ac_client::physics::managers::{
    ConstraintManager, Follow, InterpolationManager, InterpolationNode, NodeKind, StickyManager,
    StickyPull,
};
use ac_client::physics::state::TransientState;
use ac_client::world::World;
use ac_golden_traces::number;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::StageError;
use super::json::{FrameJson, Hex, PositionJson};

const STAGE: &str = "adjust";

#[derive(Deserialize)]
struct Input {
    #[serde(with = "number::f32")]
    quantum: f32,
    offset: FrameJson,
    position: PositionJson,
    transient: Hex,
    #[serde(with = "number::f32")]
    speed_rate: f32,
    #[serde(flatten)]
    managers: Managers,
    target_now: Option<PositionJson>,
}

#[derive(Deserialize, Serialize)]
struct Managers {
    interpolation: Option<InterpolationJson>,
    sticky: Option<StickyJson>,
    constraint: Option<ConstraintJson>,
}

#[derive(Deserialize, Serialize)]
struct InterpolationJson {
    queue: Vec<PositionJson>,
    keep_heading: bool,
    frame_counter: u32,
    #[serde(with = "number::f32")]
    original_distance: f32,
    #[serde(with = "number::f32")]
    progress_quantum: f32,
    fails: u32,
    blip: Option<PositionJson>,
}

#[derive(Deserialize, Serialize)]
struct StickyJson {
    target: Hex,
    #[serde(with = "number::f32")]
    radius: f32,
    initialized: bool,
    target_position: Option<PositionJson>,
    timeout: f64,
}

#[derive(Deserialize, Serialize)]
struct ConstraintJson {
    on: bool,
    #[serde(with = "number::f32")]
    start: f32,
    #[serde(with = "number::f32")]
    max: f32,
    #[serde(with = "number::f32")]
    offset: f32,
}

#[derive(Serialize)]
struct Output {
    offset: FrameJson,
    acted: Vec<&'static str>,
    #[serde(flatten)]
    managers: Managers,
}

/// Adjusts the offset of a record's `input` and answers the record's `out`. Of entity `guid` only the radius is taken.
///
/// # Errors
/// See [`StageError`].
pub fn run_adjust_stage(world: &mut World, guid: u32, input: &Value) -> Result<Value, StageError> {
    let input = Input::deserialize(input).map_err(|e| StageError::malformed(STAGE, "in", &e))?;
    let radius = world
        .entity_of_guid(guid)
        .and_then(|id| world.entity(id))
        .map(|entity| entity.radius())
        .ok_or(StageError::NoSuchEntity { stage: STAGE, guid })?;
    let output = input.run(radius, world);
    serde_json::to_value(output).map_err(|e| StageError::malformed(STAGE, "out", &e))
}

impl Input {
    fn run(self, radius: f32, world: &World) -> Output {
        let profile = &world.profile;
        let mut offset = Frame::from(&self.offset);
        let position = Position::from(self.position);
        let contact =
            TransientState::from_bits_retain(self.transient.0).contains(TransientState::CONTACT);
        let mut interpolation = self.managers.interpolation.map(InterpolationManager::from);
        let sticky = self.managers.sticky.as_ref().map(StickyManager::from);
        let mut constraint = self.managers.constraint.map(ConstraintManager::from);
        let mut acted = Vec::new();
        let follow = Follow {
            position: &position,
            contact,
            sticky: sticky.is_some_and(|s| s.target_id != 0),
            max_speed: self.speed_rate,
            quantum: self.quantum,
        };
        if let Some(manager) = &mut interpolation
            && manager.adjust_offset(&mut offset, &follow, profile)
        {
            acted.push("interpolation");
        }
        let target_now = self.target_now.map(Position::from);
        let pull = StickyPull {
            position: &position,
            radius,
            target_now: target_now.as_ref(),
            max_speed: self.speed_rate,
            quantum: self.quantum,
        };
        if sticky.is_some_and(|s| s.adjust_offset(&mut offset, &pull, profile)) {
            acted.push("sticky");
        }
        if let Some(manager) = &mut constraint
            && manager.adjust_offset(&mut offset, contact, profile)
        {
            acted.push("constraint");
        }
        Output {
            offset: (&offset).into(),
            acted,
            managers: Managers {
                interpolation: interpolation.as_ref().map(Into::into),
                sticky: self.managers.sticky,
                constraint: constraint.as_ref().map(Into::into),
            },
        }
    }
}

impl From<InterpolationJson> for InterpolationManager {
    fn from(j: InterpolationJson) -> Self {
        let node = |p: PositionJson| InterpolationNode {
            kind: NodeKind::Position,
            position: p.into(),
            velocity: ac_client::math::Vec3::ZERO,
        };
        Self {
            queue: j.queue.into_iter().map(node).collect(),
            keep_heading: j.keep_heading,
            frame_counter: j.frame_counter,
            original_distance: j.original_distance,
            progress_quantum: j.progress_quantum,
            node_fail_counter: j.fails,
            blip_to: j.blip.map(Into::into),
            broken: false,
        }
    }
}

impl From<&InterpolationManager> for InterpolationJson {
    fn from(m: &InterpolationManager) -> Self {
        Self {
            queue: m.queue.iter().map(|n| (&n.position).into()).collect(),
            keep_heading: m.keep_heading,
            frame_counter: m.frame_counter,
            original_distance: m.original_distance,
            progress_quantum: m.progress_quantum,
            fails: m.node_fail_counter,
            blip: m.blip_to.as_ref().map(Into::into),
        }
    }
}

impl From<&StickyJson> for StickyManager {
    fn from(j: &StickyJson) -> Self {
        Self {
            target_id: j.target.0,
            target_radius: j.radius,
            target_position: j.target_position.map(Into::into).unwrap_or_default(),
            initialized: j.initialized,
            timeout: j.timeout,
        }
    }
}

impl From<ConstraintJson> for ConstraintManager {
    fn from(j: ConstraintJson) -> Self {
        Self {
            constrained: j.on,
            pos_offset: j.offset,
            start: j.start,
            max: j.max,
        }
    }
}

impl From<&ConstraintManager> for ConstraintJson {
    fn from(m: &ConstraintManager) -> Self {
        Self {
            on: m.constrained,
            start: m.start,
            max: m.max,
            offset: m.pos_offset,
        }
    }
}
