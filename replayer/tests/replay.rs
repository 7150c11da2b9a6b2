//! `ac-replay run` from outside: a trace of what the client does, which is what the oracle expects.

use std::{path::Path, process::Command};

use ac_client::frame::{FrameState, FrameStates};
use ac_golden_traces::{
    corpus,
    trace::{ChannelKind, TraceEvent, TraceReader},
};

/// The frames of one channel.
fn frames(path: &Path, topic: &str) -> Vec<Vec<FrameState>> {
    let mut reader = TraceReader::open(path).expect("it is a trace");
    let mut states = FrameStates::new();
    let mut frames = Vec::new();
    while let Some(event) = reader.next_event(&mut states).expect("it is whole") {
        if let TraceEvent::States { kind, .. } = event
            && kind.topic() == topic
        {
            frames.push(states.to_vec());
        }
    }
    frames
}

fn replay(arguments: &[&str]) -> i32 {
    let output = Command::new(env!("CARGO_BIN_EXE_ac-replay"))
        .args(arguments)
        .output()
        .expect("the program starts");
    output.status.code().expect("it was not killed")
}

#[test]
fn a_replayed_scene_has_the_states_that_its_oracle_expects() {
    let scene = corpus::bundled().join("traces/terrain/cliff-jump.mcap");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.mcap");
    let arguments = [
        "run",
        scene.to_str().unwrap(),
        "--profile",
        "gdle",
        "-o",
        out.to_str().unwrap(),
    ];
    assert_eq!(replay(&arguments), 0);
    let bytes = std::fs::read(&out).unwrap();
    let produced = frames(&out, "/states");
    let expected = frames(&scene, &ChannelKind::Expect("gdle".into()).topic());
    assert_eq!(produced.len(), expected.len());
    for (produced, expected) in produced.iter().flatten().zip(expected.iter().flatten()) {
        assert!(
            produced.fields_same_bits(expected, expected.has),
            "{produced:?}\n{expected:?}"
        );
    }
    assert_eq!(TraceReader::open(&out).unwrap().info().profile, "gdle");
    // The same again gives the same file.
    assert_eq!(replay(&arguments), 0);
    assert!(
        bytes == std::fs::read(&out).unwrap(),
        "a second run wrote other bytes"
    );
}

#[test]
fn what_cannot_run_is_two() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.mcap");
    assert_eq!(
        replay(&["run", "/no/such.scene.json", "-o", out.to_str().unwrap()]),
        2
    );
    let scene = corpus::bundled().join("traces/terrain/cliff-jump.mcap");
    let scene = scene.to_str().unwrap();
    assert_eq!(
        replay(&[
            "run",
            scene,
            "--profile",
            "nobody",
            "-o",
            out.to_str().unwrap()
        ]),
        2
    );
    assert_eq!(
        replay(&[
            "run",
            scene,
            "--worlds",
            "/no/such",
            "-o",
            out.to_str().unwrap()
        ]),
        2
    );
}

#[test]
fn a_run_can_be_drawn() {
    let scene = corpus::bundled().join("traces/terrain/cliff-jump.mcap");
    let folder = tempfile::tempdir().unwrap();
    let (out, pictures) = (
        folder.path().join("out.mcap"),
        folder.path().join("pictures.mcap"),
    );
    let arguments = [
        "run",
        scene.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
        "--foxglove",
        pictures.to_str().unwrap(),
    ];
    assert_eq!(replay(&arguments), 0);
    let bytes = std::fs::read(&pictures).unwrap();
    let mut topics = std::collections::BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let channel = message.unwrap().channel.clone();
        let schema = channel.schema.as_ref().unwrap();
        *topics
            .entry((channel.topic.clone(), schema.name.clone()))
            .or_insert(0) += 1;
    }
    let names: Vec<_> = topics
        .keys()
        .map(|(t, s)| (t.as_str(), s.as_str()))
        .collect();
    let expected = [
        ("/log", "foxglove.Log"),
        ("/scene", "foxglove.SceneUpdate"),
        ("/tf", "foxglove.FrameTransforms"),
    ];
    assert_eq!(names, expected);
}
