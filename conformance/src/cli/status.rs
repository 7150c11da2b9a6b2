//! `ac-conform status`.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Instant,
};

use ac_golden_traces::{Scene, corpus, scene::Action, trace::TraceReader};
use ac_replayer::Simulator;
use miette::{IntoDiagnostic, WrapErr, miette};
use rayon::prelude::*;

use crate::{
    run::{self, Case, Mode, Options, cases, sensitivity},
    status::{
        Cost, Measurements, PlanCost, RecorderNumbers, benches_in, costs, machine, numerics_in,
        page, plan_costs, tools_in,
    },
    vectors::{FnResult, run_file},
};

/// Arguments of `ac-conform status`.
#[derive(clap::Args)]
pub struct Args {
    /// The page to write.
    #[arg(short, long, default_value = "docs/status.md")]
    output: PathBuf,
    /// Build folder in which `cargo bench` left its results.
    #[arg(long, default_value = "target")]
    target: PathBuf,
    /// What the example `tick_costs` of the client library printed.
    #[arg(long, default_value = "target/tick_costs.jsonl")]
    costs: PathBuf,
    /// What the example `plan_costs` of the replayer printed.
    #[arg(long, default_value = "target/plan-costs.jsonl")]
    plans: PathBuf,
}

/// Measures everything that is bundled and writes the page.
///
/// # Errors
/// When something that is bundled cannot be run.
pub fn run(args: &Args, simulator: &dyn Simulator) -> miette::Result<ExitCode> {
    let root = corpus::bundled();
    let files = corpus::find(&root.join("vectors"), &[".jsonl", ".jsonl.gz"]).into_diagnostic()?;
    let start = Instant::now();
    let vectors: Vec<Vec<FnResult>> = files
        .par_iter()
        .map(|file| run_file(file, None))
        .collect::<Result<_, _>>()
        .into_diagnostic()?;
    let vectors_wall = start.elapsed();
    let cases = cases::find(&[root.join("traces")], None, None).into_diagnostic()?;
    let all = Options {
        modes: Mode::ALL.into(),
        oracle: None,
        profile: None,
        series: false,
    };
    let free = Options {
        modes: vec![Mode::Free],
        oracle: None,
        profile: Some("retail".into()),
        series: false,
    };
    let start = Instant::now();
    let runs = run::run(simulator, &cases, &all, || ());
    let wall = start.elapsed();
    let retail = run::run(simulator, &cases, &free, || ());
    let start = Instant::now();
    let sensitivity = sensitivity::run(simulator, &cases, None, || ());
    let sensitivity_wall = start.elapsed();
    let errors = [&runs.errors, &retail.errors, &sensitivity.errors];
    if let Some(error) = errors.into_iter().flatten().next() {
        return Err(miette!("{error}"));
    }
    let measured = Measurements {
        machine: machine(),
        vectors: vectors.concat(),
        runs: runs.results,
        motionless: motionless(&cases)?,
        retail: retail.results,
        sensitivity: sensitivity.scenes,
        vectors_wall,
        wall,
        sensitivity_wall,
        threads: rayon::current_num_threads(),
        costs: tick_costs(&args.costs)?,
        numerics: numerics_in(&args.target),
        plans: plan_costs_in(&args.plans)?,
        benches: benches_in(&args.target),
        tools: tools_in(&args.target),
        recorder: RecorderNumbers::in_folder(&args.target).into_diagnostic()?,
    };
    let context = || format!("cannot write {}", args.output.display());
    fs::write(&args.output, page(&measured))
        .into_diagnostic()
        .wrap_err_with(context)?;
    println!("wrote {}", args.output.display());
    Ok(ExitCode::SUCCESS)
}

/// Names of the scenes whose script asks no entity to move, turn or jump by itself.
fn motionless(cases: &[Case]) -> miette::Result<BTreeSet<String>> {
    let mut names = BTreeSet::new();
    for case in cases {
        let scene = match case {
            Case::Trace(path) => TraceReader::open(path).map(|reader| reader.scene().clone()),
            Case::Files { scene, .. } => Scene::open(scene),
        }
        .into_diagnostic()?;
        if !scene
            .script
            .iter()
            .any(|step| asks_for_motion(&step.action))
        {
            names.insert(scene.name);
        }
    }
    Ok(names)
}

fn asks_for_motion(action: &Action) -> bool {
    matches!(
        action,
        Action::DoMotion { .. }
            | Action::DoInterpretedMotion { .. }
            | Action::Jump { .. }
            | Action::MoveToPosition { .. }
            | Action::MoveToObject { .. }
            | Action::TurnToHeading { .. }
            | Action::TurnToObject { .. }
            | Action::StickTo { .. }
            | Action::InterpolateTo { .. }
    )
}

/// What plans save, if it was measured.
fn plan_costs_in(path: &Path) -> miette::Result<Vec<PlanCost>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let text = fs::read(path).into_diagnostic()?;
    plan_costs(&text)
        .into_diagnostic()
        .wrap_err_with(|| format!("{} is not what plan_costs prints", path.display()))
}

/// Costs of a tick, if they were measured.
fn tick_costs(path: &Path) -> miette::Result<Vec<Cost>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let text = fs::read(path).into_diagnostic()?;
    costs(&text)
        .into_diagnostic()
        .wrap_err_with(|| format!("{} is not what tick_costs prints", path.display()))
}
