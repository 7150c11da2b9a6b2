//! What a build says about a trace.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use ac_client::frame::FrameStates;
use ac_golden_traces::trace::{ChannelKind, TraceEvent, TraceReader, rewrite::Frame};
use globset::GlobMatcher;
use serde::{Deserialize, Serialize};

use super::BisectError;
use crate::{
    compare::{Divergence, fields},
    run::profile_of,
};

/// The trace, and what is asked about it.
#[derive(Clone, Debug)]
pub struct Question {
    /// The trace or scene; absolute, because builds run in a folder of their own.
    pub trace: PathBuf,
    /// Folder of the worlds.
    pub worlds: PathBuf,
    /// Profile of a run without expectation.
    pub profile: String,
    /// Only differences of fields with this name count.
    pub field: Option<GlobMatcher>,
    /// Expectations by oracle. None: what the good build produced is expected.
    pub expected: BTreeMap<String, Vec<Frame>>,
    /// A run that takes longer has failed.
    pub timeout: Duration,
}

/// What a build says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It runs; where it first differs, by oracle (or `good`, for what the good build produced).
    Runs(BTreeMap<String, Option<Place>>),
    /// It does not run the trace to its end.
    Fails(String),
}

/// The first difference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The entity.
    pub guid: String,
    /// Frame, field and values.
    #[serde(flatten)]
    pub divergence: Divergence,
}

/// The name of the reference when a trace has no expectation.
pub const GOOD: &str = "good";

impl Verdict {
    /// Whether two builds are judged alike: the same expectations met, the others missed in the same frame, entity and field.
    pub fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Fails(_), Self::Fails(_)) => true,
            (Self::Runs(a), Self::Runs(b)) => {
                let key = |places: &BTreeMap<String, Option<Place>>| -> Vec<_> {
                    let of = |(oracle, place): (&String, &Option<Place>)| {
                        let place = place.as_ref().map(|place| {
                            let field = place.divergence.field.clone();
                            (place.guid.clone(), place.divergence.frame, field)
                        });
                        (oracle.clone(), place)
                    };
                    places.iter().map(of).collect()
                };
                key(a) == key(b)
            }
            _ => false,
        }
    }

    /// On one line.
    pub fn line(&self) -> String {
        match self {
            Self::Fails(reason) => format!("does not run: {reason}"),
            Self::Runs(places) => {
                let parts: Vec<String> = places
                    .iter()
                    .map(|(oracle, place)| match place {
                        None => format!("{oracle}: exact"),
                        Some(Place { guid, divergence }) => format!(
                            "{oracle}: frame {} {guid} {}",
                            divergence.frame, divergence.field
                        ),
                    })
                    .collect();
                parts.join("; ")
            }
        }
    }
}

impl Question {
    /// Reads the expectations of a trace: of `oracle`, or all. A scene file has none.
    ///
    /// # Errors
    /// When the trace cannot be read, or has none of this oracle.
    pub fn read_expectations(&mut self, oracle: Option<&str>) -> Result<(), BisectError> {
        if self.trace.extension().is_none_or(|of| of != "mcap") {
            return Ok(());
        }
        let mut reader = TraceReader::open(&self.trace)?;
        reader.select(|kind| matches!(kind, ChannelKind::Expect(_)));
        let mut states = FrameStates::new();
        while let Some(event) = reader.next_event(&mut states)? {
            if let TraceEvent::States {
                kind: ChannelKind::Expect(of),
                frame,
                time,
            } = event
                && oracle.is_none_or(|wanted| wanted == of)
            {
                let mut copy = FrameStates::new();
                copy.copy_from(&states);
                self.expected
                    .entry(of.clone())
                    .or_default()
                    .push((frame, time, copy));
            }
        }
        match oracle {
            Some(name) if self.expected.is_empty() => Err(BisectError::Question(format!(
                "{} has no expectation of oracle `{name}`",
                self.trace.display()
            ))),
            _ => Ok(()),
        }
    }

    /// Runs a build and compares. Without expectations, `reference` is what is expected; without that, everything is as expected.
    ///
    /// # Errors
    /// When the program cannot be started or its trace not be read.
    pub fn ask(
        &self,
        program: &Path,
        scratch: &Path,
        reference: Option<&[Frame]>,
    ) -> Result<Verdict, BisectError> {
        let out = scratch.join("run.mcap");
        if self.expected.is_empty() {
            if let Err(reason) = self.run(program, &self.profile, false, &out)? {
                return Ok(Verdict::Fails(reason));
            }
            let place = match reference {
                Some(expected) => self.first_difference(expected, &produced(&out)?),
                None => None,
            };
            return Ok(Verdict::Runs([(GOOD.into(), place)].into()));
        }
        let mut places = BTreeMap::new();
        for (oracle, expected) in &self.expected {
            if let Err(reason) = self.run(program, profile_of(oracle), false, &out)? {
                return Ok(Verdict::Fails(reason));
            }
            let place = self.first_difference(expected, &produced(&out)?);
            places.insert(oracle.clone(), place);
        }
        Ok(Verdict::Runs(places))
    }

    /// Runs a build under a profile into a trace. The inner error is why the run failed.
    ///
    /// # Errors
    /// When the program cannot be started.
    pub fn run(
        &self,
        program: &Path,
        profile: &str,
        checkpoints: bool,
        out: &Path,
    ) -> Result<Result<(), String>, BisectError> {
        let said = out.with_extension("log");
        let log = File::create(&said).map_err(BisectError::io(&said))?;
        let mut command = Command::new(program);
        command.arg("run").arg(&self.trace);
        command.arg("--worlds").arg(&self.worlds);
        command.args(["--profile", profile]).arg("-o").arg(out);
        if checkpoints {
            command.arg("--checkpoints");
        }
        command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log);
        let mut child = command.spawn().map_err(|source| BisectError::Start {
            program: program.display().to_string(),
            source,
        })?;
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().map_err(BisectError::io(program))? {
                break status;
            }
            if start.elapsed() > self.timeout {
                // It may have ended by itself just now.
                let _ = child.kill();
                let _ = child.wait();
                let seconds = self.timeout.as_secs();
                return Ok(Err(format!("not done after {seconds} s")));
            }
            thread::sleep(Duration::from_millis(5));
        };
        if status.success() {
            return Ok(Ok(()));
        }
        let text = fs::read_to_string(&said).unwrap_or_default();
        let line = text.lines().find(|line| !line.trim().is_empty());
        Ok(Err(format!("{status}: {}", line.unwrap_or("").trim())))
    }

    /// Where the produced states first differ from the expected ones in a field that counts.
    pub fn first_difference(&self, expected: &[Frame], actual: &[Frame]) -> Option<Place> {
        let by_frame: BTreeMap<i32, &FrameStates> = actual
            .iter()
            .map(|(frame, _, states)| (*frame, states))
            .collect();
        expected.iter().find_map(|(frame, _, expected)| {
            differences(
                *frame,
                expected,
                by_frame.get(frame).copied(),
                self.field.as_ref(),
            )
            .into_iter()
            .next()
        })
    }
}

/// Everything in which a frame differs, as far as the field counts.
pub(crate) fn differences(
    frame: i32,
    expected: &FrameStates,
    actual: Option<&FrameStates>,
    field: Option<&GlobMatcher>,
) -> Vec<Place> {
    let mut places = Vec::new();
    let counts = |name: &str, path: &str| {
        field.is_none_or(|field| field.is_match(name) || field.is_match(path))
    };
    for state in expected.iter() {
        let guid = format!("0x{:X}", state.guid);
        let mut add = |field: String, expected, actual| {
            places.push(Place {
                guid: guid.clone(),
                divergence: Divergence {
                    frame,
                    stage: None,
                    field,
                    expected,
                    actual,
                },
            });
        };
        let Some(found) = actual.and_then(|actual| actual.of(state.guid)) else {
            if counts("record", "record") {
                add("record".into(), "present".into(), "missing".into());
            }
            continue;
        };
        fields::differences(state, found, &mut |difference| {
            let path = difference.path();
            if counts(difference.field, &path) {
                let (expected, actual) = (difference.values)();
                add(path, expected, actual);
            }
        });
    }
    places
}

/// The states in a trace that a build wrote.
///
/// # Errors
/// When it cannot be read.
pub fn produced(path: &Path) -> Result<Vec<Frame>, BisectError> {
    let mut reader = TraceReader::open(path)?;
    reader.select(|kind| *kind == ChannelKind::States);
    let mut frames = Vec::new();
    let mut states = FrameStates::new();
    while let Some(event) = reader.next_event(&mut states)? {
        if let TraceEvent::States { frame, time, .. } = event {
            let mut copy = FrameStates::new();
            copy.copy_from(&states);
            frames.push((frame, time, copy));
        }
    }
    Ok(frames)
}
