//! Two small bundled scenes through the client library, and a scene that is not met.

use std::fs;

use ac_golden_traces::corpus;
use ac_replayer::client::ClientSimulator;

use super::*;
use crate::run::cases;

fn bundled(scenes: &[&str], oracle: Option<&str>) -> Outcome {
    let root = corpus::bundled();
    let paths: Vec<_> = scenes
        .iter()
        .map(|scene| root.join(format!("traces/{scene}.mcap")))
        .collect();
    let cases = cases::find(&paths, None, None).unwrap();
    run(
        &ClientSimulator::new(root.join("worlds")),
        &cases,
        oracle,
        || (),
    )
}

#[test]
fn two_scenes_for_a_reader() {
    let outcome = bundled(&["extreme/nan-velocity", "motion/stop-completely"], None);
    assert!(outcome.errors.is_empty(), "{:?}", outcome.errors);
    insta::assert_snapshot!(human(&outcome.scenes));
}

#[test]
fn one_scene_for_a_program() {
    let outcome = bundled(&["extreme/nan-velocity"], Some("gdle"));
    let text = json(&outcome.scenes).unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["schema"], report::SCHEMA);
    assert_eq!(value["totals"]["scenes"], 1);
    // One line per scene and switch; here only the scene's.
    insta::assert_snapshot!(text.lines().take(2).collect::<Vec<_>>().join("\n"));
}

#[test]
fn threads_do_not_change_anything() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| bundled(&["extreme/nan-velocity"], Some("ace")))
            .scenes
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn every_switch_that_differs_is_counted_once() {
    let outcome = bundled(&["extreme/nan-velocity"], None);
    let counts = switch_counts(&outcome.scenes);
    for scene in &outcome.scenes {
        let of_oracle = counts
            .iter()
            .filter(|count| count.oracles.contains_key(&scene.oracle));
        assert_eq!(of_oracle.count(), scene.tried);
    }
    assert!(counts.iter().any(SwitchCount::is_unseen));
}

const SCENE: &str = r#"{"schema":"ac-scene/1","name":"area/none","summary":"s","world":"testbed","features":[],"start_time":10,
    "frames":[{"dt":0.5,"count":2}],"track":["0x1"],"entities":[],"script":[]}"#;

#[test]
fn nothing_is_said_about_a_scene_that_is_not_met() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("none.scene.json"), SCENE).unwrap();
    let expect = |frame: i32| {
        format!(
            "{{\"schema\":\"ac-expect/1\",\"scene\":\"area/none\",\"oracle\":\"gdle\",\"oracle_version\":\"1\",\"notes\":[]}}\n\
             {{\"frame\":{frame},\"time\":10,\"guid\":\"0x1\",\"cell\":\"0xA9B40001\",\"origin\":[1,0,0]}}\n"
        )
    };
    let with = |frame| {
        fs::write(folder.path().join("none.expect.jsonl"), expect(frame)).unwrap();
        let cases = cases::find(&[folder.path().to_owned()], None, None).unwrap();
        let worlds = corpus::bundled().join("worlds");
        run(&ClientSimulator::new(worlds), &cases, None, || ())
    };
    let outcome = with(-1);
    assert!(outcome.errors.is_empty(), "{:?}", outcome.errors);
    insta::assert_snapshot!(human(&outcome.scenes).lines().next().unwrap(), @r#"area/none gdle: nothing tried, not met under the oracle's own profile: frame -1 0x1 record: expected "there", got "gone""#);
    let outcome = with(7);
    assert!(outcome.scenes.is_empty());
    assert!(
        outcome.errors[0]
            .to_string()
            .ends_with("oracle gdle has frame 7, the scene ends before it")
    );
}
