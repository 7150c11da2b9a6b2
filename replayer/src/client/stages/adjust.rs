//! Stage `adjust`: interpolation, sticky, constraint.

use ac_client::entity::Entity;
use ac_client::math::Vec3;
use ac_client::physics::managers::{
    ConstraintManager, Follow, InterpolationManager, InterpolationNode, NodeKind, PositionManager,
    StickyManager, StickyPull,
};
use ac_client::physics::state::TransientState;
use ac_client::profile::Profile;
use ac_golden_traces::number;
use ac_golden_traces::scene::{EntitySpec, OffsetSpec, PositionSpec};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::super::entity::position;
use super::shapes::{frame, frame_spec, position_spec};
use super::{SceneRun, with_stand_in};
use crate::simulation::SimulationError;

#[derive(Debug, Deserialize, Serialize)]
struct Interpolation {
    queue: Vec<PositionSpec>,
    keep_heading: bool,
    frame_counter: u32,
    #[serde(with = "number::f32")]
    original_distance: f32,
    #[serde(with = "number::f32")]
    progress_quantum: f32,
    fails: u32,
    blip: Option<PositionSpec>,
}

#[derive(Debug, Deserialize, Serialize)]
struct Sticky {
    #[serde(with = "number::hex")]
    target: u32,
    #[serde(with = "number::f32")]
    radius: f32,
    initialized: bool,
    target_position: PositionSpec,
    timeout: f64,
}

#[derive(Debug, Deserialize, Serialize)]
struct Constraint {
    on: bool,
    #[serde(with = "number::f32")]
    start: f32,
    #[serde(with = "number::f32")]
    max: f32,
    #[serde(with = "number::f32")]
    offset: f32,
}

#[derive(Debug, Deserialize)]
pub(super) struct Input {
    #[serde(with = "number::f32")]
    quantum: f32,
    offset: OffsetSpec,
    position: PositionSpec,
    #[serde(with = "number::hex")]
    transient: u32,
    #[serde(with = "number::f32")]
    speed_rate: f32,
    interpolation: Option<Interpolation>,
    sticky: Option<Sticky>,
    constraint: Option<Constraint>,
    target_now: Option<PositionSpec>,
}

#[derive(Debug, Serialize)]
struct Output {
    offset: OffsetSpec,
    acted: Vec<&'static str>,
    interpolation: Option<Interpolation>,
    sticky: Option<Sticky>,
    constraint: Option<Constraint>,
}

pub(super) fn run(
    run: &mut SceneRun,
    spec: &EntitySpec,
    input: &Input,
) -> Result<Value, SimulationError> {
    let run_rate = spec.run_rate;
    let out = with_stand_in(run, spec, |entity, world| {
        adjust(entity, input, run_rate, &world.profile)
    })?;
    super::write(&out)
}

fn adjust(entity: &Entity, input: &Input, run_rate: f32, profile: &Profile) -> Output {
    let own = position(&input.position);
    let contact =
        TransientState::from_bits_retain(input.transient).contains(TransientState::CONTACT);
    let mut managers = managers(input);
    let mut offset = frame(&input.offset);
    let mut acted = Vec::new();
    let sticky = managers.sticky_target() != 0;
    if let Some(interpolation) = &mut managers.interpolation {
        let object = Follow {
            position: &own,
            contact,
            sticky,
            max_speed: input.speed_rate,
            quantum: input.quantum,
        };
        if interpolation.adjust_offset(&mut offset, &object, profile) {
            acted.push("interpolation");
        }
    }
    if let Some(sticky) = &managers.sticky {
        let target_now = input.target_now.as_ref().map(position);
        let object = StickyPull {
            position: &own,
            radius: entity.radius(),
            target_now: target_now.as_ref(),
            max_speed: 4.0 * run_rate,
            quantum: input.quantum,
        };
        if sticky.adjust_offset(&mut offset, &object, profile) {
            acted.push("sticky");
        }
    }
    if let Some(constraint) = &mut managers.constraint
        && constraint.adjust_offset(&mut offset, contact, profile)
    {
        acted.push("constraint");
    }
    Output {
        offset: frame_spec(&offset),
        acted,
        interpolation: managers.interpolation.as_ref().map(interpolation_spec),
        sticky: managers.sticky.as_ref().map(sticky_spec),
        constraint: managers.constraint.as_ref().map(constraint_spec),
    }
}

fn managers(input: &Input) -> PositionManager {
    PositionManager {
        interpolation: input.interpolation.as_ref().map(|i| InterpolationManager {
            queue: i.queue.iter().map(node).collect(),
            keep_heading: i.keep_heading,
            frame_counter: i.frame_counter,
            original_distance: i.original_distance,
            progress_quantum: i.progress_quantum,
            node_fail_counter: i.fails,
            blip_to: i.blip.as_ref().map(position),
            broken: false,
        }),
        sticky: input.sticky.as_ref().map(|s| StickyManager {
            target_id: s.target,
            target_radius: s.radius,
            target_position: position(&s.target_position),
            initialized: s.initialized,
            timeout: s.timeout,
        }),
        constraint: input.constraint.as_ref().map(|c| ConstraintManager {
            constrained: c.on,
            pos_offset: c.offset,
            start: c.start,
            max: c.max,
        }),
    }
}

fn node(spec: &PositionSpec) -> InterpolationNode {
    InterpolationNode {
        kind: NodeKind::Position,
        position: position(spec),
        velocity: Vec3::ZERO,
    }
}

fn interpolation_spec(i: &InterpolationManager) -> Interpolation {
    Interpolation {
        queue: i.queue.iter().map(|n| position_spec(&n.position)).collect(),
        keep_heading: i.keep_heading,
        frame_counter: i.frame_counter,
        original_distance: i.original_distance,
        progress_quantum: i.progress_quantum,
        fails: i.node_fail_counter,
        blip: i.blip_to.as_ref().map(position_spec),
    }
}

fn sticky_spec(s: &StickyManager) -> Sticky {
    Sticky {
        target: s.target_id,
        radius: s.target_radius,
        initialized: s.initialized,
        target_position: position_spec(&s.target_position),
        timeout: s.timeout,
    }
}

fn constraint_spec(c: &ConstraintManager) -> Constraint {
    Constraint {
        on: c.constrained,
        start: c.start,
        max: c.max,
        offset: c.pos_offset,
    }
}
