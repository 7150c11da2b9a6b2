//! The run on tiny traces with a fake client, from files to what a person reads.

use std::{
    fs,
    path::{Path, PathBuf},
};

use ac_client::{
    frame::{FrameState, FrameStates, state::Fields},
    profile::Profile,
};
use ac_golden_traces::Scene;
use ac_replayer::{Simulation, SimulationError, Simulator};
use serde_json::{Value, json};

use super::{
    Mode, Options, Outcome,
    baseline::Baseline,
    cases,
    report::{Totals, human, json as json_report},
    run,
};
use crate::gate::Document;

/// A client in which every entity moves by its speed along x each frame, and something goes wrong in frame `slip`.
struct Fake {
    slip: Option<u32>,
}

struct FakeRun {
    slip: Option<u32>,
    time: Vec<f64>,
    entities: Vec<(u32, f32)>,
}

impl Simulator for Fake {
    fn start(&self, scene: &Scene, _: &Profile) -> Result<Box<dyn Simulation>, SimulationError> {
        let time = std::iter::once(scene.start_time)
            .chain(scene.times())
            .collect();
        Ok(Box::new(FakeRun {
            slip: self.slip,
            time,
            entities: scene.track.iter().map(|guid| (*guid, 0.0)).collect(),
        }))
    }
}

impl FakeRun {
    fn write(&self, frame: i32, out: &mut FrameStates) {
        for (guid, x) in &self.entities {
            let state = out.push(frame, self.time[(frame + 1) as usize], *guid);
            state.has = Fields::ORIGIN | Fields::SLIDING_NORMAL;
            state.cell = 0xA9B4_0001;
            state.origin = [*x, 0.0, 0.0];
        }
    }
}

impl Simulation for FakeRun {
    fn frame_minus_one(&mut self, out: &mut FrameStates) -> Result<(), SimulationError> {
        self.write(-1, out);
        Ok(())
    }

    fn step(&mut self, frame: u32, out: &mut FrameStates) -> Result<(), SimulationError> {
        for (index, (_, x)) in self.entities.iter_mut().enumerate() {
            *x += if index == 0 && self.slip == Some(frame) {
                0.75
            } else {
                0.5
            };
        }
        self.write(frame as i32, out);
        Ok(())
    }

    fn load_state(&mut self, expected: &FrameState) -> Result<(), SimulationError> {
        for (guid, x) in &mut self.entities {
            if *guid == expected.guid && expected.has.contains(Fields::ORIGIN) {
                *x = expected.origin[0];
            }
        }
        Ok(())
    }

    fn run_stage(
        &mut self,
        records: &[Value],
        index: usize,
    ) -> Result<Option<Value>, SimulationError> {
        Ok((records[index]["stage"] == "integrate").then(|| json!({"x": 1.5})))
    }
}

const SCENE: &str = r#"{"schema":"ac-scene/1","name":"area/tiny","summary":"s","world":"w","features":[],"start_time":10,
    "frames":[{"dt":0.5,"count":4}],"track":["0x1","0x2"],"entities":[],"script":[]}"#;

fn expectations() -> String {
    let mut text = r#"{"schema":"ac-expect/1","scene":"area/tiny","oracle":"gdle","oracle_version":"1","notes":[]}"#.to_owned();
    for frame in -1..4 {
        for guid in [1, 2] {
            let time = 10.5 + 0.5 * f64::from(frame);
            let x = 0.5 * f64::from(frame + 1);
            text += &format!(
                "\n{{\"frame\":{frame},\"time\":{time},\"guid\":\"0x{guid}\",\"cell\":\"0xA9B40001\",\"origin\":[{x},0,0],\"sliding_normal\":null}}"
            );
        }
    }
    text
}

const STAGES: &str = r#"{"schema":"ac-stages/1","scene":"area/tiny","oracle":"model-gdle"}
{"frame":0,"guid":"0x1","quantum":0,"stage":"integrate","in":{},"out":{"x":1.5}}
{"frame":1,"guid":"0x1","quantum":0,"stage":"integrate","in":{},"out":{"x":1.25}}
{"frame":1,"guid":"0x1","quantum":0,"stage":"commit","in":{},"out":{"x":1.5}}
"#;

/// Scene, expectations and stages of the tiny scene in a folder.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tiny.scene.json"), SCENE).unwrap();
    fs::write(folder.path().join("tiny.expect.jsonl"), expectations()).unwrap();
    fs::write(folder.path().join("tiny.stages.jsonl"), STAGES).unwrap();
    folder
}

fn run_in(path: &Path, slip: Option<u32>, modes: &[Mode]) -> Outcome {
    let cases = cases::find(&[path.to_owned()], None, None).unwrap();
    run(
        &Fake { slip },
        &cases,
        &Options {
            modes: modes.into(),
            oracle: None,
            profile: None,
            series: false,
        },
        || (),
    )
}

fn known(text: &str) -> Baseline {
    toml::from_str(text).unwrap()
}

#[test]
fn a_slip_shows_as_drift_when_free_and_once_when_resynced() {
    let folder = folder();
    let outcome = run_in(folder.path(), Some(1), &[Mode::Free, Mode::Resync]);
    assert!(outcome.errors.is_empty(), "{:?}", outcome.errors);
    let exact: Vec<_> = outcome
        .results
        .iter()
        .map(|r| {
            (
                r.mode.name(),
                r.guid.as_str(),
                r.frames_exact,
                r.frames_compared,
            )
        })
        .collect();
    assert_eq!(
        exact,
        [
            ("free", "0x1", 2, 5),
            ("free", "0x2", 5, 5),
            ("resync", "0x1", 4, 5),
            ("resync", "0x2", 5, 5)
        ]
    );
}

#[test]
fn the_json_report() {
    let folder = folder();
    let outcome = run_in(folder.path(), Some(1), &Mode::ALL);
    let totals = Totals::of(&outcome.results, &Baseline::default());
    insta::assert_snapshot!(json_report(&outcome.results, &totals).unwrap());
}

#[test]
fn the_human_report() {
    let folder = folder();
    let outcome = run_in(folder.path(), Some(1), &Mode::ALL);
    let baseline = known(
        "[[known]]\nscene = 'area/tiny'\noracle = 'gdle'\nmode = 'free'\nframe = 1\nfield = 'origin[0]'\nreason = 'the fake slips'\n\
         [[known]]\nscene = 'area/tiny'\noracle = 'gdle'\nmode = 'free'\nguid = '0x2'\nframe = 1\nfield = 'origin[0]'\nreason = 'it did once'",
    );
    let totals = Totals::of(&outcome.results, &baseline);
    assert_eq!(
        (
            totals.known_divergences,
            totals.new_divergences,
            totals.fixed
        ),
        (1, 2, 1)
    );
    let document = Document {
        results: outcome.results,
        ..Document::default()
    };
    insta::assert_snapshot!(human(&document, &baseline));
}

#[test]
fn an_earlier_divergence_is_new_and_a_later_one_known() {
    let folder = folder();
    let outcome = run_in(folder.path(), Some(1), &[Mode::Free]);
    let entry = |frame: i32, field: &str| {
        known(&format!(
            "[[known]]\nscene = 'area/tiny'\noracle = 'gdle'\nmode = 'free'\nframe = {frame}\nfield = '{field}'\nreason = 'r'"
        ))
    };
    assert!(entry(1, "origin[0]").accepts(&outcome.results[0]).is_some());
    assert!(entry(0, "cell").accepts(&outcome.results[0]).is_some());
    assert!(entry(1, "cell").accepts(&outcome.results[0]).is_none());
    assert!(entry(2, "origin[0]").accepts(&outcome.results[0]).is_none());
}

#[test]
fn blessing_accepts_what_diverges_and_drops_what_is_fixed() {
    let folder = folder();
    let outcome = run_in(folder.path(), Some(1), &[Mode::Free]);
    let before = known(
        "[[known]]\nscene = 'area/tiny'\noracle = 'gdle'\nmode = 'free'\nguid = '0x2'\nframe = 1\nfield = 'origin[0]'\nreason = 'fixed'\n\
         [[known]]\nscene = 'area/other'\noracle = 'gdle'\nmode = 'free'\nframe = 1\nfield = 'cell'\nreason = 'not run'",
    );
    let after = before.blessed(&outcome.results, "new");
    let reasons: Vec<_> = after
        .known
        .iter()
        .map(|known| known.reason.as_str())
        .collect();
    assert_eq!(reasons, ["not run", "new"]);
    assert_eq!(Totals::of(&outcome.results, &after).new_divergences, 0);
    assert_eq!(after.blessed(&outcome.results, "again"), after);
}

#[test]
fn threads_do_not_change_the_order() {
    let folder = folder();
    for copy in 0..8 {
        let name = format!("area/tiny{copy}");
        fs::write(
            folder.path().join(format!("t{copy}.scene.json")),
            SCENE.replace("area/tiny", &name),
        )
        .unwrap();
        fs::write(
            folder.path().join(format!("t{copy}.expect.jsonl")),
            expectations().replace("area/tiny", &name),
        )
        .unwrap();
    }
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| run_in(folder.path(), Some(2), &Mode::ALL))
            .results
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn a_trace_gives_the_same_results_as_its_files() {
    let folder = folder();
    let file = |name: &str| folder.path().join(name);
    let sources = ac_golden_traces::import::Sources {
        scene: file("tiny.scene.json"),
        expect: vec![file("tiny.expect.jsonl")],
        stages: vec![file("tiny.stages.jsonl")],
        world: None,
    };
    let path: PathBuf = file("tiny.mcap");
    ac_golden_traces::import::import(&sources, fs::File::create(&path).unwrap(), &path).unwrap();
    let files = run_in(&file("tiny.scene.json"), Some(1), &Mode::ALL);
    let trace = run_in(&path, Some(1), &Mode::ALL);
    assert_eq!(files.results, trace.results);
    assert!(trace.errors.is_empty());
}

#[test]
fn what_cannot_run_says_why() {
    let folder = folder();
    let replace = |from: &str, to: &str| {
        fs::write(
            folder.path().join("tiny.expect.jsonl"),
            expectations().replace(from, to),
        )
        .unwrap();
        let outcome = run_in(folder.path(), None, &[Mode::Free]);
        assert!(outcome.results.is_empty());
        outcome.errors[0]
            .to_string()
            .replace(&format!("{}/", folder.path().display()), "")
    };
    insta::assert_snapshot!(replace("\"area/tiny\"", "\"area/other\""), @"tiny.expect.jsonl: is of scene `area/other`, not of `area/tiny`");
    insta::assert_snapshot!(replace("\"gdle\"", "\"nobody\""), @"tiny.scene.json: no profile is called `nobody`; name one with --profile (retail, ace, gdle, gdle-repaired)");
    insta::assert_snapshot!(replace("\"frame\":3", "\"frame\":9"), @"tiny.scene.json: oracle gdle has frame 9, the scene ends before it");
    insta::assert_snapshot!(replace("\"guid\":\"0x2\"", "\"guid\":\"0x3\""), @"tiny.scene.json: oracle gdle has no record of the tracked entity 0x2");
    insta::assert_snapshot!(replace("\"origin\":[0.5,", "\"origin\":[true,"), @"tiny.expect.jsonl, line 4: origin[0]: expected a number, \"nan\", \"inf\" or \"-inf\"");
}

#[test]
fn what_the_client_does_not_write_is_never_equal() {
    // The client writes no velocity, and nothing at all of an entity that it does not know.
    let folder = folder();
    let with = |from: &str, to: &str| {
        let text = expectations().replace(from, to);
        fs::write(folder.path().join("tiny.expect.jsonl"), text).unwrap();
        let outcome = run_in(folder.path(), None, &[Mode::Free]);
        assert!(outcome.errors.is_empty(), "{:?}", outcome.errors);
        let results = outcome.results.into_iter();
        results
            .map(|result| {
                result
                    .first_divergence
                    .map(|first| (first.frame, first.field))
            })
            .collect::<Vec<_>>()
    };
    let nothing = with("x", "x");
    assert_eq!(nothing, [None, None]);
    let velocity = with("\"sliding_normal\":null", "\"velocity\":[0,0,0]");
    let first = Some((-1, "velocity".to_owned()));
    assert_eq!(velocity, [first.clone(), first]);
    let present = with("\"sliding_normal\":null", "\"sliding_normal\":[0,0,0]");
    let first = Some((-1, "sliding_normal".to_owned()));
    assert_eq!(present, [first.clone(), first]);
}
