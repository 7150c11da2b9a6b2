//! Runs a candidate on two sides and says where they part.

mod profiles;
mod programs;
mod recorded;

use ac_client::{
    frame::{FrameState, FrameStates, state::Fields},
    profile::Profile,
};
use ac_golden_traces::trace::rewrite::Frame;
use ac_replayer::{Simulation, client::SceneRun};
use globset::GlobMatcher;
use serde::Serialize;
use serde_json::value::RawValue;

pub use profiles::TwoProfiles;
pub use programs::TwoPrograms;
pub use recorded::Recorded;

use super::{Candidate, ShrinkError};
use crate::{bisect::verdict::Place, compare::fields};

/// Where a candidate diverges.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shown {
    /// The first difference of the tracked states.
    #[serde(flatten)]
    pub place: Place,
    /// The stage in which the two sides first differ, if both can say it.
    pub stage: Option<String>,
}

impl Shown {
    /// Name of the field without indices.
    pub fn field_name(&self) -> String {
        fields::without_indices(&self.place.divergence.field)
    }
}

/// What a smaller candidate still has to show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    /// Name of the field without indices.
    pub field: String,
    /// The stage, if it was known.
    pub stage: Option<String>,
}

impl Target {
    fn is_met(&self, shown: &Shown) -> bool {
        shown.field_name() == self.field && (self.stage.is_none() || shown.stage == self.stage)
    }
}

/// Runs candidates.
pub trait Judge {
    /// Where the candidate diverges; `None`: nowhere, or not as `target` says.
    ///
    /// # Errors
    /// When it cannot be run.
    fn judge(
        &mut self,
        candidate: &Candidate,
        target: Option<&Target>,
    ) -> Result<Option<Shown>, ShrinkError>;

    /// Whether frames other than the last ones may go.
    fn may_change_time(&self) -> bool {
        true
    }

    /// What is expected in the frames of a candidate.
    ///
    /// # Errors
    /// When it cannot be run.
    fn expectation(&mut self, candidate: &Candidate) -> Result<Vec<Frame>, ShrinkError>;

    /// The only fields that count, if not all do.
    fn field(&self) -> Option<&GlobMatcher>;
}

/// Leaves out of a record what does not count, as if nobody knew it. Frame, time, entity and cell cannot be left out.
pub(super) fn keep_only(state: &mut FrameState, field: &GlobMatcher) {
    let mut kept = Fields::empty();
    for (name, bit) in state.has.iter_names() {
        let name = name.to_lowercase();
        let (whole, part) = match name.split_once('_') {
            Some(("plane", part)) => (Fields::CONTACT_PLANE, format!("contact_plane.{part}")),
            Some(("anim", part)) => (Fields::ANIM, format!("anim.{part}")),
            Some(("motion", part)) => (Fields::MOTION, format!("motion.{part}")),
            _ => (bit, name),
        };
        if field.is_match(&part) {
            kept |= bit | whole;
        }
    }
    state.has = kept & state.has;
}

/// A run of a candidate under a profile, frame by frame.
struct Side {
    run: SceneRun,
    states: FrameStates,
    stages: Vec<Box<RawValue>>,
}

impl Side {
    fn start(candidate: &Candidate, profile: &Profile) -> Result<Self, ShrinkError> {
        Ok(Self {
            run: SceneRun::new(&candidate.scene, candidate.world()?, profile)?,
            states: FrameStates::new(),
            stages: Vec::new(),
        })
    }

    /// Runs a frame; -1 is the state before the first.
    fn step(&mut self, frame: i32, with_stages: bool) -> Result<(), ShrinkError> {
        self.states.clear();
        self.stages.clear();
        match u32::try_from(frame) {
            Err(_) => self.run.frame_minus_one(&mut self.states)?,
            Ok(frame) if with_stages => {
                self.run
                    .step_with_checkpoints(frame, &mut self.states, &mut self.stages)?;
            }
            Ok(frame) => self.run.step(frame, &mut self.states)?,
        }
        Ok(())
    }
}

/// Frames of a candidate, from the state before the first.
fn frames(candidate: &Candidate) -> std::ops::Range<i32> {
    -1..i32::try_from(candidate.scene.frame_count()).unwrap_or(i32::MAX)
}

fn same(a: &FrameState, b: &FrameState) -> bool {
    a.has == b.has
        && a.cell == b.cell
        && a.time.to_bits() == b.time.to_bits()
        && a.fields_same_bits(b, a.has)
}
