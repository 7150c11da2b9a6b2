//! The checkpoints of a free run are those that the independent model recorded: record for record, bit for bit.

use std::collections::BTreeMap;
use std::path::Path;

use ac_client::frame::FrameStates;
use ac_client::profile::Profile;
use ac_golden_traces::corpus;
use ac_golden_traces::trace::{ChannelKind, TraceEvent, TraceReader};
use ac_replayer::Simulator;
use ac_replayer::client::ClientSimulator;
use serde_json::Value;
use serde_json::value::RawValue;

/// Scenes that together run every stage.
const SCENES: [&str; 8] = [
    "bounce/drop",
    "clock/hitch-0.5",
    "interp/blip",
    "lifecycle/parent-teleport",
    "missile/hit-wall",
    "moveto/turn-to-heading",
    "objects/players",
    "sticky/far",
];

/// Of a refused transition only this much is defined.
const REFUSED: [&str; 5] = [
    "valid",
    "outcome",
    "velocity",
    "sub_steps",
    "sub_steps_planned",
];

#[derive(Debug, Default)]
struct Tally {
    total: u32,
    equal: u32,
    /// Differences by field: how many, and the first.
    fields: BTreeMap<String, (u32, String)>,
}

impl Tally {
    fn differs(&mut self, field: String, text: impl FnOnce() -> String) {
        let entry = self.fields.entry(field).or_default();
        entry.0 += 1;
        if entry.0 == 1 {
            entry.1 = text();
        }
    }
}

/// Whether two values are the same, numbers bit for bit whether or not they are written as integers.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            a.as_f64().map(f64::to_bits) == b.as_f64().map(f64::to_bits)
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && (a.iter()).all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
        }
        _ => a == b,
    }
}

/// A record without what the model does not keep up during a turn: the count of failures, which nothing reads, and the times of the
/// samples, which the next walk sets before it reads them. The client follows 08, 2.3 and 11 there.
fn comparable(text: &RawValue) -> Value {
    let mut record: Value = serde_json::from_str(text.get()).unwrap();
    for side in ["in", "out"] {
        let Some(move_to) = record[side].get_mut("move_to") else {
            continue;
        };
        if move_to["nodes"][0][0] == "turn"
            && let Some(fields) = move_to.as_object_mut()
        {
            fields.retain(|name, _| {
                !["fail_count", "previous_time", "original_time"].contains(&name.as_str())
            });
        }
    }
    record
}

fn compare(recorded: &Value, written: &Value, place: &str, tally: &mut Tally) {
    tally.total += 1;
    let before = tally.fields.values().map(|(n, _)| n).sum::<u32>();
    for head in ["frame", "guid", "quantum", "stage"] {
        if !same(&recorded[head], &written[head]) {
            tally.differs(head.into(), || format!("{place}: {recorded}\n{written}"));
        }
    }
    let refused = recorded["out"].get("valid") == Some(&Value::Bool(false));
    for side in ["in", "out"] {
        let (Some(recorded), Some(written)) =
            (recorded[side].as_object(), written[side].as_object())
        else {
            tally.differs(side.into(), || format!("{place}: no object"));
            continue;
        };
        for (key, value) in recorded {
            if side == "out" && refused && !REFUSED.contains(&key.as_str()) {
                continue;
            }
            let actual = written.get(key);
            if !actual.is_some_and(|actual| same(value, actual)) {
                let text = || format!("{place}:\n  recorded {value}\n  written  {actual:?}");
                tally.differs(format!("{side}.{key}"), text);
            }
        }
        for key in written.keys().filter(|key| !recorded.contains_key(*key)) {
            tally.differs(format!("{side}.{key}"), || format!("{place}: not recorded"));
        }
    }
    let after = tally.fields.values().map(|(n, _)| n).sum::<u32>();
    tally.equal += u32::from(before == after);
}

fn compare_frame(
    scene: &str,
    frame: i32,
    recorded: &[Box<RawValue>],
    written: &[Box<RawValue>],
    tallies: &mut BTreeMap<String, Tally>,
) {
    if recorded.len() != written.len() {
        let entry = tallies.entry("number of records".into()).or_default();
        entry.total += 1;
        entry.differs(String::new(), || {
            format!(
                "{scene} frame {frame}: {} recorded, {} written",
                recorded.len(),
                written.len()
            )
        });
    }
    for (recorded, written) in recorded.iter().zip(written) {
        let (recorded, written) = (comparable(recorded), comparable(written));
        let stage = recorded["stage"].as_str().unwrap();
        let place = format!(
            "{scene} frame {frame} {} {}",
            recorded["guid"], recorded["quantum"]
        );
        let tally = tallies.entry(stage.to_owned()).or_default();
        compare(&recorded, &written, &place, tally);
    }
}

/// Runs the scene of a trace and compares with what is recorded in it, if anything is.
fn run_trace(path: &Path, simulator: &ClientSimulator, tallies: &mut BTreeMap<String, Tally>) {
    let mut reader = TraceReader::open(path).unwrap();
    reader.select(|kind| matches!(kind, ChannelKind::Stages(_)));
    let scene = reader.scene().clone();
    let profile = Profile::named("gdle-repaired").unwrap();
    let mut simulation = simulator.start(&scene, &profile).unwrap();
    let mut states = FrameStates::default();
    let mut written = Vec::new();
    let mut next = 0;
    simulation.frame_minus_one(&mut states).unwrap();
    while let Some(event) = reader.next_event(&mut states).unwrap() {
        let TraceEvent::Stages { message, .. } = event else {
            continue;
        };
        let frame = u32::try_from(message.frame).unwrap();
        let mut produced = FrameStates::default();
        while next <= frame {
            if next > 0 && next < frame {
                compare_frame(&scene.name, message.frame, &[], &written, tallies);
            }
            written.clear();
            simulation
                .step_with_checkpoints(next, &mut produced, &mut written)
                .unwrap();
            next += 1;
        }
        compare_frame(
            &scene.name,
            message.frame,
            &message.records,
            &written,
            tallies,
        );
        written.clear();
    }
}

fn report(tallies: &BTreeMap<String, Tally>) {
    for (stage, tally) in tallies {
        println!("{stage}: {} of {} equal", tally.equal, tally.total);
        for (field, (count, first)) in &tally.fields {
            println!("  {field}: {count}, first {first}");
        }
    }
}

fn assert_equal(tallies: &BTreeMap<String, Tally>) {
    report(tallies);
    for stage in [
        "animation",
        "adjust",
        "integrate",
        "hooks",
        "transition",
        "commit",
        "motion",
    ] {
        assert!(
            tallies.get(stage).is_some_and(|t| t.total > 0),
            "{stage} did not run"
        );
    }
    for (stage, tally) in tallies {
        assert_eq!(tally.equal, tally.total, "{stage}: {:?}", tally.fields);
    }
}

#[test]
fn written_checkpoints_are_the_recorded_ones() {
    let root = corpus::bundled();
    let simulator = ClientSimulator::new(root.join("worlds"));
    let mut tallies = BTreeMap::new();
    for scene in SCENES {
        let path = root.join(format!("traces/{scene}.mcap"));
        run_trace(&path, &simulator, &mut tallies);
    }
    assert_equal(&tallies);
}

#[test]
#[ignore = "every scene takes a while without optimisation"]
fn written_checkpoints_of_every_scene_are_the_recorded_ones() {
    let root = corpus::bundled();
    let simulator = ClientSimulator::new(root.join("worlds"));
    let mut tallies = BTreeMap::new();
    for path in corpus::find(&root.join("traces"), &[corpus::TRACE_SUFFIX]).unwrap() {
        run_trace(&path, &simulator, &mut tallies);
    }
    assert_equal(&tallies);
}
