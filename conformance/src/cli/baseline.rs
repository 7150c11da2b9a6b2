//! `ac-conform baseline`.

use std::{fs, process::ExitCode};

use ac_golden_traces::corpus;
use ac_replayer::Simulator;
use miette::{IntoDiagnostic, WrapErr, miette};

use super::{
    DIFFERS, emit,
    run::{bundled_baseline, progress},
};
use crate::run::{
    self, Mode, Options, SELF,
    baseline::{Baseline, Known},
    cases,
};

/// Arguments of `ac-conform baseline`.
#[derive(clap::Args)]
pub struct Args {
    /// Why the new divergences are accepted; goes into each new entry.
    #[arg(long)]
    reason: Option<String>,
    /// Write the baseline. Without it, what would change is shown only.
    #[arg(long)]
    yes: bool,
}

/// The comment in front of the entries.
const HEAD: &str = "# Divergences that are known and accepted, each with its reason. `ac-conform run` fails on any other.\n\
    # `ac-conform baseline` shows and takes in changes. `frame` and `field` say where the first difference may be: later frames may\n\
    # differ anywhere, earlier ones may not. Without `guid` an entry is for every entity of the scene.\n\n";

/// Shows what changes in the baseline, and writes it if told so; exit code 1 when changes are shown and not written.
///
/// # Errors
/// When the traces cannot be run, a reason is missing, or the baseline cannot be read or written.
pub fn run(args: &Args, simulator: &dyn Simulator) -> miette::Result<ExitCode> {
    let path = bundled_baseline();
    let before = if path.is_file() {
        Baseline::open(&path).into_diagnostic()?
    } else {
        Baseline::default()
    };
    let cases = cases::find(&[corpus::bundled().join("traces")], None, None).into_diagnostic()?;
    let options = Options {
        modes: Mode::ALL.into(),
        oracle: None,
        profile: None,
        series: false,
    };
    let bar = progress(cases.len() as u64);
    let mut outcome = run::run(simulator, &cases, &options, || bar.inc(1));
    bar.finish_and_clear();
    // What the library expects of itself is blessed, not excused.
    outcome.results.retain(|result| result.oracle != SELF);
    if let Some(error) = outcome.errors.first() {
        return Err(miette!("{error}"));
    }
    let after = before.blessed(&outcome.results, args.reason.as_deref().unwrap_or("?"));
    let gone = before
        .known
        .iter()
        .filter(|known| !after.known.contains(known));
    let new: Vec<&Known> = after
        .known
        .iter()
        .filter(|known| !before.known.contains(known))
        .collect();
    let mut text: String = gone.map(|known| line('-', known)).collect();
    text.extend(new.iter().map(|known| line('+', known)));
    emit(&text)?;
    if text.is_empty() {
        return emit("the baseline is as it should be\n").map(|()| ExitCode::SUCCESS);
    }
    if !args.yes {
        return emit("nothing written; --yes writes it\n").map(|()| ExitCode::from(DIFFERS));
    }
    if args.reason.is_none() && !new.is_empty() {
        return Err(miette!(
            help = "say why they are accepted with --reason",
            "{} new divergences have no reason",
            new.len()
        ));
    }
    let toml = toml::to_string(&after).into_diagnostic()?;
    let context = || format!("cannot write {}", path.display());
    fs::write(&path, format!("{HEAD}{toml}"))
        .into_diagnostic()
        .wrap_err_with(context)?;
    Ok(ExitCode::SUCCESS)
}

fn line(sign: char, known: &Known) -> String {
    let guid = known.guid.as_deref().unwrap_or("every entity");
    format!(
        "{sign} {} {} {} {guid}: frame {} {} ({})\n",
        known.scene, known.oracle, known.mode, known.frame, known.field, known.reason
    )
}
