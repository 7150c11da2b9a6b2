//! Expected-state traces and stage checkpoints as JSON Lines, plain or gzip-compressed
//! (`spec/scene-format.md`, `spec/stage-format.md`).

use std::{
    fs::File,
    io::{BufRead, BufReader, Read},
    path::{Path, PathBuf},
};

use ac_client::frame::FrameState;
use flate2::read::MultiGzDecoder;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::{
    GoldenError, number,
    record::{self, Unknown},
};

/// Schema of expected-state traces.
pub const EXPECT_SCHEMA: &str = "ac-expect/1";
/// Schema of stage checkpoints.
pub const STAGES_SCHEMA: &str = "ac-stages/1";

/// A longer line is refused before it is read into memory.
const MAX_LINE: u64 = 16 << 20;

/// First line of an expected-state trace or a stage file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// [`EXPECT_SCHEMA`] or [`STAGES_SCHEMA`].
    pub schema: String,
    /// Name of the scene.
    pub scene: String,
    /// Who wrote it.
    pub oracle: String,
    /// The version of who wrote it, whatever that is.
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub oracle_version: serde_json::Value,
    /// Settings, and what the writer was told while it ran.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// Lines of a file, read one by one into the same memory.
struct Lines {
    path: PathBuf,
    reader: Box<dyn BufRead + Send>,
    text: Vec<u8>,
    number: u64,
}

impl Lines {
    fn open(path: &Path) -> Result<Self, GoldenError> {
        let file = File::open(path).map_err(|source| GoldenError::Io {
            path: path.into(),
            source,
        })?;
        let reader: Box<dyn BufRead + Send> =
            if path.extension().is_some_and(|extension| extension == "gz") {
                Box::new(BufReader::with_capacity(1 << 16, MultiGzDecoder::new(file)))
            } else {
                Box::new(BufReader::with_capacity(1 << 16, file))
            };
        Ok(Self {
            path: path.into(),
            reader,
            text: Vec::new(),
            number: 0,
        })
    }

    /// The next line that is not empty, left in `text`; `false` at the end.
    fn advance(&mut self) -> Result<bool, GoldenError> {
        loop {
            self.text.clear();
            let read = self
                .reader
                .by_ref()
                .take(MAX_LINE + 1)
                .read_until(b'\n', &mut self.text);
            let read = read.map_err(|source| GoldenError::Io {
                path: self.path.clone(),
                source,
            })?;
            if read == 0 {
                return Ok(false);
            }
            self.number += 1;
            if read as u64 > MAX_LINE {
                return Err(self.bad(format!("longer than {MAX_LINE} bytes")));
            }
            if !self.text.trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    fn bad(&self, reason: String) -> GoldenError {
        GoldenError::Line {
            path: self.path.clone(),
            line: self.number,
            reason,
        }
    }

    fn header(&mut self, schema: &str) -> Result<Header, GoldenError> {
        if !self.advance()? {
            return Err(self.bad("the file is empty".into()));
        }
        let header: Header = serde_json::from_slice(&self.text)
            .map_err(|error| self.bad(format!("header: {error}")))?;
        if header.schema != schema {
            return Err(self.bad(format!(
                "schema `{}`, this program reads `{schema}`",
                header.schema
            )));
        }
        Ok(header)
    }
}

/// Reads an expected-state trace record by record.
pub struct ExpectReader {
    /// Its first line.
    pub header: Header,
    lines: Lines,
}

impl ExpectReader {
    /// Opens `*.expect.jsonl` or `*.expect.jsonl.gz`.
    ///
    /// # Errors
    /// When the file cannot be read or its header is not that of an expected-state trace.
    pub fn open(path: &Path) -> Result<Self, GoldenError> {
        let mut lines = Lines::open(path)?;
        Ok(Self {
            header: lines.header(EXPECT_SCHEMA)?,
            lines,
        })
    }

    /// Reads the next record into `state`, reusing its memory; `false` at the end.
    ///
    /// # Errors
    /// When reading fails or a line is not a record.
    pub fn next_into(&mut self, state: &mut FrameState) -> Result<bool, GoldenError> {
        if !self.lines.advance()? {
            return Ok(false);
        }
        record::read_line(&self.lines.text, Unknown::Refuse, state)
            .map_err(|error| self.lines.bad(error.to_string()))?;
        Ok(true)
    }
}

/// What every stage record begins with.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct StageHead {
    /// 0-based frame.
    pub frame: i32,
    /// The entity.
    #[serde(with = "number::hex")]
    pub guid: u32,
    /// Index of the physics quantum in the frame.
    pub quantum: u32,
    /// Name of the stage.
    pub stage: String,
}

/// Reads stage checkpoints record by record.
pub struct StageReader {
    /// Its first line.
    pub header: Header,
    lines: Lines,
}

impl StageReader {
    /// Opens `*.stages.jsonl` or `*.stages.jsonl.gz`.
    ///
    /// # Errors
    /// When the file cannot be read or its header is not that of a stage file.
    pub fn open(path: &Path) -> Result<Self, GoldenError> {
        let mut lines = Lines::open(path)?;
        Ok(Self {
            header: lines.header(STAGES_SCHEMA)?,
            lines,
        })
    }

    /// The next record: its head and its JSON text, unchanged.
    ///
    /// # Errors
    /// When reading fails or a line is no stage record.
    pub fn next_record(&mut self) -> Result<Option<(StageHead, &RawValue)>, GoldenError> {
        if !self.lines.advance()? {
            return Ok(None);
        }
        let lines = &self.lines;
        let head =
            serde_json::from_slice(&lines.text).map_err(|error| lines.bad(error.to_string()))?;
        let text =
            serde_json::from_slice(&lines.text).map_err(|error| lines.bad(error.to_string()))?;
        Ok(Some((head, text)))
    }
}
