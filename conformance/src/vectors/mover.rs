//! The mover of the families `sphere` and `cylsphere`: a path in no cell at all, and its records afterwards.

use ac_client::math::CellId;
use ac_client::physics::transition::{InsertType, ObjectInfoState, Transition, TransitionState};
use ac_client::world::World;
use serde_json::{Value, json};

use super::json::{boolean, f32, id, list, nullable, put};
use super::math::{plane, position, put_plane, put_vec3, sphere};

/// The transition of a vector's arguments.
pub fn transition<'w>(world: &'w World, args: &Value) -> Option<Transition<'w>> {
    let mut t = Transition::new(world);
    t.object.state = ObjectInfoState::from_bits_retain(id(&args["object_state"])?);
    t.object.scale = 1.0;
    t.object.step_down = true;
    t.object.step_up_height = f32(&args["step_up_height"])?;
    t.object.step_down_height = f32(&args["step_down_height"])?;
    set_path(&mut t, args)?;
    set_planes(&mut t, args)?;
    Some(t)
}

fn set_path(t: &mut Transition<'_>, args: &Value) -> Option<()> {
    let path = &mut t.path;
    let spheres = list(&args["spheres"], sphere)?;
    path.num_sphere = spheres.len().min(2);
    for (own, given) in path.local_sphere.iter_mut().zip(&spheres) {
        *own = *given;
    }
    path.local_low_point = path.local_sphere[0].center;
    path.local_low_point.z -= path.local_sphere[0].radius;
    path.curr_pos = position(&args["curr_pos"])?;
    path.begin_pos = Some(path.curr_pos);
    path.check_pos = position(&args["check_pos"])?;
    path.end_pos = path.check_pos;
    path.cache_global_curr_center(&t.world.profile);
    path.cache_global_sphere(&t.world.profile);
    path.walk_interp = f32(&args["walk_interp"])?;
    path.step_down_amt = f32(&args["step_down_amt"])?;
    path.walkable_allowance = f32(&args["walkable_allowance"])?;
    path.step_down = boolean(&args["step_down"])?;
    path.collide = boolean(&args["collide"])?;
    path.check_walkable = boolean(&args["check_walkable"])?;
    path.insert_type = if boolean(&args["placement"])? {
        InsertType::Placement
    } else {
        InsertType::Transition
    };
    Some(())
}

fn set_planes(t: &mut Transition<'_>, args: &Value) -> Option<()> {
    let cell = t.path.check_pos.cell;
    if let Some(plane) = nullable(&args["contact_plane"], plane)? {
        t.set_contact_plane(plane, false);
        t.info.contact_plane.cell_id = cell;
    }
    let last = &mut t.info.last_known_contact_plane;
    last.valid = boolean(&args["last_known_valid"])?;
    if let Some(plane) = nullable(&args["last_known_contact_plane"], plane)? {
        last.plane = plane;
        last.cell_id = if last.valid { cell } else { CellId::NONE };
    }
    Some(())
}

fn outcome(state: TransitionState) -> &'static str {
    match state {
        TransitionState::Invalid => "invalid",
        TransitionState::Ok => "ok",
        TransitionState::Collided => "collided",
        TransitionState::Adjusted => "adjusted",
        TransitionState::Slid => "slid",
    }
}

/// What a vector tells of the records after the call.
pub fn records(t: &Transition<'_>, result: TransitionState) -> Value {
    let (path, info) = (&t.path, &t.info);
    json!({
        "result": outcome(result),
        "check_origin": put_vec3(path.check_pos.frame.origin),
        "walk_interp": put::f32(path.walk_interp),
        "walkable_allowance": put::f32(path.walkable_allowance),
        "collide": path.collide,
        "collision_normal": info.collision_normal_valid.then(|| put_vec3(info.collision_normal)),
        "contact_plane": info.contact_plane.valid.then(|| put_plane(&info.contact_plane.plane)),
        "contact_is_water": info.contact_plane.is_water,
        "step_up_normal": put_vec3(path.step_up_normal),
    })
}
