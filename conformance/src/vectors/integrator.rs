//! Vector family `integrator` (`spec/vector-format.md`; defined in `spec/06-physics-object.md`, B6 to B8 and C7).

use ac_client::entity::Entity;
use ac_client::math::{Frame, Plane, Quat, Vec3};
use ac_client::physics::body::EntityId;
use ac_client::physics::state::{PhysicsState, TransientState};
use ac_client::physics::transition::CollisionInfo;
use ac_client::profile::Profile;
use ac_client::world::World;
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{boolean, f32, frame, id, int, plane, put, vec3};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let args = vector.get("in")?;
    match vector.get("fn")?.as_str()? {
        "update_physics" => update_physics(args, ctx.profile),
        "calc_friction" => calc_friction(args, ctx.profile),
        "calc_acceleration" => calc_acceleration(args, ctx.profile),
        "set_velocity" => set_velocity(args, ctx.previous?.get("in")?, ctx.profile),
        "handle_all_collisions" => handle_all_collisions(args, ctx.profile),
        _ => None,
    }
}

/// An object without weenie, parts, movement manager and cell.
fn object(args: &Value) -> Option<Entity> {
    let mut entity = Entity::new(EntityId(0), 0, 0.0);
    entity.body.state = PhysicsState::from_bits_retain(id(args.get("state")?)?);
    let kin = &mut entity.kin;
    kin.velocity = vec3(args.get("velocity")?)?.into();
    kin.acceleration = vec3(args.get("acceleration")?)?.into();
    kin.omega = vec3(args.get("omega")?)?.into();
    kin.transient = TransientState::from_bits_retain(id(args.get("transient")?)?);
    let ground = plane(args.get("contact_plane")?)?;
    kin.contact_plane = Plane {
        n: ground.n.into(),
        d: ground.d,
    };
    kin.friction = f32(args.get("friction")?)?;
    kin.elasticity = f32(args.get("elasticity")?)?;
    Some(entity)
}

fn quantum(args: &Value) -> Option<f32> {
    f32(args.get("quantum")?)
}

fn vector(v: Vec3) -> Value {
    put::vec3(v.into())
}

fn transient(entity: &Entity) -> Value {
    put::id(entity.kin.transient.bits())
}

fn update_physics(args: &Value, profile: &Profile) -> Option<Value> {
    let mut entity = object(args)?;
    let at = frame(args.get("frame")?)?;
    let [w, x, y, z] = at.rotation;
    let mut moved = Frame::new(at.origin.into(), Quat::new(w, x, y, z));
    let state = entity.body.state;
    entity
        .kin
        .update_physics(&mut moved, quantum(args)?, state, false, profile);
    let q = moved.rotation();
    Some(json!({
        "frame": {
            "origin": vector(moved.origin),
            "rotation": put::quat([q.w, q.x, q.y, q.z]),
        },
        "velocity": vector(entity.kin.velocity),
        "transient": transient(&entity),
    }))
}

fn calc_friction(args: &Value, profile: &Profile) -> Option<Value> {
    let mut entity = object(args)?;
    let speed_squared = f32(args.get("velocity_mag2")?)?;
    let state = entity.body.state;
    entity
        .kin
        .apply_friction(quantum(args)?, speed_squared, state, profile);
    Some(json!({ "velocity": vector(entity.kin.velocity) }))
}

fn calc_acceleration(args: &Value, profile: &Profile) -> Option<Value> {
    let mut entity = object(args)?;
    let state = entity.body.state;
    entity.kin.calc_acceleration(state, profile);
    Some(json!({
        "acceleration": vector(entity.kin.acceleration),
        "omega": vector(entity.kin.omega),
    }))
}

/// Goes on with the object of the line before.
fn set_velocity(args: &Value, before: &Value, profile: &Profile) -> Option<Value> {
    let mut entity = object(before)?;
    let state = entity.body.state;
    entity.kin.calc_acceleration(state, profile);
    let new = vec3(args.get("new_velocity")?)?.into();
    entity.kin.set_velocity(new, state, 0.0, profile);
    Some(json!({
        "velocity": vector(entity.kin.velocity),
        "jumped_this_frame": i32::from(entity.kin.jumped_this_frame),
        "transient": transient(&entity),
    }))
}

fn handle_all_collisions(args: &Value, profile: &Profile) -> Option<Value> {
    let mut entity = object(args)?;
    let mut world = World::new(profile.clone(), 0.0);
    let info = CollisionInfo {
        collision_normal_valid: boolean(args.get("collision_normal_valid")?)?,
        collision_normal: vec3(args.get("collision_normal")?)?.into(),
        frames_stationary_fall: u32::try_from(int(args.get("frames_stationary_fall")?)?).ok()?,
        collided_with_environment: boolean(args.get("collided_with_environment")?)?,
        ..CollisionInfo::default()
    };
    let was_contact = boolean(args.get("prev_contact")?)?;
    let was_walkable = boolean(args.get("prev_on_walkable")?)?;
    let result = entity.handle_all_collisions(&info, was_contact, was_walkable, &mut world);
    Some(json!({
        "result": result,
        "velocity": vector(entity.kin.velocity),
        "transient": transient(&entity),
        "state": put::id(entity.body.state.bits()),
        "colliding_with_environment": entity.kin.colliding_with_environment,
    }))
}
