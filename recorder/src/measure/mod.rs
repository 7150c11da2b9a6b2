//! Measurements of the recorder itself: what relaying adds and loses, and what is left after a kill. Hidden commands of `ac-record`;
//! `docs/recording.md` says how to run them.

pub mod bench;
pub mod trials;

mod echo;

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::RecordError;

/// Appends lines of JSON to a file.
fn write_lines<T: Serialize>(path: &Path, lines: &[T]) -> Result<(), RecordError> {
    let failed = |source| RecordError::File {
        path: path.into(),
        source,
    };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    let mut text = String::new();
    for line in lines {
        // Cannot fail: structs of numbers and texts.
        text += &serde_json::to_string(line).unwrap_or_default();
        text.push('\n');
    }
    std::fs::write(path, text).map_err(failed)
}

/// A folder for recordings that are looked at and deleted.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Result<Self, RecordError> {
        let path = std::env::temp_dir().join(format!("ac-record-{name}-{}", std::process::id()));
        match std::fs::create_dir_all(&path) {
            Ok(()) => Ok(Self(path)),
            Err(source) => Err(RecordError::File { path, source }),
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
