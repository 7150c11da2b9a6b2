//! Two profiles of the library.

use ac_client::{frame::FrameStates, profile::Profile};
use ac_golden_traces::trace::rewrite::Frame;
use globset::GlobMatcher;

use super::{Judge, Shown, Side, Target, frames, same};
use crate::{
    bisect::{
        locate::{self, StageDifference},
        verdict::{self, Place},
    },
    compare::fields,
    shrink::{Candidate, ShrinkError},
};

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
    pub(super) fn stage(
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
