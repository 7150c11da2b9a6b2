//! `docs/status.md`: what matches how well, from measurements only.

use std::{collections::BTreeMap, fmt::Write, fs, path::Path, time::Duration};

use ac_golden_traces::corpus;
use serde_json::Value;

use crate::{
    run::{Mode, RunResult, StageCount},
    vectors::FnResult,
};

/// Everything that the page shows.
#[derive(Clone, Debug, Default)]
pub struct Measurements {
    /// Vectors, per function.
    pub vectors: Vec<FnResult>,
    /// All modes, each oracle under its own profile.
    pub runs: Vec<RunResult>,
    /// Free runs under the profile `retail`.
    pub retail: Vec<RunResult>,
    /// Time that `runs` took, from start to end.
    pub wall: Duration,
    /// Threads that it ran on.
    pub threads: usize,
    /// Benchmarks that have been run.
    pub benches: Vec<Bench>,
}

/// A benchmark's result.
#[derive(Clone, Debug, PartialEq)]
pub struct Bench {
    /// Group and function.
    pub name: String,
    /// Nanoseconds per iteration, median.
    pub median: f64,
    /// Elements per iteration, if it counts them.
    pub elements: Option<u64>,
}

/// The page.
pub fn page(measured: &Measurements) -> String {
    let mut text = String::from(
        "# Status\n\nWritten by `ac-conform status` from measurements. *Exact* means the same bits in every recorded number, sign of zero included.\n\n",
    );
    summary(&mut text, measured);
    vectors(&mut text, &measured.vectors);
    scenes(&mut text, &measured.runs);
    stages(&mut text, &measured.runs);
    retail(&mut text, &measured.retail);
    benches(&mut text, measured);
    text
}

/// `exact of total`, in bold when something is missing.
fn share(exact: u64, total: u64) -> String {
    if exact == total {
        format!("{exact}")
    } else {
        format!("**{exact}** of {total}")
    }
}

fn summary(text: &mut String, measured: &Measurements) {
    let sum = |results: &[FnResult], count: fn(&FnResult) -> usize| {
        results.iter().map(count).sum::<usize>() as u64
    };
    let _ = writeln!(
        text,
        "- vectors exact: {}",
        share(
            sum(&measured.vectors, |r| r.exact),
            sum(&measured.vectors, |r| r.total)
        )
    );
    for mode in Mode::ALL {
        let results: Vec<_> = measured
            .runs
            .iter()
            .filter(|result| result.mode == mode)
            .collect();
        let count =
            |each: fn(&RunResult) -> u64| results.iter().map(|result| each(result)).sum::<u64>();
        let what = if mode == Mode::Stage {
            "records"
        } else {
            "frames"
        };
        let _ = writeln!(
            text,
            "- {}: {what} exact {}, entities exact {}",
            mode.name(),
            share(count(|r| r.frames_exact), count(|r| r.frames_compared)),
            share(
                results
                    .iter()
                    .filter(|r| r.first_divergence.is_none())
                    .count() as u64,
                results.len() as u64
            )
        );
    }
    let _ = writeln!(
        text,
        "- time of the whole corpus, all oracles, all modes: {:.1} s on {} threads\n",
        measured.wall.as_secs_f64(),
        measured.threads
    );
}

fn vectors(text: &mut String, results: &[FnResult]) {
    let mut families: BTreeMap<&str, BTreeMap<&str, (u64, u64)>> = BTreeMap::new();
    for result in results {
        let counts = families
            .entry(&result.family)
            .or_default()
            .entry(&result.oracle)
            .or_default();
        counts.0 += result.exact as u64;
        counts.1 += result.total as u64;
    }
    let oracles = columns(results.iter().map(|result| result.oracle.as_str()));
    text.push_str("## Vectors\n\nExact calls of single primitives, per family and oracle.\n\n");
    heading(text, "family", &oracles);
    for (family, counts) in families {
        let cells = oracles.iter().map(|oracle| {
            counts
                .get(oracle)
                .map_or("–".into(), |(exact, total)| share(*exact, *total))
        });
        row(text, family, cells);
    }
    text.push('\n');
}

fn scenes(text: &mut String, results: &[RunResult]) {
    text.push_str(
        "## Scenes\n\nExact scenes (exact frames) per area, each oracle under its own profile.\n\n",
    );
    let frames: Vec<_> = results
        .iter()
        .filter(|result| result.mode != Mode::Stage)
        .collect();
    let columns_: Vec<(&str, Mode)> = columns(frames.iter().map(|result| result.oracle.as_str()))
        .into_iter()
        .flat_map(|oracle| [(oracle, Mode::Free), (oracle, Mode::Resync)])
        .collect();
    let names: Vec<String> = columns_
        .iter()
        .map(|(oracle, mode)| format!("{oracle}, {}", mode.name()))
        .collect();
    heading(text, "area", &names);
    for area in columns(frames.iter().map(|result| result.area.as_str())) {
        let cells = columns_.iter().map(|(oracle, mode)| {
            cell(
                frames
                    .iter()
                    .copied()
                    .filter(|r| r.area == area && r.oracle == *oracle && r.mode == *mode),
            )
        });
        row(text, area, cells);
    }
    text.push('\n');
}

/// Exact scenes and exact frames of some results.
fn cell<'a>(results: impl Iterator<Item = &'a RunResult>) -> String {
    let mut scenes: BTreeMap<&str, bool> = BTreeMap::new();
    let (mut exact, mut frames) = (0, 0);
    for result in results {
        *scenes.entry(&result.scene).or_insert(true) &= result.first_divergence.is_none();
        exact += result.frames_exact;
        frames += result.frames_compared;
    }
    let exact_scenes = scenes.values().filter(|exact| **exact).count() as u64;
    format!(
        "{} ({})",
        share(exact_scenes, scenes.len() as u64),
        share(exact, frames)
    )
}

fn stages(text: &mut String, results: &[RunResult]) {
    const ORDER: [&str; 7] = [
        "animation",
        "adjust",
        "integrate",
        "hooks",
        "transition",
        "commit",
        "motion",
    ];
    let mut stages: BTreeMap<(usize, &str), StageCount> = BTreeMap::new();
    for (stage, count) in results.iter().flat_map(|result| &result.stages) {
        let place = ORDER
            .iter()
            .position(|name| name == stage)
            .unwrap_or(ORDER.len());
        let sum = stages.entry((place, stage)).or_default();
        sum.compared += count.compared;
        sum.exact += count.exact;
        sum.not_run += count.not_run;
    }
    text.push_str(
        "## Stages\n\nExact records of each stage run alone from its recorded inputs.\n\n",
    );
    heading(text, "stage", &["records", "not run alone"]);
    for ((_, stage), count) in stages {
        row(
            text,
            stage,
            [
                share(count.exact, count.compared),
                count.not_run.to_string(),
            ],
        );
    }
    text.push('\n');
}

fn retail(text: &mut String, results: &[RunResult]) {
    text.push_str("## The profile `retail`\n\nFree runs under the normative choices: where these differ from an oracle, the scene is sensitive to a numbered difference.\n\n");
    let oracles = columns(results.iter().map(|result| result.oracle.as_str()));
    heading(text, "area", &oracles);
    for area in columns(results.iter().map(|result| result.area.as_str())) {
        let cells = oracles.iter().map(|oracle| {
            cell(
                results
                    .iter()
                    .filter(|r| r.area == area && r.oracle == *oracle),
            )
        });
        row(text, area, cells);
    }
    text.push('\n');
}

fn benches(text: &mut String, measured: &Measurements) {
    if measured.benches.is_empty() {
        return;
    }
    text.push_str("## Speed\n\nMedians of `cargo bench`, one thread.\n\n");
    heading(text, "benchmark", &["time", "per second"]);
    for bench in &measured.benches {
        let rate = bench.elements.map_or("–".into(), |elements| {
            format!("{:.2e}", elements as f64 * 1e9 / bench.median)
        });
        row(text, &bench.name, [duration(bench.median), rate]);
    }
}

fn duration(nanoseconds: f64) -> String {
    match nanoseconds {
        ns if ns < 1e3 => format!("{ns:.1} ns"),
        ns if ns < 1e6 => format!("{:.2} µs", ns / 1e3),
        ns if ns < 1e9 => format!("{:.2} ms", ns / 1e6),
        ns => format!("{:.2} s", ns / 1e9),
    }
}

/// Distinct names in order.
fn columns<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names: Vec<_> = names.collect();
    names.sort_unstable();
    names.dedup();
    names
}

fn heading(text: &mut String, first: &str, columns: &[impl AsRef<str>]) {
    row(
        text,
        first,
        columns.iter().map(|column| column.as_ref().to_owned()),
    );
    let _ = writeln!(text, "|---|{}", "---|".repeat(columns.len()));
}

fn row(text: &mut String, first: &str, cells: impl IntoIterator<Item = String>) {
    let _ = writeln!(
        text,
        "| {first} | {} |",
        cells.into_iter().collect::<Vec<_>>().join(" | ")
    );
}

/// Results that `cargo bench` left under `target/criterion`, by name. What cannot be read is left out.
pub fn benches_in(target: &Path) -> Vec<Bench> {
    let files = corpus::find(
        &target.join("criterion"),
        &["new/estimates.json", "new\\estimates.json"],
    )
    .unwrap_or_default();
    let mut benches: Vec<Bench> = files.iter().filter_map(|file| bench(file)).collect();
    benches.sort_by(|a, b| a.name.cmp(&b.name));
    benches
}

fn bench(estimates: &Path) -> Option<Bench> {
    let read = |path: &Path| serde_json::from_slice::<Value>(&fs::read(path).ok()?).ok();
    let about = read(&estimates.with_file_name("benchmark.json"))?;
    Some(Bench {
        name: about.get("full_id")?.as_str()?.into(),
        median: read(estimates)?
            .pointer("/median/point_estimate")?
            .as_f64()?,
        elements: about
            .pointer("/throughput/Elements")
            .and_then(Value::as_u64),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Class;

    fn result(mode: Mode, exact: u64) -> RunResult {
        let stage = StageCount {
            compared: 4,
            exact,
            not_run: 2,
        };
        RunResult {
            scene: "area/one".into(),
            area: "area".into(),
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

    #[test]
    fn the_page() {
        let measured = Measurements {
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
            retail: vec![result(Mode::Free, 2)],
            wall: Duration::from_millis(1500),
            threads: 2,
            benches: vec![Bench {
                name: "group/one".into(),
                median: 1500.0,
                elements: Some(3),
            }],
        };
        insta::assert_snapshot!(page(&measured));
    }

    #[test]
    fn no_benchmarks_are_no_error() {
        assert_eq!(benches_in(Path::new("/no/such/folder")), []);
    }
}
