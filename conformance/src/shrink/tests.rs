//! Shrinking bundled scenes between profiles, and against what an oracle recorded.

use std::fs;

use ac_client::profile::Profile;
use ac_golden_traces::corpus;
use ac_replayer::client::ClientSimulator;

use super::{
    Candidate, Judge, ShrinkError, Shrunk,
    candidate::Records,
    judge::{Recorded, TwoProfiles},
    output, shrink,
};
use crate::run::{self, Mode, Options, cases};

fn candidate(scene: &str) -> Candidate {
    let path = corpus::bundled().join(format!("traces/{scene}.mcap"));
    let case = run::Case::Trace(path);
    let scene = crate::hash::scene_of(&case).unwrap();
    let simulator = ClientSimulator::new(corpus::bundled().join("worlds"));
    let world = simulator.world(&scene.world).unwrap();
    let records = Records::of(&world).unwrap();
    Candidate::new(scene, records)
}

/// `retail` beside itself with one switch of another profile.
fn one_switch(switch: &str, from: &Profile) -> TwoProfiles {
    let mut expected = Profile::retail();
    let switch = Profile::SWITCHES
        .iter()
        .find(|of| of.field == switch)
        .unwrap();
    (switch.copy)(&mut expected, from);
    TwoProfiles {
        expected,
        actual: Profile::retail(),
        field: None,
    }
}

fn shrunk(scene: &str, judge: &mut dyn Judge, runs: usize) -> Shrunk {
    shrink(candidate(scene), judge, runs, &|_, _| ()).unwrap()
}

#[test]
fn a_scene_shrinks_to_what_the_divergence_needs() {
    let mut judge = one_switch("sphere_slide", &Profile::gdle());
    let before = judge.judge(&candidate("objects/boulder"), None).unwrap();
    let before = before.expect("it diverges");
    let small = shrunk("objects/boulder", &mut judge, 2000);
    assert_eq!(small.shown.field_name(), before.field_name());
    assert_eq!(small.shown.stage, before.stage);
    assert!(!small.budget_spent, "{} runs", small.runs);
    let (a, b) = (small.before, small.after);
    assert!(b.frames * 4 <= a.frames, "{a:?} {b:?}");
    assert!(b.records * 4 <= a.records, "{a:?} {b:?}");
    assert!(b.steps <= a.steps && b.entities <= a.entities);
    assert!(b.world_bytes < 100_000, "{b:?}");
    // Nothing more can go.
    let again = shrink(small.candidate.clone(), &mut judge, 2000, &|_, _| ()).unwrap();
    assert_eq!(again.after, small.after);
    assert_eq!(again.candidate.scene, small.candidate.scene);
}

#[test]
fn only_a_named_field_counts_and_is_expected() {
    // The two profiles differ in an event before the first frame; the position parts later.
    let mut judge = TwoProfiles {
        expected: Profile::gdle(),
        actual: Profile::retail(),
        field: Some(globset::Glob::new("origin").unwrap().compile_matcher()),
    };
    let small = shrunk("jump/running", &mut judge, 3000);
    assert_eq!(small.shown.field_name(), "origin");
    assert!(small.shown.place.divergence.frame >= 0);
    let folder = tempfile::tempdir().unwrap();
    output::write(
        folder.path(),
        "jump/running",
        "gdle",
        "",
        &small,
        &mut judge,
    )
    .unwrap();
    let text = fs::read_to_string(folder.path().join("jump-running.expect.jsonl")).unwrap();
    assert!(
        text.contains("\"origin\"") && !text.contains("\"velocity\""),
        "{text}"
    );
}

#[test]
fn the_budget_is_kept_and_what_was_found_so_far_is_answered() {
    let mut judge = one_switch("sphere_slide", &Profile::gdle());
    let small = shrunk("objects/boulder", &mut judge, 12);
    assert_eq!(small.runs, 12);
    assert!(small.budget_spent);
    assert!(judge.judge(&small.candidate, None).unwrap().is_some());
}

#[test]
fn what_does_not_diverge_cannot_be_shrunk() {
    let mut judge = TwoProfiles {
        expected: Profile::retail(),
        actual: Profile::retail(),
        field: None,
    };
    let error = shrink(candidate("bounce/drop"), &mut judge, 10, &|_, _| ()).unwrap_err();
    assert!(matches!(error, ShrinkError::Nothing(_)), "{error}");
}

#[test]
fn against_a_recording_only_what_has_no_part_in_it_goes() {
    let name = "objects/boulder";
    let whole = candidate(name);
    let trace = corpus::bundled().join(format!("traces/{name}.mcap"));
    let mut question = crate::bisect::verdict::Question {
        trace,
        worlds: corpus::bundled().join("worlds"),
        profile: String::new(),
        field: None,
        expected: Default::default(),
        timeout: Default::default(),
    };
    question.read_expectations(Some("gdle")).unwrap();
    let expected = question.expected.remove("gdle").unwrap();
    let mut judge = Recorded::new(&whole, expected, Profile::retail()).unwrap();
    let before = judge.judge(&whole, None).unwrap().expect("it diverges");
    let small = shrink(whole.clone(), &mut judge, 2000, &|_, _| ()).unwrap();
    assert_eq!(small.shown.place, before.place, "the same values");
    assert!(small.after.records < small.before.records / 2);
    // Time before the divergence stays as it was.
    let kept: Vec<f64> = small.candidate.scene.times().collect();
    let all: Vec<f64> = whole.scene.times().collect();
    assert_eq!(kept[..], all[..kept.len()]);
}

#[test]
fn what_is_written_runs_and_shows_the_divergence() {
    let mut judge = one_switch("sphere_slide", &Profile::gdle());
    let small = shrunk("objects/boulder", &mut judge, 2000);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let report = output::write(
        path,
        "objects/boulder",
        "gdle",
        "--profile retail",
        &small,
        &mut judge,
    )
    .unwrap();
    assert!(report.bytes < 100_000, "{}", report.bytes);
    let cases = cases::find(&[path.to_owned()], None, None).unwrap();
    let simulator = ClientSimulator::new(path.join("worlds"));
    let options = Options {
        modes: vec![Mode::Free],
        oracle: None,
        profile: Some("retail".into()),
        series: false,
    };
    let outcome = run::run(&simulator, &cases, &options, || ());
    assert!(outcome.errors.is_empty(), "{:?}", outcome.errors);
    let first = outcome
        .results
        .iter()
        .find_map(|result| result.first_divergence.clone());
    assert_eq!(first.unwrap(), small.shown.place.divergence);
    assert!(
        fs::read_to_string(path.join("README.md"))
            .unwrap()
            .contains("objects/boulder")
    );
}
