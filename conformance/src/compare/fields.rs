//! The slow way: every field of two records, in the order of the format.

use ac_client::frame::state::{Collision, Fields, FrameState};
use serde_json::{Value, json};

use super::{
    error::{self, Error},
    is_gone, outcome,
};
use crate::vectors::json::put;

/// A field that differs.
pub struct Difference<'a> {
    /// Name of the field, without indices.
    pub field: &'static str,
    /// Index in it.
    pub index: Option<usize>,
    /// What follows the index.
    pub rest: &'static str,
    /// Distance, if it is a number.
    pub error: Option<Error>,
    /// Unit of the distance.
    pub unit: &'static str,
    /// Both values as JSON, made only when someone wants to read them.
    pub values: &'a dyn Fn() -> (Value, Value),
}

impl Difference<'_> {
    /// The path of the field.
    pub fn path(&self) -> String {
        match self.index {
            Some(index) => format!("{}[{index}]{}", self.field, self.rest),
            None => format!("{}{}", self.field, self.rest),
        }
    }
}

type Report<'a> = &'a mut dyn FnMut(&Difference<'_>);

/// Metres between the two positions, in whichever landblocks they are. Infinite when only one of them is in a cell.
pub fn distance(expected: &FrameState, actual: &FrameState) -> f64 {
    if (expected.cell == 0) != (actual.cell == 0) {
        return f64::INFINITY;
    }
    let shift = landblock_shift(expected.cell, actual.cell);
    (0..3)
        .map(|i| f64::from(expected.origin[i]) - f64::from(actual.origin[i]) + shift[i])
        .map(|off| off * off)
        .sum::<f64>()
        .sqrt()
}

/// Reports every difference of two records, in the order of the format.
pub fn differences(expected: &FrameState, actual: &FrameState, report: Report<'_>) {
    double("time", "s", expected.time, actual.time, report);
    if is_gone(expected) != is_gone(actual) {
        let name = |gone| Value::from(if gone { "gone" } else { "there" });
        structure(
            "record",
            &|| (name(is_gone(expected)), name(is_gone(actual))),
            report,
        );
        return;
    }
    id("cell", expected.cell, actual.cell, report);
    let shift = landblock_shift(expected.cell, actual.cell);
    let both = |field: Fields, name: &'static str, report: &mut dyn FnMut(&Difference<'_>)| {
        presence(expected.has, actual.has, field, name, report)
    };
    if both(Fields::ORIGIN, "origin", report) {
        origin(expected.origin, actual.origin, shift, report);
    }
    if both(Fields::ROTATION, "rotation", report) {
        floats("rotation", "", &expected.rotation, &actual.rotation, report);
    }
    if both(Fields::VELOCITY, "velocity", report) {
        floats(
            "velocity",
            "m/s",
            &expected.velocity,
            &actual.velocity,
            report,
        );
    }
    if both(Fields::ACCELERATION, "acceleration", report) {
        floats(
            "acceleration",
            "m/s²",
            &expected.acceleration,
            &actual.acceleration,
            report,
        );
    }
    if both(Fields::OMEGA, "omega", report) {
        floats("omega", "rad/s", &expected.omega, &actual.omega, report);
    }
    if both(Fields::STATE, "state", report) {
        id("state", expected.state, actual.state, report);
    }
    if both(Fields::TRANSIENT, "transient", report) {
        id("transient", expected.transient, actual.transient, report);
    }
    if both(Fields::CONTACT_PLANE, "contact_plane", report) {
        plane(expected, actual, report);
    }
    if both(Fields::SLIDING_NORMAL, "sliding_normal", report) {
        match (&expected.sliding_normal, &actual.sliding_normal) {
            (Some(a), Some(b)) => floats("sliding_normal", "", a, b, report),
            (None, None) => {}
            (a, b) => structure(
                "sliding_normal",
                &|| {
                    (
                        a.map_or(Value::Null, put::vec3),
                        b.map_or(Value::Null, put::vec3),
                    )
                },
                report,
            ),
        }
    }
    if both(Fields::ANIM, "anim", report) {
        anim(expected, actual, report);
    }
    if both(Fields::MOTION, "motion", report) {
        motion(expected, actual, report);
    }
    lists(expected, actual, report);
}

/// Whether both carry a field; reports it if only the expectation does.
fn presence(
    expected: Fields,
    actual: Fields,
    field: Fields,
    name: &'static str,
    report: Report<'_>,
) -> bool {
    if !expected.contains(field) {
        return false;
    }
    let present = actual.contains(field);
    if !present {
        structure(name, &|| ("present".into(), "missing".into()), report);
    }
    present
}

fn structure(field: &'static str, values: &dyn Fn() -> (Value, Value), report: Report<'_>) {
    report(&Difference {
        field,
        index: None,
        rest: "",
        error: None,
        unit: "",
        values,
    });
}

fn id(field: &'static str, expected: u32, actual: u32, report: Report<'_>) {
    if expected != actual {
        structure(field, &|| (put::id(expected), put::id(actual)), report);
    }
}

fn same(expected: f32, actual: f32) -> bool {
    expected.to_bits() == actual.to_bits() || expected.is_nan() && actual.is_nan()
}

fn float(field: &'static str, unit: &'static str, expected: f32, actual: f32, report: Report<'_>) {
    if !same(expected, actual) {
        let values = || (put::f32(expected), put::f32(actual));
        let error = Some(error::between(expected, actual));
        report(&Difference {
            field,
            index: None,
            rest: "",
            error,
            unit,
            values: &values,
        });
    }
}

fn double(field: &'static str, unit: &'static str, expected: f64, actual: f64, report: Report<'_>) {
    if expected.to_bits() != actual.to_bits() && !(expected.is_nan() && actual.is_nan()) {
        let values = || (put::f64(expected), put::f64(actual));
        let error = Some(error::between_doubles(expected, actual));
        report(&Difference {
            field,
            index: None,
            rest: "",
            error,
            unit,
            values: &values,
        });
    }
}

fn floats(
    field: &'static str,
    unit: &'static str,
    expected: &[f32],
    actual: &[f32],
    report: Report<'_>,
) {
    for (index, (&expected, &actual)) in expected.iter().zip(actual).enumerate() {
        if !same(expected, actual) {
            let values = || (put::f32(expected), put::f32(actual));
            let error = Some(error::between(expected, actual));
            report(&Difference {
                field,
                index: Some(index),
                rest: "",
                error,
                unit,
                values: &values,
            });
        }
    }
}

/// Positions in different landblocks are made comparable first; their bits differ for that alone.
fn origin(expected: [f32; 3], actual: [f32; 3], shift: [f64; 3], report: Report<'_>) {
    for index in 0..3 {
        let (a, b) = (expected[index], actual[index]);
        if same(a, b) && shift[index] == 0.0 {
            continue;
        }
        let values = || (put::f32(a), put::f32(b));
        let mut error = error::between(a, b);
        if shift[index] != 0.0 {
            error.abs = (f64::from(a) - f64::from(b) + shift[index]).abs();
        }
        report(&Difference {
            field: "origin",
            index: Some(index),
            rest: "",
            error: Some(error),
            unit: "m",
            values: &values,
        });
    }
}

/// Metres from the landblock of `actual` to that of `expected`; zero if one of them is in no cell.
fn landblock_shift(expected: u32, actual: u32) -> [f64; 3] {
    if expected == 0 || actual == 0 {
        return [0.0; 3];
    }
    let blocks =
        |shift: u32| f64::from((expected >> shift & 0xFF) as i32 - (actual >> shift & 0xFF) as i32);
    [blocks(24) * 192.0, blocks(16) * 192.0, 0.0]
}

fn plane(expected: &FrameState, actual: &FrameState, report: Report<'_>) {
    match (&expected.contact_plane, &actual.contact_plane) {
        (None, None) => {}
        (Some(a), Some(b)) => {
            if presence(
                expected.has,
                actual.has,
                Fields::PLANE_N,
                "contact_plane.n",
                report,
            ) {
                floats("contact_plane.n", "", &a.n, &b.n, report);
            }
            if presence(
                expected.has,
                actual.has,
                Fields::PLANE_D,
                "contact_plane.d",
                report,
            ) {
                float("contact_plane.d", "m", a.d, b.d, report);
            }
            if presence(
                expected.has,
                actual.has,
                Fields::PLANE_CELL,
                "contact_plane.cell",
                report,
            ) {
                id("contact_plane.cell", a.cell, b.cell, report);
            }
        }
        (a, b) => {
            let show = |plane: &Option<ac_client::frame::state::ContactPlane>| {
                plane.map_or(Value::Null, |plane| json!({"n": put::vec3(plane.n), "d": put::f32(plane.d), "cell": put::id(plane.cell)}))
            };
            structure("contact_plane", &|| (show(a), show(b)), report);
        }
    }
}

fn anim(expected: &FrameState, actual: &FrameState, report: Report<'_>) {
    let both = |field, name, report: &mut dyn FnMut(&Difference<'_>)| {
        presence(expected.has, actual.has, field, name, report)
    };
    match (&expected.anim, &actual.anim) {
        (None, None) => {}
        (Some(a), Some(b)) => {
            if both(Fields::ANIM_FRAME_NUMBER, "anim.frame_number", report) {
                double(
                    "anim.frame_number",
                    "frames",
                    a.frame_number,
                    b.frame_number,
                    report,
                );
            }
            if both(Fields::ANIM_ID, "anim.id", report) {
                id("anim.id", a.id, b.id, report);
            }
            if both(Fields::ANIM_FIRST_CYCLIC, "anim.first_cyclic", report)
                && a.first_cyclic != b.first_cyclic
            {
                structure(
                    "anim.first_cyclic",
                    &|| (a.first_cyclic.into(), b.first_cyclic.into()),
                    report,
                );
            }
            if both(Fields::ANIM_QUEUE, "anim.queue", report) {
                list(
                    "anim.queue",
                    "",
                    &a.queue,
                    &b.queue,
                    |id| put::id(*id),
                    |a, b| a == b,
                    report,
                );
            }
            if both(Fields::ANIM_VELOCITY, "anim.velocity", report) {
                floats("anim.velocity", "m/s", &a.velocity, &b.velocity, report);
            }
            if both(Fields::ANIM_OMEGA, "anim.omega", report) {
                floats("anim.omega", "rad/s", &a.omega, &b.omega, report);
            }
        }
        (a, b) => structure(
            "anim",
            &|| (null_or(a.is_some()), null_or(b.is_some())),
            report,
        ),
    }
}

fn null_or(present: bool) -> Value {
    if present {
        "present".into()
    } else {
        Value::Null
    }
}

fn motion(expected: &FrameState, actual: &FrameState, report: Report<'_>) {
    let (a, b) = match (&expected.motion, &actual.motion) {
        (None, None) => return,
        (Some(a), Some(b)) => (a, b),
        (a, b) => {
            return structure(
                "motion",
                &|| (null_or(a.is_some()), null_or(b.is_some())),
                report,
            );
        }
    };
    for (field, name, a, b) in [
        (Fields::MOTION_STYLE, "motion.style", a.style, b.style),
        (
            Fields::MOTION_SUBSTATE,
            "motion.substate",
            a.substate,
            b.substate,
        ),
        (
            Fields::MOTION_FORWARD,
            "motion.forward",
            a.forward,
            b.forward,
        ),
        (
            Fields::MOTION_SIDESTEP,
            "motion.sidestep",
            a.sidestep,
            b.sidestep,
        ),
        (Fields::MOTION_TURN, "motion.turn", a.turn, b.turn),
    ] {
        if presence(expected.has, actual.has, field, name, report) {
            id(name, a, b, report);
        }
    }
    for (field, name, a, b) in [
        (
            Fields::MOTION_SUBSTATE_SPEED,
            "motion.substate_speed",
            a.substate_speed,
            b.substate_speed,
        ),
        (
            Fields::MOTION_FORWARD_SPEED,
            "motion.forward_speed",
            a.forward_speed,
            b.forward_speed,
        ),
        (
            Fields::MOTION_SIDESTEP_SPEED,
            "motion.sidestep_speed",
            a.sidestep_speed,
            b.sidestep_speed,
        ),
        (
            Fields::MOTION_TURN_SPEED,
            "motion.turn_speed",
            a.turn_speed,
            b.turn_speed,
        ),
    ] {
        if presence(expected.has, actual.has, field, name, report) {
            float(name, "", a, b, report);
        }
    }
}

fn lists(expected: &FrameState, actual: &FrameState, report: Report<'_>) {
    if presence(expected.has, actual.has, Fields::STEPS, "steps", report) {
        let count = expected.steps.len() == actual.steps.len();
        for (index, (a, b)) in expected
            .steps
            .iter()
            .zip(&actual.steps)
            .enumerate()
            .filter(|_| count)
        {
            if !same(a.dt, b.dt) {
                let values = || (put::f32(a.dt), put::f32(b.dt));
                let error = Some(error::between(a.dt, b.dt));
                report(&Difference {
                    field: "steps",
                    index: Some(index),
                    rest: ".dt",
                    error,
                    unit: "s",
                    values: &values,
                });
            }
            if a.outcome != b.outcome {
                let values = || (outcome(a.outcome), outcome(b.outcome));
                report(&Difference {
                    field: "steps",
                    index: Some(index),
                    rest: ".outcome",
                    error: None,
                    unit: "",
                    values: &values,
                });
            }
        }
        if !count {
            let show = |state: &FrameState| {
                state
                    .steps
                    .iter()
                    .map(|step| json!({"dt": put::f32(step.dt), "outcome": outcome(step.outcome)}))
                    .collect::<Value>()
            };
            structure("steps", &|| (show(expected), show(actual)), report);
        }
    }
    if presence(
        expected.has,
        actual.has,
        Fields::COLLISIONS,
        "collisions",
        report,
    ) {
        let show = |collision: &Collision| match collision {
            Collision::Environment => "environment".into(),
            Collision::Object(guid) => put::id(*guid),
        };
        list(
            "collisions",
            "",
            &expected.collisions,
            &actual.collisions,
            show,
            |a, b| a == b,
            report,
        );
    }
    if presence(expected.has, actual.has, Fields::EVENTS, "events", report) {
        list(
            "events",
            "",
            &expected.events,
            &actual.events,
            |event| event.to_string().into(),
            |a, b| a == b,
            report,
        );
    }
}

/// Lists of the same length differ in an item, others as a whole.
fn list<T>(
    field: &'static str,
    rest: &'static str,
    expected: &[T],
    actual: &[T],
    show: impl Fn(&T) -> Value,
    same: impl Fn(&T, &T) -> bool,
    report: Report<'_>,
) {
    if expected.len() != actual.len() {
        let values = || {
            (
                expected.iter().map(&show).collect(),
                actual.iter().map(&show).collect(),
            )
        };
        return structure(field, &values, report);
    }
    for (index, (a, b)) in expected
        .iter()
        .zip(actual)
        .enumerate()
        .filter(|(_, (a, b))| !same(a, b))
    {
        let values = || (show(a), show(b));
        report(&Difference {
            field,
            index: Some(index),
            rest,
            error: None,
            unit: "",
            values: &values,
        });
    }
}

/// What a walk over two JSON values reports: path, expected, actual.
pub type ValueReport<'a> = &'a mut dyn FnMut(&str, &Value, Option<&Value>);

/// Reports every leaf of `expected` that `actual` does not match. What only `actual` has is left out.
pub fn value_differences(
    path: &str,
    expected: &Value,
    actual: Option<&Value>,
    report: ValueReport<'_>,
) {
    match (expected, actual) {
        (Value::Object(fields), Some(Value::Object(others))) => {
            for (key, value) in fields {
                value_differences(&format!("{path}.{key}"), value, others.get(key), report);
            }
        }
        (Value::Array(items), Some(Value::Array(others))) if items.len() == others.len() => {
            for (index, (item, other)) in items.iter().zip(others).enumerate() {
                value_differences(&format!("{path}[{index}]"), item, Some(other), report);
            }
        }
        (expected, Some(actual)) if crate::vectors::same_leaf(expected, actual) => {}
        (expected, actual) => report(path, expected, actual),
    }
}

/// `out.position.origin[2]` as `position.origin`.
pub fn without_indices(path: &str) -> String {
    let mut depth = 0;
    let plain: String = path
        .chars()
        .filter(|c| {
            depth += i32::from(*c == '[');
            let keep = depth == 0;
            depth -= i32::from(*c == ']');
            keep
        })
        .collect();
    plain.strip_prefix("out.").map_or(plain.clone(), Into::into)
}
