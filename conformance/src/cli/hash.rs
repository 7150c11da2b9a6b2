//! `ac-conform hash`.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use ac_client::profile::Profile;
use ac_golden_traces::corpus;
use ac_replayer::Simulator;
use miette::{IntoDiagnostic, WrapErr, miette};

use super::{COULD_NOT_RUN, DIFFERS, emit, run::progress};
use crate::{
    hash::{self, HashDifference, HashFile, SceneHash},
    run::{PROFILES, cases},
};

/// Arguments of `ac-conform hash`.
#[derive(clap::Args)]
pub struct Args {
    /// Traces (`*.mcap`), scenes (`*.scene.json`), or folders of them. Default: the bundled traces.
    pub(super) paths: Vec<PathBuf>,
    /// Folder of the worlds. Default: `worlds` in a given folder, else the bundled worlds.
    #[arg(long)]
    pub(super) worlds: Option<PathBuf>,
    /// Behaviour to run under.
    #[arg(long, default_value = "retail")]
    profile: String,
    /// Threads; 0: one per processor.
    #[arg(long, default_value_t = 0)]
    jobs: usize,
    /// Print the hash of every frame too.
    #[arg(long)]
    frames: bool,
    /// Compare with a file that this command printed, instead of printing.
    #[arg(long, value_name = "FILE")]
    check: Option<PathBuf>,
}

/// Prints the state hash of every scene, or compares with a file; exit code 1 when one differs.
///
/// # Errors
/// When nothing can be run or the file cannot be read.
pub fn run(args: &Args, simulator: &dyn Simulator) -> miette::Result<ExitCode> {
    let profile = Profile::named(&args.profile).ok_or_else(|| {
        miette!(
            help = format!("profiles: {}", PROFILES.join(", ")),
            "no profile is called `{}`",
            args.profile
        )
    })?;
    let file = args.check.as_deref().map(|path| open(path, &args.profile));
    let file = file.transpose()?;
    let bundled = [corpus::bundled().join("traces")];
    let paths = if args.paths.is_empty() {
        &bundled[..]
    } else {
        &args.paths
    };
    let cases = cases::find(paths, None, None).into_diagnostic()?;
    if cases.is_empty() {
        return Err(miette!(
            help = "traces end in .mcap, scenes in .scene.json",
            "nothing to run"
        ));
    }
    let bar = progress(cases.len() as u64);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.jobs)
        .build()
        .into_diagnostic()?;
    let (hashes, errors) =
        pool.install(|| hash::hash_all(simulator, &cases, &profile, || bar.inc(1)));
    bar.finish_and_clear();
    let same = match file {
        Some(file) => compare(&file, &hashes, args.paths.is_empty())?,
        None => {
            emit(&hash::text(&args.profile, &hashes, args.frames))?;
            true
        }
    };
    for error in &errors {
        eprintln!("could not run: {error}");
    }
    Ok(if !errors.is_empty() {
        ExitCode::from(COULD_NOT_RUN)
    } else if same {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(DIFFERS)
    })
}

fn open(path: &Path, profile: &str) -> miette::Result<HashFile> {
    let text = fs::read_to_string(path)
        .into_diagnostic()
        .wrap_err_with(|| format!("{}: cannot be read", path.display()))?;
    let file = HashFile::parse(&text).map_err(|error| miette!("{}, {error}", path.display()))?;
    if file.profile != profile {
        return Err(miette!(
            help = format!("name it with --profile {}", file.profile),
            "{}: the hashes are of profile `{}`, not `{profile}`",
            path.display(),
            file.profile
        ));
    }
    Ok(file)
}

/// Prints the differences. Scenes that were not run count when `all` were asked for.
fn compare(file: &HashFile, hashes: &[SceneHash], all: bool) -> miette::Result<bool> {
    let mut differences = hash::check(file, hashes);
    if !all {
        differences.retain(|difference| !matches!(difference, HashDifference::Missing(_)));
    }
    let mut text: String = differences
        .iter()
        .map(|difference| format!("{difference}\n"))
        .collect();
    text += &format!(
        "{} scenes run, {} differ\n",
        hashes.len(),
        differences.len()
    );
    emit(&text)?;
    Ok(differences.is_empty())
}
