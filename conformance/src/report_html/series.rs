//! What is kept of every frame while a scene runs, so that the report can draw it.

use ac_client::frame::{
    FrameState,
    state::{Fields, Outcome},
};

use crate::{
    compare::{fields, is_gone},
    run::Mode,
};

/// Side of a landblock, metres.
const BLOCK: f64 = 192.0;

/// Outcomes from the least to the most obstructed: what a slice of time shows is the last of these in it.
pub const BY_SEVERITY: [Outcome; 6] = [
    Outcome::None,
    Outcome::Ok,
    Outcome::Adjusted,
    Outcome::Slid,
    Outcome::Collided,
    Outcome::Failed,
];

/// Index into [`BY_SEVERITY`].
pub fn severity(outcome: Outcome) -> u8 {
    match outcome {
        Outcome::None => 0,
        Outcome::Ok => 1,
        Outcome::Adjusted => 2,
        Outcome::Slid => 3,
        Outcome::Collided => 4,
        Outcome::Failed => 5,
    }
}

/// One state, as far as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The frame; `-1` is the state after creation.
    pub frame: i32,
    /// Id of the cell, 0 for none.
    pub cell: u32,
    /// Worst outcome of the quanta of the frame, as [`severity`]; `None` without a quantum.
    pub outcome: Option<u8>,
    /// Position in metres from the south-west corner of the map; `None` without one.
    pub place: Option<[f64; 3]>,
}

impl Sample {
    /// What is drawn of a state.
    pub fn of(state: &FrameState) -> Self {
        let block = |shift: u32| f64::from(state.cell >> shift & 0xFF) * BLOCK;
        let [x, y, z] = state.origin.map(f64::from);
        let place = [x + block(24), y + block(16), z];
        let shown = state.has.contains(Fields::ORIGIN)
            && !is_gone(state)
            && place.iter().all(|number| number.is_finite());
        Self {
            frame: state.frame,
            cell: state.cell,
            outcome: state.steps.iter().map(|step| severity(step.outcome)).max(),
            place: shown.then_some(place),
        }
    }
}

/// The frames of one entity, compared with one oracle in one mode.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name of the scene.
    pub scene: String,
    /// Who expects.
    pub oracle: String,
    /// How it was compared.
    pub mode: Mode,
    /// The entity.
    pub guid: u32,
    /// Expected states.
    pub expected: Vec<Sample>,
    /// States of the client beside them; empty as long as all were drawn alike.
    pub actual: Vec<Option<Sample>>,
    /// Per numeric field, index of the frame in `expected` and absolute error (infinite for not-a-number).
    pub errors: Vec<(&'static str, Vec<(u32, f32)>)>,
}

impl Series {
    /// Nothing yet.
    pub fn new(scene: &str, oracle: &str, mode: Mode, guid: u32) -> Self {
        Self {
            scene: scene.into(),
            oracle: oracle.into(),
            mode,
            guid,
            expected: Vec::new(),
            actual: Vec::new(),
            errors: Vec::new(),
        }
    }

    /// Takes one frame; `exact`: the comparison found no difference in it.
    pub fn frame(&mut self, expected: &FrameState, actual: Option<&FrameState>, exact: bool) {
        let index = self.expected.len();
        let sample = Sample::of(expected);
        let found = actual.map(Sample::of);
        if self.actual.is_empty() && found != Some(sample) {
            self.actual = self.expected.iter().copied().map(Some).collect();
        }
        if !self.actual.is_empty() || found != Some(sample) {
            self.actual.push(found);
        }
        self.expected.push(sample);
        if let Some(actual) = actual.filter(|_| !exact) {
            self.errors_of(u32::try_from(index).unwrap_or(u32::MAX), expected, actual);
        }
    }

    #[cold]
    fn errors_of(&mut self, index: u32, expected: &FrameState, actual: &FrameState) {
        fields::differences(expected, actual, &mut |difference| {
            let Some(error) = difference.error else {
                return;
            };
            let abs = error.abs as f32;
            let place = self
                .errors
                .iter()
                .position(|(field, _)| *field == difference.field)
                .unwrap_or_else(|| {
                    self.errors.push((difference.field, Vec::new()));
                    self.errors.len() - 1
                });
            let points = &mut self.errors[place].1;
            match points.last_mut().filter(|(last, _)| *last == index) {
                Some((_, max)) => *max = max.max(abs),
                None => points.push((index, abs)),
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(frame: i32, x: f32) -> FrameState {
        FrameState {
            has: Fields::ORIGIN,
            frame,
            cell: 0x0102_0001,
            origin: [x, 2.0, 3.0],
            ..FrameState::default()
        }
    }

    #[test]
    fn the_clients_states_are_kept_from_the_first_difference_on() {
        let mut series = Series::new("a/b", "ace", Mode::Free, 1);
        series.frame(&state(0, 1.0), Some(&state(0, 1.0)), true);
        assert!(series.actual.is_empty());
        series.frame(&state(1, 1.0), Some(&state(1, 1.5)), false);
        series.frame(&state(2, 1.0), None, false);
        assert_eq!(series.actual.len(), series.expected.len());
        assert_eq!(series.expected[0].place, Some([193.0, 386.0, 3.0]));
        assert_eq!(series.errors, [("origin", vec![(1, 0.5)])]);
    }

    #[test]
    fn severity_is_the_place_in_the_list() {
        for (index, outcome) in BY_SEVERITY.into_iter().enumerate() {
            assert_eq!(usize::from(severity(outcome)), index);
        }
    }

    #[test]
    fn a_state_that_is_not_finite_has_no_place() {
        assert_eq!(Sample::of(&state(0, f32::NAN)).place, None);
    }
}
