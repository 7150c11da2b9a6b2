//! Stage `transition`: the swept spheres, and everybody in their way.

use ac_client::entity::Entity;
use ac_client::frame::{StageData, StageView};
use ac_client::math::{Frame, Sphere};
use ac_client::physics::body::ObjectRef;
use ac_client::physics::state::PhysicsState;
use ac_client::physics::transition::{
    CollisionInfo, ObjectInfoState, Path, TransitionInput, TransitionResult,
};
use ac_client::world::World;
use serde_json::{Value, json};

use super::shapes::{
    cell_id, double, hex, hexes, number, optional_vector, plane, position, rotation, vector,
};

/// Bits that the weenie gives the mover; records leave them out.
const WEENIE_BITS: ObjectInfoState = ObjectInfoState::IS_PLAYER
    .union(ObjectInfoState::IS_IMPENETRABLE)
    .union(ObjectInfoState::IS_PK)
    .union(ObjectInfoState::IS_PK_LITE);

/// Others farther away than this, m, are left out.
const NEAR: f32 = 48.0;

pub(super) fn input(view: &StageView<'_>) -> Value {
    let StageData::Transition { input, transit, .. } = view.data else {
        return Value::Null;
    };
    let world = view.world;
    let Path::Move { begin, end } = input.path else {
        return Value::Null;
    };
    let mut record = json!({
        "begin": position(&begin),
        "begin_cell": hex(cell_id(input.begin_cell, world)),
        "end": position(&end),
    });
    put_mover(input, &mut record);
    put_contact(&world.transition_start(transit, input), &mut record);
    record["velocity"] = vector(view.entity.kin.velocity);
    record["others"] = others(view.entity, world);
    record
}

pub(super) fn output(view: &StageView<'_>) -> Value {
    let StageData::Transition {
        result: Some(result),
        ..
    } = view.data
    else {
        return Value::Null;
    };
    let mut record = json!({
        "valid": result.valid,
        "outcome": result.outcome.name(),
        "position": position(&result.position),
        "cell": hex(cell_id(result.cell, view.world)),
        "object_info": hex(result.object_info.difference(WEENIE_BITS).bits()),
    });
    put_contact(&result.info, &mut record);
    put_touched(result, view.world, &mut record);
    record["velocity"] = vector(view.entity.kin.velocity);
    record["sub_steps"] = result.progress.done.into();
    record["sub_steps_planned"] = result.progress.planned.into();
    record["cell_array"] = hexes(result.cells.entries().map(|entry| entry.id.0));
    record
}

fn put_mover(input: &TransitionInput, record: &mut Value) {
    let mover = &input.mover;
    let sphere = |s: &Sphere| json!({"center": vector(s.center), "radius": number(s.radius)});
    record["object_info"] = hex(mover.state.difference(WEENIE_BITS).bits());
    record["state"] = hex(mover.physics_state.bits());
    record["step_up_height"] = number(mover.step_up_height);
    record["step_down_height"] = number(mover.step_down_height);
    record["step_down"] = mover.step_down.into();
    record["is_player"] = mover.state.contains(ObjectInfoState::IS_PLAYER).into();
    record["spheres"] = input.spheres.as_slice().iter().map(sphere).collect();
    record["scale"] = number(mover.scale);
}

fn put_contact(info: &CollisionInfo, record: &mut Value) {
    let sliding = info.sliding_normal_valid.then_some(info.sliding_normal);
    record["contact_plane"] = plane(&info.contact_plane);
    record["last_known_contact_plane"] = plane(&info.last_known_contact_plane);
    record["sliding_normal"] = optional_vector(sliding);
    record["frames_stationary_fall"] = info.frames_stationary_fall.into();
}

fn put_touched(result: &TransitionResult, world: &World, record: &mut Value) {
    let info = &result.info;
    let hit = info.collision_normal_valid.then_some(info.collision_normal);
    let guid = |&object: &ObjectRef| match object {
        ObjectRef::Entity(id) => world.entity(id).map(Entity::guid),
        ObjectRef::Static(_) => None,
    };
    record["collision_normal"] = optional_vector(hit);
    record["collided"] = hexes(info.collide_object.iter().filter_map(guid));
    record["environment"] = info.collided_with_environment.into();
}

/// Everybody else near the mover who stands in shadow lists, in order of creation. What is carried is never tested (06 C6).
fn others(mover: &Entity, world: &World) -> Value {
    let table = world.entities.table().iter();
    table
        .filter_map(|&id| world.entity(id))
        .filter(|other| other.id != mover.id && other.body.parent.is_none())
        .filter(|other| !other.body.shadows.is_empty())
        .filter(|other| mover.body.position.distance(&other.body.position) <= NEAR)
        .map(|other| self::other(other, world))
        .collect()
}

fn other(other: &Entity, world: &World) -> Value {
    let body = &other.body;
    let frame = &body.position.frame;
    let mut record = json!({
        "guid": hex(body.guid),
        "state": hex(body.state.bits()),
        "scale": number(body.scale),
        "cell": hex(body.position.cell.0),
        "origin": vector(frame.origin),
        "rotation": rotation(frame.rotation()),
        "shadow_cells": shadow_cells(other, world),
    });
    if body.state.contains(PhysicsState::HAS_PHYSICS_BSP) {
        put_pose(other, frame, &mut record);
    }
    record
}

/// The parts get their pose whenever the frame is set, so its place is that of the object.
fn put_pose(other: &Entity, frame: &Frame, record: &mut Value) {
    let sequence = other.part_array().map(|parts| &parts.sequence);
    let node = sequence.and_then(|s| s.current_node());
    record["anim"] = hex(node.map_or(0, |n| n.animation_id()));
    record["frame_number"] = double(sequence.map_or(0.0, |s| s.frame_number()));
    record["pose_origin"] = vector(frame.origin);
    record["pose_rotation"] = rotation(frame.rotation());
}

/// Cells in whose shadow lists an entity stands, and its place in each list.
fn shadow_cells(other: &Entity, world: &World) -> Value {
    let object = other.object_ref();
    let place = |cell| {
        let shadows = &world.land.cell(cell)?.base().shadows;
        shadows.iter().position(|&o| o == object)
    };
    let shadows = other.body.shadows.iter();
    shadows
        .filter_map(|entry| Some(json!([hex(entry.id.0), place(entry.cell?)?])))
        .collect()
}
