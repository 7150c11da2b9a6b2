//! Common shapes of stage records.

use ac_client::math::{CellId, Frame, Position, Vec3};
use ac_golden_traces::scene::{OffsetSpec, PositionSpec};

use super::super::entity;

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
