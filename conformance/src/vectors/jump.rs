//! Vector family `jump` (`spec/vector-format.md`; defined in `spec/08-motion.md`, 8.18 and 8.24).

use ac_client::math::{Frame, Vec3};
use ac_client::motion::{Command, Movement, MovementParameters, Mover};
use ac_client::physics::state::TransientState;
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{boolean, f32, id, put};
use super::math::{put_vec3, quat, vec3};
use super::motion_object::{Object, STANDING, hold_key, interpreter, weenie};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let arguments = &vector["in"];
    match vector["fn"].as_str()? {
        "leave_ground_velocity" => leave_ground_velocity(ctx, arguments),
        "jump" => jump(ctx, arguments),
        _ => None,
    }
}

fn leave_ground_velocity(ctx: &VectorContext<'_>, arguments: &Value) -> Option<Value> {
    let (weenie, interp) = (weenie(arguments)?, interpreter(arguments)?);
    let mover = Mover {
        profile: ctx.profile,
        weenie: Some(&weenie),
        creature: boolean(&arguments["creature"])?,
        gravity: true,
        transient: TransientState::from_bits_retain(STANDING),
    };
    let frame = Frame::new(Vec3::ZERO, quat(&arguments["rotation"])?);
    let velocity = vec3(&arguments["velocity"])?;
    Some(json!({
        "jump_v_z": put::f32(interp.jump_v_z(&mover)),
        "local_velocity": put_vec3(interp.leave_ground_velocity(&mover, &frame, velocity)),
    }))
}

fn jump(ctx: &VectorContext<'_>, arguments: &Value) -> Option<Value> {
    let mut object = Object::new(ctx, arguments)?;
    // The interpreter was made in the air: the object plays Falling when it is put on the ground.
    object.entity.kin.transient = TransientState::empty();
    object.enter_default_state();
    let Object { world, entity } = &mut object;
    entity.kin.transient = TransientState::from_bits_retain(id(&arguments["transient"])?);
    if let Some(motion) = arguments.get("motion") {
        let params = MovementParameters {
            hold_key: hold_key(&arguments["hold_key"])?,
            ..MovementParameters::default()
        };
        let movement = Movement::Raw(Command(id(motion)?), params);
        // Some of these motions are refused.
        let _ = entity.perform_movement(&movement, world);
    }
    let result = entity.jump(f32(&arguments["extent"])?, world);
    let parts = entity.body.part_array.as_ref()?;
    Some(json!({
        "result": result.map_or_else(|error| error.code(), |_| 0),
        "velocity": put_vec3(entity.kin.velocity),
        "transient": put::id(entity.kin.transient.bits()),
        "acceleration": put_vec3(entity.kin.acceleration),
        "substate": put::id(parts.motion_table.as_ref()?.state.substate),
    }))
}
