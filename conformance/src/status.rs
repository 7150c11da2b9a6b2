//! `docs/status.md`: what matches how well, from measurements only.

mod numerics;
mod plans;
mod recorder;
mod sensitivity;
mod speed;
mod tools;

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    time::Duration,
};

pub use numerics::{Numerics, numerics_in};
pub use plans::{PlanCost, plan_costs};
pub use recorder::RecorderNumbers;
pub use speed::{Bench, Cost, benches_in, costs, machine};
pub use tools::{Tools, tools_in};

use crate::{
    run::{Mode, RunResult, StageCount, sensitivity::SceneSensitivity},
    vectors::FnResult,
};

/// Everything that the page shows.
#[derive(Clone, Debug, Default)]
pub struct Measurements {
    /// What it was measured on; see [`machine`].
    pub machine: String,
    /// Vectors, per function.
    pub vectors: Vec<FnResult>,
    /// All modes, each oracle under its own profile.
    pub runs: Vec<RunResult>,
    /// Names of the scenes whose script asks for no motion.
    pub motionless: BTreeSet<String>,
    /// Free runs under the profile `retail`.
    pub retail: Vec<RunResult>,
    /// What scenes are sensitive to.
    pub sensitivity: Vec<SceneSensitivity>,
    /// Time that `vectors` took, from start to end.
    pub vectors_wall: Duration,
    /// Time that `runs` took, from start to end.
    pub wall: Duration,
    /// Time that `sensitivity` took, from start to end.
    pub sensitivity_wall: Duration,
    /// Threads that it ran on.
    pub threads: usize,
    /// Costs of a tick.
    pub costs: Vec<Cost>,
    /// Stability and precision.
    pub numerics: Numerics,
    /// What plans save.
    pub plans: Vec<PlanCost>,
    /// What relaying and killing the recorder costs.
    pub recorder: RecorderNumbers,
    /// Benchmarks that have been run.
    pub benches: Vec<Bench>,
    /// Bisections and shrinkings that were tried.
    pub tools: Tools,
}

/// The page.
pub fn page(measured: &Measurements) -> String {
    let build = if cfg!(debug_assertions) {
        "debug"
    } else {
        "release"
    };
    let mut text = format!(
        "# Status\n\nWritten by `cargo run --release -p ac-conformance -- status` ({build} build; {}) from measurements, not by hand. *Exact* means the same \
         bits in every recorded number, sign of zero included. `exact/total`, in bold where something is missing.\n\n",
        measured.machine
    );
    summary(&mut text, measured);
    vectors(&mut text, &measured.vectors);
    scenes(&mut text, measured);
    stages(&mut text, &measured.runs);
    retail(&mut text, &measured.retail);
    sensitivity::section(&mut text, &measured.sensitivity);
    numerics::section(&mut text, &measured.numerics);
    plans::section(&mut text, &measured.plans);
    speed::section(&mut text, &measured.benches, &measured.costs);
    tools::section(&mut text, &measured.tools);
    recorder::section(&mut text, &measured.recorder);
    text
}

/// `exact/total`, in bold when something is missing.
fn share(exact: u64, total: u64) -> String {
    if exact == total {
        format!("{exact}/{total}")
    } else {
        format!("**{exact}**/{total}")
    }
}

fn summary(text: &mut String, measured: &Measurements) {
    let oracles = columns(measured.runs.iter().map(|result| result.oracle.as_str()));
    heading(text, "exact", &oracles);
    row(
        text,
        "vectors",
        oracles.iter().map(|oracle| {
            let of = || measured.vectors.iter().filter(|r| r.oracle == *oracle);
            share(
                of().map(|r| r.exact as u64).sum(),
                of().map(|r| r.total as u64).sum(),
            )
        }),
    );
    let lines = [
        ("scenes (frames), free", Mode::Free),
        ("scenes (frames), resync", Mode::Resync),
        ("scenes (records that can run alone), stage", Mode::Stage),
    ];
    for (name, mode) in lines {
        row(
            text,
            name,
            cells(&measured.runs, &oracles, |r| r.mode == mode),
        );
    }
    row(
        text,
        "scenes (frames), free, under `retail`",
        cells(&measured.retail, &oracles, |_| true),
    );
    let _ = writeln!(
        text,
        "\nTime on {} threads: {:.2} s for every bundled scene with all oracles in all modes, {:.2} s for all vectors, {:.2} s for the sensitivities.\n",
        measured.threads,
        measured.wall.as_secs_f64(),
        measured.vectors_wall.as_secs_f64(),
        measured.sensitivity_wall.as_secs_f64()
    );
}

/// One [`cell`] per oracle of the results that `wanted` names.
fn cells(
    results: &[RunResult],
    oracles: &[&str],
    wanted: impl Fn(&RunResult) -> bool,
) -> Vec<String> {
    oracles
        .iter()
        .map(|oracle| {
            cell(
                results
                    .iter()
                    .filter(|result| result.oracle == *oracle && wanted(result)),
            )
        })
        .collect()
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

fn scenes(text: &mut String, measured: &Measurements) {
    text.push_str(
        "## Scenes\n\nExact scenes (exact frames) per area, each oracle under its own profile.\n\n",
    );
    let frames: Vec<&RunResult> = measured
        .runs
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
    let mut line = |name: &str, wanted: &dyn Fn(&RunResult) -> bool| {
        let cells = columns_.iter().map(|(oracle, mode)| {
            cell(
                frames
                    .iter()
                    .copied()
                    .filter(|r| r.oracle == *oracle && r.mode == *mode && wanted(r)),
            )
        });
        row(text, name, cells);
    };
    let areas = columns(frames.iter().map(|result| result.area.as_str()));
    for area in areas {
        line(area, &|result| result.area == area);
    }
    line("**all**", &|_| true);
    let still = |result: &RunResult| measured.motionless.contains(&result.scene);
    for area in ["terrain", "extreme"] {
        let name = format!("*{area}, no motion asked for*");
        line(&name, &|result| result.area == area && still(result));
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
    if scenes.is_empty() {
        return "–".into();
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
                match count.compared {
                    0 => "–".into(),
                    compared => share(count.exact, compared),
                },
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

#[cfg(test)]
mod tests;
