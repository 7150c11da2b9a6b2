//! Which commit changed what a trace says, and where in the trace the change begins.
//!
//! A *build* is a program that runs scenes as `ac-replay run` does. [`verdict`] asks a build about a trace: where do the states it
//! produces part from the expectations in the trace, or, where it has none, from what the good build produced? The comparing is
//! done here and not by the build, so that all builds are judged by the same rules. [`search()`](search::search) looks for the first
//! commit whose verdict is not that of the good commit; [`locate()`](locate::locate) compares the traces of the two builds beside
//! each other, stage by stage, and says where they part.
//!
//! Commits come from git ([`git`]), builds from a shell command in a worktree of its own ([`build`]). Everything that was found out
//! is in a file ([`state`]): a search that was interrupted goes on where it was.

pub mod build;
pub mod git;
pub mod locate;
pub mod report;
pub mod search;
pub mod state;
pub mod verdict;

use std::path::{Path, PathBuf};

use ac_golden_traces::GoldenError;

/// Why a bisection cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum BisectError {
    /// A trace or scene cannot be read.
    #[error(transparent)]
    Golden(#[from] GoldenError),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        #[source]
        source: std::io::Error,
    },
    /// A program cannot be started.
    #[error("`{program}` cannot be started: {source}")]
    Start {
        /// The program.
        program: String,
        /// What the system said.
        #[source]
        source: std::io::Error,
    },
    /// Git refused.
    #[error("git {command}: {said}")]
    Git {
        /// Its arguments.
        command: String,
        /// What it said.
        said: String,
    },
    /// One of the ends cannot be built.
    #[error("{what} cannot be built; see {}", log.display())]
    Build {
        /// Which commit.
        what: String,
        /// What the build said.
        log: PathBuf,
    },
    /// There is nothing to look for.
    #[error("{0}")]
    Question(String),
}

impl BisectError {
    fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Io {
            path: path.into(),
            source,
        }
    }
}

#[cfg(test)]
mod tests;
