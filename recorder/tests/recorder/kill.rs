//! A few kills of a running proxy; `ac-record kill-trials` makes many.

use std::process::Command;

#[test]
fn a_kill_loses_nothing_older_than_the_bound() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_ac-record"))
        .args(["kill-trials", "--trials", "5", "--jobs", "5", "--lines"])
        .arg(folder.path().join("kill.jsonl"))
        .output()
        .expect("built");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.starts_with("5 kills: 5 recovered"), "{said}");
}
