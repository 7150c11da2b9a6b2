//! The part of the page about the recorder: what relaying adds and loses, and what is left after a kill. The numbers are lines of JSON
//! that `ac-record bench` and `ac-record kill-trials` leave under `target/`.

use std::{fs, path::Path};

use serde::{Deserialize, de::DeserializeOwned};

use super::{heading, row};

/// Datagrams of one way at one rate.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Way {
    /// Datagrams sent.
    pub sent: u64,
    /// Datagrams that did not come back.
    pub lost: u64,
    /// Median time there and back, µs.
    pub p50_us: f64,
    /// 99 of 100 came back within, µs.
    pub p99_us: f64,
}

/// A rate of datagrams, without and with a relay.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct RelayCost {
    /// Datagrams per second.
    pub rate: u32,
    /// A bare echo.
    pub direct: Way,
    /// The same through `ac-record proxy`.
    pub relayed: Way,
    /// Datagrams that the relay passed on, both directions.
    pub passed: u64,
    /// Of these, recorded.
    pub recorded: u64,
    /// Of these, not recorded.
    pub unwritten: u64,
    /// Datagrams that the writer thread alone takes per second.
    #[serde(default)]
    pub writer_per_second: f64,
}

/// Outcome of trials in which a running proxy was killed.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct KillTrials {
    /// Kills.
    pub trials: u32,
    /// Trials after which every file was recovered.
    pub recovered: u32,
    /// Datagrams passed on before the kills.
    pub passed: u64,
    /// Datagrams missing although they were older than the bound.
    pub lost_beyond_bound: u64,
    /// Longest time that a datagram may be in memory only, s.
    pub bound_s: f64,
    /// Files that were left.
    pub files: u64,
}

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecorderNumbers {
    /// Relay costs, one per rate.
    pub relay: Vec<RelayCost>,
    /// Kills, at most one entry.
    pub kills: Vec<KillTrials>,
}

impl RecorderNumbers {
    /// Numbers in the folder where builds leave theirs. What was not measured is left out.
    ///
    /// # Errors
    /// When a file is there but is no such list.
    pub fn in_folder(target: &Path) -> std::io::Result<Self> {
        Ok(Self {
            relay: lines(&target.join("recorder-bench.jsonl"))?,
            kills: lines(&target.join("recorder-kill.jsonl"))?,
        })
    }
}

fn lines<T: DeserializeOwned>(path: &Path) -> std::io::Result<Vec<T>> {
    let text = match fs::read(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let values = serde_json::Deserializer::from_slice(&text).into_iter();
    Ok(values.collect::<serde_json::Result<_>>()?)
}

pub(super) fn section(text: &mut String, numbers: &RecorderNumbers) {
    if numbers == &RecorderNumbers::default() {
        return;
    }
    text.push_str("## Recorder\n\n");
    if let Some(first) = numbers.relay.first() {
        text.push_str(
            "Datagrams to an echo server and back over loopback, without and with `ac-record proxy` in between, one after the other in the same run; the relay passes and records each one twice \
             (`cargo run --release -p ac-recorder -- bench`).\n\n",
        );
        heading(
            text,
            "per second",
            &[
                "bare p50, p99 (µs)",
                "relayed p50, p99 (µs)",
                "added p50, p99 (µs)",
                "lost bare, relayed",
                "not recorded",
            ],
        );
        for cost in &numbers.relay {
            let (direct, relayed) = (&cost.direct, &cost.relayed);
            let cells = [
                format!("{:.0}, {:.0}", direct.p50_us, direct.p99_us),
                format!("{:.0}, {:.0}", relayed.p50_us, relayed.p99_us),
                format!(
                    "{:.0}, {:.0}",
                    relayed.p50_us - direct.p50_us,
                    relayed.p99_us - direct.p99_us
                ),
                format!(
                    "{}/{}, {}/{}",
                    direct.lost, direct.sent, relayed.lost, relayed.sent
                ),
                format!("{}/{}", cost.unwritten, cost.passed),
            ];
            row(text, &cost.rate.to_string(), cells);
        }
        let line = format!(
            "\nThe writer thread alone takes {:.0} datagrams per second (redaction, index, compression, file).\n\n",
            first.writer_per_second
        );
        text.push_str(&line);
    }
    for kill in &numbers.kills {
        let line = format!(
            "Killed (`kill -9`) at {} random moments, half of them while files are rotated every 0.3 s: {} recovered with all of their {} files; of {} datagrams passed on, {} were lost beyond the bound of {} s \
             (`cargo run --release -p ac-recorder -- kill-trials`).\n\n",
            kill.trials,
            kill.recovered,
            kill.files,
            kill.passed,
            kill.lost_beyond_bound,
            kill.bound_s
        );
        text.push_str(&line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_a_section() {
        let folder = tempfile::tempdir().unwrap();
        let none = RecorderNumbers::in_folder(folder.path()).unwrap();
        let mut text = String::new();
        section(&mut text, &none);
        assert_eq!(text, "");
        let bench = r#"{"rate":1000,"seconds":3.0,"direct":{"sent":3000,"lost":0,"p50_us":50.4,"p99_us":90.0},"relayed":{"sent":3000,"lost":1,"p50_us":99.6,"p99_us":150.0},"added_p50_us":49.2,"added_p99_us":60.0,"passed":6000,"recorded":6000,"unwritten":0,"system_dropped":0,"cores":2}"#;
        let kill = r#"{"trials":200,"recovered":200,"passed":9,"in_files":18,"lost_beyond_bound":0,"bound_s":1.0,"files":300,"problems":[]}"#;
        fs::write(folder.path().join("recorder-bench.jsonl"), bench).unwrap();
        fs::write(folder.path().join("recorder-kill.jsonl"), kill).unwrap();
        let numbers = RecorderNumbers::in_folder(folder.path()).unwrap();
        section(&mut text, &numbers);
        assert!(
            text.contains("| 1000 | 50, 90 | 100, 150 | 49, 60 | 0/3000, 1/3000 | 0/6000 |"),
            "{text}"
        );
        assert!(text.contains("at 200 random moments"), "{text}");
        fs::write(folder.path().join("recorder-kill.jsonl"), "[").unwrap();
        assert!(RecorderNumbers::in_folder(folder.path()).is_err());
    }
}
