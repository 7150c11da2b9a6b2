//! Reads any valid JSON through a tree, and says where and why when it is not a record.

use ac_client::frame::state::{
    AnimState, Collision, ContactPlane, Fields, FrameEvent, FrameState, FrameStates, MotionState,
    Outcome, Step, parse_hex,
};
use serde_json::{Map, Value};

use super::{RecordError, Unknown};

type Read<T> = Result<T, RecordError>;

pub(super) fn line(value: &Value, unknown: Unknown, state: &mut FrameState) -> Read<()> {
    let fields = object(value, "record")?;
    let frame = integer(required(fields, "frame", "")?, "frame")?;
    let time = double(required(fields, "time", "")?, "time")?;
    state.reset(frame, time, 0);
    record(fields, "", unknown, &["frame", "time"], state)
}

pub(super) fn message(
    value: &Value,
    unknown: Unknown,
    states: &mut FrameStates,
) -> Read<(i32, f64)> {
    let fields = object(value, "message")?;
    let frame = integer(required(fields, "frame", "")?, "frame")?;
    let time = double(required(fields, "time", "")?, "time")?;
    let entities = array(required(fields, "entities", "")?, "entities")?;
    if unknown == Unknown::Refuse
        && let Some(key) = fields
            .keys()
            .find(|key| !["frame", "time", "entities"].contains(&key.as_str()))
    {
        return error(key, "unknown field");
    }
    for (index, entity) in entities.iter().enumerate() {
        let path = format!("entities[{index}]");
        record(
            object(entity, &path)?,
            &format!("{path}."),
            unknown,
            &[],
            states.push(frame, time, 0),
        )?;
    }
    Ok((frame, time))
}

/// All fields of a record but those in `before`. `at` is the path in front of a field's name.
fn record(
    fields: &Map<String, Value>,
    at: &str,
    unknown: Unknown,
    before: &[&str],
    state: &mut FrameState,
) -> Read<()> {
    state.anim = None;
    state.guid = hex(required(fields, "guid", at)?, &format!("{at}guid"))?;
    state.cell = hex(required(fields, "cell", at)?, &format!("{at}cell"))?;
    for (key, value) in fields {
        let path = format!("{at}{key}");
        let path = path.as_str();
        let field = match key.as_str() {
            "guid" | "cell" => Fields::empty(),
            "origin" => set(&mut state.origin, floats(value, path)?, Fields::ORIGIN),
            "rotation" => set(&mut state.rotation, floats(value, path)?, Fields::ROTATION),
            "velocity" => set(&mut state.velocity, floats(value, path)?, Fields::VELOCITY),
            "acceleration" => set(
                &mut state.acceleration,
                floats(value, path)?,
                Fields::ACCELERATION,
            ),
            "omega" => set(&mut state.omega, floats(value, path)?, Fields::OMEGA),
            "state" => set(&mut state.state, hex(value, path)?, Fields::STATE),
            "transient" => set(&mut state.transient, hex(value, path)?, Fields::TRANSIENT),
            "contact_plane" => {
                Fields::CONTACT_PLANE
                    | nullable(value, &mut state.contact_plane, |value| {
                        plane(value, path, unknown)
                    })?
            }
            "sliding_normal" => {
                Fields::SLIDING_NORMAL
                    | nullable(value, &mut state.sliding_normal, |value| {
                        Ok((floats(value, path)?, Fields::empty()))
                    })?
            }
            "anim" => {
                Fields::ANIM | nullable(value, &mut state.anim, |value| anim(value, path, unknown))?
            }
            "motion" => {
                Fields::MOTION
                    | nullable(value, &mut state.motion, |value| {
                        motion(value, path, unknown)
                    })?
            }
            "steps" => set(&mut state.steps, list(value, path, step)?, Fields::STEPS),
            "collisions" => set(
                &mut state.collisions,
                list(value, path, collision)?,
                Fields::COLLISIONS,
            ),
            "events" => set(&mut state.events, list(value, path, event)?, Fields::EVENTS),
            key if before.contains(&key) || unknown == Unknown::Skip => Fields::empty(),
            _ => return error(path, "unknown field"),
        };
        state.has |= field;
    }
    Ok(())
}

fn set<T>(slot: &mut T, value: T, field: Fields) -> Fields {
    *slot = value;
    field
}

fn nullable<T>(
    value: &Value,
    slot: &mut Option<T>,
    read: impl FnOnce(&Value) -> Read<(T, Fields)>,
) -> Read<Fields> {
    if value.is_null() {
        *slot = None;
        return Ok(Fields::empty());
    }
    let (read, parts) = read(value)?;
    *slot = Some(read);
    Ok(parts)
}

fn plane(value: &Value, at: &str, unknown: Unknown) -> Read<(ContactPlane, Fields)> {
    let mut plane = ContactPlane::default();
    let parts = parts(value, at, unknown, |key, value, path| {
        Ok(Some(match key {
            "n" => set(&mut plane.n, floats(value, path)?, Fields::PLANE_N),
            "d" => set(&mut plane.d, float(value, path)?, Fields::PLANE_D),
            "cell" => set(&mut plane.cell, hex(value, path)?, Fields::PLANE_CELL),
            _ => return Ok(None),
        }))
    })?;
    Ok((plane, parts))
}

fn anim(value: &Value, at: &str, unknown: Unknown) -> Read<(AnimState, Fields)> {
    let mut anim = AnimState::default();
    let parts = parts(value, at, unknown, |key, value, path| {
        Ok(Some(match key {
            "frame_number" => set(
                &mut anim.frame_number,
                double(value, path)?,
                Fields::ANIM_FRAME_NUMBER,
            ),
            "id" => set(&mut anim.id, hex(value, path)?, Fields::ANIM_ID),
            "first_cyclic" => {
                let cyclic = value
                    .as_bool()
                    .ok_or_else(|| expected(path, "true or false"))?;
                set(&mut anim.first_cyclic, cyclic, Fields::ANIM_FIRST_CYCLIC)
            }
            "queue" => set(&mut anim.queue, list(value, path, hex)?, Fields::ANIM_QUEUE),
            "velocity" => set(
                &mut anim.velocity,
                floats(value, path)?,
                Fields::ANIM_VELOCITY,
            ),
            "omega" => set(&mut anim.omega, floats(value, path)?, Fields::ANIM_OMEGA),
            _ => return Ok(None),
        }))
    })?;
    Ok((anim, parts))
}

fn motion(value: &Value, at: &str, unknown: Unknown) -> Read<(MotionState, Fields)> {
    let mut motion = MotionState::default();
    let parts = parts(value, at, unknown, |key, value, path| {
        Ok(Some(match key {
            "style" => set(&mut motion.style, hex(value, path)?, Fields::MOTION_STYLE),
            "substate" => set(
                &mut motion.substate,
                hex(value, path)?,
                Fields::MOTION_SUBSTATE,
            ),
            "substate_speed" => set(
                &mut motion.substate_speed,
                float(value, path)?,
                Fields::MOTION_SUBSTATE_SPEED,
            ),
            "forward" => set(
                &mut motion.forward,
                hex(value, path)?,
                Fields::MOTION_FORWARD,
            ),
            "forward_speed" => set(
                &mut motion.forward_speed,
                float(value, path)?,
                Fields::MOTION_FORWARD_SPEED,
            ),
            "sidestep" => set(
                &mut motion.sidestep,
                hex(value, path)?,
                Fields::MOTION_SIDESTEP,
            ),
            "sidestep_speed" => set(
                &mut motion.sidestep_speed,
                float(value, path)?,
                Fields::MOTION_SIDESTEP_SPEED,
            ),
            "turn" => set(&mut motion.turn, hex(value, path)?, Fields::MOTION_TURN),
            "turn_speed" => set(
                &mut motion.turn_speed,
                float(value, path)?,
                Fields::MOTION_TURN_SPEED,
            ),
            _ => return Ok(None),
        }))
    })?;
    Ok((motion, parts))
}

/// Walks an object; `read` answers the field of a key it knows.
fn parts(
    value: &Value,
    at: &str,
    unknown: Unknown,
    mut read: impl FnMut(&str, &Value, &str) -> Read<Option<Fields>>,
) -> Read<Fields> {
    let mut has = Fields::empty();
    for (key, value) in object(value, at)? {
        let path = format!("{at}.{key}");
        match read(key, value, &path)? {
            Some(field) => has |= field,
            None if unknown == Unknown::Skip => {}
            None => return error(&path, "unknown field"),
        }
    }
    Ok(has)
}

fn step(value: &Value, at: &str) -> Read<Step> {
    let fields = object(value, at)?;
    let path = format!("{at}.");
    let outcome = required(fields, "outcome", &path)?;
    Ok(Step {
        dt: float(required(fields, "dt", &path)?, &format!("{at}.dt"))?,
        outcome: outcome
            .as_str()
            .and_then(Outcome::from_name)
            .ok_or_else(|| expected(&format!("{at}.outcome"), "the name of an outcome"))?,
    })
}

fn collision(value: &Value, at: &str) -> Read<Collision> {
    if value == "environment" {
        return Ok(Collision::Environment);
    }
    hex(value, at).map(Collision::Object)
}

fn event(value: &Value, at: &str) -> Read<FrameEvent> {
    value
        .as_str()
        .and_then(FrameEvent::parse)
        .ok_or_else(|| expected(at, "the name of an event"))
}

fn list<T>(value: &Value, at: &str, read: impl Fn(&Value, &str) -> Read<T>) -> Read<Vec<T>> {
    array(value, at)?
        .iter()
        .enumerate()
        .map(|(index, item)| read(item, &format!("{at}[{index}]")))
        .collect()
}

fn floats<const N: usize>(value: &Value, at: &str) -> Read<[f32; N]> {
    let items = array(value, at)?;
    if items.len() != N {
        return error(at, &format!("has {} numbers, not {N}", items.len()));
    }
    let mut numbers = [0.0; N];
    for (index, (number, item)) in numbers.iter_mut().zip(items).enumerate() {
        *number = float(item, &format!("{at}[{index}]"))?;
    }
    Ok(numbers)
}

fn float(value: &Value, at: &str) -> Read<f32> {
    // Narrowing the widened value gives back the float.
    double(value, at).map(|wide| wide as f32)
}

fn double(value: &Value, at: &str) -> Read<f64> {
    crate::number::double(value)
        .ok_or_else(|| expected(at, "a number, \"nan\", \"inf\" or \"-inf\""))
}

fn integer(value: &Value, at: &str) -> Read<i32> {
    value
        .as_i64()
        .and_then(|number| number.try_into().ok())
        .ok_or_else(|| expected(at, "an integer"))
}

fn hex(value: &Value, at: &str) -> Read<u32> {
    value
        .as_str()
        .and_then(parse_hex)
        .ok_or_else(|| expected(at, "a hexadecimal id as text, like \"0xA9B40019\""))
}

fn object<'a>(value: &'a Value, at: &str) -> Read<&'a Map<String, Value>> {
    value.as_object().ok_or_else(|| expected(at, "an object"))
}

fn array<'a>(value: &'a Value, at: &str) -> Read<&'a Vec<Value>> {
    value.as_array().ok_or_else(|| expected(at, "a list"))
}

fn required<'a>(fields: &'a Map<String, Value>, key: &str, at: &str) -> Read<&'a Value> {
    fields.get(key).ok_or_else(|| RecordError {
        path: format!("{at}{key}"),
        reason: "is missing".into(),
    })
}

fn expected(path: &str, what: &str) -> RecordError {
    RecordError {
        path: path.into(),
        reason: format!("expected {what}"),
    }
}

fn error<T>(path: &str, reason: &str) -> Read<T> {
    Err(RecordError {
        path: path.into(),
        reason: reason.into(),
    })
}
