//! The part of the page about finding causes: what bisecting and shrinking did when they were tried.
//!
//! Both commands print a line of JSON with `--format json`; the page reads the lines in `target/bisect.jsonl` and
//! `target/shrink.jsonl` (docs/bisecting.md says where they come from).

use std::{fmt::Write, fs, path::Path};

use serde::Deserialize;
use serde_json::Value;

/// What was tried.
#[derive(Clone, Debug, Default)]
pub struct Tools {
    /// Bisections.
    pub bisections: Vec<Bisection>,
    /// Scenes that were shrunk.
    pub shrunk: Vec<Shrunk>,
}

/// A line of `ac-conform bisect --format json`, as far as the page shows it.
#[derive(Clone, Debug, Deserialize)]
pub struct Bisection {
    trace: String,
    first_bad: Option<FirstBad>,
    states: Vec<Value>,
    stage: Option<Stage>,
}

#[derive(Clone, Debug, Deserialize)]
struct FirstBad {
    subject: String,
    commits: usize,
    asked: usize,
    unbuildable: usize,
}

#[derive(Clone, Debug, Deserialize)]
struct Stage {
    frame: i32,
    stage: String,
    how: String,
    fields: Vec<(String, Value, Value)>,
}

/// A line of `ac-conform shrink --format json`.
#[derive(Clone, Debug, Deserialize)]
pub struct Shrunk {
    from: String,
    oracle: String,
    before: Size,
    after: Size,
    bytes: u64,
    runs: usize,
    shown: Shown,
}

#[derive(Clone, Debug, Deserialize)]
struct Size {
    frames: u32,
    entities: usize,
    steps: usize,
    records: usize,
}

#[derive(Clone, Debug, Deserialize)]
struct Shown {
    field: String,
    stage: Option<String>,
}

/// What was kept in the build folder. Lines that cannot be read, and files that are not there, are left out.
pub fn tools_in(target: &Path) -> Tools {
    fn lines<T: for<'a> Deserialize<'a>>(path: &Path) -> Vec<T> {
        let text = fs::read_to_string(path).unwrap_or_default();
        let lines = text.lines();
        lines
            .filter_map(|line| serde_json::from_str(line).ok())
            .collect()
    }
    Tools {
        bisections: lines(&target.join("bisect.jsonl")),
        shrunk: lines(&target.join("shrink.jsonl")),
    }
}

/// A number as short as it can be; anything else as JSON.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() > 40 {
        let start: String = text.chars().take(39).collect();
        return format!("{start}…");
    }
    text
}

/// `area/name` of the path of a bundled trace.
fn scene(path: &str) -> String {
    let mut parts: Vec<&str> = path.trim_end_matches(".mcap").rsplit('/').take(2).collect();
    parts.reverse();
    parts.join("/")
}

pub(super) fn section(text: &mut String, tools: &Tools) {
    bisections(text, &tools.bisections);
    shrunk(text, &tools.shrunk);
}

fn bisections(text: &mut String, bisections: &[Bisection]) {
    if bisections.is_empty() {
        return;
    }
    *text += "\n## Bisecting\n\nFaults planted in the sources, one commit each among others that change nothing here and one that cannot be \
              built, and what `ac-conform bisect` found.\n\n\
              | trace | commit found | commits | built and run | not to be built | frame | stage | field | before | since |\n\
              |---|---|---|---|---|---|---|---|---|---|\n";
    for found in bisections {
        let Some(first) = &found.first_bad else {
            continue;
        };
        let (frame, stage, field, good, bad) = place(found);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {frame} | {stage} | {field} | {good} | {bad} |",
            scene(&found.trace),
            first.subject.replace('|', "\\|"),
            first.commits,
            first.asked,
            first.unbuildable,
        );
    }
}

/// Frame, stage, field and both values of the first difference.
fn place(found: &Bisection) -> (String, String, String, String, String) {
    if let Some(stage) = &found.stage {
        let name = match stage.how.as_str() {
            "output" => stage.stage.clone(),
            "input" => format!("before {}", stage.stage),
            _ => format!("{} (in one only)", stage.stage),
        };
        let (field, good, bad) = match stage.fields.first() {
            Some((path, good, bad)) => (format!("`{path}`"), short(good), short(bad)),
            None => ("–".into(), "–".into(), "–".into()),
        };
        return (stage.frame.to_string(), name, field, good, bad);
    }
    let first = found.states.first();
    let of = |key: &str| first.map_or_else(|| "–".into(), |first| short(&first[key]));
    let field = first.and_then(|first| first["field"].as_str());
    (
        of("frame"),
        "–".into(),
        field.map_or_else(|| "–".into(), |field| format!("`{field}`")),
        of("expected"),
        of("actual"),
    )
}

fn shrunk(text: &mut String, shrunk: &[Shrunk]) {
    if shrunk.is_empty() {
        return;
    }
    *text += "\n## Shrinking\n\nScenes in which `retail` differs from another profile, and what `ac-conform shrink` left of them with the same field \
              and stage. Bytes are those of scene, expectation and world together.\n\n\
              | scene | against | differs in | stage | frames | entities | steps | records of the world | bytes | runs |\n\
              |---|---|---|---|---|---|---|---|---|---|\n";
    for of in shrunk {
        let (a, b) = (&of.before, &of.after);
        let _ = writeln!(
            text,
            "| {} | {} | `{}` | {} | {} of {} | {} of {} | {} of {} | {} of {} | {} | {} |",
            of.from,
            of.oracle,
            crate::compare::fields::without_indices(&of.shown.field),
            of.shown.stage.as_deref().unwrap_or("–"),
            b.frames,
            a.frames,
            b.entities,
            a.entities,
            b.steps,
            a.steps,
            b.records,
            a.records,
            of.bytes,
            of.runs,
        );
    }
    let mut kept: Vec<f64> = shrunk
        .iter()
        .map(|of| f64::from(of.after.frames) / f64::from(of.before.frames.max(1)))
        .collect();
    kept.sort_by(f64::total_cmp);
    let median = |sorted: &[f64]| sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let frames = median(&kept);
    let mut records: Vec<f64> = shrunk
        .iter()
        .map(|of| of.after.records as f64 / of.before.records.max(1) as f64)
        .collect();
    records.sort_by(f64::total_cmp);
    let largest = shrunk.iter().map(|of| of.bytes).max().unwrap_or(0);
    let _ = writeln!(
        text,
        "\nMedian of {}: {:.1} % of the frames and {:.1} % of the records are left; the largest is {largest} bytes.",
        shrunk.len(),
        frames * 100.0,
        median(&records) * 100.0,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_tables_and_nothing_becomes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut text = String::new();
        section(&mut text, &tools_in(folder.path()));
        assert_eq!(text, "");
        let bisection = r#"{"schema":"ac-conform-bisect/1","trace":"golden-traces/self/bounce/drop.mcap","first_bad":{"commit":"c","subject":"plant | it","or":[],"commits":9,"asked":4,"unbuildable":1,"before":{},"since":{}},"states":[],"stage":{"frame":3,"guid":"0x1","quantum":0,"stage":"integrate","how":"output","fields":[["out.velocity[2]",1.5,1.25]]}}"#;
        let shrunk = r#"{"schema":"ac-conform-shrink/1","from":"a/b","oracle":"gdle","before":{"frames":100,"entities":2,"steps":3,"records":400,"world_bytes":1},"after":{"frames":4,"entities":1,"steps":1,"records":8,"world_bytes":1},"bytes":20000,"runs":90,"budget_spent":false,"shown":{"guid":"0x1","frame":3,"stage":"transition","field":"origin[0]","expected":1,"actual":2}}"#;
        fs::write(
            folder.path().join("bisect.jsonl"),
            format!("{bisection}\nnonsense\n"),
        )
        .unwrap();
        fs::write(folder.path().join("shrink.jsonl"), shrunk).unwrap();
        section(&mut text, &tools_in(folder.path()));
        insta::assert_snapshot!(text);
    }
}
