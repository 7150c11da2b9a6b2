//! Vector family `motioninterp` (`spec/vector-format.md`; defined in `spec/08-motion.md`, section 8).

use ac_client::motion::{
    Command, InterpretedMotionState, Motion, MotionInterp, MotionResult, Movement,
    MovementParameters, Mover, RawAxis, RawMotionState, code_of, contact_allows_move,
    motion_allows_jump,
};
use ac_client::physics::state::{PhysicsState, TransientState};
use serde_json::{Map, Value, json};

use super::VectorContext;
use super::json::{boolean, f32, id, put};
use super::math::put_vec3;
use super::motion_object::{Object, STANDING, hold_key, interpreter, put_hold_key, weenie};
use super::motiontable;

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let arguments = &vector["in"];
    match vector["fn"].as_str()? {
        "adjust_motion" => adjust_motion(ctx, arguments),
        "speeds" => speeds(ctx, arguments),
        "allows" => allows(ctx, arguments),
        "commands" => commands(ctx, arguments, vector["ops"].as_array()?),
        _ => None,
    }
}

fn adjust_motion(ctx: &VectorContext<'_>, arguments: &Value) -> Option<Value> {
    let weenie = weenie(arguments)?;
    let mover = Mover {
        profile: ctx.profile,
        weenie: Some(&weenie),
        creature: boolean(&arguments["creature"])?,
        gravity: true,
        transient: TransientState::from_bits_retain(STANDING),
    };
    let mut interp = MotionInterp {
        my_run_rate: f32(&arguments["my_run_rate"])?,
        ..MotionInterp::default()
    };
    interp.raw.current_hold_key = hold_key(&arguments["raw_hold_key"])?;
    let motion = Motion {
        command: Command(id(&arguments["motion"])?),
        speed: f32(&arguments["speed"])?,
    };
    let motion = interp.adjust_motion(motion, hold_key(&arguments["hold_key"])?, &mover);
    Some(json!({"motion": put::id(motion.command.0), "speed": put::f32(motion.speed)}))
}

fn speeds(ctx: &VectorContext<'_>, arguments: &Value) -> Option<Value> {
    let (weenie, interp) = (weenie(arguments)?, interpreter(arguments)?);
    let mover = Mover {
        profile: ctx.profile,
        weenie: Some(&weenie),
        creature: boolean(&arguments["creature"])?,
        gravity: true,
        transient: TransientState::from_bits_retain(STANDING),
    };
    Some(json!({
        "state_velocity": put_vec3(interp.state_velocity(&mover)),
        "max_speed": put::f32(interp.max_speed(&mover)),
        "adjusted_max_speed": put::f32(interp.adjusted_max_speed(&mover)),
    }))
}

fn allows(ctx: &VectorContext<'_>, arguments: &Value) -> Option<Value> {
    let weenie = ac_client::entity::Weenie::default();
    let state = PhysicsState::from_bits_retain(id(&arguments["state"])?);
    let mover = Mover {
        profile: ctx.profile,
        weenie: Some(&weenie),
        creature: boolean(&arguments["creature"])?,
        gravity: state.contains(PhysicsState::GRAVITY),
        transient: TransientState::from_bits_retain(id(&arguments["transient"])?),
    };
    let command = Command(id(&arguments["motion"])?);
    let jump = motion_allows_jump(command, ctx.profile);
    Some(json!({
        "contact_allows_move": contact_allows_move(command, &mover),
        "motion_allows_jump": if jump { 0 } else { 0x48 },
    }))
}

fn commands(ctx: &VectorContext<'_>, arguments: &Value, ops: &[Value]) -> Option<Value> {
    let mut object = Object::new(ctx, arguments)?;
    ops.iter()
        .take_while(|op| op.get("exception").is_none())
        .map(|op| {
            let mut results = operate(&mut object, op)?;
            results.extend(state(&object)?);
            Some(Value::Object(results))
        })
        .collect()
}

/// Carries out one operation; its results, without the state.
fn operate(object: &mut Object, op: &Value) -> Option<Map<String, Value>> {
    let name = op["op"].as_str()?;
    let mut results = Map::new();
    let movement = match name {
        "init" => {
            object.enter_default_state();
            return Some(results);
        }
        "leave_ground" => {
            object.entity.kin.transient = TransientState::ACTIVE;
            object.entity.movement_leave_ground(&mut object.world);
            let velocity = put_vec3(object.entity.kin.velocity);
            results.insert("velocity".into(), velocity);
            return Some(results);
        }
        "hit_ground" => {
            object.entity.kin.transient = TransientState::from_bits_retain(STANDING);
            object.entity.movement_hit_ground(&mut object.world);
            return Some(results);
        }
        "stop_completely" => Movement::StopCompletely,
        _ => {
            let command = Command(id(&op["motion"])?);
            let mut params = MovementParameters::default();
            if let Some(speed) = op.get("speed") {
                params.speed = f32(speed)?;
            }
            if let Some(key) = op.get("hold_key") {
                params.hold_key = hold_key(key)?;
            }
            match name {
                "do_motion" => Movement::Raw(command, params),
                "stop_motion" => Movement::StopRaw(command, params),
                "do_interpreted_motion" => Movement::Interpreted(command, params),
                "stop_interpreted_motion" => Movement::StopInterpreted(command, params),
                _ => return None,
            }
        }
    };
    let result: MotionResult = object.entity.perform_movement(&movement, &mut object.world);
    results.insert("result".into(), code_of(result).into());
    Some(results)
}

fn state(object: &Object) -> Option<Map<String, Value>> {
    let interp = object.entity.interp()?;
    let pending: Vec<Value> = interp
        .pending
        .iter()
        .map(|p| json!([put::id(p.command.0), if p.forbids_jump { 0x48 } else { 0 }]))
        .collect();
    let velocity = interp.state_velocity(&object.entity.mover(&object.world));
    let fields = [
        ("interpreted", interpreted(&interp.interpreted)),
        ("raw", raw(&interp.raw)),
        ("pending_motions", pending.into()),
        ("my_run_rate", put::f32(interp.my_run_rate)),
        ("standing_longjump", interp.standing_longjump.into()),
        ("state_velocity", put_vec3(velocity)),
    ];
    let mut state: Map<String, Value> =
        fields.map(|(k, v)| (k.to_owned(), v)).into_iter().collect();
    let parts = object.entity.body.part_array.as_ref()?;
    state.extend(motiontable::state(parts.motion_table.as_ref()?));
    Some(state)
}

fn interpreted(state: &InterpretedMotionState) -> Value {
    json!({
        "style": put::id(state.style.0),
        "forward": put::id(state.forward_command.0),
        "forward_speed": put::f32(state.forward_speed),
        "sidestep": put::id(state.sidestep_command.0),
        "sidestep_speed": put::f32(state.sidestep_speed),
        "turn": put::id(state.turn_command.0),
        "turn_speed": put::f32(state.turn_speed),
        "actions": state.actions.len(),
    })
}

fn raw(state: &RawMotionState) -> Value {
    let mut fields = Map::new();
    fields.insert("hold_key".into(), put_hold_key(state.current_hold_key));
    fields.insert("style".into(), put::id(state.style.0));
    let mut axis = |name: &str, axis: &RawAxis| {
        fields.insert(name.into(), put::id(axis.command.0));
        fields.insert(format!("{name}_hold"), put_hold_key(axis.hold_key));
        fields.insert(format!("{name}_speed"), put::f32(axis.speed));
    };
    axis("forward", &state.forward);
    axis("sidestep", &state.sidestep);
    axis("turn", &state.turn);
    fields.insert("actions".into(), state.actions.len().into());
    fields.into()
}
