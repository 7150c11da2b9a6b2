//! `ac-conform precision` and `ac-conform stability` as a person calls them.

use std::process::{Command, Output};

fn conform(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ac-conform"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn precision_without_times_is_the_same_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().display().to_string();
    let arguments = [
        "precision",
        "analytic",
        "--quick",
        "--repeats",
        "0",
        "--format",
        "csv",
        "--report",
        &report,
    ];
    let once = conform(&arguments);
    assert_eq!(once.status.code(), Some(0), "{}", text(&once.stderr));
    let lines = text(&once.stdout);
    assert!(lines.starts_with("scene,class,axis,setting,"), "{lines}");
    assert_eq!(lines.lines().count(), 1 + 3 * 9, "{lines}");
    assert_eq!(once.stdout, conform(&arguments).stdout);
    let page = std::fs::read_to_string(folder.path().join("precision.html")).unwrap();
    assert!(page.contains("<svg") && !page.contains("NaN") && !page.contains("<script"));
}

#[test]
fn stability_runs_what_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().display().to_string();
    let found = conform(&[
        "stability",
        "04/11",
        "07",
        "--format",
        "json",
        "--report",
        &report,
    ]);
    assert_eq!(found.status.code(), Some(0), "{}", text(&found.stderr));
    let document: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
    assert_eq!(document["totals"]["listed"], 23);
    assert_eq!(document["totals"]["ours"], 0);
    assert!(folder.path().join("stability.html").is_file());
}

#[test]
fn a_bundled_scene_has_an_ensemble_and_rules() {
    let trace = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../golden-traces/traces/bounce/drop.mcap"
    );
    let found = conform(&["stability", trace, "--quick", "--format", "json"]);
    assert_eq!(found.status.code(), Some(0), "{}", text(&found.stderr));
    let document: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
    assert_eq!(
        document["ensembles"][0]["members"].as_array().map(Vec::len),
        Some(3)
    );
    assert_eq!(document["scenes"][0]["verdict"], "holds");
}

#[test]
fn what_is_not_there_says_what_to_do() {
    let found = conform(&["stability", "99/01"]);
    assert_eq!(found.status.code(), Some(2));
    let message = text(&found.stderr);
    assert!(
        message.contains("nothing to run") && message.contains("docs/stability.md"),
        "{message}"
    );
    assert_eq!(
        conform(&["precision", "no/such/scene.mcap"]).status.code(),
        Some(2)
    );
}
