//! `ac-conform vectors`.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use miette::{IntoDiagnostic, WrapErr, miette};
use rayon::prelude::*;

use super::{DIFFERS, Format, emit};
use crate::vectors::{FnResult, human_table, run_file};

/// Arguments of `ac-conform vectors`.
#[derive(clap::Args)]
pub struct Args {
    /// Vector files (`*.jsonl`, `*.jsonl.gz`) or folders of them.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Profile to run under; `auto` takes that of the oracle that a file names.
    #[arg(long, default_value = "auto")]
    profile: String,
    /// How to write the results.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the files; exit code 1 when a vector is not met.
///
/// # Errors
/// When a file cannot be found or read.
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let mut files = Vec::new();
    for path in &args.files {
        collect(path, &mut files)?;
    }
    if files.is_empty() {
        return Err(miette!(
            help = "vector files end in .jsonl or .jsonl.gz",
            "no vector files in the given folders"
        ));
    }
    let profile = (args.profile != "auto").then_some(args.profile.as_str());
    let results: Vec<Vec<FnResult>> = files
        .par_iter()
        .map(|file| run_file(file, profile))
        .collect::<Result<_, _>>()
        .into_diagnostic()?;
    let results = results.concat();
    match args.format {
        Format::Human => emit(&human_table(&results))?,
        Format::Json => {
            let json = serde_json::json!({"results": results});
            emit(&(serde_json::to_string_pretty(&json).into_diagnostic()? + "\n"))?;
        }
    }
    Ok(if results.iter().all(FnResult::all_exact) {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(DIFFERS)
    })
}

/// The vector files at or under a path, folders in name order.
fn collect(path: &Path, files: &mut Vec<PathBuf>) -> miette::Result<()> {
    let context = || format!("cannot look at {}", path.display());
    if !path
        .metadata()
        .into_diagnostic()
        .wrap_err_with(context)?
        .is_dir()
    {
        files.push(path.into());
        return Ok(());
    }
    let mut entries: Vec<PathBuf> = std::fs::read_dir(path)
        .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect())
        .into_diagnostic()
        .wrap_err_with(context)?;
    entries.sort();
    for entry in entries {
        let name = entry
            .file_name()
            .and_then(|name| name.to_str())
            .unwrap_or("");
        if entry.is_dir() || name.ends_with(".jsonl") || name.ends_with(".jsonl.gz") {
            collect(&entry, files)?;
        }
    }
    Ok(())
}
