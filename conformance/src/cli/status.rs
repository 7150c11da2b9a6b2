//! `ac-conform status`.

use std::{fs, path::PathBuf, process::ExitCode, time::Instant};

use ac_golden_traces::corpus;
use ac_replayer::Simulator;
use miette::{IntoDiagnostic, WrapErr, miette};
use rayon::prelude::*;

use crate::{
    run::{self, Mode, Options, cases},
    status::{Measurements, benches_in, page},
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
}

/// Measures everything that is bundled and writes the page.
///
/// # Errors
/// When something that is bundled cannot be run.
pub fn run(args: &Args, simulator: &dyn Simulator) -> miette::Result<ExitCode> {
    let root = corpus::bundled();
    let files = corpus::find(&root.join("vectors"), &[".jsonl", ".jsonl.gz"]).into_diagnostic()?;
    let vectors: Vec<Vec<FnResult>> = files
        .par_iter()
        .map(|file| run_file(file, None))
        .collect::<Result<_, _>>()
        .into_diagnostic()?;
    let cases = cases::find(&[root.join("traces")], None, None).into_diagnostic()?;
    let all = Options {
        modes: Mode::ALL.into(),
        oracle: None,
        profile: None,
    };
    let free = Options {
        modes: vec![Mode::Free],
        oracle: None,
        profile: Some("retail".into()),
    };
    let start = Instant::now();
    let runs = run::run(simulator, &cases, &all, || ());
    let wall = start.elapsed();
    let retail = run::run(simulator, &cases, &free, || ());
    if let Some(error) = runs.errors.iter().chain(&retail.errors).next() {
        return Err(miette!("{error}"));
    }
    let measured = Measurements {
        vectors: vectors.concat(),
        runs: runs.results,
        retail: retail.results,
        wall,
        threads: rayon::current_num_threads(),
        benches: benches_in(&args.target),
    };
    let context = || format!("cannot write {}", args.output.display());
    fs::write(&args.output, page(&measured))
        .into_diagnostic()
        .wrap_err_with(context)?;
    println!("wrote {}", args.output.display());
    Ok(ExitCode::SUCCESS)
}
