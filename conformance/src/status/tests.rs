//! The page from made-up measurements, as a reader sees it.

use std::path::Path;

use serde_json::json;

use super::*;
use crate::{
    compare::{Class, Divergence},
    run::sensitivity::{Change, Sensitive},
};

fn result(mode: Mode, exact: u64) -> RunResult {
    let stage = StageCount {
        compared: 4,
        exact,
        not_run: 2,
    };
    RunResult {
        scene: "terrain/one".into(),
        area: "terrain".into(),
        oracle: "gdle".into(),
        profile: "gdle".into(),
        mode,
        guid: "0x1".into(),
        frames_compared: 4,
        frames_exact: exact,
        first_divergence: None,
        max_error: BTreeMap::new(),
        undefined: 0,
        class: Class::Exact,
        tolerated: BTreeMap::new(),
        not_run: 2,
        stages: [("commit".to_owned(), stage)]
            .into_iter()
            .filter(|_| mode == Mode::Stage)
            .collect(),
    }
}

fn sensitive() -> SceneSensitivity {
    let change = Change {
        guid: "0x1".into(),
        divergence: Divergence {
            frame: 2,
            stage: None,
            field: "origin[0]".into(),
            expected: json!(1.5),
            actual: json!(1.25),
        },
    };
    SceneSensitivity {
        scene: "terrain/one".into(),
        oracle: "gdle".into(),
        tried: 40,
        unmet: None,
        sensitive: vec![Sensitive {
            switch: "floor_z",
            id: "T-12 01:T4 O-15 D32",
            oracle_choice: "F64".into(),
            retail_choice: "F32".into(),
            change,
        }],
    }
}

#[test]
fn the_page() {
    let measured = Measurements {
        machine: "2 processors, a model".into(),
        vectors: vec![FnResult {
            family: "frame".into(),
            function: "combine".into(),
            oracle: "gdle".into(),
            profile: "gdle".into(),
            total: 3,
            exact: 2,
            not_implemented: 1,
            left_out: 0,
            first_mismatch: None,
        }],
        runs: vec![result(Mode::Free, 4), result(Mode::Stage, 3)],
        motionless: ["terrain/one".to_owned()].into(),
        retail: vec![result(Mode::Free, 2)],
        sensitivity: vec![sensitive()],
        plans: Vec::new(),
        numerics: Numerics::default(),
        wall: Duration::from_millis(1500),
        vectors_wall: Duration::from_millis(250),
        sensitivity_wall: Duration::from_millis(12_340),
        threads: 2,
        costs: costs(
            b"{\"case\":\"resting\",\"ns\":12.5,\"allocations\":0}\n{\"case\":\"walking\",\"ns\":2500,\"instructions\":900,\"allocations\":0.5}\n",
        )
        .unwrap(),
        benches: vec![Bench {
            name: "group/one".into(),
            median: 1500.0,
            elements: Some(3),
        }],
        tools: Default::default(),
        recorder: RecorderNumbers::default(),
    };
    let page = page(&measured).replace("(debug build; ", "(release build; ");
    // What other switches there are is no matter of this test.
    let page: Vec<_> = page
        .lines()
        .filter(|line| !line.starts_with("| `") || line.contains("floor_z"))
        .collect();
    insta::assert_snapshot!(page.join("\n"));
}

#[test]
fn no_benchmarks_are_no_error() {
    assert_eq!(benches_in(Path::new("/no/such/folder")), []);
}

#[test]
fn costs_that_are_none_are_an_error() {
    assert!(costs(b"{\"case\":\"resting\"}").is_err());
    assert_eq!(costs(b"").unwrap(), []);
}

#[test]
fn the_machine_has_processors() {
    assert!(machine().contains("processor"));
}
