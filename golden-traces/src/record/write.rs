//! Writes the canonical form: fields in the order of the specification, no white space.

use ac_client::frame::state::{
    AnimState, Collision, ContactPlane, Fields, FrameEvent, FrameState, MotionState,
};

/// Appends the record of one entity without `frame` and `time`.
pub fn write_record(out: &mut Vec<u8>, state: &FrameState) {
    out.extend_from_slice(b"{\"guid\":");
    hex(out, state.guid);
    rest(out, state);
}

/// Appends a line of an expected-state trace, without the line break.
pub fn write_line(out: &mut Vec<u8>, state: &FrameState) {
    out.extend_from_slice(b"{\"frame\":");
    integer(out, state.frame.into());
    out.extend_from_slice(b",\"time\":");
    double(out, state.time);
    out.extend_from_slice(b",\"guid\":");
    hex(out, state.guid);
    rest(out, state);
}

/// Appends the message of a frame.
pub fn write_message(out: &mut Vec<u8>, frame: i32, time: f64, states: &[FrameState]) {
    out.extend_from_slice(b"{\"frame\":");
    integer(out, frame.into());
    out.extend_from_slice(b",\"time\":");
    double(out, time);
    out.extend_from_slice(b",\"entities\":[");
    for (index, state) in states.iter().enumerate() {
        if index > 0 {
            out.push(b',');
        }
        write_record(out, state);
    }
    out.extend_from_slice(b"]}");
}

/// Everything from `cell` to the closing brace.
fn rest(out: &mut Vec<u8>, state: &FrameState) {
    let has = |field| state.has.contains(field);
    key(out, "cell");
    hex(out, state.cell);
    for (field, name, value) in [
        (Fields::ORIGIN, "origin", &state.origin[..]),
        (Fields::ROTATION, "rotation", &state.rotation),
    ] {
        if has(field) {
            key(out, name);
            floats(out, value);
        }
    }
    for (field, name, value) in [
        (Fields::VELOCITY, "velocity", &state.velocity),
        (Fields::ACCELERATION, "acceleration", &state.acceleration),
        (Fields::OMEGA, "omega", &state.omega),
    ] {
        if has(field) {
            key(out, name);
            floats(out, value);
        }
    }
    for (field, name, value) in [
        (Fields::STATE, "state", state.state),
        (Fields::TRANSIENT, "transient", state.transient),
    ] {
        if has(field) {
            key(out, name);
            hex(out, value);
        }
    }
    if has(Fields::CONTACT_PLANE) {
        key(out, "contact_plane");
        nullable(out, state.contact_plane.as_ref(), |out, value| {
            plane(out, value, state.has)
        });
    }
    if has(Fields::SLIDING_NORMAL) {
        key(out, "sliding_normal");
        nullable(out, state.sliding_normal.as_ref(), |out, value| {
            floats(out, value)
        });
    }
    if has(Fields::ANIM) {
        key(out, "anim");
        nullable(out, state.anim.as_ref(), |out, value| {
            anim(out, value, state.has)
        });
    }
    if has(Fields::MOTION) {
        key(out, "motion");
        nullable(out, state.motion.as_ref(), |out, value| {
            motion(out, value, state.has)
        });
    }
    lists(out, state);
    out.push(b'}');
}

fn lists(out: &mut Vec<u8>, state: &FrameState) {
    if state.has.contains(Fields::STEPS) {
        key(out, "steps");
        list(out, &state.steps, |out, step| {
            out.extend_from_slice(b"{\"dt\":");
            float(out, step.dt);
            out.extend_from_slice(b",\"outcome\":\"");
            out.extend_from_slice(step.outcome.name().as_bytes());
            out.extend_from_slice(b"\"}");
        });
    }
    if state.has.contains(Fields::COLLISIONS) {
        key(out, "collisions");
        list(out, &state.collisions, |out, collision| match collision {
            Collision::Environment => out.extend_from_slice(b"\"environment\""),
            Collision::Object(guid) => hex(out, *guid),
        });
    }
    if state.has.contains(Fields::EVENTS) {
        key(out, "events");
        list(out, &state.events, |out, event| match event {
            FrameEvent::HitGround => out.extend_from_slice(b"\"hit_ground\""),
            FrameEvent::LeaveGround => out.extend_from_slice(b"\"leave_ground\""),
            FrameEvent::MotionDone(command) => {
                out.extend_from_slice(b"\"motion_done:");
                hex_digits(out, *command);
                out.push(b'"');
            }
            FrameEvent::AnimHook(kind) => {
                out.extend_from_slice(b"\"anim_hook:");
                integer(out, (*kind).into());
                out.push(b'"');
            }
        });
    }
}

fn plane(out: &mut Vec<u8>, plane: &ContactPlane, has: Fields) {
    object(out, |out, separator| {
        if has.contains(Fields::PLANE_N) {
            part(out, separator, "n");
            floats(out, &plane.n);
        }
        if has.contains(Fields::PLANE_D) {
            part(out, separator, "d");
            float(out, plane.d);
        }
        if has.contains(Fields::PLANE_CELL) {
            part(out, separator, "cell");
            hex(out, plane.cell);
        }
    });
}

fn anim(out: &mut Vec<u8>, anim: &AnimState, has: Fields) {
    object(out, |out, separator| {
        if has.contains(Fields::ANIM_FRAME_NUMBER) {
            part(out, separator, "frame_number");
            double(out, anim.frame_number);
        }
        if has.contains(Fields::ANIM_ID) {
            part(out, separator, "id");
            hex(out, anim.id);
        }
        if has.contains(Fields::ANIM_FIRST_CYCLIC) {
            part(out, separator, "first_cyclic");
            out.extend_from_slice(if anim.first_cyclic { b"true" } else { b"false" });
        }
        if has.contains(Fields::ANIM_QUEUE) {
            part(out, separator, "queue");
            list(out, &anim.queue, |out, id| hex(out, *id));
        }
        if has.contains(Fields::ANIM_VELOCITY) {
            part(out, separator, "velocity");
            floats(out, &anim.velocity);
        }
        if has.contains(Fields::ANIM_OMEGA) {
            part(out, separator, "omega");
            floats(out, &anim.omega);
        }
    });
}

fn motion(out: &mut Vec<u8>, motion: &MotionState, has: Fields) {
    enum Value {
        Command(u32),
        Speed(f32),
    }
    use Value::{Command, Speed};
    object(out, |out, separator| {
        for (field, name, value) in [
            (Fields::MOTION_STYLE, "style", Command(motion.style)),
            (
                Fields::MOTION_SUBSTATE,
                "substate",
                Command(motion.substate),
            ),
            (
                Fields::MOTION_SUBSTATE_SPEED,
                "substate_speed",
                Speed(motion.substate_speed),
            ),
            (Fields::MOTION_FORWARD, "forward", Command(motion.forward)),
            (
                Fields::MOTION_FORWARD_SPEED,
                "forward_speed",
                Speed(motion.forward_speed),
            ),
            (
                Fields::MOTION_SIDESTEP,
                "sidestep",
                Command(motion.sidestep),
            ),
            (
                Fields::MOTION_SIDESTEP_SPEED,
                "sidestep_speed",
                Speed(motion.sidestep_speed),
            ),
            (Fields::MOTION_TURN, "turn", Command(motion.turn)),
            (
                Fields::MOTION_TURN_SPEED,
                "turn_speed",
                Speed(motion.turn_speed),
            ),
        ] {
            if has.contains(field) {
                part(out, separator, name);
                match value {
                    Command(command) => hex(out, command),
                    Speed(speed) => float(out, speed),
                }
            }
        }
    });
}

/// An object whose parts are written by `parts`; the flag says whether a separator is due.
fn object(out: &mut Vec<u8>, parts: impl FnOnce(&mut Vec<u8>, &mut bool)) {
    out.push(b'{');
    parts(out, &mut false);
    out.push(b'}');
}

fn part(out: &mut Vec<u8>, separator: &mut bool, name: &str) {
    if *separator {
        out.push(b',');
    }
    *separator = true;
    out.push(b'"');
    out.extend_from_slice(name.as_bytes());
    out.extend_from_slice(b"\":");
}

fn key(out: &mut Vec<u8>, name: &str) {
    part(out, &mut true, name);
}

fn nullable<T>(out: &mut Vec<u8>, value: Option<&T>, write: impl FnOnce(&mut Vec<u8>, &T)) {
    match value {
        Some(value) => write(out, value),
        None => out.extend_from_slice(b"null"),
    }
}

fn list<T>(out: &mut Vec<u8>, items: &[T], write: impl Fn(&mut Vec<u8>, &T)) {
    out.push(b'[');
    for (index, item) in items.iter().enumerate() {
        if index > 0 {
            out.push(b',');
        }
        write(out, item);
    }
    out.push(b']');
}

fn floats(out: &mut Vec<u8>, numbers: &[f32]) {
    list(out, numbers, |out, number| float(out, *number));
}

fn float(out: &mut Vec<u8>, number: f32) {
    double(out, number.into());
}

/// A number as its shortest decimal; a whole number without `.0`, except for -0.0, which some readers would lose.
pub(crate) fn double(out: &mut Vec<u8>, number: f64) {
    if number.is_nan() {
        out.extend_from_slice(b"\"nan\"");
    } else if number.is_infinite() {
        out.extend_from_slice(if number > 0.0 {
            b"\"inf\""
        } else {
            b"\"-inf\""
        });
    } else {
        let mut buffer = zmij::Buffer::new();
        let text = buffer.format_finite(number);
        let short = if number == 0.0 && number.is_sign_negative() {
            text
        } else {
            text.strip_suffix(".0").unwrap_or(text)
        };
        out.extend_from_slice(short.as_bytes());
    }
}

fn integer(out: &mut Vec<u8>, number: i64) {
    use std::io::Write;
    // Writing to memory cannot fail.
    let _ = write!(out, "{number}");
}

fn hex(out: &mut Vec<u8>, id: u32) {
    out.push(b'"');
    hex_digits(out, id);
    out.push(b'"');
}

fn hex_digits(out: &mut Vec<u8>, id: u32) {
    out.extend_from_slice(b"0x");
    let digits = (8 - id.leading_zeros() / 4).max(1);
    for digit in (0..digits).rev() {
        out.push(b"0123456789ABCDEF"[(id >> (digit * 4)) as usize & 0xF]);
    }
}
