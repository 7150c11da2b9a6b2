//! `ac-conform sensitivity`.

use std::{path::PathBuf, process::ExitCode};

use ac_golden_traces::corpus;
use ac_replayer::Simulator;
use miette::{IntoDiagnostic, miette};

use super::{COULD_NOT_RUN, DIFFERS, Format, emit, run::progress};
use crate::run::{
    cases,
    sensitivity::{self, human, json},
};

/// Arguments of `ac-conform sensitivity`.
#[derive(clap::Args)]
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
    /// Start from the profile of this oracle only.
    #[arg(long, default_value = "all")]
    oracle: String,
    /// How to write the results.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Measures and prints; exit code 1 when a scene is not met under its oracle's own profile, so that nothing can be told about
/// it.
///
/// # Errors
/// When nothing can be run.
pub fn run(args: &Args, simulator: &dyn Simulator) -> miette::Result<ExitCode> {
    let bundled = [corpus::bundled().join("traces")];
    let paths = if args.paths.is_empty() {
        &bundled[..]
    } else {
        &args.paths
    };
    let cases = cases::find(paths, args.expect.as_deref(), None).into_diagnostic()?;
    let oracle = (args.oracle != "all").then_some(args.oracle.as_str());
    let bar = progress(cases.len() as u64);
    let outcome = sensitivity::run(simulator, &cases, oracle, || bar.inc(1));
    bar.finish_and_clear();
    for error in &outcome.errors {
        eprintln!("could not run: {error}");
    }
    if outcome.scenes.is_empty() && outcome.errors.is_empty() {
        return Err(miette!(
            help =
                "traces end in .mcap, scenes in .scene.json; name other paths or another --oracle",
            "there are no expectations in the {} cases found",
            cases.len()
        ));
    }
    match args.format {
        Format::Human => emit(&human(&outcome.scenes))?,
        Format::Json => emit(&json(&outcome.scenes).into_diagnostic()?)?,
    }
    Ok(if !outcome.errors.is_empty() {
        ExitCode::from(COULD_NOT_RUN)
    } else if outcome.scenes.iter().any(|scene| scene.unmet.is_some()) {
        ExitCode::from(DIFFERS)
    } else {
        ExitCode::SUCCESS
    })
}
