//! JSON Schemas of the messages, attached to the channels so that generic tools can read a trace.
//!
//! The types here exist for their schema only; [`super`] reads and writes the real thing.
#![allow(dead_code, reason = "only the derived schemas are used")]

use schemars::{JsonSchema, Schema, schema_for};

/// A number, or `"nan"`, `"inf"`, `"-inf"`. An f32 is written as its widened f64: narrowing is exact.
#[derive(JsonSchema)]
#[serde(untagged)]
enum Number {
    Finite(f64),
    Special(Special),
}

#[derive(JsonSchema)]
enum Special {
    #[serde(rename = "nan")]
    Nan,
    #[serde(rename = "inf")]
    Infinite,
    #[serde(rename = "-inf")]
    NegativeInfinite,
}

/// A hexadecimal id, not padded.
#[derive(JsonSchema)]
struct Id(#[schemars(regex(pattern = r"^0x[0-9A-F]{1,8}$"))] String);

type Vector = [Number; 3];

/// All records of one frame.
#[derive(JsonSchema)]
struct FrameMessage {
    /// 0-based; -1 before the first frame.
    frame: i32,
    /// Seconds.
    time: Number,
    /// In the order of the scene's `track`.
    entities: Vec<Record>,
}

/// State of one entity after the frame. What is absent is not known; an entity that is gone has cell 0x0 and events only.
#[derive(JsonSchema)]
struct Record {
    guid: Id,
    cell: Id,
    /// m, landblock-local.
    #[serde(skip_serializing_if = "Option::is_none")]
    origin: Option<Vector>,
    /// w, x, y, z.
    rotation: Option<[Number; 4]>,
    /// m/s, world space.
    velocity: Option<Vector>,
    /// m/s², world space.
    acceleration: Option<Vector>,
    /// rad/s, world space.
    omega: Option<Vector>,
    state: Option<Id>,
    transient: Option<Id>,
    contact_plane: Option<Plane>,
    sliding_normal: Option<Vector>,
    anim: Option<Anim>,
    motion: Option<Motion>,
    steps: Option<Vec<StepRecord>>,
    /// `environment` or a GUID.
    collisions: Option<Vec<String>>,
    /// hit_ground, leave_ground, motion_done:0x…, anim_hook:TYPE.
    events: Option<Vec<String>>,
}

#[derive(JsonSchema)]
struct Plane {
    n: Vector,
    d: Number,
    cell: Id,
}

#[derive(JsonSchema)]
struct Anim {
    frame_number: Number,
    id: Id,
    first_cyclic: bool,
    queue: Vec<Id>,
    velocity: Vector,
    omega: Vector,
}

#[derive(JsonSchema)]
struct Motion {
    style: Id,
    substate: Id,
    substate_speed: Number,
    forward: Option<Id>,
    forward_speed: Option<Number>,
    sidestep: Option<Id>,
    sidestep_speed: Option<Number>,
    turn: Option<Id>,
    turn_speed: Option<Number>,
}

/// One physics quantum.
#[derive(JsonSchema)]
struct StepRecord {
    /// Seconds.
    dt: Number,
    /// none, failed, ok, collided, adjusted, slid.
    outcome: String,
}

/// Frames of the same length, from `frame` on.
#[derive(JsonSchema)]
struct ClockMessage {
    frame: u32,
    /// Seconds.
    dt: f64,
    count: u32,
}

/// An input of the scene's script; its arguments depend on `do`.
#[derive(JsonSchema)]
struct ScriptMessage {
    frame: u32,
    guid: Id,
    #[serde(rename = "do")]
    action: String,
}

/// All stage checkpoints of one frame, in order.
#[derive(JsonSchema)]
struct StagesMessage {
    frame: i32,
    records: Vec<StageRecord>,
}

/// What went into and came out of one stage.
#[derive(JsonSchema)]
struct StageRecord {
    frame: i32,
    guid: Id,
    quantum: u32,
    stage: String,
    #[serde(rename = "in")]
    input: serde_json::Map<String, serde_json::Value>,
    out: serde_json::Map<String, serde_json::Value>,
}

/// Schema of `/states` and `/expect/…`.
pub fn frame_message() -> Schema {
    schema_for!(FrameMessage)
}

/// Schema of `/clock`.
pub fn clock_message() -> Schema {
    schema_for!(ClockMessage)
}

/// Schema of `/script`.
pub fn script_message() -> Schema {
    schema_for!(ScriptMessage)
}

/// Schema of `/stages/…`.
pub fn stages_message() -> Schema {
    schema_for!(StagesMessage)
}
