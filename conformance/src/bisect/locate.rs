//! Where two traces of the same scene part: the frame and the fields, and the stage that did it.
//!
//! Stage records ([`ac_replayer::checkpoints`]) are in the order in which the stages ran. The first record that is not the same
//! in both traces tells the stage: if it got the same and gave something else, the stage itself changed; if it already got
//! something else, what lies before it did (packets, script steps, creation, or what runs between the stages).

use std::{fs::File, path::Path};

use ac_client::frame::FrameStates;
use ac_golden_traces::trace::{ChannelFilter, ChannelKind, StageMessage, TraceEvent, TraceReader};
use serde::Serialize;
use serde_json::{Value, value::RawValue};

use super::{
    BisectError,
    verdict::{self, Place},
};
use crate::compare::fields;

/// Differences that are listed.
const LISTED: usize = 12;

/// Where two traces part.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Location {
    /// The first frame whose states differ, with its differences.
    pub states: Vec<Place>,
    /// The first stage that differs.
    pub stage: Option<StageDifference>,
}

/// The first stage record that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageDifference {
    /// The frame.
    pub frame: i32,
    /// The entity.
    pub guid: String,
    /// The quantum in the frame.
    pub quantum: u64,
    /// The stage.
    pub stage: String,
    /// How it differs.
    pub how: How,
    /// What differs: path in the record, value of the good build, value of the bad one.
    pub fields: Vec<(String, Value, Value)>,
}

/// How a stage differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// The same input, another output: the stage itself.
    Output,
    /// It got something else: what lies before it.
    Input,
    /// Only the good build runs it there.
    OnlyGood,
    /// Only the bad build runs it there.
    OnlyBad,
}

impl How {
    /// What it means, for people.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Output => "same input, other output: this stage changed",
            Self::Input => {
                "other input: what lies before this stage changed (packets, script, creation, order)"
            }
            Self::OnlyGood => "the bad build does not run this stage here",
            Self::OnlyBad => "the good build does not run this stage here",
        }
    }
}

/// Compares two traces that builds wrote.
///
/// # Errors
/// When one cannot be read.
pub fn locate(good: &Path, bad: &Path) -> Result<Location, BisectError> {
    Ok(Location {
        states: states(good, bad)?,
        stage: stages(good, bad)?,
    })
}

fn states(good: &Path, bad: &Path) -> Result<Vec<Place>, BisectError> {
    let is_states: ChannelFilter = |kind| *kind == ChannelKind::States;
    let mut sides = [open(good, is_states)?, open(bad, is_states)?];
    let mut read = [FrameStates::new(), FrameStates::new()];
    loop {
        let mut frames = [None, None];
        for (side, (states, frame)) in sides.iter_mut().zip(read.iter_mut().zip(&mut frames)) {
            if let Some(TraceEvent::States { frame: of, .. }) = side.next_event(states)? {
                *frame = Some(of);
            }
        }
        let [Some(frame), bad] = frames else {
            return Ok(Vec::new());
        };
        let actual = bad.is_some().then_some(&read[1]);
        let mut places = verdict::differences(frame, &read[0], actual, None);
        if !places.is_empty() {
            places.truncate(LISTED);
            return Ok(places);
        }
    }
}

fn open(path: &Path, wanted: ChannelFilter) -> Result<TraceReader<File>, BisectError> {
    let mut reader = TraceReader::open(path)?;
    reader.select(wanted);
    Ok(reader)
}

/// The stage records of the next frame.
fn next(reader: &mut TraceReader<File>) -> Result<Option<StageMessage>, BisectError> {
    match reader.next_event(&mut FrameStates::new())? {
        Some(TraceEvent::Stages { message, .. }) => Ok(Some(message)),
        _ => Ok(None),
    }
}

fn stages(good: &Path, bad: &Path) -> Result<Option<StageDifference>, BisectError> {
    let is_stages: ChannelFilter = |kind| matches!(kind, ChannelKind::Stages(_));
    let mut sides = [open(good, is_stages)?, open(bad, is_stages)?];
    loop {
        let [a, b] = &mut sides;
        let (Some(a), Some(b)) = (next(a)?, next(b)?) else {
            return Ok(None);
        };
        let found = first_stage(a.frame, &a.records, &b.records);
        if found.is_some() {
            return Ok(found);
        }
    }
}

/// The first stage record of a frame that is not the same on both sides.
pub fn first_stage(
    frame: i32,
    good: &[Box<RawValue>],
    bad: &[Box<RawValue>],
) -> Option<StageDifference> {
    let same = good
        .iter()
        .zip(bad)
        .take_while(|(a, b)| a.get() == b.get())
        .count();
    let parse = |records: &[Box<RawValue>]| {
        let record = records.get(same)?;
        serde_json::from_str(record.get()).ok()
    };
    difference(frame, parse(good), parse(bad))
}

fn difference(frame: i32, good: Option<Value>, bad: Option<Value>) -> Option<StageDifference> {
    let same_place = |a: &Value, b: &Value| {
        ["guid", "quantum", "stage"]
            .iter()
            .all(|key| a.get(key) == b.get(key))
    };
    let (record, how, fields) = match (good, bad) {
        (Some(good), Some(bad)) if same_place(&good, &bad) => {
            let input = paths("in", &good, &bad);
            if input.is_empty() {
                let output = paths("out", &good, &bad);
                (good, How::Output, output)
            } else {
                (good, How::Input, input)
            }
        }
        // The lists go apart here. The longer one has a record more, as a rule; which one, nobody can say.
        (Some(good), None) => (good, How::OnlyGood, Vec::new()),
        (None, Some(bad)) => (bad, How::OnlyBad, Vec::new()),
        (Some(good), Some(bad)) => {
            if order(&good) <= order(&bad) {
                (good, How::OnlyGood, Vec::new())
            } else {
                (bad, How::OnlyBad, Vec::new())
            }
        }
        (None, None) => return None,
    };
    let text = |key: &str| record.get(key).and_then(Value::as_str).unwrap_or("?");
    Some(StageDifference {
        frame,
        guid: text("guid").into(),
        quantum: record.get("quantum").and_then(Value::as_u64).unwrap_or(0),
        stage: text("stage").into(),
        how,
        fields,
    })
}

/// Place of a record in its entity's tick: quantum, then the order of the stages.
fn order(record: &Value) -> (u64, usize) {
    const STAGES: [&str; 7] = [
        "animation",
        "adjust",
        "integrate",
        "hooks",
        "transition",
        "commit",
        "motion",
    ];
    let stage = record.get("stage").and_then(Value::as_str);
    (
        record.get("quantum").and_then(Value::as_u64).unwrap_or(0),
        STAGES
            .iter()
            .position(|name| Some(*name) == stage)
            .unwrap_or(STAGES.len()),
    )
}

/// Every leaf in which a part of two records differs, also where only the bad one has it.
fn paths(part: &str, good: &Value, bad: &Value) -> Vec<(String, Value, Value)> {
    let (good, bad) = (&good[part], &bad[part]);
    let mut found: Vec<(String, Value, Value)> = Vec::new();
    fields::value_differences(part, good, Some(bad), &mut |path, a, b| {
        found.push((path.into(), a.clone(), b.cloned().unwrap_or(Value::Null)));
    });
    fields::value_differences(part, bad, Some(good), &mut |path, b, a| {
        if !found.iter().any(|(known, ..)| known == path) {
            found.push((path.into(), a.cloned().unwrap_or(Value::Null), b.clone()));
        }
    });
    found.truncate(LISTED);
    found
}
