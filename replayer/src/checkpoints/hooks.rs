//! Stage `hooks`: the hooks of the frames crossed.

use ac_client::dat::HookAction;
use ac_client::entity::Entity;
use ac_client::frame::StageView;
use serde_json::{Value, json};

use super::motion::put_motion;
use super::shapes::{events, hex, sequence_ids, vector};

pub(super) fn input(view: &StageView<'_>) -> Value {
    let entity = view.entity;
    let queued = entity.part_array().map(|parts| &parts.hooks[..]);
    let hooks: Value = queued.unwrap_or_default().iter().map(hook).collect();
    let mut record = json!({"hooks": hooks});
    put_state(entity, &mut record);
    put_motion(entity, &mut record);
    record
}

pub(super) fn output(view: &StageView<'_>, events_before: usize) -> Value {
    let mut record = json!({});
    put_state(view.entity, &mut record);
    record["sequence"] = sequence_ids(view.entity);
    record["events"] = events(view.entity, events_before);
    put_motion(view.entity, &mut record);
    record
}

fn put_state(entity: &Entity, record: &mut Value) {
    record["omega"] = vector(entity.kin.omega);
    record["state"] = hex(entity.body.state.bits());
}

/// A hook; with its fields if the tick acts on them.
fn hook(hook: &HookAction) -> Value {
    let mut record = json!({"type": hook.kind()});
    match *hook {
        HookAction::Ethereal { value } => record["fields"] = json!({"value": value}),
        HookAction::NoDraw { value } => record["fields"] = json!({"value": value}),
        HookAction::SetOmega { axis } => record["fields"] = json!({"axis": vector(axis)}),
        _ => {}
    }
    record
}
