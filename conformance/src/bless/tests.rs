//! Blessing with a client whose behaviour changes, from the first expectation to a changed one.

use std::fs;

use ac_client::{
    frame::{FrameState, FrameStates, state::Fields},
    profile::Profile,
};
use ac_golden_traces::Scene;
use ac_replayer::{Simulation, SimulationError, Simulator};
use serde_json::Value;

use super::{collect, human, write};
use crate::run::{self, Mode, Options, SELF, cases};

/// A client in which two entities move along x, the first faster by `extra` from frame 2 on.
struct Moving {
    extra: f32,
    /// Also records velocities.
    more: bool,
}

struct MovingRun {
    extra: f32,
    more: bool,
    x: [f32; 2],
    times: Vec<f64>,
}

impl Simulator for Moving {
    fn start(
        &self,
        scene: &Scene,
        profile: &Profile,
    ) -> Result<Box<dyn Simulation>, SimulationError> {
        assert_eq!(
            profile.name, "retail",
            "the library expects `retail` of itself"
        );
        let times = std::iter::once(scene.start_time).chain(scene.times());
        Ok(Box::new(MovingRun {
            extra: self.extra,
            more: self.more,
            x: [0.0; 2],
            times: times.collect(),
        }))
    }
}

impl MovingRun {
    fn write(&self, frame: i32, out: &mut FrameStates) {
        for (guid, x) in [(1, self.x[0]), (2, self.x[1])] {
            let state = out.push(frame, self.times[(frame + 1) as usize], guid);
            state.has = Fields::ORIGIN | Fields::SLIDING_NORMAL;
            if self.more {
                state.has |= Fields::VELOCITY;
            }
            state.cell = 0xA9B4_0001;
            state.origin = [x, 0.0, 0.0];
        }
    }
}

impl Simulation for MovingRun {
    fn frame_minus_one(&mut self, out: &mut FrameStates) -> Result<(), SimulationError> {
        self.write(-1, out);
        Ok(())
    }

    fn step(&mut self, frame: u32, out: &mut FrameStates) -> Result<(), SimulationError> {
        self.x[0] += if frame < 2 { 0.5 } else { 0.5 + self.extra };
        self.x[1] += 0.5;
        self.write(frame as i32, out);
        Ok(())
    }

    fn load_state(&mut self, expected: &FrameState) -> Result<(), SimulationError> {
        self.x[expected.guid as usize - 1] = expected.origin[0];
        Ok(())
    }

    fn run_stage(&mut self, _: &[Value], _: usize) -> Result<Option<Value>, SimulationError> {
        Ok(None)
    }
}

const SCENE: &str = r#"{"schema":"ac-scene/1","name":"area/tiny","summary":"s","world":"w","features":[],"start_time":10,
    "frames":[{"dt":0.5,"count":6}],"track":["0x1","0x2"],"entities":[],"script":[]}"#;

/// A folder with the scene and an empty world.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tiny.scene.json"), SCENE).unwrap();
    fs::create_dir_all(folder.path().join("worlds/w")).unwrap();
    for file in ["client_portal.dat", "client_cell_1.dat"] {
        fs::write(folder.path().join("worlds/w").join(file), "x").unwrap();
    }
    folder
}

fn plain(extra: f32) -> Moving {
    Moving { extra, more: false }
}

/// Takes everything that changes, and answers how many scenes that were, and their text.
fn bless(client: &Moving, folder: &std::path::Path) -> Vec<String> {
    let scene = folder.join("tiny.scene.json");
    let cases = cases::find(&[scene], None, None).unwrap();
    let own = folder.join("own");
    let collected = collect(client, &cases, Some(&own), || ());
    assert!(collected.errors.is_empty(), "{:?}", collected.errors);
    for change in &collected.changes {
        write::write(client, &folder.join("worlds"), change).unwrap();
    }
    collected.changes.iter().map(human).collect()
}

fn diverged(client: &Moving, folder: &std::path::Path) -> Vec<(Mode, String)> {
    let cases = cases::find(&[folder.join("own")], None, None).unwrap();
    let options = Options {
        modes: vec![Mode::Free, Mode::Resync],
        oracle: None,
        profile: None,
        series: false,
    };
    let outcome = run::run(client, &cases, &options, || ());
    assert!(outcome.errors.is_empty(), "{:?}", outcome.errors);
    assert_eq!(outcome.results.len(), 4);
    let results = outcome.results.into_iter();
    results
        .filter(|result| result.first_divergence.is_some())
        .map(|result| {
            assert_eq!((&*result.oracle, &*result.profile), (SELF, "retail"));
            (result.mode, result.first_divergence.unwrap().field)
        })
        .collect()
}

#[test]
fn a_change_shows_in_a_run_until_it_is_blessed() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(
        bless(&plain(0.0), folder),
        ["area/tiny: 7 frames, no expectation of its own yet\n"]
    );
    assert_eq!(diverged(&plain(0.0), folder), []);
    assert!(
        bless(&plain(0.0), folder).is_empty(),
        "nothing changed since"
    );
    let changed = plain(0.25);
    let origin = "origin[0]".to_owned();
    let both = [(Mode::Free, origin.clone()), (Mode::Resync, origin)];
    assert_eq!(diverged(&changed, folder), both);
    let texts = bless(&changed, folder);
    assert_eq!(texts.len(), 1);
    insta::assert_snapshot!(texts[0], @r"
    area/tiny: 4 of 7 frames change
      origin: 4 times from frame 2 on; most: frame 5, 0x1 origin[0]: 3.0 -> 4.0 (1.000e0 m)
      frame 2
        0x1 origin[0]: 1.5 -> 1.75 (2.500e-1 m)
      frame 5
        0x1 origin[0]: 3.0 -> 4.0 (1.000e0 m)
    ");
    assert_eq!(diverged(&changed, folder), []);
    assert!(!diverged(&plain(0.0), folder).is_empty());
}

#[test]
fn a_field_that_is_recorded_from_now_on_is_a_change() {
    let folder = folder();
    bless(&plain(0.0), folder.path());
    let more = Moving {
        extra: 0.0,
        more: true,
    };
    let texts = bless(&more, folder.path());
    assert!(
        texts[0].contains("origin sliding_normal\" -> \"origin velocity sliding_normal\""),
        "{texts:?}"
    );
    assert!(bless(&more, folder.path()).is_empty());
}

#[test]
fn an_expectation_in_a_trace_with_others_is_replaced_in_place() {
    let folder = folder();
    let folder = folder.path();
    bless(&plain(0.0), folder);
    let own = folder.join("own/area/tiny.mcap");
    let before = fs::read(&own).unwrap();
    // The case is the trace itself now: nothing says where to put a new one, and nothing has to.
    let cases = cases::find(std::slice::from_ref(&own), None, None).unwrap();
    let collected = collect(&plain(0.5), &cases, None, || ());
    assert_eq!((collected.scenes, collected.changes.len()), (1, 1));
    write::write(&plain(0.5), folder, &collected.changes[0]).unwrap();
    assert_ne!(fs::read(&own).unwrap(), before);
    assert!(!diverged(&plain(0.0), folder).is_empty());
    // Back again: the same bytes as if nothing had been.
    let collected = collect(&plain(0.0), &cases, None, || ());
    write::write(&plain(0.0), folder, &collected.changes[0]).unwrap();
    assert_eq!(fs::read(&own).unwrap(), before);
}

#[test]
fn a_scene_that_was_edited_replaces_the_old_one() {
    let folder = folder();
    bless(&plain(0.0), folder.path());
    fs::write(
        folder.path().join("tiny.scene.json"),
        SCENE.replace("\"count\":6", "\"count\":4"),
    )
    .unwrap();
    let texts = bless(&plain(0.0), folder.path());
    assert_eq!(
        texts,
        ["area/tiny: 0 of 5 frames change, the scene itself is another, 2 frames go\n"]
    );
    assert_eq!(diverged(&plain(0.0), folder.path()), []);
    assert!(bless(&plain(0.0), folder.path()).is_empty());
}

#[test]
fn without_a_place_for_it_a_scene_is_refused() {
    let folder = folder();
    let scene = folder.path().join("tiny.scene.json");
    let cases = cases::find(&[scene], None, None).unwrap();
    let collected = collect(&plain(0.0), &cases, None, || ());
    let error = collected.errors[0].to_string();
    assert!(error.contains("those of oracles are not to be blessed"));
    assert!(error.contains("--into"));
}
