//! `ac-conform run`.

use std::{
    io::IsTerminal,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Duration,
};

use ac_client::profile::Profile;
use ac_golden_traces::corpus;
use ac_replayer::Simulator;
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, miette};

use super::{COULD_NOT_RUN, DIFFERS, Format, emit};
use crate::run::{
    self, Mode, Options, PROFILES,
    baseline::Baseline,
    cases,
    report::{Totals, human, json},
};

/// Arguments of `ac-conform run`.
#[derive(clap::Args)]
pub struct Args {
    /// Traces (`*.mcap`), scenes (`*.scene.json`, with their expectations beside them or under --expect), or folders of them.
    /// Default: the bundled traces.
    paths: Vec<PathBuf>,
    /// Folder of the worlds. Default: the bundled worlds.
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
}

/// Runs and compares; exit code 1 when something diverges that the baseline does not know.
///
/// # Errors
/// When nothing can be run.
pub fn run(args: &Args, simulator: &dyn Simulator) -> miette::Result<ExitCode> {
    let options = options(args)?;
    let baseline = baseline(args)?;
    let cases = find_cases(args)?;
    let bar = progress(cases.len() as u64);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.jobs)
        .build()
        .into_diagnostic()?;
    let outcome = pool.install(|| run::run(simulator, &cases, &options, || bar.inc(1)));
    bar.finish_and_clear();
    let totals = Totals::of(&outcome.results, &baseline);
    match args.format {
        Format::Human => emit(&human(&outcome.results, &totals, &baseline))?,
        Format::Json => emit(&json(&outcome.results, &totals).into_diagnostic()?)?,
    }
    for error in &outcome.errors {
        eprintln!("could not run: {error}");
    }
    Ok(if !outcome.errors.is_empty() {
        ExitCode::from(COULD_NOT_RUN)
    } else if outcome.results.is_empty() {
        return Err(miette!(
            help = "name other paths, another --oracle or another --mode",
            "there is nothing to compare in the {} cases found",
            cases.len()
        ));
    } else if totals.new_divergences > 0 {
        ExitCode::from(DIFFERS)
    } else {
        ExitCode::SUCCESS
    })
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
    })
}

fn find_cases(args: &Args) -> miette::Result<Vec<run::Case>> {
    let bundled = [corpus::bundled().join("traces")];
    let paths = if args.paths.is_empty() {
        &bundled[..]
    } else {
        &args.paths
    };
    let cases =
        cases::find(paths, args.expect.as_deref(), args.stages.as_deref()).into_diagnostic()?;
    if cases.is_empty() {
        let paths: Vec<_> = paths
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
