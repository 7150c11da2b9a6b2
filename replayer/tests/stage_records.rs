//! Every recorded stage that can run alone gives its recorded output, bit for bit.

use std::collections::BTreeMap;

use ac_client::profile::Profile;
use ac_golden_traces::corpus;
use ac_golden_traces::trace::{ChannelKind, TraceEvent, TraceReader};
use ac_replayer::Simulator;
use ac_replayer::client::ClientSimulator;
use serde_json::Value;

/// Stages whose records must all be met.
const EXACT: [&str; 1] = ["transition"];

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
            if !EXACT.iter().any(|stage| record["stage"] == *stage) {
                continue;
            }
            let Some(out) = simulation.run_stage(&records, index).unwrap() else {
                continue;
            };
            let stage = record["stage"].as_str().unwrap();
            let entry = tally.entry(stage.to_owned()).or_default();
            entry.ran += 1;
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

#[test]
fn recorded_stages_are_met() {
    let root = corpus::bundled();
    let simulator = ClientSimulator::new(root.join("worlds"));
    let mut tally = BTreeMap::new();
    for path in corpus::find(&root.join("traces"), &[corpus::TRACE_SUFFIX]).unwrap() {
        run_trace(&path, &simulator, &mut tally);
    }
    for (stage, t) in &tally {
        println!("{stage}: {} of {} exact", t.exact, t.ran);
    }
    for stage in EXACT {
        let t = &tally[stage];
        assert!(t.ran > 0);
        assert_eq!(t.exact, t.ran, "{stage}: {:?}", t.first);
    }
}
