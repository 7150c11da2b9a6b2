//! Iteration record: which versions of the file are present, id 0xFFFF0001 of every file; no id of its own.
//! Source: `spec/11-dat-files.md, 3.9`.

use serde::Serialize;

use super::error::Problem;
use super::kind::{ITERATION_ID, RecordKind};
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// Iterations of a file. A complete file has one run from 1 on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Iteration {
    /// Total number of iterations.
    pub total: i32,
    /// (minus the number of consecutive iterations, first of them).
    pub runs: Vec<(i32, i32)>,
}

impl Iteration {
    /// A complete file.
    #[must_use]
    pub fn complete(total: i32) -> Self {
        Self {
            total,
            runs: vec![(-total, 1)],
        }
    }

    /// No iteration is missing.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.runs.len() <= 1
    }
}

impl Record for Iteration {
    const KIND: RecordKind = RecordKind::Iteration;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let total = r.i32()?;
        let mut runs = Vec::new();
        let mut left = i64::from(total);
        while left > 0 {
            let (run, start) = (r.i32()?, r.i32()?);
            if run >= 0 {
                return Err(r.error_at(
                    r.offset() - 8,
                    Problem::Value {
                        what: "iteration run",
                        found: i64::from(run),
                        expected: "below zero",
                    },
                ));
            }
            left += i64::from(run);
            runs.push((run, start));
        }
        Ok(Self { total, runs })
    }

    fn write(&self, w: &mut Writer) {
        w.i32(self.total);
        for (run, start) in &self.runs {
            w.i32(*run);
            w.i32(*start);
        }
    }

    fn id(&self) -> u32 {
        ITERATION_ID
    }
}
