//! Common shapes of stage records.

use ac_client::entity::Entity;
use ac_client::math::{CellId, Frame, Position, Vec3};
use ac_golden_traces::number;
use ac_golden_traces::scene::{OffsetSpec, PositionSpec};
use serde::{Deserialize, Serialize};

use super::super::entity;

/// A vector that may be null: `Option<VecSpec>`.
#[derive(Debug, Clone, Copy, Deserialize, Serialize)]
#[serde(transparent)]
pub(super) struct VecSpec(#[serde(with = "number::floats")] pub [f32; 3]);

/// An id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(transparent)]
pub(super) struct Hex(#[serde(with = "number::hex")] pub u32);

/// Events since they were last cleared, as records have them.
pub(super) fn events(entity: &Entity) -> Vec<String> {
    entity.events.iter().map(ToString::to_string).collect()
}

/// Animations being played, as records have them.
pub(super) fn sequence(entity: &Entity) -> Vec<u32> {
    let nodes = entity.part_array().map(|parts| parts.sequence.nodes());
    nodes.map_or_else(Vec::new, |nodes| nodes.map(|n| n.animation_id()).collect())
}

/// A frame.
pub(super) fn frame(spec: &OffsetSpec) -> Frame {
    Frame::new(Vec3::from(spec.origin), entity::quat(spec.rotation))
}

/// A frame, as records have it.
pub(super) fn frame_spec(frame: &Frame) -> OffsetSpec {
    let q = frame.rotation();
    OffsetSpec {
        origin: frame.origin.into(),
        rotation: [q.w, q.x, q.y, q.z],
    }
}

/// A position, as records have it.
pub(super) fn position_spec(position: &Position) -> PositionSpec {
    let OffsetSpec { origin, rotation } = frame_spec(&position.frame);
    let CellId(cell) = position.cell;
    PositionSpec {
        cell,
        origin,
        rotation,
    }
}
