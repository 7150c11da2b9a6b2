//! What `run` and `merge` share: where a judged run goes, and the exit code.

use std::{fs, io::Write, path::PathBuf, process::ExitCode};

use miette::{IntoDiagnostic, WrapErr};

use super::{COULD_NOT_RUN, DIFFERS, Format, emit};
use crate::{
    gate::{Document, output},
    run::baseline::Baseline,
};

/// The exit codes, for `--help`.
pub(super) const EXIT_CODES: &str = "Exit codes:\n  \
    0  nothing is new, changed or flaky\n  \
    1  something is new, changed or flaky\n  \
    2  something could not run; results of the rest are still written";

/// Outputs of `run` and `merge`.
#[derive(clap::Args)]
pub struct Outputs {
    /// Write JUnit XML to this file.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write GitHub annotations to standard error.
    #[arg(long)]
    annotations: bool,
    /// Append a Markdown summary to this file. Default: $GITHUB_STEP_SUMMARY, if it is set.
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
}

impl Outputs {
    /// Writes a run wherever it was asked for and answers the exit code.
    ///
    /// # Errors
    /// When something cannot be written.
    pub(super) fn write(
        &self,
        document: &Document,
        baseline: &Baseline,
        format: Format,
    ) -> miette::Result<ExitCode> {
        match format {
            Format::Human => emit(&output::human(document, baseline))?,
            Format::Json => emit(&document.json(baseline).into_diagnostic()?)?,
        }
        if let Some(path) = &self.junit {
            let text = output::junit(document, baseline).into_diagnostic()?;
            fs::write(path, text)
                .into_diagnostic()
                .wrap_err_with(|| format!("cannot write {}", path.display()))?;
        }
        let from_github = || {
            let path = std::env::var_os("GITHUB_STEP_SUMMARY")?;
            (!path.is_empty()).then(|| path.into())
        };
        if let Some(path) = self.summary.clone().or_else(from_github) {
            let mut file = fs::OpenOptions::new().create(true).append(true).open(&path);
            file.as_mut()
                .map_err(|error| std::io::Error::new(error.kind(), error.to_string()))
                .and_then(|file| file.write_all(output::summary(document, baseline).as_bytes()))
                .into_diagnostic()
                .wrap_err_with(|| format!("cannot write {}", path.display()))?;
        }
        if self.annotations {
            eprint!("{}", output::annotations(document, baseline));
        }
        for error in &document.errors {
            eprintln!("could not run: {error}");
        }
        Ok(if !document.errors.is_empty() {
            ExitCode::from(COULD_NOT_RUN)
        } else if document.fails(baseline) {
            ExitCode::from(DIFFERS)
        } else {
            ExitCode::SUCCESS
        })
    }
}
