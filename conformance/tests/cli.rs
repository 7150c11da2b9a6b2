//! The program from outside: exit codes, and what goes to which stream.

use std::{
    fs,
    process::{Command, Output},
};

fn conform(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ac-conform"))
        .args(arguments)
        .env("NO_COLOR", "1")
        .output()
        .expect("the program starts")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("it was not killed")
}

#[test]
fn help_is_no_error_and_nonsense_is() {
    assert_eq!(code(&conform(&["--help"])), 0);
    assert_eq!(code(&conform(&["run", "--mode", "sideways"])), 2);
    assert_eq!(code(&conform(&[])), 2);
}

#[test]
fn what_cannot_run_is_two_and_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    for arguments in [
        &["run", "/no/such/place"][..],
        &["run", path],
        &["run", path, "--profile", "nobody"],
        &["vectors", path],
    ] {
        let output = conform(arguments);
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(
            output.stdout.is_empty(),
            "{arguments:?} wrote to standard output"
        );
        assert!(!output.stderr.is_empty(), "{arguments:?} said nothing");
    }
}

#[test]
fn a_damaged_trace_is_two_with_json_on_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.mcap");
    fs::write(&path, b"this is no trace at all").unwrap();
    let output = conform(&["run", path.to_str().unwrap(), "--format", "json"]);
    assert_eq!(code(&output), 2);
    let json: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("one JSON document");
    assert_eq!(json["totals"]["results"], 0);
    assert!(String::from_utf8_lossy(&output.stderr).contains("bad.mcap: not a readable trace"));
}

#[test]
fn a_vector_that_is_not_met_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.jsonl");
    let header = r#"{"schema":"ac-vectors/1","family":"frame","oracle":"gdle","seed":1,"count":1,"notes":[]}"#;
    let vector = |x: f32| {
        format!(
            "{header}\n{{\"fn\":\"localtoglobal\",\"in\":{{\"frame\":{{\"origin\":[1,2,3],\"rotation\":[1,0,0,0]}},\"point\":[1,1,1]}},\"out\":{{\"point\":[{x},3,4]}}}}\n"
        )
    };
    fs::write(&path, vector(2.0)).unwrap();
    assert_eq!(code(&conform(&["vectors", path.to_str().unwrap()])), 0);
    fs::write(&path, vector(2.5)).unwrap();
    let output = conform(&["vectors", path.to_str().unwrap(), "--format", "json"]);
    assert_eq!(code(&output), 1);
    let json: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("one JSON document");
    assert_eq!(
        json["results"][0]["first_mismatch"]["field"],
        "out.point[0]"
    );
}
