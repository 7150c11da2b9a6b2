//! Every bundled trace, every oracle, every mode: nothing may diverge that the baseline does not accept.

use std::path::Path;

use ac_conformance::run::{Mode, Options, baseline::Baseline, cases, report::Totals, run};
use ac_golden_traces::corpus;
use ac_replayer::client::ClientSimulator;

#[test]
fn the_bundled_traces_are_met() {
    let root = corpus::bundled();
    let cases =
        cases::find(&[root.join("traces")], None, None).expect("the bundled traces are there");
    assert!(!cases.is_empty());
    let options = Options {
        modes: Mode::ALL.into(),
        oracle: None,
        profile: None,
        series: false,
    };
    let outcome = run(
        &ClientSimulator::new(root.join("worlds")),
        &cases,
        &options,
        || (),
    );
    assert!(
        outcome.errors.is_empty(),
        "could not run: {}",
        outcome.errors[0]
    );
    let baseline = Path::new(env!("CARGO_MANIFEST_DIR")).join("baseline.toml");
    let baseline = Baseline::open(&baseline).expect("the baseline is readable");
    let new: Vec<_> = outcome
        .results
        .iter()
        .filter(|result| result.first_divergence.is_some() && baseline.accepts(result).is_none())
        .map(|result| {
            (
                &result.scene,
                &result.oracle,
                result.mode,
                &result.guid,
                &result.first_divergence,
            )
        })
        .collect();
    let totals = Totals::of(&outcome.results, &baseline);
    assert!(
        new.is_empty(),
        "{totals:?}\n{:#?}",
        &new[..new.len().min(5)]
    );
}
