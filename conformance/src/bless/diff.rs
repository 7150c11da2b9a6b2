//! What differs between two runs of a scene, field by field.

use std::collections::BTreeMap;

use ac_client::frame::{FrameState, FrameStates};
use ac_golden_traces::trace::rewrite::Frame;
use serde_json::Value;

use crate::compare::{error::Error, fields};

/// Differences listed of one frame of one entity.
const LISTED: usize = 8;

/// Everything that differs.
#[derive(Clone, Debug, Default)]
pub struct Difference {
    /// Frames of the new run.
    pub frames: usize,
    /// Of these, with a difference.
    pub changed: usize,
    /// Frames of the old expectation that the new run does not have.
    pub gone: usize,
    /// The fields that differ, by name.
    pub fields: BTreeMap<String, FieldChange>,
    /// The first frame that differs, the one with the largest difference of `origin` (or, without one, of anything), and the last.
    pub samples: Vec<Sample>,
}

/// One field over all frames.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldChange {
    /// Records in which it differs.
    pub count: usize,
    /// The first frame in which it differs.
    pub first: i32,
    /// Its largest change: frame, entity, path of the field, old and new value, and the distance where they are numbers.
    pub largest: Place,
}

/// A value that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The frame.
    pub frame: i32,
    /// The entity.
    pub guid: u32,
    /// Path of the field.
    pub path: String,
    /// In the old expectation.
    pub old: Value,
    /// In the new run.
    pub new: Value,
    /// Absolute difference, in `unit`; `None` for what is no number.
    pub abs: Option<f64>,
    /// Unit of `abs`.
    pub unit: &'static str,
}

/// One frame that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The frame.
    pub frame: i32,
    /// The differences in it, as far as they are listed.
    pub places: Vec<Place>,
    /// Those that are not.
    pub more: usize,
}

impl Difference {
    /// Compares a new run with the old expectation.
    pub fn between(old: &[Frame], new: &[Frame]) -> Self {
        let before: BTreeMap<i32, &FrameStates> = old
            .iter()
            .map(|(frame, _, states)| (*frame, states))
            .collect();
        let mut difference = Self {
            frames: new.len(),
            gone: old
                .iter()
                .filter(|(frame, ..)| !new.iter().any(|(of, ..)| of == frame))
                .count(),
            ..Self::default()
        };
        if old.is_empty() {
            return difference;
        }
        let mut changed: Vec<(Sample, f64)> = Vec::new();
        for (frame, _, states) in new {
            let places = places(*frame, before.get(frame).copied(), states);
            if !places.is_empty() {
                difference.take(&places);
                let size = size(&places);
                let sample = sample(*frame, places);
                keep(&mut changed, sample, size);
            }
        }
        difference.samples = changed.into_iter().map(|(sample, _)| sample).collect();
        difference.samples.dedup();
        difference
    }

    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        self.changed == 0 && self.gone == 0
    }

    fn take(&mut self, places: &[Place]) {
        self.changed += 1;
        for place in places {
            let name = fields::without_indices(&place.path);
            match self.fields.get_mut(&name) {
                None => {
                    let change = FieldChange {
                        count: 1,
                        first: place.frame,
                        largest: place.clone(),
                    };
                    self.fields.insert(name, change);
                }
                Some(change) => {
                    change.count += 1;
                    if place.abs > change.largest.abs {
                        change.largest = place.clone();
                    }
                }
            }
        }
    }
}

/// Keeps the first, the largest and the last of the frames that differ.
fn keep(kept: &mut Vec<(Sample, f64)>, sample: Sample, size: f64) {
    match &mut kept[..] {
        [] => {
            kept.push((sample.clone(), size));
            kept.push((sample.clone(), size));
            kept.push((sample, size));
        }
        [_, largest, last] => {
            if size > largest.1 {
                *largest = (sample.clone(), size);
            }
            *last = (sample, size);
        }
        _ => {}
    }
}

/// How much a frame differs: by the position if that does, else by anything that is a number.
fn size(places: &[Place]) -> f64 {
    let largest = |wanted: &dyn Fn(&Place) -> bool| {
        let of = places.iter().filter(|place| wanted(place));
        of.filter_map(|place| place.abs).fold(0.0, f64::max)
    };
    let origin = largest(&|place| place.path.starts_with("origin"));
    // A position that differs counts more than any other number.
    if origin > 0.0 {
        1e6 + origin
    } else {
        largest(&|_| true).min(1e6)
    }
}

fn sample(frame: i32, mut places: Vec<Place>) -> Sample {
    let more = places.len().saturating_sub(LISTED);
    places.truncate(LISTED);
    Sample {
        frame,
        places,
        more,
    }
}

/// Everything that differs in a frame.
fn places(frame: i32, old: Option<&FrameStates>, new: &FrameStates) -> Vec<Place> {
    let mut places = Vec::new();
    let missing = |guid, old: &str, new: &str| Place {
        frame,
        guid,
        path: "record".into(),
        old: old.into(),
        new: new.into(),
        abs: None,
        unit: "",
    };
    for state in new.iter() {
        match old.and_then(|old| old.of(state.guid)) {
            Some(before) => record(frame, before, state, &mut places),
            None => places.push(missing(state.guid, "missing", "present")),
        }
    }
    for state in old.into_iter().flat_map(|old| old.iter()) {
        if new.of(state.guid).is_none() {
            places.push(missing(state.guid, "present", "missing"));
        }
    }
    places
}

fn record(frame: i32, old: &FrameState, new: &FrameState, places: &mut Vec<Place>) {
    let before = places.len();
    fields::differences(old, new, &mut |difference| {
        let (old_value, new_value) = (difference.values)();
        places.push(Place {
            frame,
            guid: new.guid,
            path: difference.path(),
            old: old_value,
            new: new_value,
            abs: difference.error.map(|Error { abs, .. }| abs),
            unit: difference.unit,
        });
    });
    // The comparison leaves out what the expectation does not carry; an expectation that is written anew carries it.
    if places.len() == before && !old.has.contains(new.has) {
        places.push(Place {
            frame,
            guid: new.guid,
            path: "fields".into(),
            old: names(old).into(),
            new: names(new).into(),
            abs: None,
            unit: "",
        });
    }
}

/// Names of the fields that a record carries.
fn names(state: &FrameState) -> String {
    let names: Vec<String> = state
        .has
        .iter_names()
        .map(|(name, _)| name.to_lowercase())
        .collect();
    names.join(" ")
}
