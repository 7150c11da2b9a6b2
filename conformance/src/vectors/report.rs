//! Counts per function, and the table a person reads.

use std::fmt::Write;

use serde::Serialize;
use serde_json::Value;

use super::{
    Header,
    compare::{Mismatch, Verdict, compare_vector, has_answer},
};

/// The result of one function of one file.
#[derive(Clone, Debug, Serialize)]
pub struct FnResult {
    /// Family of the file.
    pub family: String,
    /// The function.
    #[serde(rename = "fn")]
    pub function: String,
    /// Who answered.
    pub oracle: String,
    /// Profile the library ran under.
    pub profile: String,
    /// Vectors that the oracle answered.
    pub total: usize,
    /// Of these, with the same bits everywhere.
    pub exact: usize,
    /// Of these, without an answer of the library.
    pub not_implemented: usize,
    /// Vectors that the oracle did not answer.
    pub left_out: usize,
    /// The first difference.
    pub first_mismatch: Option<FirstMismatch>,
}

/// Where the first difference is.
#[derive(Clone, Debug, Serialize)]
pub struct FirstMismatch {
    /// 1-based line of the file.
    pub line: usize,
    /// What differs.
    #[serde(flatten)]
    pub mismatch: Mismatch,
}

impl FnResult {
    pub(super) fn new(header: &Header, function: &str, profile: &str) -> Self {
        Self {
            family: header.family.clone(),
            function: function.into(),
            oracle: header.oracle.clone(),
            profile: profile.into(),
            total: 0,
            exact: 0,
            not_implemented: 0,
            left_out: 0,
            first_mismatch: None,
        }
    }

    pub(super) fn count(
        &mut self,
        line: usize,
        vector: &Value,
        answer: impl FnOnce() -> Option<Value>,
    ) {
        if !has_answer(vector) {
            self.left_out += 1;
            return;
        }
        self.total += 1;
        let Some(actual) = answer() else {
            self.not_implemented += 1;
            return;
        };
        match compare_vector(vector, &actual) {
            Verdict::Exact | Verdict::LeftOut => self.exact += 1,
            Verdict::Different(mismatch) => {
                self.first_mismatch
                    .get_or_insert(FirstMismatch { line, mismatch });
            }
        }
    }

    /// Whether every vector that the oracle answered is met.
    pub fn all_exact(&self) -> bool {
        self.exact == self.total
    }
}

/// A table of all results, with the first difference of each function that has one.
pub fn human_table(results: &[FnResult]) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{:<14} {:<26} {:<14} {:<14} {:>6} {:>6} {:>9}",
        "family", "function", "oracle", "profile", "total", "exact", "missing"
    );
    for result in results {
        let _ = writeln!(
            text,
            "{:<14} {:<26} {:<14} {:<14} {:>6} {:>6} {:>9}",
            result.family,
            result.function,
            result.oracle,
            result.profile,
            result.total,
            result.exact,
            result.not_implemented
        );
        if let Some(first) = &result.first_mismatch {
            let actual = first
                .mismatch
                .actual
                .as_ref()
                .map_or_else(|| "nothing".into(), Value::to_string);
            let _ = writeln!(
                text,
                "    line {}: {} expected {}, got {actual}",
                first.line, first.mismatch.field, first.mismatch.expected
            );
        }
    }
    let sum = |count: fn(&FnResult) -> usize| results.iter().map(count).sum::<usize>();
    let _ = writeln!(
        text,
        "{} of {} vectors exact, {} not implemented, {} without an answer of the oracle",
        sum(|r| r.exact),
        sum(|r| r.total),
        sum(|r| r.not_implemented),
        sum(|r| r.left_out)
    );
    text
}
