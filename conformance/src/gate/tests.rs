//! Verdicts, merging and everything that a person or a CI system reads.

use std::collections::BTreeMap;

use super::{Document, Flake, MergeError, Shard, Skipped, Verdict, output};
use crate::{
    compare::{Class, Divergence},
    run::{Mode, RunResult, baseline::Baseline, report},
};

fn result(scene: &str, frame: Option<i32>) -> RunResult {
    RunResult {
        scene: scene.into(),
        area: scene.split('/').next().unwrap().into(),
        oracle: "gdle".into(),
        profile: "gdle".into(),
        mode: Mode::Free,
        guid: "0x1".into(),
        frames_compared: 4,
        frames_exact: if frame.is_some() { 2 } else { 4 },
        first_divergence: frame.map(|frame| Divergence {
            frame,
            stage: None,
            field: "origin[0]".into(),
            expected: 1.5.into(),
            actual: 1.25.into(),
        }),
        max_error: BTreeMap::new(),
        undefined: 0,
        class: match frame {
            Some(_) => Class::Diverged,
            None => Class::Exact,
        },
        tolerated: BTreeMap::new(),
        not_run: 0,
        stages: BTreeMap::new(),
    }
}

/// One of everything.
fn document() -> Document {
    let mut within = result("b/within", None);
    within.class = Class::WithinTolerance;
    within
        .tolerated
        .insert("velocity within 4 ulp: table lookup".into(), 3);
    Document {
        schema: report::SCHEMA.into(),
        results: vec![
            result("a/changed", Some(1)),
            result("a/exact", None),
            result("a/fixed", None),
            result("a/flaky", Some(2)),
            result("a/known", Some(2)),
            result("a/new", Some(2)),
            within,
        ],
        series: Vec::new(),
        shard: Some("2/3".parse().unwrap()),
        flaky: vec![Flake {
            scene: "a/flaky".into(),
            what: "the second run gave other results".into(),
        }],
        skipped: vec![Skipped {
            scene: "c/skipped".into(),
            reason: "takes | hours".into(),
        }],
        errors: vec!["d.mcap: 100% damaged,\nno trace".into()],
    }
}

fn baseline() -> Baseline {
    let entry = |scene| {
        format!(
            "[[known]]\nscene = '{scene}'\noracle = 'gdle'\nmode = 'free'\nframe = 2\nfield = 'origin[0]'\nreason = 'because'\n"
        )
    };
    toml::from_str(
        &["a/changed", "a/fixed", "a/known", "z/elsewhere"]
            .map(entry)
            .concat(),
    )
    .unwrap()
}

#[test]
fn every_result_has_its_verdict() {
    let (document, baseline) = (document(), baseline());
    let verdicts: Vec<_> = document
        .judged(&baseline)
        .map(|(_, verdict)| verdict)
        .collect();
    assert_eq!(
        verdicts,
        [
            Verdict::Changed,
            Verdict::Exact,
            Verdict::Exact,
            Verdict::Flaky,
            Verdict::Known,
            Verdict::New,
            Verdict::WithinTolerance
        ]
    );
    assert!(document.fails(&baseline));
    let quiet = Document {
        results: vec![result("a/known", Some(2)), result("a/fixed", None)],
        ..Document::default()
    };
    assert!(!quiet.fails(&baseline));
}

#[test]
fn what_a_person_reads() {
    insta::assert_snapshot!("human", output::human(&document(), &baseline()));
    insta::assert_snapshot!("annotations", output::annotations(&document(), &baseline()));
    insta::assert_snapshot!("summary", output::summary(&document(), &baseline()));
}

#[test]
fn what_a_machine_reads() {
    insta::assert_snapshot!("junit", output::junit(&document(), &baseline()).unwrap());
    insta::assert_snapshot!("json", document().json(&baseline()).unwrap());
}

#[test]
fn many_annotations_are_cut() {
    let results = (0..30)
        .map(|n| result(&format!("a/{n}"), Some(1)))
        .collect();
    let text = output::annotations(
        &Document {
            results,
            ..Document::default()
        },
        &Baseline::default(),
    );
    assert_eq!(text.lines().count(), 10);
    assert!(text.ends_with("and 21 more\n"), "{text}");
}

fn part(shard: &str, scenes: &[&str]) -> (String, Document) {
    let part = Document {
        shard: Some(shard.parse::<Shard>().unwrap()),
        results: scenes.iter().map(|scene| result(scene, Some(1))).collect(),
        flaky: Vec::new(),
        skipped: Vec::new(),
        errors: Vec::new(),
        schema: report::SCHEMA.into(),
        series: Vec::new(),
    };
    // Through text, as between machines.
    let text = part.json(&Baseline::default()).unwrap();
    (
        format!("{}.json", shard.replace('/', "-")),
        serde_json::from_str(&text).unwrap(),
    )
}

#[test]
fn shards_make_the_whole_run() {
    let merged = Document::merge(vec![
        part("2/2", &["a/one"]),
        part("1/2", &["a/two", "a/0"]),
    ])
    .unwrap();
    let scenes: Vec<_> = merged.results.iter().map(|result| &*result.scene).collect();
    assert_eq!(scenes, ["a/0", "a/one", "a/two"]);
    assert_eq!(merged.results[0], result("a/0", Some(1)));
    let everything = document();
    let text = everything.json(&baseline()).unwrap();
    let read: Document = serde_json::from_str(&text).unwrap();
    assert_eq!(
        read.results,
        Document::merge(vec![(
            "x".into(),
            Document {
                shard: None,
                ..everything.clone()
            },
        )])
        .unwrap()
        .results
        .into_iter()
        .map(|mut result| {
            // Diverged is not written: it follows from the divergence.
            if result.first_divergence.is_some() {
                result.class = Class::Exact;
            }
            result
        })
        .collect::<Vec<_>>()
    );
    assert_eq!(
        (read.flaky, read.skipped, read.errors),
        (everything.flaky, everything.skipped, everything.errors)
    );
}

#[test]
fn half_a_run_is_no_run() {
    let bad =
        |parts: Vec<(String, Document)>| -> MergeError { Document::merge(parts).unwrap_err() };
    insta::assert_snapshot!(bad(vec![part("1/2", &[])]), @"shard 2/2 is missing");
    insta::assert_snapshot!(bad(vec![part("1/2", &[]), part("1/2", &[])]), @"1-2.json: shard 1/2 is in another document too");
    insta::assert_snapshot!(bad(vec![part("1/2", &[]), part("2/3", &[])]), @"2-3.json: shard 2/3 does not belong to a run cut like 1/2");
    insta::assert_snapshot!(bad(vec![part("1/2", &["a/b"]), part("2/2", &["a/b"])]), @"2-2.json: a/b gdle free 0x1 is in another document too");
    insta::assert_snapshot!(bad(vec![("x.json".into(), Document::default())]), @"x.json: schema `` is not `ac-conform-run/1`");
}

/// A client whose every start is a little further along than the one before, if it drifts.
struct Drifting {
    starts: std::sync::atomic::AtomicU8,
    drifts: bool,
}

struct DriftingRun(f32);

impl ac_replayer::Simulator for Drifting {
    fn start(
        &self,
        _: &ac_golden_traces::Scene,
        _: &ac_client::profile::Profile,
    ) -> Result<Box<dyn ac_replayer::Simulation>, ac_replayer::SimulationError> {
        let starts = self
            .starts
            .fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let drift = if self.drifts { f32::from(starts) } else { 0.0 };
        Ok(Box::new(DriftingRun(1.0 + drift)))
    }
}

impl ac_replayer::Simulation for DriftingRun {
    fn frame_minus_one(
        &mut self,
        out: &mut ac_client::frame::FrameStates,
    ) -> Result<(), ac_replayer::SimulationError> {
        let state = out.push(-1, 10.0, 1);
        state.has = ac_client::frame::state::Fields::ORIGIN;
        state.cell = 0xA9B4_0001;
        state.origin = [self.0, 0.0, 0.0];
        Ok(())
    }

    fn step(
        &mut self,
        _: u32,
        _: &mut ac_client::frame::FrameStates,
    ) -> Result<(), ac_replayer::SimulationError> {
        Ok(())
    }

    fn load_state(
        &mut self,
        _: &ac_client::frame::FrameState,
    ) -> Result<(), ac_replayer::SimulationError> {
        Ok(())
    }

    fn run_stage(
        &mut self,
        _: &[serde_json::Value],
        _: usize,
    ) -> Result<Option<serde_json::Value>, ac_replayer::SimulationError> {
        Ok(None)
    }
}

#[test]
fn a_failure_that_changes_is_flaky_and_one_that_stays_is_new() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "t.scene.json",
        r#"{"schema":"ac-scene/1","name":"area/tiny","summary":"s","world":"w","features":[],"start_time":10,"frames":[{"dt":0.5,"count":1}],"track":["0x1"],"entities":[],"script":[]}"#,
    );
    write(
        "t.expect.jsonl",
        "{\"schema\":\"ac-expect/1\",\"scene\":\"area/tiny\",\"oracle\":\"gdle\",\"oracle_version\":\"1\",\"notes\":[]}\n{\"frame\":-1,\"time\":10,\"guid\":\"0x1\",\"cell\":\"0xA9B40001\",\"origin\":[0,0,0]}\n",
    );
    let cases = crate::run::cases::find(&[folder.path().to_owned()], None, None).unwrap();
    let options = crate::run::Options {
        modes: vec![Mode::Free],
        oracle: None,
        profile: None,
        series: false,
    };
    let verdict = |drifts| {
        let client = Drifting {
            starts: 0.into(),
            drifts,
        };
        let policy = Default::default();
        let document = Document::run(&client, &cases, &options, &policy, None, |_, _| ());
        assert!(document.errors.is_empty(), "{:?}", document.errors);
        document.verdict(&document.results[0], &Baseline::default())
    };
    assert_eq!(verdict(true), Verdict::Flaky);
    assert_eq!(verdict(false), Verdict::New);
}
