//! The library beside what an oracle recorded.

use ac_client::{frame::FrameStates, profile::Profile};
use ac_golden_traces::trace::rewrite::Frame;
use globset::GlobMatcher;

use super::{Judge, Shown, Side, Target, TwoProfiles, frames, same};
use crate::{
    bisect::verdict,
    shrink::{Candidate, ShrinkError},
};

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
