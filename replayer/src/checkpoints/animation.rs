//! Stage `animation`: the sequence before and after, the root motion, the hooks crossed.

use ac_client::animation::Sequence;
use ac_client::entity::Entity;
use ac_client::frame::{StageData, StageView};
use serde_json::{Map, Value, json};

use super::shapes::{double, frame, hex, number, vector};

pub(super) fn input(view: &StageView<'_>) -> Value {
    let entity = view.entity;
    let mut record = json!({
        "quantum": number(view.quantum),
        "scale": number(entity.body.scale),
        "transient": hex(entity.kin.transient.bits()),
    });
    put_sequence(entity, &mut record);
    record
}

pub(super) fn output(view: &StageView<'_>, queued_before: usize) -> Value {
    let mut record = Value::Object(Map::new());
    if let StageData::Offset(offset) = view.data {
        record["offset"] = frame(offset);
    }
    put_sequence(view.entity, &mut record);
    let hooks = view.entity.part_array().map(|parts| &parts.hooks[..]);
    record["hooks"] = hooks
        .and_then(|hooks| hooks.get(queued_before..))
        .into_iter()
        .flatten()
        .map(|hook| Value::from(hook.kind()))
        .collect();
    record
}

/// Hooks that wait already.
pub(super) fn queued(entity: &Entity) -> usize {
    entity.part_array().map_or(0, |parts| parts.hooks.len())
}

fn put_sequence(entity: &Entity, record: &mut Value) {
    let empty = Sequence::new();
    let sequence = entity.part_array().map_or(&empty, |parts| &parts.sequence);
    record["sequence"] = sequence
        .nodes()
        .map(|node| {
            json!({
                "anim": hex(node.animation_id()),
                "low": node.low,
                "high": node.high,
                "framerate": number(node.rate),
            })
        })
        .collect();
    record["current"] = index(sequence.current_index());
    record["first_cyclic"] = index(sequence.first_cyclic_index());
    record["frame_number"] = double(sequence.frame_number());
    record["velocity"] = vector(sequence.velocity);
    record["omega"] = vector(sequence.omega);
}

fn index(index: Option<usize>) -> Value {
    index.map_or_else(|| Value::from(-1), Value::from)
}
