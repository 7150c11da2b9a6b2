//! Common shapes of stage records: numbers, ids, vectors, frames, positions, planes, and the state of the managers.

use ac_client::entity::Entity;
use ac_client::math::{CellId, Frame, Position, Quat, Vec3};
use ac_client::physics::managers::{
    ConstraintManager, InterpolationManager, PositionManager, StickyManager,
};
use ac_client::physics::transition::{CellArrayEntry, ContactPlane};
use ac_client::world::{CellHandle, World};
use serde_json::{Value, json};

/// A double; what JSON has no number for is text.
pub(super) fn double(x: f64) -> Value {
    match x {
        _ if x.is_nan() => "nan".into(),
        f64::INFINITY => "inf".into(),
        f64::NEG_INFINITY => "-inf".into(),
        _ => x.into(),
    }
}

/// An f32, widened.
pub(super) fn number(x: f32) -> Value {
    double(x.into())
}

/// An id.
pub(super) fn hex(id: u32) -> Value {
    format!("0x{id:X}").into()
}

/// Ids.
pub(super) fn hexes(ids: impl IntoIterator<Item = u32>) -> Value {
    ids.into_iter().map(hex).collect()
}

/// A vector.
pub(super) fn vector(v: Vec3) -> Value {
    v.to_array().into_iter().map(number).collect()
}

/// A vector that may be missing.
pub(super) fn optional_vector(v: Option<Vec3>) -> Value {
    v.map_or(Value::Null, vector)
}

/// `[w, x, y, z]`.
pub(super) fn rotation(q: Quat) -> Value {
    [q.w, q.x, q.y, q.z].into_iter().map(number).collect()
}

/// A frame.
pub(super) fn frame(frame: &Frame) -> Value {
    json!({"origin": vector(frame.origin), "rotation": rotation(frame.rotation())})
}

/// A place in the landblock of `cell`.
pub(super) fn place(cell: u32, frame: &Frame) -> Value {
    json!({
        "cell": hex(cell),
        "origin": vector(frame.origin),
        "rotation": rotation(frame.rotation()),
    })
}

/// A position.
pub(super) fn position(position: &Position) -> Value {
    place(position.cell.0, &position.frame)
}

/// Id of the cell object, 0 for none.
pub(super) fn cell_id(cell: Option<CellHandle>, world: &World) -> u32 {
    cell.map_or(0, |cell| world.cell_id(cell).0)
}

/// Ids of a list of cells, in order.
pub(super) fn cells(entries: &[CellArrayEntry]) -> Value {
    hexes(
        entries
            .iter()
            .map(|&CellArrayEntry { id: CellId(id), .. }| id),
    )
}

/// A plane of a transition, also where it is not valid.
pub(super) fn plane(plane: &ContactPlane) -> Value {
    json!({
        "valid": plane.valid,
        "n": vector(plane.plane.n),
        "d": number(plane.plane.d),
        "cell": hex(plane.cell_id.0),
        "water": plane.is_water,
    })
}

/// What happened since `from` events had happened.
pub(super) fn events(entity: &Entity, from: usize) -> Value {
    let new = entity.events.get(from..).unwrap_or_default();
    new.iter()
        .map(|event| Value::from(event.to_string()))
        .collect()
}

/// Animations of the nodes left, head to tail.
pub(super) fn sequence_ids(entity: &Entity) -> Value {
    let nodes = entity.part_array().map(|parts| parts.sequence.nodes());
    hexes(nodes.into_iter().flatten().map(|node| node.animation_id()))
}

/// States of interpolation, sticky and constraint, each null if it was never made.
pub(super) fn managers(entity: &Entity) -> [(&'static str, Value); 3] {
    let managers = entity.position_manager.as_deref();
    let of = |read: fn(&PositionManager) -> Option<Value>| {
        managers.and_then(read).unwrap_or(Value::Null)
    };
    [
        (
            "interpolation",
            of(|m| m.interpolation.as_ref().map(interpolation)),
        ),
        ("sticky", of(|m| m.sticky.as_ref().and_then(sticky))),
        ("constraint", of(|m| m.constraint.as_ref().map(constraint))),
    ]
}

fn interpolation(i: &InterpolationManager) -> Value {
    let queue: Value = i.queue.iter().map(|n| position(&n.position)).collect();
    json!({
        "queue": queue,
        "keep_heading": i.keep_heading,
        "frame_counter": i.frame_counter,
        "original_distance": number(i.original_distance),
        "progress_quantum": number(i.progress_quantum),
        "fails": i.node_fail_counter,
        "blip": i.blip_to.as_ref().map(position),
    })
}

/// A manager that sticks to nothing counts as none.
fn sticky(s: &StickyManager) -> Option<Value> {
    (s.target_id != 0).then(|| {
        json!({
            "target": hex(s.target_id),
            "radius": number(s.target_radius),
            "initialized": s.initialized,
            "target_position": position(&s.target_position),
            "timeout": double(s.timeout),
        })
    })
}

fn constraint(c: &ConstraintManager) -> Value {
    json!({
        "on": c.constrained,
        "start": number(c.start),
        "max": number(c.max),
        "offset": number(c.pos_offset),
    })
}
