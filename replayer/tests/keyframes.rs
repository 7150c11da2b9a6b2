//! Keyframes over all bundled scenes: going on from one is the same as not having stopped.

use std::path::{Path, PathBuf};
use std::process::Command;

use ac_client::{
    frame::{FrameState, FrameStates},
    profile::Profile,
};
use ac_golden_traces::{Scene, corpus, trace::TraceReader};
use ac_replayer::{
    Simulation, Simulator,
    client::ClientSimulator,
    keyframes::{Identity, KeyframeHeader, decode, encode},
};
use rayon::prelude::*;

/// All but packet sessions, which take no keyframes (`ac-replay run --keyframes` refuses them).
fn traces() -> Vec<PathBuf> {
    let folder = corpus::bundled().join("traces");
    let mut all = corpus::find(&folder, &[".mcap"]).expect("the traces are there");
    all.retain(|path| !path.starts_with(folder.join("packets")));
    all
}

/// The records of the rest of a run from `next` on, and all state at its end.
fn finish(simulation: &mut dyn Simulation, next: u32, end: u32) -> (Vec<Vec<FrameState>>, Vec<u8>) {
    let mut states = FrameStates::new();
    let mut frames = Vec::new();
    for frame in next..end {
        states.clear();
        simulation.step(frame, &mut states).expect("the scene runs");
        frames.push(states.to_vec());
    }
    let state = simulation.snapshot().expect("it can be stored");
    (frames, state.expect("this client takes snapshots"))
}

fn same(a: &[FrameState], b: &[FrameState]) -> bool {
    a.len() == b.len()
        && a.iter()
            .zip(b)
            .all(|(a, b)| a.has == b.has && a.guid == b.guid && a.fields_same_bits(b, b.has))
}

/// Runs a scene straight, takes keyframes on the way, goes on from each, and compares every frame after it and all state at the end.
fn check(
    path: &Path,
    simulator: &ClientSimulator,
    profile: &Profile,
    at: &[u32],
) -> Result<(), String> {
    let reader = TraceReader::open(path).expect("it is a trace");
    let (scene, text) = (reader.scene().clone(), reader.scene_text().to_vec());
    let identity = Identity::new(reader.info(), &text, profile);
    let count = scene.frame_count();
    let mut straight = simulator.start(&scene, profile).expect("the scene starts");
    let mut states = FrameStates::new();
    straight.frame_minus_one(&mut states).unwrap();
    let (mut frames, mut keyframes) = (Vec::new(), Vec::new());
    for frame in 0..count {
        states.clear();
        straight.step(frame, &mut states).expect("the scene runs");
        frames.push(states.to_vec());
        // The first frame, the last but one, and some between.
        let wanted = at.iter().any(|share| frame == (count - 1) * share / 100);
        if wanted {
            let snapshot = straight.snapshot().unwrap().unwrap();
            let header = KeyframeHeader::new(frame.cast_signed(), &identity, &snapshot);
            keyframes.push((frame, encode(&header, &snapshot).expect("it is written")));
        }
    }
    let end = straight.snapshot().unwrap().unwrap();
    for (frame, bytes) in keyframes {
        let context = format!("{} {} after frame {frame}", scene.name, profile.name);
        let (header, snapshot) = decode(&bytes).expect("it is read");
        identity.accept(&header).expect("it is of this run");
        let mut resumed =
            resume(simulator, &scene, profile, &snapshot).map_err(|e| format!("{context}: {e}"))?;
        resumed.records(frame.cast_signed(), &mut states).unwrap();
        if !same(&states, &frames[frame as usize]) {
            return Err(format!("{context}: its own records differ"));
        }
        if resumed.snapshot().unwrap().unwrap() != snapshot {
            return Err(format!("{context}: stored again it is another state"));
        }
        let (rest, last) = finish(resumed.as_mut(), frame + 1, count);
        for (next, (a, b)) in (frame + 1..).zip(rest.iter().zip(&frames[frame as usize + 1..])) {
            if !same(a, b) {
                return Err(format!("{context}: frame {next} differs"));
            }
        }
        if last != end {
            return Err(format!("{context}: the state at the end differs"));
        }
    }
    Ok(())
}

fn resume(
    simulator: &ClientSimulator,
    scene: &Scene,
    profile: &Profile,
    snapshot: &[u8],
) -> Result<Box<dyn Simulation>, String> {
    simulator
        .resume(scene, profile, snapshot)
        .map_err(|error| error.to_string())
}

#[test]
fn every_scene_goes_on_from_its_keyframes_bit_for_bit() {
    let simulator = ClientSimulator::new(corpus::bundled().join("worlds"));
    let cases: Vec<(PathBuf, Profile)> = traces()
        .into_iter()
        .enumerate()
        .flat_map(|(index, path)| {
            // Every scene under two profiles, all pairs of neighbours in turn.
            [index, index + 1].map(|at| {
                let name = Profile::NAMES[at % Profile::NAMES.len()];
                let profile = Profile::named(name).expect("it is a preset");
                (path.clone(), profile)
            })
        })
        .collect();
    assert!(cases.len() > 300, "{} runs", cases.len());
    let failed: Vec<String> = cases
        .par_iter()
        .filter_map(|(path, profile)| check(path, &simulator, profile, &[0, 30, 70]).err())
        .collect();
    assert!(failed.is_empty(), "{} differ: {failed:#?}", failed.len());
}

fn replay(arguments: &[&str]) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_ac-replay"))
        .args(arguments)
        .output()
        .expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    (output.status.code().expect("it was not killed"), text)
}

/// States of a trace by frame.
fn states_of(path: &Path) -> Vec<(i32, Vec<FrameState>)> {
    use ac_golden_traces::trace::TraceEvent;

    let mut reader = TraceReader::open(path).expect("it is a trace");
    let mut states = FrameStates::new();
    let mut frames = Vec::new();
    while let Some(event) = reader.next_event(&mut states).expect("it is whole") {
        if let TraceEvent::States { frame, .. } = event {
            frames.push((frame, states.to_vec()));
        }
    }
    frames
}

#[test]
fn a_trace_with_keyframes_is_entered_anywhere() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let scene = corpus::bundled().join("traces/terrain/cliff-jump.mcap");
    let scene = scene.to_str().unwrap();
    let (whole, part) = (path("whole.mcap"), path("part.mcap"));
    let run = [
        "run",
        scene,
        "--profile",
        "ace",
        "--keyframes",
        "20",
        "-o",
        &whole,
    ];
    assert_eq!(replay(&run).0, 0);
    let (code, text) = replay(&["keyframes", &whole]);
    assert!(code == 0 && text.contains("\n      19 "), "{text}");
    let (code, text) = replay(&["seek", &whole, "--frame", "47"]);
    assert_eq!(code, 0, "{text}");
    assert!(
        text.contains("frame 47: 8 frames run from the keyframe after frame 39"),
        "{text}"
    );
    assert!(text.contains("the trace holds the same bits"), "{text}");
    let (_, from_start) = replay(&["seek", &whole, "--frame", "47", "--from-start"]);
    let hash = |text: &str| text.split("all state ").nth(1).unwrap()[..64].to_owned();
    assert_eq!(hash(&text), hash(&from_start), "all state is the same");
    let (code, text) = replay(&["seek", &whole, "--frame", "-1"]);
    assert!(
        code == 0 && text.contains("from the start of the scene"),
        "{text}"
    );
    assert_eq!(replay(&["seek", &whole, "--frame", "99999"]).0, 2);
    assert_eq!(
        replay(&["run", &whole, "--from", "41", "--to", "60", "-o", &part]).0,
        0
    );
    let whole_states = states_of(Path::new(&whole));
    let part_states = states_of(Path::new(&part));
    assert_eq!(part_states.len(), 20);
    for (frame, states) in &part_states {
        let (_, expected) = whole_states.iter().find(|(f, _)| f == frame).unwrap();
        assert!(same(states, expected), "frame {frame}");
    }
    // Under another profile the keyframes do not count, and the program says so.
    let (code, text) = replay(&["seek", &whole, "--frame", "47", "--profile", "gdle"]);
    assert!(
        code == 2 && text.contains("belongs to another profile"),
        "{text}"
    );
    let (code, _) = replay(&[
        "seek",
        &whole,
        "--frame",
        "47",
        "--profile",
        "gdle",
        "--from-start",
    ]);
    assert_eq!(code, 0);
}
