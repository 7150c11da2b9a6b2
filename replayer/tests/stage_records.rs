//! Every stage, run alone from its record, gives the recorded output, bit for bit. One scene or two of each area; `ac-conform run --mode stage`
//! runs all.

use std::collections::BTreeMap;

use ac_client::profile::Profile;
use ac_golden_traces::corpus;
use ac_golden_traces::trace::{ChannelKind, TraceEvent, TraceReader};
use ac_replayer::Simulator;
use ac_replayer::client::ClientSimulator;
use serde_json::Value;

/// Scenes whose records are run.
const SCENES: [&str; 18] = [
    "bounce/small-velocity",
    "building/jump-through-door",
    "clock/late-start",
    "dungeon/leave-by-teleport",
    "extreme/nan-velocity",
    "extreme/static-object",
    "interp/blip",
    "jump/turn-in-air",
    "lifecycle/create-destroy",
    "lifecycle/parent-teleport",
    "missile/hit-wall",
    "motion/actions",
    "moveto/object-gone",
    "objects/half-sunk-crates",
    "sticky/constraint",
    "sticky/far",
    "sticky/target-gone",
    "terrain/run-block-border-east",
];

/// Stages whose records must all be met.
const EXACT: [&str; 7] = [
    "animation",
    "adjust",
    "integrate",
    "hooks",
    "transition",
    "commit",
    "motion",
];

#[derive(Default)]
struct Tally {
    ran: u32,
    exact: u32,
    first: Option<String>,
}

/// Whether two values are the same, numbers bit for bit whether or not they are written as integers.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let bits = |n: &serde_json::Number| n.as_f64().map(f64::to_bits);
            bits(a) == bits(b)
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len()
                && a.iter()
                    .all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
        }
        _ => a == b,
    }
}

/// First differing field of two outputs.
fn difference(expected: &Value, actual: &Value) -> Option<String> {
    let (Value::Object(e), Value::Object(a)) = (expected, actual) else {
        return (expected != actual).then(|| format!("expected {expected}, got {actual}"));
    };
    // A refused transition leaves the mover where it is: only this much matters.
    let refused = e.get("valid") == Some(&Value::Bool(false));
    let matters = |key: &str| {
        !refused
            || [
                "valid",
                "outcome",
                "velocity",
                "sub_steps",
                "sub_steps_planned",
            ]
            .contains(&key)
    };
    e.iter()
        .filter(|(key, _)| matters(key))
        .find(|&(key, value)| !a.get(key).is_some_and(|a| same(value, a)))
        .map(|(key, value)| {
            format!(
                "{key}: expected {value}, got {:?}",
                a.get(key).map(Value::to_string)
            )
        })
}

fn run_trace(
    path: &std::path::Path,
    simulator: &ClientSimulator,
    tally: &mut BTreeMap<String, Tally>,
) {
    let mut reader = TraceReader::open(path).unwrap();
    reader.select(|kind| matches!(kind, ChannelKind::Stages(_)));
    let scene = reader.scene().clone();
    let profile = Profile::named("gdle-repaired").unwrap();
    let mut simulation = simulator.start(&scene, &profile).unwrap();
    let mut states = ac_client::frame::FrameStates::default();
    while let Some(event) = reader.next_event(&mut states).unwrap() {
        let TraceEvent::Stages { message, .. } = event else {
            continue;
        };
        let records: Vec<Value> = message
            .records
            .iter()
            .map(|raw| serde_json::from_str(raw.get()).unwrap())
            .collect();
        for index in 0..records.len() {
            let record = &records[index];
            let stage = record["stage"].as_str().unwrap();
            let entry = tally.entry(stage.to_owned()).or_default();
            entry.ran += 1;
            let out = simulation.run_stage(&records, index).unwrap();
            let out = out.unwrap_or(Value::Null);
            match difference(&record["out"], &out) {
                None => entry.exact += 1,
                Some(text) => {
                    let place = format!(
                        "{} frame {} {} quantum {} ({}): {text}",
                        scene.name,
                        record["frame"],
                        record["guid"],
                        record["quantum"],
                        record["out"]["outcome"]
                    );
                    println!("{place}");
                    entry.first.get_or_insert(place);
                }
            }
        }
    }
}

fn simulator() -> ClientSimulator {
    ClientSimulator::new(corpus::bundled().join("worlds"))
}

fn trace(scene: &str) -> std::path::PathBuf {
    let name = format!("{scene}{}", corpus::TRACE_SUFFIX);
    corpus::bundled().join("traces").join(name)
}

#[test]
fn recorded_stages_are_met() {
    let simulator = simulator();
    let mut tally = BTreeMap::new();
    for scene in SCENES {
        run_trace(&trace(scene), &simulator, &mut tally);
    }
    for (stage, t) in &tally {
        println!("{stage}: {} of {} exact", t.exact, t.ran);
    }
    assert_eq!(tally.len(), EXACT.len());
    for stage in EXACT {
        let t = &tally[stage];
        assert!(t.ran > 0);
        assert_eq!(t.exact, t.ran, "{stage}: {:?}", t.first);
    }
}

/// What is recorded wins over the scene beside the records: a changed `in` changes the `out` accordingly, and only of that record.
#[test]
fn recorded_inputs_win() {
    let mut reader = TraceReader::open(&trace("moveto/object-gone")).unwrap();
    reader.select(|kind| matches!(kind, ChannelKind::Stages(_)));
    let scene = reader.scene().clone();
    let profile = Profile::named("gdle-repaired").unwrap();
    let mut simulation = simulator().start(&scene, &profile).unwrap();
    let mut states = ac_client::frame::FrameStates::default();
    let mut changed = 0;
    while let Some(event) = reader.next_event(&mut states).unwrap() {
        let TraceEvent::Stages { message, .. } = event else {
            continue;
        };
        let mut records: Vec<Value> = message
            .records
            .iter()
            .map(|raw| serde_json::from_str(raw.get()).unwrap())
            .collect();
        for index in 0..records.len() {
            let recorded = records[index].clone();
            if !change(&mut records[index]) {
                continue;
            }
            changed += 1;
            let out = simulation.run_stage(&records, index).unwrap().unwrap();
            let place = format!("frame {} {}", recorded["frame"], recorded["stage"]);
            assert!(follows(&out, &recorded["out"]), "{place}");
            records[index] = recorded;
            let out = simulation.run_stage(&records, index).unwrap().unwrap();
            let difference = difference(&records[index]["out"], &out);
            assert_eq!(difference, None, "{place}");
        }
    }
    assert!(changed > 100);
}

/// Changes an input that its stage hands through.
fn change(record: &mut Value) -> bool {
    let input = &mut record["in"];
    if input["kind"] == "still" {
        input["omega"] = serde_json::json!([0.25, 0.5, 0.75]);
        return true;
    }
    let idle = record["stage"] == "motion" && record["in"]["pending"] == serde_json::json!([]);
    if idle {
        // A motion that waits for three animations stays.
        record["in"]["table"]["queue"] = serde_json::json!([["0x44000007", 3]]);
    }
    idle && record["out"]["events"] == serde_json::json!([])
        && record["out"]["table"]["queue"] == serde_json::json!([])
}

/// Whether the output shows the change.
fn follows(out: &Value, recorded: &Value) -> bool {
    let expected = serde_json::json!([0.25, 0.5, 0.75]);
    let queue = serde_json::json!([["0x44000007", 3]]);
    if recorded.get("omega").is_some() {
        same(&out["omega"], &expected)
    } else {
        same(&out["table"]["queue"], &queue)
    }
}
