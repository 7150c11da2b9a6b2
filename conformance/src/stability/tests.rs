//! Every listed case runs and has a verdict, and the table that people read names the same cases.

use std::{collections::BTreeSet, path::Path};

use super::{
    ensemble::{self, Change, Class},
    generators, lab,
    lab::Report,
    output,
    trial::Verdict,
    worlds,
};
use ac_client::profile::Profile;

/// How many cases each section of the specification lists.
const LISTED: [(&str, usize); 12] = [
    ("01", 16),
    ("02", 19),
    ("03", 20),
    ("04", 25),
    ("05", 20),
    ("06", 25),
    ("07", 22),
    ("08", 28),
    ("09", 16),
    ("10", 23),
    ("11", 18),
    ("12", 27),
];

#[test]
fn every_listed_case_has_a_generator() {
    for (section, count) in LISTED {
        let numbers: Vec<u16> = generators::all()
            .iter()
            .filter(|case| case.section == section)
            .map(|case| case.number)
            .collect();
        let wanted: Vec<u16> = (1..=count as u16).collect();
        assert_eq!(numbers, wanted, "section {section}");
    }
    assert_eq!(generators::all().len(), 259);
}

#[test]
fn the_table_of_the_documentation_is_complete() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/stability.md");
    let text = std::fs::read_to_string(path).unwrap();
    let in_table: BTreeSet<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split(" |").next())
        .filter(|id| id.len() == 5 && id.as_bytes()[2] == b'/')
        .collect();
    let generated: BTreeSet<String> = generators::all().iter().map(|case| case.id()).collect();
    let generated: BTreeSet<&str> = generated.iter().map(String::as_str).collect();
    assert_eq!(in_table, generated);
}

#[test]
fn every_listed_case_runs_and_none_is_ours() {
    // The longest ones have their own time: an hour of turning, 10⁵ steps.
    let long = ["06/01", "06/11"];
    let cases = lab::cases(|id| !long.contains(&id));
    assert_eq!(cases.len(), generators::all().len() - long.len());
    for case in &cases {
        assert_ne!(
            case.verdict,
            Verdict::Ours,
            "{}: {:#?}",
            case.id,
            case.violations
        );
        assert!(
            case.checks > 0 || case.verdict == Verdict::NoCode,
            "{} checks nothing",
            case.id
        );
        assert!(
            case.verdict != Verdict::NoCode || matches!(&case.id[..2], "02" | "12"),
            "{}",
            case.id
        );
    }
}

#[test]
fn results_are_the_same_every_time() {
    let report = || Report {
        cases: lab::cases(|id| id.starts_with("05")),
        scenes: lab::whole_scenes(),
        ..Report::default()
    };
    let once = report();
    assert_eq!(output::document(&once), output::document(&report()));
    assert_eq!(once.ours(), 0, "{}", output::human(&once));
    assert!(once.scenes.len() > 10);
}

#[test]
fn a_fall_is_neutral_and_repeats_of_itself_are_equal() {
    let play = worlds::play().unwrap();
    let (_, stage) = lab::plain(play).swap_remove(1);
    let found = ensemble::run(
        &stage.scene,
        &stage.source,
        &Profile::retail(),
        &Change::ALL,
    )
    .unwrap();
    assert_eq!(found.members.len(), Change::ALL.len());
    assert_ne!(found.class, Class::Discontinuous, "{found:#?}");
    for member in &found.members {
        let nudged = matches!(member.change, Change::Place(_) | Change::PlaceUlps(_));
        assert!(!nudged || member.start > 0.0, "{member:?}");
    }
    let nothing = ensemble::run(
        &stage.scene,
        &stage.source,
        &Profile::retail(),
        &[Change::PlaceUlps(0)],
    )
    .unwrap();
    assert_eq!(
        (nothing.members[0].start, nothing.members[0].max),
        (0.0, 0.0)
    );
}
