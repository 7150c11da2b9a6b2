//! Stage `motion`: targets, move-to, completed motions, position managers. The motion state is also part of other stages.

use ac_client::animation::{MotionEntry, MotionTableManager};
use ac_client::entity::Entity;
use ac_client::frame::StageView;
use ac_client::math::Position;
use ac_client::motion::{MotionInterp, MoveToManager, MoveToNode, MovementParameters};
use serde_json::{Value, json};

use super::shapes::{double, events, hex, hexes, managers, number, position, sequence_ids, vector};

pub(super) fn input(view: &StageView<'_>) -> Value {
    let (entity, clock) = (view.entity, &view.world.clock);
    let mut record = json!({
        "quantum": number(view.quantum),
        "now": double(clock.now),
        "sim_time": double(clock.sim_time),
    });
    put_motion(entity, &mut record);
    for (name, state) in managers(entity) {
        record[name] = state;
    }
    record["cached_velocity"] = vector(entity.kin.cached_velocity);
    record
}

pub(super) fn output(view: &StageView<'_>, events_before: usize) -> Value {
    let mut record = json!({});
    put_motion(view.entity, &mut record);
    record["sequence"] = sequence_ids(view.entity);
    record["events"] = events(view.entity, events_before);
    record
}

/// The fields of the motion state.
pub(super) fn put_motion(entity: &Entity, record: &mut Value) {
    let interp = entity.interp();
    let table = entity.part_array().and_then(|p| p.motion_table.as_ref());
    record["position"] = position(&entity.body.position);
    record["velocity"] = vector(entity.kin.velocity);
    record["transient"] = hex(entity.kin.transient.bits());
    record["interpreted"] = interpreted(interp);
    record["pending"] = interp.map_or(Value::Null, |interp| {
        hexes(interp.pending.iter().map(|motion| motion.command.0))
    });
    record["table"] = table.map_or(Value::Null, table_state);
    let active = entity.move_to().filter(|m| m.is_active());
    record["move_to_type"] = active.map_or(0, |m| m.kind as u8).into();
    if let Some(manager) = active {
        record["move_to"] = move_to(manager);
    }
}

/// The interpreted motion state, null without an interpreter.
pub(super) fn interpreted(interp: Option<&MotionInterp>) -> Value {
    let Some(state) = interp.map(|interp| &interp.interpreted) else {
        return Value::Null;
    };
    json!({
        "style": hex(state.style.0),
        "forward": hex(state.forward_command.0),
        "forward_speed": number(state.forward_speed),
        "sidestep": hex(state.sidestep_command.0),
        "sidestep_speed": number(state.sidestep_speed),
        "turn": hex(state.turn_command.0),
        "turn_speed": number(state.turn_speed),
        "actions": hexes(state.actions.iter().map(|action| action.command.0)),
    })
}

fn table_state(table: &MotionTableManager) -> Value {
    let state = &table.state;
    let entry = |m: &MotionEntry| json!([hex(m.motion), number(m.speed)]);
    let modifiers: Value = state.modifiers.iter().map(entry).collect();
    let queue: Value = (table.pending())
        .map(|motion| json!([hex(motion.motion), motion.animations]))
        .collect();
    json!({
        "style": hex(state.style),
        "substate": hex(state.substate),
        "substate_speed": number(state.substate_speed),
        "modifiers": modifiers,
        "actions": hexes(state.actions.iter().map(|m| m.motion)),
        "queue": queue,
        "counter": table.animation_counter,
    })
}

fn move_to(m: &MoveToManager) -> Value {
    let node = |node: &MoveToNode| match *node {
        MoveToNode::Move => json!(["move", 0]),
        MoveToNode::Turn(heading) => json!(["turn", number(heading)]),
    };
    let nodes: Value = m.nodes.iter().map(node).collect();
    let start = Some(&m.starting_position).filter(|at| **at != Position::default());
    json!({
        "nodes": nodes,
        "command": hex(m.current_command.0),
        "aux_command": hex(m.aux_command.0),
        "moving_away": m.moving_away,
        "initialized": m.initialized,
        "fail_count": m.fail_progress_count,
        "previous_heading": number(m.previous_heading),
        "previous_distance": number(m.previous.distance),
        "original_distance": number(m.original.distance),
        "previous_time": double(m.previous.time),
        "original_time": double(m.original.time),
        "target": hex(m.top_level_object_id),
        "target_position": position(&m.current_target_position),
        "sought": position(&m.sought_position),
        "start": start.map(position),
        "params": params(&m.params),
    })
}

fn params(p: &MovementParameters) -> Value {
    json!({
        "bitfield": hex(p.flags.bits()),
        "distance_to_object": number(p.distance_to_object),
        "min_distance": number(p.min_distance),
        "desired_heading": number(p.desired_heading),
        "speed": number(p.speed),
        "fail_distance": number(p.fail_distance),
        "walk_run_threshold": number(p.walk_run_threshold),
        "hold_key": p.hold_key.code(),
    })
}
