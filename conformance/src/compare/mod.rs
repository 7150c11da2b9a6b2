//! Comparing produced states with expected ones.
//!
//! A field is exact when it has the same bits, sign of zero included. A field that the expectation does not carry is left out;
//! one that it carries and the simulation does not is a difference, and so is a value where null is expected. Where an
//! oracle's own value is not finite, equality says nothing about the retail client: such frames are counted apart
//! ([`Comparison::undefined`]) instead of passing silently.
//!
//! The usual case, everything equal, costs a few dozen integer comparisons and no text ([`FrameState::fields_same_bits`]).
//! Only a frame that differs is looked at field by field ([`fields`]).

pub mod error;
pub mod fields;
pub mod policy;

use std::{collections::BTreeMap, sync::Arc};

use ac_client::frame::{
    FrameState,
    state::{Fields, Outcome},
};
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use error::{Class, MaxError};

/// The result of comparing one entity of one scene with one oracle in one mode.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// Frames (in stage mode: stage records) with an expectation.
    pub frames_compared: u64,
    /// Of these, with the same bits everywhere.
    pub frames_exact: u64,
    /// Of these, with a value that is not finite in the expectation.
    pub undefined: u64,
    /// Stage records that the client cannot run alone: they are neither compared nor counted above.
    pub not_run: u64,
    /// The first difference that no rule tolerates.
    pub first_divergence: Option<Divergence>,
    /// Largest error of each numeric field that differs anywhere.
    pub max_error: BTreeMap<String, MaxError>,
    /// Something differs that is no number: an id, an outcome, an event, presence.
    pub structural: bool,
    /// What may differ; nothing when empty. The first rule that names a field decides.
    pub rules: Vec<Arc<policy::Rule>>,
    /// Differences within a rule's bound: how many, by the rule's title.
    pub tolerated: BTreeMap<String, u64>,
}

/// A place where expectation and simulation part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Divergence {
    /// The frame.
    pub frame: i32,
    /// The stage, when it is known.
    pub stage: Option<String>,
    /// Path of the field, e.g. `contact_plane.n[2]`.
    pub field: String,
    /// Value of the expectation.
    pub expected: Value,
    /// Value of the simulation; null also when it has none.
    pub actual: Value,
}

impl Comparison {
    /// Compares one frame; `actual` is `None` when the simulation wrote no record.
    pub fn frame(&mut self, expected: &FrameState, actual: Option<&FrameState>) {
        self.frames_compared += 1;
        let undefined = has_undefined(expected);
        self.undefined += u64::from(undefined);
        let Some(actual) = actual else {
            return self.differ(
                expected.frame,
                None,
                "record".into(),
                "present".into(),
                "missing".into(),
            );
        };
        let same = actual.has.contains(expected.has)
            && expected.time.to_bits() == actual.time.to_bits()
            && expected.fields_same_bits(actual, expected.has)
            && is_gone(expected) == is_gone(actual);
        if same {
            self.frames_exact += 1;
            return;
        }
        self.differing_frame(expected, actual);
    }

    /// A frame whose bits are not all the same: not-a-number in both is still the same.
    #[cold]
    fn differing_frame(&mut self, expected: &FrameState, actual: &FrameState) {
        let mut exact = true;
        let vectors = self.vectors(expected, actual);
        fields::differences(expected, actual, &mut |difference| {
            exact = false;
            if vectors.contains(&difference.field) && difference.error.is_some() {
                return;
            }
            if let Some(rule) = policy::rule_of(&self.rules, difference.field)
                && rule.bound.tolerates(difference)
            {
                *self.tolerated.entry(rule.title()).or_default() += 1;
                if let Some(error) = difference.error {
                    self.error(difference.field, expected.frame, error, difference.unit);
                }
                return;
            }
            match difference.error {
                Some(error) => self.error(difference.field, expected.frame, error, difference.unit),
                None => self.structural = true,
            }
            if self.first_divergence.is_none() {
                let (expected_value, actual_value) = (difference.values)();
                self.first_divergence = Some(Divergence {
                    frame: expected.frame,
                    stage: None,
                    field: difference.path(),
                    expected: expected_value,
                    actual: actual_value,
                });
            }
        });
        self.frames_exact += u64::from(exact);
    }

    /// The vectors that a rule bounds as a whole and that are within that bound: their parts are not looked at.
    fn vectors(&mut self, expected: &FrameState, actual: &FrameState) -> Vec<&'static str> {
        let mut within = Vec::new();
        for (name, field) in [("origin", Fields::ORIGIN), ("rotation", Fields::ROTATION)] {
            let Some(rule) = policy::rule_of(&self.rules, name) else {
                continue;
            };
            if !(expected.has & actual.has).contains(field) {
                continue;
            }
            let (abs, bound, measured, unit) = match rule.bound {
                policy::Bound::Angle(bound) => (
                    policy::angle(expected.rotation, actual.rotation),
                    bound,
                    "rotation (angle)",
                    "rad",
                ),
                policy::Bound::Distance(bound) => (
                    fields::distance(expected, actual),
                    bound,
                    "origin (distance)",
                    "m",
                ),
                _ => continue,
            };
            let same = match field {
                Fields::ORIGIN => {
                    expected.origin.map(f32::to_bits) == actual.origin.map(f32::to_bits)
                        && abs == 0.0
                }
                _ => expected.rotation.map(f32::to_bits) == actual.rotation.map(f32::to_bits),
            };
            // Written so that not-a-number is not within the bound.
            if !same && abs <= bound {
                within.push(name);
                *self.tolerated.entry(rule.title()).or_default() += 1;
                self.error(measured, expected.frame, error::Error { abs, ulp: 0 }, unit);
            }
        }
        within
    }

    /// Compares one stage record's `out` with the actual one; `None`, when the client cannot run the stage alone, is left out
    /// and counted.
    pub fn stage(&mut self, frame: i32, stage: &str, expected: &Value, actual: Option<&Value>) {
        let Some(actual) = actual else {
            self.not_run += 1;
            return;
        };
        self.frames_compared += 1;
        let mut exact = true;
        fields::value_differences(
            "out",
            expected,
            Some(actual),
            &mut |path, expected, actual| {
                exact = false;
                let error = actual.and_then(|actual| error::between_values(expected, actual));
                let field = format!("{stage}.{}", fields::without_indices(path));
                let values = || (expected.clone(), actual.cloned().unwrap_or(Value::Null));
                if let Some(rule) = policy::rule_of(&self.rules, &field)
                    && rule.bound.holds(error, values)
                {
                    *self.tolerated.entry(rule.title()).or_default() += 1;
                    if let Some(error) = error {
                        self.error(&field, frame, error, "");
                    }
                    return;
                }
                match error {
                    Some(error) => self.error(&field, frame, error, ""),
                    None => self.structural = true,
                }
                if self.first_divergence.is_none() {
                    self.first_divergence = Some(Divergence {
                        frame,
                        stage: Some(stage.into()),
                        field: path.into(),
                        expected: expected.clone(),
                        actual: actual.cloned().unwrap_or(Value::Null),
                    });
                }
            },
        );
        self.frames_exact += u64::from(exact);
    }

    fn differ(
        &mut self,
        frame: i32,
        stage: Option<&str>,
        field: String,
        expected: Value,
        actual: Value,
    ) {
        self.structural = true;
        self.first_divergence.get_or_insert_with(|| Divergence {
            frame,
            stage: stage.map(Into::into),
            field,
            expected,
            actual,
        });
    }

    fn error(&mut self, field: &str, frame: i32, error: error::Error, unit: &'static str) {
        match self.max_error.get_mut(field) {
            Some(max) => max.include(frame, error),
            None => {
                self.max_error
                    .insert(field.into(), MaxError::new(frame, error, unit));
            }
        }
    }

    /// Exact, within tolerance, or diverged.
    pub fn class(&self) -> Class {
        if self.first_divergence.is_some() {
            Class::Diverged
        } else if self.tolerated.is_empty() {
            Class::Exact
        } else {
            Class::WithinTolerance
        }
    }
}

/// Whether this is the short record of an entity that is gone (or not there yet).
pub fn is_gone(state: &FrameState) -> bool {
    state.cell == 0 && Fields::GONE.contains(state.has)
}

/// Whether any number that the record carries is not finite.
fn has_undefined(state: &FrameState) -> bool {
    let has = |field| state.has.contains(field);
    let bad = |numbers: &[f32]| numbers.iter().any(|number| !number.is_finite());
    has(Fields::ORIGIN) && bad(&state.origin)
        || has(Fields::ROTATION) && bad(&state.rotation)
        || has(Fields::VELOCITY) && bad(&state.velocity)
        || has(Fields::ACCELERATION) && bad(&state.acceleration)
        || has(Fields::OMEGA) && bad(&state.omega)
        || state
            .contact_plane
            .is_some_and(|plane| bad(&plane.n) || !plane.d.is_finite())
        || state.sliding_normal.is_some_and(|normal| bad(&normal))
        || state.anim.as_ref().is_some_and(|anim| {
            !anim.frame_number.is_finite() || bad(&anim.velocity) || bad(&anim.omega)
        })
}

/// The name of an outcome as JSON.
fn outcome(outcome: Outcome) -> Value {
    outcome.name().into()
}

#[cfg(test)]
mod tests;
