//! The gate from outside, on bundled traces: verdicts, policies, shards, merging, hashes, and what is written for others to read.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use ac_golden_traces::corpus;
use serde_json::Value;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Runs the program in this folder. `@/` in an argument is the folder of the bundled traces.
    fn conform(&self, line: &str) -> Output {
        let bundled = corpus::bundled().join("traces").display().to_string();
        let arguments = line.split(' ').map(|word| word.replace("@", &bundled));
        Command::new(env!("CARGO_BIN_EXE_ac-conform"))
            .args(arguments)
            .current_dir(self.0.path())
            .env("NO_COLOR", "1")
            .env_remove("GITHUB_STEP_SUMMARY")
            .output()
            .expect("the program starts")
    }
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("it was not killed")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("one JSON document")
}

/// One trace that is exact under the oracle's profile; its four entities diverge under `retail`, in frame 0.
const DIVERGES: &str = "run @/objects/boulder.mcap --oracle ace --mode free --profile retail";

#[test]
fn exit_codes_say_what_a_run_means() {
    let folder = Folder::new();
    let exact = folder.conform("run @/bounce/drop.mcap");
    assert_eq!(code(&exact), 0, "{exact:?}");
    assert!(stdout(&exact).contains("gate: 0 new, 0 changed, 0 flaky"));
    assert_eq!(code(&folder.conform(DIVERGES)), 1);
    assert_eq!(
        code(&folder.conform("run @/bounce/drop.mcap --oracle nobody")),
        2
    );
    assert_eq!(code(&folder.conform("run nowhere.mcap")), 2);
}

#[test]
fn every_divergence_has_one_label_and_the_counts_agree() {
    let folder = Folder::new();
    // The baseline has an entry for two of the four, one of them for a later frame.
    let found = json(&folder.conform(&format!("{DIVERGES} --format json")));
    let first = |index: usize| &found["results"][index]["first_divergence"];
    let diverging: Vec<usize> = (0..4).filter(|index| !first(*index).is_null()).collect();
    assert!(diverging.len() >= 3, "{found:#}");
    let entry = |index: usize, later: i64| {
        let divergence = first(index);
        format!(
            "[[known]]\nscene = 'objects/boulder'\noracle = 'ace'\nmode = 'free'\nguid = {}\nframe = {}\nfield = {}\nreason = 'because'\n",
            found["results"][index]["guid"],
            divergence["frame"].as_i64().unwrap() + later,
            divergence["field"]
        )
    };
    let entries = entry(diverging[0], 0) + &entry(diverging[1], 5);
    folder.write("known.toml", &entries);
    let output = folder.conform(&format!("{DIVERGES} --baseline known.toml"));
    assert_eq!(code(&output), 1);
    let text = stdout(&output);
    let labelled = |label: &str| {
        let start = format!("{label}: objects/boulder ace free ");
        text.lines().filter(|line| line.starts_with(&start)).count()
    };
    assert_eq!((labelled("known"), labelled("changed")), (1, 1), "{text}");
    assert_eq!(labelled("new"), diverging.len() - 2, "{text}");
    let counts = format!("gate: {} new, 1 changed, 0 flaky", diverging.len() - 2);
    assert!(text.contains(&counts), "{text}");
    assert!(text.contains("the baseline has frame"), "{text}");
    // What closes the gate comes first.
    assert!(text.find("\nnew: ") < text.find("\nchanged: "));
    assert!(text.find("\nchanged: ") < text.find("\nknown: "));
}

#[test]
fn a_policy_widens_skips_and_is_named_with_its_reasons() {
    let folder = Folder::new();
    let arc = DIVERGES.replace("objects/boulder", "missile/arc");
    folder.write(
        "wide.toml",
        "[[tolerance]]\nscene = 'missile/*'\nfield = '*'\nany = true\nreason = 'only to try it'\n",
    );
    let output = folder.conform(&format!("{arc} --policy wide.toml --report report"));
    assert_eq!(code(&output), 0, "{output:?}");
    let text = stdout(&output);
    assert!(
        text.contains("within tolerance: missile/arc ace free"),
        "{text}"
    );
    assert!(text.contains("only to try it"), "{text}");
    assert!(!text.contains("new:"), "{text}");
    assert!(folder.text("report/index.html").contains("only to try it"));
    folder.write(
        "skip.toml",
        "[[skip]]\nscene = 'missile/*'\nreason = 'takes hours'\n",
    );
    let output = folder.conform(&format!("{arc} --policy skip.toml"));
    assert_eq!(code(&output), 0, "{output:?}");
    assert!(stdout(&output).contains("skipped: missile/arc: takes hours"));
    folder.write(
        "bad.toml",
        "[[tolerance]]\nfield = 'origin'\nulp = 1\nreason = ''\n",
    );
    let output = folder.conform(&format!("{DIVERGES} --policy bad.toml"));
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("say why"), "{output:?}");
}

#[test]
fn shards_merge_to_the_whole_run() {
    let folder = Folder::new();
    let run = "run @/bounce --oracle ace --mode free --profile retail --format json";
    let whole = folder.conform(run);
    assert_eq!(code(&whole), 1);
    for cut in ["", "hash:"] {
        for part in 1..=3 {
            let output = folder.conform(&format!("{run} --shard {cut}{part}/3"));
            folder.write(&format!("{part}.json"), &stdout(&output));
        }
        let merged = folder.conform("merge 3.json 1.json 2.json --format json");
        assert_eq!(code(&merged), 1, "{merged:?}");
        assert_eq!(json(&merged)["results"], json(&whole)["results"]);
        assert_eq!(json(&merged)["totals"], json(&whole)["totals"]);
        let half = folder.conform("merge 3.json 1.json");
        assert_eq!(code(&half), 2);
        assert!(stderr(&half).contains("2/3 is missing"), "{half:?}");
        let twice = folder.conform("merge 1.json 1.json 2.json 3.json");
        assert_eq!(code(&twice), 2);
        assert!(stderr(&twice).contains("is in another document too"));
    }
    folder.write("nonsense.json", "{}");
    assert_eq!(code(&folder.conform("merge nonsense.json")), 2);
}

#[test]
fn a_scene_in_two_traces_is_in_one_shard_and_no_flake() {
    let folder = Folder::new();
    // The oracles' trace and the library's own, of the same scene.
    let own = corpus::bundled().join("self/bounce").display().to_string();
    let run = format!("run @/bounce {own} --mode free --profile gdle --format json");
    let mut scenes: Vec<String> = Vec::new();
    for part in 1..=2 {
        let output = json(&folder.conform(&format!("{run} --shard {part}/2")));
        assert!(output["flaky"].is_null(), "{output:#}");
        let results = output["results"].as_array().unwrap();
        let mut here: Vec<String> = results
            .iter()
            .map(|result| result["scene"].as_str().unwrap().to_owned())
            .collect();
        here.dedup();
        for scene in &here {
            let mut oracles: Vec<&str> = results
                .iter()
                .filter(|result| result["scene"] == **scene)
                .map(|result| result["oracle"].as_str().unwrap())
                .collect();
            oracles.dedup();
            assert_eq!(oracles, ["ace", "gdle", "gdle-repaired", "self"], "{scene}");
        }
        scenes.extend(here);
    }
    let all = scenes.len();
    scenes.sort();
    scenes.dedup();
    assert_eq!((all, scenes.len()), (6, 6));
}

#[test]
fn junit_annotations_and_summaries_are_written() {
    let folder = Folder::new();
    let output = folder.conform(&format!(
        "{DIVERGES} --junit junit.xml --annotations --summary summary.md"
    ));
    assert_eq!(code(&output), 1);
    let junit = folder.text("junit.xml");
    assert!(junit.starts_with("<?xml"), "{junit}");
    assert_eq!(junit.matches("<testcase").count(), 4, "{junit}");
    assert!(junit.contains("type=\"new\""), "{junit}");
    assert!(stderr(&output).contains("::error title=new%3A objects/boulder ace free"));
    assert!(
        folder
            .text("summary.md")
            .starts_with("### Conformance: failed")
    );
    // A summary is added to what is there.
    folder.conform("run @/bounce/drop.mcap --summary summary.md");
    assert_eq!(
        folder.text("summary.md").matches("### Conformance").count(),
        2
    );
}

#[test]
fn hashes_are_checked_against_a_file() {
    let folder = Folder::new();
    let output = folder.conform("hash @/bounce --frames");
    assert_eq!(code(&output), 0);
    folder.write("hashes.txt", &stdout(&output));
    assert_eq!(code(&folder.conform("hash @/bounce --check hashes.txt")), 0);
    // One frame of one scene.
    let text = folder.text("hashes.txt");
    let line = text
        .lines()
        .find(|line| line.ends_with("bounce/drop 7"))
        .unwrap();
    let changed = format!("{:032x} bounce/drop 7", 7);
    folder.write("changed.txt", &text.replace(line, &changed));
    let output = folder.conform("hash @/bounce --check changed.txt");
    assert_eq!(code(&output), 1);
    assert!(stdout(&output).contains("from frame 7 on"), "{output:?}");
    let output = folder.conform("hash @/bounce --check hashes.txt --profile gdle");
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("--profile retail"), "{output:?}");
    folder.write("bad.txt", "no hashes\n");
    assert_eq!(code(&folder.conform("hash @/bounce --check bad.txt")), 2);
}

#[test]
fn a_path_that_is_not_there_gets_advice() {
    let folder = Folder::new();
    let advice = |path: &str| {
        let output = folder.conform(&format!("run {path}"));
        assert_eq!(code(&output), 2);
        assert!(stdout(&output).is_empty());
        // Lines are broken where the terminal ends.
        stderr(&output)
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    };
    let scene = advice("bounce/drop");
    assert!(
        scene.contains("bounce/drop: there is no such file or folder"),
        "{scene}"
    );
    assert!(
        scene.contains("the bundled scene of this name is"),
        "{scene}"
    );
    let other = advice("nowhere/tiny.scene.json");
    assert!(other.contains("scenes in .scene.json"), "{other}");
}

#[test]
fn only_the_own_expectations_can_be_blessed() {
    let folder = Folder::new();
    let output = folder.conform("bless @/bounce/drop.mcap --oracle gdle --accept *");
    assert_eq!(code(&output), 2);
    let said = stderr(&output)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    assert!(
        said.contains("the expectations of oracle `gdle` cannot be blessed"),
        "{said}"
    );
    let output = folder.conform("bless @/bounce/drop.mcap --accept *");
    assert_eq!(code(&output), 2, "it has none of its own: {output:?}");
    // A new one is shown, then written, then there is nothing left to say.
    let bless = "bless @/bounce/drop.mcap --into own";
    assert_eq!(code(&folder.conform(bless)), 1);
    assert!(!Path::new(&folder.path("own")).exists());
    assert_eq!(
        code(&folder.conform(&format!("{bless} --accept bounce/*"))),
        0
    );
    assert_eq!(code(&folder.conform(bless)), 0);
    let run = folder.conform("run own --format json");
    assert_eq!(code(&run), 0);
    assert_eq!(json(&run)["results"][0]["oracle"], "self");
}
