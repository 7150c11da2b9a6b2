//! Making a scene that shows a divergence as small as it can be.
//!
//! A [`Candidate`] is a scene with the records of its own world. A [`Judge`] runs it and says where, if anywhere, it diverges.
//! [`shrink()`] takes things out (frames, entities, steps of the script, tracked entities, records of the world), asks the judge,
//! and keeps what still shows the same divergence: the same field and, where both sides can say it, the same stage. It takes out
//! large pieces first and single ones last (delta debugging), until nothing more can go or the budget of runs is spent.
//!
//! What the judge compares with decides what may go ([`judge`]):
//! - *Two sides that both can be run* (two profiles, or two programs): anything, since both are run again.
//! - *An oracle's expectation*: it was computed for the whole scene and nobody can compute it again. Frames behind the
//!   divergence go; anything else only if the client's own states stay what they were, bit for bit, which shows that it had no
//!   part in them.

pub mod candidate;
pub mod judge;
pub mod output;
mod passes;

use ac_golden_traces::GoldenError;
use ac_replayer::SimulationError;
use serde::Serialize;

pub use candidate::Candidate;
pub use judge::{Judge, Shown, Target};

use crate::bisect::BisectError;

/// Why a scene cannot be shrunk.
#[derive(Debug, thiserror::Error)]
pub enum ShrinkError {
    /// Its files cannot be read or written.
    #[error(transparent)]
    Golden(#[from] GoldenError),
    /// The client cannot run it.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A program cannot be asked.
    #[error(transparent)]
    Program(#[from] BisectError),
    /// The world cannot be read or written.
    #[error("world: {0}")]
    World(String),
    /// There is nothing to shrink.
    #[error("{0}")]
    Nothing(String),
}

/// How large a candidate is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Size {
    /// Frames.
    pub frames: u32,
    /// Entities, those that the script creates among them.
    pub entities: usize,
    /// Steps of the script.
    pub steps: usize,
    /// Records of the world, in both dat files.
    pub records: usize,
    /// Bytes of both dat files.
    pub world_bytes: usize,
}

/// What came of shrinking.
#[derive(Debug)]
pub struct Shrunk {
    /// The smallest candidate that still shows it.
    pub candidate: Candidate,
    /// What it shows.
    pub shown: Shown,
    /// Size before.
    pub before: Size,
    /// Size after.
    pub after: Size,
    /// Candidates that were run.
    pub runs: usize,
    /// Whether the budget ended it: it might be smaller still.
    pub budget_spent: bool,
}

/// Called with the number of runs and the size of the smallest candidate, now and then.
pub type Progress<'a> = &'a dyn Fn(usize, &Candidate);

/// Shrinks a candidate that diverges.
///
/// # Errors
/// When it does not diverge, or cannot be run.
pub fn shrink(
    start: Candidate,
    judge: &mut dyn Judge,
    max_runs: usize,
    progress: Progress<'_>,
) -> Result<Shrunk, ShrinkError> {
    let before = start.size()?;
    let mut session = Session::start(start, judge, max_runs, progress)?;
    passes::all(&mut session)?;
    Ok(Shrunk {
        after: session.best.size()?,
        shown: session.shown,
        runs: session.runs,
        budget_spent: session.runs >= max_runs,
        candidate: session.best,
        before,
    })
}

/// The smallest candidate so far, and how to try another.
struct Session<'a> {
    judge: &'a mut dyn Judge,
    best: Candidate,
    shown: Shown,
    target: Target,
    runs: usize,
    max_runs: usize,
    progress: Progress<'a>,
}

impl<'a> Session<'a> {
    fn start(
        start: Candidate,
        judge: &'a mut dyn Judge,
        max_runs: usize,
        progress: Progress<'a>,
    ) -> Result<Self, ShrinkError> {
        let nothing = || {
            ShrinkError::Nothing(
                "the two sides do not differ in any frame of this scene, so there is nothing to shrink".into(),
            )
        };
        let shown = judge.judge(&start, None)?.ok_or_else(nothing)?;
        let target = Target {
            field: shown.field_name(),
            stage: shown.stage.clone(),
        };
        let mut best = start;
        best.end_after(shown.place.divergence.frame);
        Ok(Self {
            judge,
            best,
            shown,
            target,
            runs: 1,
            max_runs,
            progress,
        })
    }

    fn spent(&self) -> bool {
        self.runs >= self.max_runs
    }

    /// Takes a candidate if it shows the same divergence. One that cannot be run does not.
    fn attempt(&mut self, mut candidate: Candidate) -> Result<bool, ShrinkError> {
        if self.spent() || candidate.scene.track.is_empty() {
            return Ok(false);
        }
        self.runs += 1;
        let judged = match self.judge.judge(&candidate, Some(&self.target)) {
            Ok(judged) => judged,
            Err(ShrinkError::Simulation(_) | ShrinkError::World(_)) => None,
            Err(error) => return Err(error),
        };
        (self.progress)(self.runs, &self.best);
        let Some(shown) = judged else {
            return Ok(false);
        };
        candidate.end_after(shown.place.divergence.frame);
        self.best = candidate;
        self.shown = shown;
        Ok(true)
    }
}

#[cfg(test)]
mod tests;
