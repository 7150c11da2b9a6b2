//! Known divergences: a file that says which are accepted and why, so that only new ones fail a run.
//!
//! A divergence is *known* when an entry names its scene, oracle, mode and (if given) entity, and it does not come earlier than
//! the entry says: in a later frame, or in the same frame and field. An earlier one is new, whatever the file says. Known
//! divergences stay in every report. Entries whose scene ran without a divergence are reported as fixed.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Mode, RunResult};

/// A baseline file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// The entries.
    #[serde(default)]
    pub known: Vec<Known>,
}

/// A known divergence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// Name of the scene.
    pub scene: String,
    /// The oracle.
    pub oracle: String,
    /// The mode.
    pub mode: String,
    /// The entity; absent: every entity of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guid: Option<String>,
    /// Frame of the first divergence.
    pub frame: i32,
    /// Field of the first divergence.
    pub field: String,
    /// Why it is accepted.
    pub reason: String,
}

/// Why a baseline cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    /// Reading failed.
    #[error("{}: cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        source: std::io::Error,
    },
    /// It is no baseline.
    #[error("{}: {reason}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl Baseline {
    /// Reads a baseline file.
    ///
    /// # Errors
    /// When it cannot be read, is no TOML of this form, or names a mode that does not exist.
    pub fn open(path: &Path) -> Result<Self, BaselineError> {
        let text = std::fs::read_to_string(path).map_err(|source| BaselineError::Io {
            path: path.into(),
            source,
        })?;
        let parse = |reason: String| BaselineError::Parse {
            path: path.into(),
            reason,
        };
        let baseline: Self = toml::from_str(&text).map_err(|error| parse(error.to_string()))?;
        for known in &baseline.known {
            if !Mode::ALL.iter().any(|mode| mode.name() == known.mode) {
                return Err(parse(format!(
                    "{}: no mode is called `{}`",
                    known.scene, known.mode
                )));
            }
        }
        Ok(baseline)
    }

    /// The entry that accepts the divergence of a result.
    pub fn accepts(&self, result: &RunResult) -> Option<&Known> {
        let divergence = result.first_divergence.as_ref()?;
        self.known.iter().find(|known| {
            known.names(result)
                && (divergence.frame > known.frame
                    || divergence.frame == known.frame && divergence.field == known.field)
        })
    }

    /// Entries whose every result ran without a divergence.
    pub fn fixed<'a>(&'a self, results: &'a [RunResult]) -> impl Iterator<Item = &'a Known> {
        self.known.iter().filter(|known| {
            let mut named = results
                .iter()
                .filter(|result| known.names(result))
                .peekable();
            named.peek().is_some() && named.all(|result| result.first_divergence.is_none())
        })
    }
}

impl Baseline {
    /// The baseline that accepts exactly the divergences of `results`: entries that still apply stay as they are, those of
    /// scenes that were not run too; each new divergence gets an entry with `reason`.
    #[must_use]
    pub fn blessed(&self, results: &[RunResult], reason: &str) -> Self {
        let mut known: Vec<Known> = self
            .known
            .iter()
            .filter(|known| {
                let mut named = results
                    .iter()
                    .filter(|result| known.names(result))
                    .peekable();
                named.peek().is_none() || named.any(|result| self.accepts(result) == Some(known))
            })
            .cloned()
            .collect();
        for result in results
            .iter()
            .filter(|result| self.accepts(result).is_none())
        {
            if let Some(divergence) = &result.first_divergence {
                known.push(Known {
                    scene: result.scene.clone(),
                    oracle: result.oracle.clone(),
                    mode: result.mode.name().into(),
                    guid: Some(result.guid.clone()),
                    frame: divergence.frame,
                    field: divergence.field.clone(),
                    reason: reason.into(),
                });
            }
        }
        known.sort_by(|a, b| {
            (&a.scene, &a.oracle, &a.mode, &a.guid).cmp(&(&b.scene, &b.oracle, &b.mode, &b.guid))
        });
        Self { known }
    }
}

impl Known {
    /// Whether the entry is for this result, wherever it diverges.
    pub(crate) fn names(&self, result: &RunResult) -> bool {
        self.scene == result.scene
            && self.oracle == result.oracle
            && self.mode == result.mode.name()
            && self.guid.as_ref().is_none_or(|guid| *guid == result.guid)
    }
}
