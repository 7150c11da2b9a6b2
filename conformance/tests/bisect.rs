//! Bisecting from outside: a scratch repository whose commits build programs with planted faults.
//!
//! A commit has a file `plant` that names the fault; "building" it writes a script that starts this test program as a stand-in for
//! `ac-replay`: the real client library, with the fault planted in the named stage. So every fault goes through real code, and a build
//! takes no time.

#![cfg(unix)]

use std::{
    fs,
    io::BufWriter,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use ac_client::profile::Profile;
use ac_golden_traces::{
    Scene, corpus,
    scene::Action,
    trace::{FormatVersion, TraceInfo, TraceReader},
};
use ac_replayer::{
    Simulator,
    client::ClientSimulator,
    replay::{Detail, replay},
};
use serde_json::Value;

/// Holds the arguments when this program is started as a stand-in.
const ARGUMENTS: &str = "AC_STAND_IN";

/// As `ac-replay run TRACE --worlds DIR --profile NAME -o OUT [--checkpoints]`, when a script says so; else nothing.
#[test]
fn the_stand_in() {
    let Ok(arguments) = std::env::var(ARGUMENTS) else {
        return;
    };
    let words: Vec<&str> = arguments.split('\n').collect();
    let value = |name: &str| {
        let place = words.iter().position(|word| *word == name).unwrap();
        words[place + 1]
    };
    let input = Path::new(words[2]);
    let (mut scene, text) = if words[2].ends_with(".mcap") {
        let reader = TraceReader::open(input).unwrap();
        (reader.scene().clone(), reader.scene_text().to_vec())
    } else {
        (Scene::open(input).unwrap(), fs::read(input).unwrap())
    };
    let mut profile = Profile::named(value("--profile")).unwrap();
    plant(words[0], &mut scene, &mut profile);
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: scene.name.clone(),
        producer: "stand-in".into(),
        profile: value("--profile").into(),
        world: Default::default(),
    };
    let simulator = ClientSimulator::new(value("--worlds"));
    let mut simulation = simulator.start(&scene, &profile).unwrap();
    let detail = match words.contains(&"--checkpoints") {
        true => Detail::Checkpoints,
        false => Detail::States,
    };
    let out = BufWriter::new(fs::File::create(value("-o")).unwrap());
    replay(simulation.as_mut(), &scene, &text, &info, detail, out).unwrap();
}

fn plant(name: &str, scene: &mut Scene, profile: &mut Profile) {
    let mut switch = |field: &str, from: Profile| {
        let of = Profile::SWITCHES.iter().find(|of| of.field == field);
        (of.unwrap().copy)(profile, &from);
    };
    match name {
        "none" => {}
        "integrator" => switch("grotate_skips_tiny", Profile::ace()),
        "transition" => switch("sphere_slide", Profile::gdle()),
        "sequence" => switch("frame_number", Profile::ace()),
        // What a position update of the server asks for is lost.
        "updates" => scene
            .script
            .retain(|step| !matches!(step.action, Action::InterpolateTo { .. })),
        "crash" => panic!("planted"),
        _ => panic!("nothing is called {name}"),
    }
}

/// A scratch repository, and where its builds go.
struct Scratch {
    folder: tempfile::TempDir,
}

impl Scratch {
    fn new() -> Self {
        let scratch = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        fs::create_dir(scratch.repository()).unwrap();
        scratch.git(&["init", "-q", "-b", "main"]);
        let script = format!(
            "set -e\nplant=$(cat plant)\ntest \"$plant\" != broken\nmkdir -p \"$CARGO_TARGET_DIR\"\n\
             cat > \"$CARGO_TARGET_DIR/ac-replay\" <<END\n#!/bin/sh\n\
             export {ARGUMENTS}=\"$plant\\$(printf '\\\\n%s' \"\\$@\")\"\n\
             exec {} --exact the_stand_in --quiet\nEND\n\
             chmod +x \"$CARGO_TARGET_DIR/ac-replay\"\n",
            std::env::current_exe().unwrap().display()
        );
        fs::write(scratch.repository().join("build.sh"), script).unwrap();
        scratch
    }

    fn repository(&self) -> PathBuf {
        self.folder.path().join("repository")
    }

    fn git(&self, arguments: &[&str]) -> String {
        let output = Command::new("git")
            .arg("-C")
            .arg(self.repository())
            .args(["-c", "user.name=Test", "-c", "user.email=test@example.com"])
            .args(["-c", "commit.gpgsign=false"])
            .args(arguments)
            .env_remove("GIT_DIR")
            .env_remove("GIT_WORK_TREE")
            .env_remove("GIT_INDEX_FILE")
            .output()
            .unwrap();
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    fn commit(&self, plant: &str, subject: &str) -> String {
        fs::write(self.repository().join("plant"), plant).unwrap();
        self.git(&["add", "-A"]);
        self.git(&["commit", "-q", "--allow-empty", "-m", subject]);
        self.git(&["rev-parse", "HEAD"])
    }

    /// A program without git.
    fn build(&self, plant: &str) -> String {
        fs::write(self.repository().join("plant"), plant).unwrap();
        let target = self.folder.path().join(plant);
        let built = Command::new("sh")
            .arg("build.sh")
            .current_dir(self.repository())
            .env("CARGO_TARGET_DIR", &target)
            .status();
        assert!(built.unwrap().success());
        target.join("ac-replay").display().to_string()
    }

    fn bisect(&self, trace: &str, more: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_ac-conform"))
            .arg("bisect")
            .arg("--trace")
            .arg(corpus::bundled().join(trace))
            .arg("--repo")
            .arg(self.repository())
            .arg("--worktree")
            .arg(self.folder.path().join("work"))
            .args(["--build-command", "sh build.sh", "--program", "ac-replay"])
            .args(more)
            .env("NO_COLOR", "1")
            .output()
            .unwrap()
    }
}

fn json(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    serde_json::from_slice(&output.stdout).expect("one JSON document")
}

/// Nine commits, of which the sixth plants a fault and the fourth cannot be built; answers what was found and the id of the sixth.
fn planted(name: &str, trace: &str) -> (Value, String) {
    let scratch = Scratch::new();
    let good = scratch.commit("none", "start");
    scratch.commit("none", "words");
    scratch.commit("none", "more words");
    scratch.commit("broken", "does not build");
    scratch.commit("none", "builds again");
    let culprit = scratch.commit(name, "plants a fault");
    scratch.commit(name, "words after it");
    scratch.commit(name, "more words after it");
    let output = scratch.bisect(
        trace,
        &["--good", &good, "--bad", "HEAD", "--format", "json"],
    );
    let found = json(&output);
    assert_eq!(found["first_bad"]["commit"], *culprit);
    assert_eq!(found["first_bad"]["subject"], "plants a fault");
    assert_eq!(found["first_bad"]["or"], Value::Array(Vec::new()));
    // The repository itself is as it was.
    assert_eq!(scratch.git(&["status", "--porcelain"]), "");
    (found, culprit)
}

fn stage(found: &Value) -> (&str, &str) {
    let text = |value: &'_ Value| -> String { value.as_str().unwrap_or("none").to_owned() };
    let stage: &'static str = text(&found["stage"]["stage"]).leak();
    let how: &'static str = text(&found["stage"]["how"]).leak();
    (stage, how)
}

#[test]
fn a_fault_in_the_integrator_is_found() {
    let (found, _) = planted("integrator", "self/terrain/walk-flat.mcap");
    assert_eq!(stage(&found), ("integrate", "output"), "{found:#}");
    assert!(
        found["stage"]["fields"][0][0]
            .as_str()
            .unwrap()
            .contains("rotation")
    );
}

#[test]
fn a_fault_in_the_transition_is_found() {
    let (found, _) = planted("transition", "self/objects/boulder.mcap");
    assert_eq!(stage(&found), ("transition", "output"), "{found:#}");
    assert_ne!(found["states"][0]["expected"], found["states"][0]["actual"]);
}

#[test]
fn a_fault_in_the_sequence_is_found() {
    let (found, _) = planted("sequence", "self/motion/walk-start-stop.mcap");
    assert_eq!(stage(&found), ("animation", "output"), "{found:#}");
    assert!(
        found["stage"]["fields"][0][0]
            .as_str()
            .unwrap()
            .contains("frame_number")
    );
}

#[test]
fn updates_that_are_lost_show_as_another_input() {
    let (found, _) = planted("updates", "self/interp/queue.mcap");
    let (_, how) = stage(&found);
    assert_ne!(how, "output", "no stage by itself did it: {found:#}");
    assert!(found["states"][0]["frame"].as_i64().unwrap() >= 0);
}

#[test]
fn a_crash_is_found_too_though_there_is_nothing_to_compare() {
    let (found, _) = planted("crash", "self/bounce/drop.mcap");
    assert!(
        found["first_bad"]["since"]["line"]
            .as_str()
            .unwrap()
            .starts_with("does not run")
    );
    assert_eq!(found["stage"], Value::Null);
}

#[test]
fn an_interrupted_search_goes_on_and_only_a_named_field_counts() {
    let scratch = Scratch::new();
    let good = scratch.commit("none", "start");
    let first = scratch.commit("transition", "changes the slide");
    let second = scratch.commit("sequence", "changes the frame number instead");
    scratch.commit("sequence", "words");
    let range = ["--good", &good, "--bad", "HEAD", "--format", "json"];
    let trace = "self/objects/boulder.mcap";
    let found = json(&scratch.bisect(trace, &range));
    assert_eq!(found["first_bad"]["commit"], *first);
    // The same again: everything is known, nothing is built.
    let again = scratch.bisect(trace, &range);
    assert_eq!(json(&again), found);
    let said = String::from_utf8_lossy(&again.stderr);
    assert!(said.contains("are known from before"), "{said}");
    assert!(!said.contains("built in"), "{said}");
    // Where only the animation counts, another commit is the first. What was built is still there.
    let frame_number = [&range[..], &["--field", "anim.frame_number"]].concat();
    let output = scratch.bisect(trace, &frame_number);
    assert_eq!(json(&output)["first_bad"]["commit"], *second);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!said.contains("are known from before"), "{said}");
    assert!(said.matches("built in").count() <= 2, "{said}");
}

#[test]
fn two_programs_are_compared_without_git() {
    let scratch = Scratch::new();
    let (good, bad) = (scratch.build("none"), scratch.build("sequence"));
    let compare = |a: &str, b: &str, more: &[&str]| {
        let arguments = [&["--good-bin", a, "--bad-bin", b], more].concat();
        scratch.bisect("self/motion/walk-start-stop.mcap", &arguments)
    };
    let found = json(&compare(&good, &bad, &["--format", "json"]));
    assert_eq!(stage(&found), ("animation", "output"));
    assert_eq!(found["first_bad"], Value::Null);
    let text = String::from_utf8(compare(&good, &bad, &[]).stdout).unwrap();
    assert!(text.contains("states differ first in frame "), "{text}");
    assert!(
        text.contains(": animation (same input, other output: this stage changed)"),
        "{text}"
    );
    let same = compare(&good, &good, &[]);
    assert_eq!(same.status.code(), Some(0), "{same:?}");
}

#[test]
fn a_scene_shrinks_between_two_programs() {
    let scratch = Scratch::new();
    let (good, bad) = (scratch.build("none"), scratch.build("sequence"));
    let out = scratch.folder.path().join("small");
    let output = Command::new(env!("CARGO_BIN_EXE_ac-conform"))
        .arg("shrink")
        .arg(corpus::bundled().join("traces/motion/walk-start-stop.mcap"))
        .args(["--good-bin", &good, "--bad-bin", &bad, "--max-runs", "30"])
        .args(["--format", "json", "-o"])
        .arg(&out)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["shown"]["stage"], "animation", "{report:#}");
    assert_eq!(report["budget_spent"], true);
    let size = |when: &str, what: &str| report[when][what].as_u64().unwrap();
    assert!(
        size("after", "frames") < size("before", "frames") / 2,
        "{report:#}"
    );
    assert!(out.join("motion-walk-start-stop.scene.json").is_file());
}

#[test]
fn what_cannot_be_looked_for_is_two() {
    let scratch = Scratch::new();
    let good = scratch.commit("none", "start");
    scratch.commit("none", "words");
    let trace = "self/bounce/drop.mcap";
    let same = scratch.bisect(trace, &["--good", &good, "--bad", "HEAD"]);
    assert_eq!(same.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&same.stderr).contains("both ends have the same verdict"));
    assert_eq!(scratch.bisect(trace, &[]).status.code(), Some(2));
    assert_eq!(
        scratch.bisect(trace, &["--good", &good]).status.code(),
        Some(2)
    );
    let nowhere = scratch.bisect("traces/no/such.mcap", &["--good", &good, "--bad", "HEAD"]);
    assert_eq!(nowhere.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&nowhere.stderr).contains("such.mcap"));
}
