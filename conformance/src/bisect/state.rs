//! The file that remembers what a search found out.

use std::{collections::BTreeMap, fs, path::Path};

use serde::{Deserialize, Serialize};

use super::{BisectError, verdict::Verdict};

/// Name and version of the file.
const SCHEMA: &str = "ac-bisect/1";

/// What is looked for. A file with another question is of no use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Asked {
    /// The trace.
    pub trace: String,
    /// BLAKE3 of the trace.
    pub trace_blake3: String,
    /// Id of the good commit.
    pub good: String,
    /// Id of the bad commit.
    pub bad: String,
    /// Only this field.
    pub field: Option<String>,
    /// Only this oracle.
    pub oracle: Option<String>,
    /// Profile of runs without expectation.
    pub profile: String,
    /// How commits are built.
    pub build: String,
}

/// What is known of a commit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Known {
    /// It was built and asked.
    Judged(Verdict),
    /// It cannot be built.
    Unbuildable,
}

/// Everything that is known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// [`SCHEMA`].
    schema: String,
    /// The question.
    pub asked: Asked,
    /// By id of the commit.
    pub commits: BTreeMap<String, Known>,
}

impl State {
    /// Nothing is known yet.
    pub fn new(asked: Asked) -> Self {
        Self {
            schema: SCHEMA.into(),
            asked,
            commits: BTreeMap::new(),
        }
    }

    /// What an earlier search with the same question left in a file; else nothing.
    ///
    /// # Errors
    /// When the file is there and cannot be read.
    pub fn open(path: &Path, asked: Asked) -> Result<Self, BisectError> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Ok(Self::new(asked));
            }
            Err(error) => return Err(BisectError::io(path)(error)),
        };
        // A file of another version or question is as good as none.
        Ok(match serde_json::from_str::<Self>(&text) {
            Ok(state) if state.schema == SCHEMA && state.asked == asked => state,
            _ => Self::new(asked),
        })
    }

    /// Writes the file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), BisectError> {
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(BisectError::io(folder))?;
        }
        let draft = path.with_extension("new");
        fs::write(&draft, text + "\n").map_err(BisectError::io(&draft))?;
        fs::rename(&draft, path).map_err(BisectError::io(path))
    }
}
