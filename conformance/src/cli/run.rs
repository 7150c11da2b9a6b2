//! `ac-conform run`.

use std::{
    io::IsTerminal,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::atomic::{AtomicUsize, Ordering},
    time::Duration,
};

use ac_client::profile::Profile;
use ac_golden_traces::{GoldenError, corpus};
use ac_replayer::Simulator;
use ac_replayer::client::{ClientSimulator, PlanChoice};
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, miette};

use super::{Format, gate};
use crate::{
    compare::policy::Policy,
    gate::{Document, Shard},
    report_html,
    run::{Case, Mode, Options, PROFILES, RunResult, baseline::Baseline, cases},
};

/// Arguments of `ac-conform run`.
#[derive(clap::Args)]
#[command(after_help = gate::EXIT_CODES)]
pub struct Args {
    /// Traces (`*.mcap`), scenes (`*.scene.json`, with their expectations beside them or under --expect), or folders of them.
    /// Default: the bundled traces.
    pub(super) paths: Vec<PathBuf>,
    /// Folder of the worlds. Default: `worlds` in a given folder, else the bundled worlds.
    #[arg(long)]
    pub(super) worlds: Option<PathBuf>,
    /// Folder of expectations for scene files: `ORACLE/AREA/NAME.expect.jsonl` (`.gz`).
    #[arg(long)]
    expect: Option<PathBuf>,
    /// Folder of stage checkpoints for scene files: `ORACLE/AREA/NAME.stages.jsonl` (`.gz`).
    #[arg(long)]
    stages: Option<PathBuf>,
    /// Compare with this oracle only.
    #[arg(long, default_value = "all")]
    oracle: String,
    /// free: never corrected; resync: every frame from the expected state before; stage: each recorded stage alone.
    #[arg(long, default_value = "all", value_parser = ["free", "resync", "stage", "all"])]
    mode: String,
    /// Behaviour to run under; auto: that of the oracle.
    #[arg(long, default_value = "auto")]
    profile: String,
    /// Threads; 0: one per processor.
    #[arg(long, default_value_t = 0)]
    jobs: usize,
    /// How to write the results.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// File of known divergences. Default for the bundled traces: `conformance/baseline.toml`.
    #[arg(long)]
    baseline: Option<PathBuf>,
    /// Work that is done: `full` (everything a client does), `auto` (what can change the states), or a file of `ac-replay plan`. Results are
    /// the same. Default: records are opened when they are first asked for, every entity is advanced in every frame.
    #[arg(long, value_name = "full|auto|FILE")]
    plan: Option<String>,
    /// Carry a plan file out even if it leaves out what may change results.
    #[arg(long, requires = "plan")]
    force_plan: bool,
    /// Write a report for a browser into this folder: DIR/index.html.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// File that says what may differ and what is not run (docs/ci.md). Default: nothing may differ.
    #[arg(long, value_name = "FILE")]
    policy: Option<PathBuf>,
    /// Run one part of the scenes: `i/n` deals them out, `hash:i/n` goes by their names; i counts from 1.
    #[arg(long)]
    shard: Option<Shard>,
    #[command(flatten)]
    outputs: gate::Outputs,
}

impl Args {
    /// The client library on the worlds and under the plan that the arguments name.
    pub(super) fn simulator(&self) -> miette::Result<ClientSimulator> {
        let plan = PlanChoice::parse(self.plan.as_deref(), self.force_plan).into_diagnostic()?;
        Ok(super::simulator(self.worlds.as_deref(), &self.paths).with_plan(plan))
    }
}

/// Runs and compares; exit code 1 when something is new, changed or flaky.
///
/// # Errors
/// When nothing can be run.
pub fn run(args: &Args, simulator: &dyn Simulator) -> miette::Result<ExitCode> {
    let options = options(args)?;
    let baseline = baseline(args)?;
    let policy = match &args.policy {
        Some(path) => Policy::open(path).into_diagnostic()?,
        None => Policy::default(),
    };
    let cases = find_cases(args)?;
    let bar = progress(cases.len() as u64);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.jobs)
        .build()
        .into_diagnostic()?;
    let live = Live::new(&bar, &baseline);
    let document = pool.install(|| {
        let done = |case: &Case, results: &[RunResult]| live.done(case, results);
        Document::run(simulator, &cases, &options, &policy, args.shard, done)
    });
    bar.finish_and_clear();
    // A small shard may be empty; a run that compares nothing is a mistake.
    let nothing = document.results.is_empty()
        && document.errors.is_empty()
        && document.skipped.is_empty()
        && args.shard.is_none();
    if nothing {
        return Err(miette!(
            help = "name other paths, another --oracle or another --mode",
            "there is nothing to compare in the {} cases found",
            cases.len()
        ));
    }
    if let Some(folder) = &args.report {
        let file = report_html::write(folder, &document, &policy, &baseline);
        eprintln!("report: {}", file.into_diagnostic()?.display());
    }
    args.outputs.write(&document, &baseline, args.format)
}

/// What is seen while scenes run: how far it is, and the first divergences that the baseline does not know.
struct Live<'a> {
    bar: &'a ProgressBar,
    baseline: &'a Baseline,
    failures: AtomicUsize,
}

impl<'a> Live<'a> {
    /// Divergences that are shown at once; all are in the result.
    const SHOWN: usize = 5;

    fn new(bar: &'a ProgressBar, baseline: &'a Baseline) -> Self {
        Self {
            bar,
            baseline,
            failures: AtomicUsize::new(0),
        }
    }

    fn done(&self, case: &Case, results: &[RunResult]) {
        for result in results {
            let Some(first) = &result.first_divergence else {
                continue;
            };
            if self.baseline.accepts(result).is_some() {
                continue;
            }
            let before = self.failures.fetch_add(1, Ordering::Relaxed);
            if before < Self::SHOWN {
                self.bar.println(format!(
                    "{} {} {} {}: frame {} {}",
                    result.scene,
                    result.oracle,
                    result.mode.name(),
                    result.guid,
                    first.frame,
                    first.field
                ));
            } else if before == Self::SHOWN {
                self.bar.println("more divergences: see below");
            }
        }
        let scene = results.first().map(|result| result.scene.clone());
        let name = scene.unwrap_or_else(|| case.path().display().to_string());
        let message = match self.failures.load(Ordering::Relaxed) {
            0 => name,
            failures => format!("{name} ({failures} diverge)"),
        };
        self.bar.set_message(message);
        self.bar.inc(1);
    }
}

fn options(args: &Args) -> miette::Result<Options> {
    let profile = (args.profile != "auto").then(|| args.profile.clone());
    if let Some(name) = profile
        .as_deref()
        .filter(|name| Profile::named(name).is_none())
    {
        return Err(miette!(
            help = format!("profiles: auto, {}", PROFILES.join(", ")),
            "no profile is called `{name}`"
        ));
    }
    let modes = Mode::ALL
        .into_iter()
        .filter(|mode| args.mode == "all" || mode.name() == args.mode)
        .collect();
    Ok(Options {
        modes,
        oracle: (args.oracle != "all").then(|| args.oracle.clone()),
        profile,
        series: args.report.is_some(),
    })
}

fn find_cases(args: &Args) -> miette::Result<Vec<Case>> {
    let (expect, stages) = (args.expect.as_deref(), args.stages.as_deref());
    let cases = cases::find_or_bundled(&args.paths, expect, stages).map_err(no_cases)?;
    if cases.is_empty() {
        let paths: Vec<_> = args
            .paths
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        return Err(miette!(
            help = "traces end in .mcap, scenes in .scene.json",
            "nothing to run in {}",
            paths.join(", ")
        ));
    }
    Ok(cases)
}

/// What to do about a path at which there is nothing.
fn no_cases(error: GoldenError) -> miette::Report {
    match &error {
        GoldenError::Io { path, source } if source.kind() == std::io::ErrorKind::NotFound => {
            let advice = advice_for(path);
            miette!(
                help = advice,
                "{}: there is no such file or folder",
                path.display()
            )
        }
        _ => miette::Report::msg(error.to_string()),
    }
}

fn advice_for(path: &Path) -> String {
    let name = path.to_string_lossy();
    let bundled = corpus::bundled().join("traces");
    let near = bundled.join(format!("{}.mcap", name.trim_end_matches(".mcap")));
    if path.is_relative() && near.is_file() {
        return format!("the bundled scene of this name is {}", near.display());
    }
    format!(
        "traces end in .mcap, scenes in .scene.json; without a path the bundled traces under {} are run",
        bundled.display()
    )
}

/// The named baseline, or that of the bundled traces when those are run.
fn baseline(args: &Args) -> miette::Result<Baseline> {
    if let Some(path) = &args.baseline {
        return Baseline::open(path).into_diagnostic();
    }
    let bundled = bundled_baseline();
    if args.paths.is_empty() && bundled.is_file() {
        return Baseline::open(&bundled).into_diagnostic();
    }
    Ok(Baseline::default())
}

/// The baseline of the bundled traces: in the source tree that this program was built from, else under the current folder.
pub(super) fn bundled_baseline() -> PathBuf {
    let built = Path::new(env!("CARGO_MANIFEST_DIR"));
    if built.is_dir() {
        built.join("baseline.toml")
    } else {
        "conformance/baseline.toml".into()
    }
}

/// A bar on standard error, if someone can see it.
pub(super) fn progress(length: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} scenes, {elapsed} {msg}")
    {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
