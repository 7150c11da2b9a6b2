//! Running scenes and comparing what comes out: the `run` command without its printing.
//!
//! A *case* is one scene with its expectations ([`cases`]). A case is read as a stream; for every oracle and mode in it one
//! simulation runs along (`runner`), so that memory does not grow with the length of a trace. Cases run in parallel;
//! results come in a fixed order whatever the number of threads.

pub mod baseline;
pub mod cases;
pub mod report;
mod runner;
pub mod sensitivity;

use std::{collections::BTreeMap, path::PathBuf};

use ac_golden_traces::GoldenError;
use ac_replayer::{SimulationError, Simulator};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use cases::Case;

use crate::{
    compare::{Class, Comparison, Divergence, MaxError, policy::Policy},
    report_html::Series,
};

/// How to compare.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// From the first state on, never corrected: shows drift.
    Free,
    /// Before each frame the entities are set to the expected state of the frame before: counts independent divergences.
    Resync,
    /// Each recorded stage alone, from its recorded inputs.
    Stage,
}

impl Mode {
    /// Every mode.
    pub const ALL: [Self; 3] = [Self::Free, Self::Resync, Self::Stage];

    /// The name in results and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Resync => "resync",
            Self::Stage => "stage",
        }
    }
}

/// What to run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Modes to compare in.
    pub modes: Vec<Mode>,
    /// Only this oracle.
    pub oracle: Option<String>,
    /// Profile to run under; `None`: that of the oracle.
    pub profile: Option<String>,
    /// Keep of every frame what a report draws: memory then grows with the number of frames.
    pub series: bool,
}

/// The result for one scene, oracle, mode and entity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// Name of the scene.
    pub scene: String,
    /// Its first part.
    pub area: String,
    /// Who expects.
    pub oracle: String,
    /// Profile the library ran under.
    pub profile: String,
    /// How it was compared.
    pub mode: Mode,
    /// The entity.
    pub guid: String,
    /// Frames (in stage mode: stage records) compared.
    pub frames_compared: u64,
    /// Of these exact.
    pub frames_exact: u64,
    /// The first difference.
    pub first_divergence: Option<Divergence>,
    /// Largest error per numeric field that differs.
    pub max_error: BTreeMap<String, MaxError>,
    /// Frames whose expectation is not finite somewhere.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub undefined: u64,
    /// Exact, within tolerance or diverged.
    #[serde(default, skip_serializing_if = "is_said_by_divergence")]
    pub class: Class,
    /// Differences that a rule of the policy tolerates: how many, by the rule.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tolerated: BTreeMap<String, u64>,
    /// Stage records that the client cannot run alone.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub not_run: u64,
    /// Stage records per stage (stage mode).
    #[serde(skip)]
    pub stages: BTreeMap<String, StageCount>,
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// Exact and diverged follow from `first_divergence`.
fn is_said_by_divergence(class: &Class) -> bool {
    *class != Class::WithinTolerance
}

/// Records of one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageCount {
    /// Run alone and compared.
    pub compared: u64,
    /// Of these exact.
    pub exact: u64,
    /// Not run: the client cannot run this stage alone.
    pub not_run: u64,
}

impl RunResult {
    fn new(
        scene: &str,
        oracle: &str,
        profile: &str,
        mode: Mode,
        guid: u32,
        comparison: Comparison,
    ) -> Self {
        Self {
            scene: scene.into(),
            area: scene.split('/').next().unwrap_or("").into(),
            oracle: oracle.into(),
            profile: profile.into(),
            mode,
            guid: format!("0x{guid:X}"),
            frames_compared: comparison.frames_compared,
            frames_exact: comparison.frames_exact,
            undefined: comparison.undefined,
            not_run: comparison.not_run,
            class: comparison.class(),
            tolerated: comparison.tolerated,
            first_divergence: comparison.first_divergence,
            max_error: comparison.max_error,
            stages: BTreeMap::new(),
        }
    }
}

/// Why a case could not be run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// Its files cannot be read.
    #[error(transparent)]
    Golden(#[from] GoldenError),
    /// The client cannot run it.
    #[error("{}: {source}", path.display())]
    Simulation {
        /// The case.
        path: PathBuf,
        /// What the client said.
        #[source]
        source: SimulationError,
    },
    /// No profile has the name of the oracle.
    #[error(
        "{}: no profile is called `{name}`; name one with --profile ({})",
        path.display(),
        PROFILES.join(", ")
    )]
    Profile {
        /// The case.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// The expectations do not fit the scene.
    #[error("{}: {reason}", path.display())]
    Expectation {
        /// The case.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// The oracle that is this library itself: what its profile `retail` did when it was last blessed (see [`crate::bless`]).
pub const SELF: &str = "self";

/// Name of the profile that is compared with an oracle.
pub fn profile_of(oracle: &str) -> &str {
    if oracle == SELF { "retail" } else { oracle }
}

/// The presets that `--profile` accepts.
pub const PROFILES: [&str; 4] = ["retail", "ace", "gdle", "gdle-repaired"];

/// What came of all cases.
#[derive(Debug, Default)]
pub struct Outcome {
    /// By scene, oracle, mode, and the order of entities in the scene.
    pub results: Vec<RunResult>,
    /// Cases that could not run.
    pub errors: Vec<RunError>,
    /// What a report draws; empty unless it was asked for ([`Options::series`]).
    pub series: Vec<Series>,
}

/// Runs all cases on the current thread pool. `done` is called after each case.
pub fn run(
    simulator: &dyn Simulator,
    cases: &[Case],
    options: &Options,
    done: impl Fn() + Sync,
) -> Outcome {
    run_with(simulator, cases, options, &Policy::default(), |_, _| done())
}

/// [`run`] with a policy that says what may differ. `done` is called with each case and its results, in the order in which they
/// are done.
pub fn run_with(
    simulator: &dyn Simulator,
    cases: &[Case],
    options: &Options,
    policy: &Policy,
    done: impl Fn(&Case, &[RunResult]) + Sync,
) -> Outcome {
    let each: Vec<_> = cases
        .par_iter()
        .map(|case| {
            let results = runner::run_case(simulator, case, options, policy);
            done(case, &results.results);
            results
        })
        .collect();
    let mut outcome = Outcome::default();
    for case in each {
        outcome.results.extend(case.results);
        outcome.errors.extend(case.errors);
        outcome.series.extend(case.series);
    }
    // Entities keep their order: the sort is stable.
    outcome
        .results
        .sort_by(|a, b| (&a.scene, &a.oracle, a.mode).cmp(&(&b.scene, &b.oracle, b.mode)));
    outcome
}

#[cfg(test)]
mod tests;
