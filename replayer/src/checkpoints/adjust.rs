//! Stage `adjust`: interpolation, sticky, constraint.

use ac_client::entity::Entity;
use ac_client::frame::{StageData, StageView};
use ac_client::motion::MotionInterp;
use ac_client::physics::managers::StickyManager;
use ac_client::physics::state::TransientState;
use ac_client::world::World;
use serde_json::{Value, json};

use super::shapes::{frame, hex, managers, number, position};

pub(super) fn input(view: &StageView<'_>) -> Value {
    let (entity, world) = (view.entity, view.world);
    let mut record = json!({
        "quantum": number(view.quantum),
        "offset": offset(view),
        "position": position(&entity.body.position),
        "transient": hex(entity.kin.transient.bits()),
        "speed_rate": number(speed_rate(entity, world)),
    });
    put_managers(entity, &mut record);
    record["target_now"] = target_now(entity, world);
    record
}

pub(super) fn output(view: &StageView<'_>, acted: &[&'static str]) -> Value {
    let mut record = json!({"offset": offset(view), "acted": acted});
    put_managers(view.entity, &mut record);
    record
}

/// Which managers are going to act, in order.
pub(super) fn acting(entity: &Entity) -> Vec<&'static str> {
    let mut acting = Vec::new();
    let Some(managers) = &entity.position_manager else {
        return acting;
    };
    let contact = entity.kin.transient.contains(TransientState::CONTACT);
    let follows = |queued: bool| contact && queued;
    if (managers.interpolation.as_ref()).is_some_and(|i| follows(!i.queue.is_empty())) {
        acting.push("interpolation");
    }
    if managers.sticky.as_ref().is_some_and(|s| s.is_pulling()) {
        acting.push("sticky");
    }
    if managers.constraint.as_ref().is_some_and(|c| c.constrained) {
        acting.push("constraint");
    }
    acting
}

fn offset(view: &StageView<'_>) -> Value {
    match view.data {
        StageData::Offset(offset) => frame(offset),
        _ => Value::Null,
    }
}

fn put_managers(entity: &Entity, record: &mut Value) {
    for (name, state) in managers(entity) {
        record[name] = state;
    }
}

/// What the interpolation manager would be told. Asking it makes an interpreter; looking must not.
fn speed_rate(entity: &Entity, world: &World) -> f32 {
    let mover = entity.mover(world);
    match entity.interp() {
        Some(interp) => interp.adjusted_max_speed(&mover),
        None => MotionInterp::default().adjusted_max_speed(&mover),
    }
}

fn target_now(entity: &Entity, world: &World) -> Value {
    let managers = entity.position_manager.as_ref();
    let target = managers
        .and_then(|m| m.sticky.as_ref())
        .map_or(0, |s: &StickyManager| s.target_id);
    if target == 0 {
        return Value::Null;
    }
    if target == entity.guid() {
        return position(&entity.body.position);
    }
    let id = world.entity_of_guid(target);
    id.and_then(|id| world.entity(id))
        .map_or(Value::Null, |e| position(&e.body.position))
}
