//! Reads vector files: gzip-compressed or plain JSON Lines.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read},
    path::{Path, PathBuf},
};

use flate2::read::MultiGzDecoder;
use serde::Deserialize;
use serde_json::Value;

/// The schema this reader knows.
const SCHEMA: &str = "ac-vectors/1";

/// No line of a vector file comes near this; a longer one is refused before it is read into memory.
const MAX_LINE: u64 = 16 << 20;

/// Why a vector file could not be run.
#[derive(Debug, thiserror::Error)]
pub enum VectorError {
    /// Reading failed.
    #[error("{}: cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        source: std::io::Error,
    },
    /// A line is not what the format says.
    #[error("{}, line {line}: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// 1-based line number.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// The header names a family that does not exist.
    #[error("{}: no vector family is called `{name}`", path.display())]
    Family {
        /// The file.
        path: PathBuf,
        /// The family.
        name: String,
    },
    /// No profile has that name.
    #[error("{}: no profile is called `{name}`", path.display())]
    Profile {
        /// The file.
        path: PathBuf,
        /// The profile.
        name: String,
    },
}

/// First line of a vector file.
#[derive(Clone, Debug, Deserialize)]
pub struct Header {
    /// `ac-vectors/1`.
    pub schema: String,
    /// Name of the family.
    pub family: String,
    /// Who answered.
    pub oracle: String,
    /// Seed of the arguments.
    pub seed: u64,
    /// Number of calls of the generator.
    pub count: u64,
    /// Remarks of the oracle.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// A vector file in memory.
#[derive(Clone, Debug)]
pub struct VectorFile {
    /// First line.
    pub header: Header,
    /// Table lines.
    pub tables: Vec<Value>,
    /// Vectors with their 1-based line numbers.
    pub vectors: Vec<(usize, Value)>,
}

impl VectorFile {
    /// Reads `*.jsonl` or `*.jsonl.gz`.
    ///
    /// # Errors
    /// When the file cannot be read, a line is too long or no JSON, or the header is missing or of another schema.
    pub fn open(path: &Path) -> Result<Self, VectorError> {
        let io = |source| VectorError::Io {
            path: path.into(),
            source,
        };
        let file = File::open(path).map_err(io)?;
        let reader: Box<dyn Read> = if path.extension().is_some_and(|extension| extension == "gz") {
            Box::new(MultiGzDecoder::new(file))
        } else {
            Box::new(file)
        };
        let mut reader = BufReader::new(reader);
        let mut header: Option<Header> = None;
        let mut tables = Vec::new();
        let mut vectors = Vec::new();
        let mut text = Vec::new();
        for line in 1.. {
            text.clear();
            let read = reader
                .by_ref()
                .take(MAX_LINE + 1)
                .read_until(b'\n', &mut text)
                .map_err(io)?;
            if read == 0 {
                break;
            }
            let bad = |reason: String| VectorError::Line {
                path: path.into(),
                line,
                reason,
            };
            if read as u64 > MAX_LINE {
                return Err(bad(format!("longer than {MAX_LINE} bytes")));
            }
            if text.trim_ascii().is_empty() {
                continue;
            }
            let value: Value =
                serde_json::from_slice(&text).map_err(|error| bad(error.to_string()))?;
            if header.is_none() {
                let read: Header = serde_json::from_value(value)
                    .map_err(|error| bad(format!("header: {error}")))?;
                if read.schema != SCHEMA {
                    return Err(bad(format!(
                        "schema `{}`, this reader knows `{SCHEMA}`",
                        read.schema
                    )));
                }
                header = Some(read);
            } else if value.get("fn").is_some() {
                vectors.push((line, value));
            } else {
                tables.push(value);
            }
        }
        let header = header.ok_or_else(|| VectorError::Line {
            path: path.into(),
            line: 1,
            reason: "empty file".into(),
        })?;
        Ok(Self {
            header,
            tables,
            vectors,
        })
    }
}
