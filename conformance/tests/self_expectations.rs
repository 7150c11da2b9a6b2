//! The library's own expectations of the bundled scenes: there for every scene, met, and small.

use ac_conformance::{
    bless,
    run::{Mode, Options, SELF, cases, run},
};
use ac_golden_traces::corpus;
use ac_replayer::client::ClientSimulator;

#[test]
fn the_own_expectations_are_met() {
    let cases = cases::find(&[bless::bundled()], None, None).expect("they are there");
    let options = Options {
        modes: vec![Mode::Free, Mode::Resync],
        oracle: Some(SELF.into()),
        profile: None,
        series: false,
    };
    let simulator = ClientSimulator::new(corpus::bundled().join("worlds"));
    let outcome = run(&simulator, &cases, &options, || ());
    assert!(outcome.errors.is_empty(), "{}", outcome.errors[0]);
    let changed: Vec<_> = outcome
        .results
        .iter()
        .filter(|result| result.first_divergence.is_some())
        .map(|result| (&result.scene, result.mode, &result.first_divergence))
        .collect();
    assert!(
        changed.is_empty(),
        "if the change is wanted, look at it with `ac-conform bless` and accept it: {:#?}",
        &changed[..changed.len().min(5)]
    );
}

#[test]
fn every_bundled_scene_has_one_and_they_are_small() {
    let root = corpus::bundled();
    let simulator = ClientSimulator::new(root.join("worlds"));
    let cases = cases::find_or_bundled(&[], None, None).expect("the traces are there");
    let collected = bless::collect(&simulator, &cases, Some(&bless::bundled()), || ());
    assert!(collected.errors.is_empty(), "{:?}", collected.errors);
    let new: Vec<_> = collected
        .changes
        .iter()
        .map(|change| &change.scene)
        .collect();
    assert!(new.is_empty(), "run `ac-conform bless`: {new:?}");
    let files = corpus::find(&bless::bundled(), &[corpus::TRACE_SUFFIX]).expect("they are there");
    let bytes: u64 = files
        .iter()
        .map(|file| file.metadata().expect("it is there").len())
        .sum();
    assert!(bytes < 8 << 20, "{bytes} bytes");
}
