//! Runs a candidate on two sides and says where they part.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Duration,
};

use ac_client::{
    frame::{FrameState, FrameStates, state::Fields},
    profile::Profile,
};
use ac_golden_traces::trace::rewrite::Frame;
use ac_replayer::{Simulation, client::SceneRun};
use globset::GlobMatcher;
use serde::Serialize;
use serde_json::value::RawValue;

use super::{Candidate, ShrinkError, output};
use crate::{
    bisect::{
        locate::{self, StageDifference},
        verdict::{self, Place, Question},
    },
    compare::fields,
};

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

/// The library under two profiles: the first is expected, the second is judged.
#[derive(Clone, Debug)]
pub struct TwoProfiles {
    /// What is expected.
    pub expected: Profile,
    /// What is judged.
    pub actual: Profile,
    /// Only differences of fields with this name count.
    pub field: Option<GlobMatcher>,
}

impl TwoProfiles {
    fn first(&self, candidate: &Candidate) -> Result<Option<Place>, ShrinkError> {
        let mut expected = Side::start(candidate, &self.expected)?;
        let mut actual = Side::start(candidate, &self.actual)?;
        for frame in frames(candidate) {
            expected.step(frame, false)?;
            actual.step(frame, false)?;
            let differing = expected
                .states
                .iter()
                .zip(actual.states.iter())
                .any(|(a, b)| !same(a, b));
            if differing {
                let field = self.field.as_ref();
                let places =
                    verdict::differences(frame, &expected.states, Some(&actual.states), field);
                // A not-a-number with other bits is no difference.
                if let Some(place) = places.into_iter().next() {
                    return Ok(Some(place));
                }
            }
        }
        Ok(None)
    }

    /// The first stage that differs, up to a frame.
    fn stage(
        &self,
        candidate: &Candidate,
        last: i32,
    ) -> Result<Option<StageDifference>, ShrinkError> {
        let mut expected = Side::start(candidate, &self.expected)?;
        let mut actual = Side::start(candidate, &self.actual)?;
        for frame in -1..=last {
            expected.step(frame, true)?;
            actual.step(frame, true)?;
            let found = locate::first_stage(frame, &expected.stages, &actual.stages);
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }

    fn shown(&self, candidate: &Candidate, place: Place) -> Result<Shown, ShrinkError> {
        let stage = self.stage(candidate, place.divergence.frame)?;
        Ok(Shown {
            place,
            stage: stage.map(|stage| stage.stage),
        })
    }
}

impl Judge for TwoProfiles {
    fn judge(
        &mut self,
        candidate: &Candidate,
        target: Option<&Target>,
    ) -> Result<Option<Shown>, ShrinkError> {
        let Some(place) = self.first(candidate)? else {
            return Ok(None);
        };
        // The stage costs much more than the field: it is asked second.
        let field = fields::without_indices(&place.divergence.field);
        if target.is_some_and(|target| target.field != field) {
            return Ok(None);
        }
        let shown = self.shown(candidate, place)?;
        Ok(target
            .is_none_or(|target| target.is_met(&shown))
            .then_some(shown))
    }

    fn expectation(&mut self, candidate: &Candidate) -> Result<Vec<Frame>, ShrinkError> {
        let mut side = Side::start(candidate, &self.expected)?;
        frames(candidate)
            .map(|frame| {
                side.step(frame, false)?;
                let time = side.states.first().map_or(0.0, |state| state.time);
                let mut copy = FrameStates::new();
                copy.copy_from(&side.states);
                Ok((frame, time, copy))
            })
            .collect()
    }

    fn field(&self) -> Option<&GlobMatcher> {
        self.field.as_ref()
    }
}

/// The library under a profile beside an expectation that cannot be computed again.
#[derive(Debug)]
pub struct Recorded {
    /// What is expected.
    pub expected: Vec<Frame>,
    /// What is judged.
    pub profile: Profile,
    /// What the library did in the whole scene: a candidate has to do the same.
    produced: Vec<FrameStates>,
    /// Only differences of fields with this name count.
    pub field: Option<GlobMatcher>,
    /// The two profiles that tell the stage, when the oracle's own profile meets the expectation.
    pub stages: Option<TwoProfiles>,
}

impl Recorded {
    /// A judge for a scene as it was recorded.
    ///
    /// # Errors
    /// When it cannot be run.
    pub fn new(
        whole: &Candidate,
        expected: Vec<Frame>,
        profile: Profile,
    ) -> Result<Self, ShrinkError> {
        let mut side = Side::start(whole, &profile)?;
        let mut produced = Vec::new();
        for frame in frames(whole) {
            side.step(frame, false)?;
            let mut copy = FrameStates::new();
            copy.copy_from(&side.states);
            produced.push(copy);
        }
        Ok(Self {
            expected,
            profile,
            produced,
            field: None,
            stages: None,
        })
    }

    /// The expectation of the entities that a candidate tracks.
    fn tracked(&self, candidate: &Candidate, states: &FrameStates) -> FrameStates {
        let mut kept = FrameStates::new();
        for state in states.iter() {
            if candidate.scene.track.contains(&state.guid) {
                kept.push(state.frame, state.time, state.guid)
                    .copy_from(state);
            }
        }
        kept
    }
}

impl Judge for Recorded {
    fn judge(
        &mut self,
        candidate: &Candidate,
        target: Option<&Target>,
    ) -> Result<Option<Shown>, ShrinkError> {
        let mut side = Side::start(candidate, &self.profile)?;
        let mut expected = self.expected.iter().peekable();
        let mut found = None;
        for (frame, before) in frames(candidate).zip(&self.produced) {
            side.step(frame, false)?;
            let unchanged = side
                .states
                .iter()
                .all(|state| before.of(state.guid).is_some_and(|old| same(old, state)));
            if !unchanged {
                return Ok(None);
            }
            if let Some((_, _, states)) = expected.next_if(|(of, ..)| *of == frame)
                && found.is_none()
            {
                let tracked = self.tracked(candidate, states);
                let field = self.field.as_ref();
                let places = verdict::differences(frame, &tracked, Some(&side.states), field);
                found = places.into_iter().next();
            }
        }
        let Some(place) = found else { return Ok(None) };
        let stage = match (&self.stages, target) {
            // What the client does is the same as before, so the stage is too.
            (_, Some(target)) => target.stage.clone(),
            (Some(profiles), None) => profiles
                .stage(candidate, place.divergence.frame)?
                .map(|stage| stage.stage),
            (None, None) => None,
        };
        let shown = Shown { place, stage };
        Ok(target
            .is_none_or(|target| target.is_met(&shown))
            .then_some(shown))
    }

    fn may_change_time(&self) -> bool {
        false
    }

    fn expectation(&mut self, candidate: &Candidate) -> Result<Vec<Frame>, ShrinkError> {
        let range = frames(candidate);
        let wanted = self
            .expected
            .iter()
            .filter(|(frame, ..)| range.contains(frame));
        Ok(wanted
            .map(|(frame, time, states)| (*frame, *time, self.tracked(candidate, states)))
            .collect())
    }

    fn field(&self) -> Option<&GlobMatcher> {
        self.field.as_ref()
    }
}

/// Two programs: the first is expected, the second is judged.
#[derive(Debug)]
pub struct TwoPrograms {
    /// What is expected.
    pub good: PathBuf,
    /// What is judged.
    pub bad: PathBuf,
    /// Profile of both.
    pub profile: String,
    /// A run that takes longer has failed.
    pub timeout: Duration,
    /// Only differences of fields with this name count.
    pub field: Option<GlobMatcher>,
    /// Folder for the scenes that they run.
    pub scratch: tempfile::TempDir,
    /// The world that is in the folder.
    written: Option<Arc<super::candidate::Records>>,
}

impl TwoPrograms {
    /// Programs that are run in a temporary folder.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn new(good: &Path, bad: &Path, profile: &str, timeout: Duration) -> std::io::Result<Self> {
        Ok(Self {
            good: good.into(),
            bad: bad.into(),
            profile: profile.into(),
            timeout,
            field: None,
            scratch: tempfile::tempdir()?,
            written: None,
        })
    }

    fn question(&mut self, candidate: &Candidate) -> Result<Question, ShrinkError> {
        let folder = self.scratch.path();
        let worlds = folder.join("worlds");
        let scene = folder.join("candidate.scene.json");
        output::write_scene(&scene, &candidate.scene)?;
        let known = self.written.as_ref();
        if !known.is_some_and(|known| Arc::ptr_eq(known, &candidate.records)) {
            output::write_world(&worlds.join(&candidate.scene.world), &candidate.records)?;
            self.written = Some(Arc::clone(&candidate.records));
        }
        Ok(Question {
            trace: scene,
            worlds,
            profile: self.profile.clone(),
            field: self.field.clone(),
            expected: Default::default(),
            timeout: self.timeout,
        })
    }

    /// Both traces; `None` if one of the programs does not run the candidate.
    fn traces(
        &self,
        question: &Question,
        checkpoints: bool,
    ) -> Result<Option<[PathBuf; 2]>, ShrinkError> {
        let traces = ["good.mcap", "bad.mcap"].map(|name| self.scratch.path().join(name));
        for (program, out) in [&self.good, &self.bad].into_iter().zip(&traces) {
            let ran = question.run(program, &self.profile, checkpoints, out)?;
            if ran.is_err() {
                return Ok(None);
            }
        }
        Ok(Some(traces))
    }
}

impl Judge for TwoPrograms {
    fn judge(
        &mut self,
        candidate: &Candidate,
        target: Option<&Target>,
    ) -> Result<Option<Shown>, ShrinkError> {
        let question = self.question(candidate)?;
        let Some([good, bad]) = self.traces(&question, false)? else {
            return Ok(None);
        };
        let expected = verdict::produced(&good)?;
        let Some(place) = question.first_difference(&expected, &verdict::produced(&bad)?) else {
            return Ok(None);
        };
        let field = fields::without_indices(&place.divergence.field);
        if target.is_some_and(|target| target.field != field) {
            return Ok(None);
        }
        let stage = match self.traces(&question, true)? {
            Some([good, bad]) => locate::locate(&good, &bad)?.stage.map(|stage| stage.stage),
            None => None,
        };
        let shown = Shown { place, stage };
        Ok(target
            .is_none_or(|target| target.is_met(&shown))
            .then_some(shown))
    }

    fn expectation(&mut self, candidate: &Candidate) -> Result<Vec<Frame>, ShrinkError> {
        let question = self.question(candidate)?;
        match self.traces(&question, false)? {
            Some([good, _]) => Ok(verdict::produced(&good)?),
            None => Err(ShrinkError::Nothing(
                "the good program does not run the shrunk scene".into(),
            )),
        }
    }

    fn field(&self) -> Option<&GlobMatcher> {
        self.field.as_ref()
    }
}
