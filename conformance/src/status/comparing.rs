//! The part of the page about comparing long traces, from what the example `big_trace` printed.

use std::path::Path;

use serde::Deserialize;

use super::{heading, row};

/// One trace that was read and compared.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Comparing {
    /// What was compared.
    pub case: String,
    /// States compared.
    pub states: u64,
    /// Size of the file, bytes.
    pub file_bytes: u64,
    /// Time from opening to the end, s.
    pub seconds: f64,
    /// Most memory that the process had, bytes; 0: not known.
    pub peak_bytes: u64,
}

/// What was measured, from JSON Lines; nothing where there is no such file.
///
/// # Errors
/// When the file is not what `big_trace compare` prints.
pub fn comparing_in(target: &Path) -> std::io::Result<Vec<Comparing>> {
    let path = target.join("comparing.jsonl");
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let text = std::fs::read(path)?;
    let values = serde_json::Deserializer::from_slice(&text).into_iter();
    Ok(values.collect::<serde_json::Result<_>>()?)
}

pub(super) fn section(text: &mut String, measured: &[Comparing]) {
    if measured.is_empty() {
        return;
    }
    text.push_str(
        "## Comparing long traces\n\nReading, decompressing, decoding and comparing, one thread (`cargo run --release -p ac-conformance --example \
         big_trace`).\n\n",
    );
    heading(
        text,
        "trace",
        &["states", "file", "states per second", "peak memory"],
    );
    for case in measured {
        let peak = match case.peak_bytes {
            0 => "–".into(),
            bytes => megabytes(bytes),
        };
        let rate = case.states as f64 / case.seconds / 1e6;
        let cells = [
            format!("{:.1} M", case.states as f64 / 1e6),
            megabytes(case.file_bytes),
            format!("{rate:.2} M"),
            peak,
        ];
        row(text, &case.case, cells);
    }
    text.push('\n');
}

fn megabytes(bytes: u64) -> String {
    format!("{:.0} MB", bytes as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measurements_are_shown() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(comparing_in(folder.path()).unwrap(), []);
        let line = r#"{"case":"long trace","states":30000000,"file_bytes":2000000000,"seconds":20.0,"peak_bytes":60000000}"#;
        std::fs::write(folder.path().join("comparing.jsonl"), line).unwrap();
        let mut text = String::new();
        section(&mut text, &comparing_in(folder.path()).unwrap());
        let last = text.trim_end().lines().last().unwrap();
        insta::assert_snapshot!(last, @"| long trace | 30.0 M | 2000 MB | 1.50 M | 60 MB |");
    }
}
