//! `ac-conform merge`.

use std::{fs, path::PathBuf, process::ExitCode};

use miette::{IntoDiagnostic, WrapErr, miette};

use super::{Format, gate, run::bundled_baseline};
use crate::{gate::Document, run::baseline::Baseline};

/// Arguments of `ac-conform merge`.
#[derive(clap::Args)]
#[command(after_help = gate::EXIT_CODES)]
pub struct Args {
    /// What `ac-conform run --format json` wrote, one file per shard.
    #[arg(required = true)]
    results: Vec<PathBuf>,
    /// File of known divergences. Default: `conformance/baseline.toml`, if it is there.
    #[arg(long)]
    baseline: Option<PathBuf>,
    /// How to write the results.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    outputs: gate::Outputs,
}

/// Puts the results of all shards together and judges them as one run.
///
/// # Errors
/// When a file cannot be read, or they are not the parts of one run.
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let bundled = Some(bundled_baseline()).filter(|path| path.is_file());
    let baseline = match args.baseline.clone().or(bundled) {
        Some(path) => Baseline::open(&path).into_diagnostic()?,
        None => Baseline::default(),
    };
    let mut parts = Vec::new();
    for path in &args.results {
        let name = path.display().to_string();
        let text = fs::read_to_string(path)
            .into_diagnostic()
            .wrap_err_with(|| format!("{name}: cannot be read"))?;
        let part: Document = serde_json::from_str(&text)
            .map_err(|error| miette!("{name}: is no result of `run --format json`: {error}"))?;
        parts.push((name, part));
    }
    let document = Document::merge(parts).map_err(|error| {
        miette!(
            help = "name the result of every shard of one run, each once",
            "{error}"
        )
    })?;
    args.outputs.write(&document, &baseline, args.format)
}
