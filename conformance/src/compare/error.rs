//! How far apart two numbers are.

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use crate::vectors::json;

/// Distance of two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Error {
    /// Absolute difference, in the field's unit.
    pub abs: f64,
    /// Number of floats between them.
    pub ulp: u64,
}

/// The largest distance of a field over all frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaxError {
    /// Largest absolute difference, in the field's unit. Infinite where one of the numbers is not finite; JSON has null there.
    #[serde(deserialize_with = "or_infinite")]
    pub abs: f64,
    /// Largest number of floats (of the field's width) between the two.
    pub ulp: u64,
    /// The frame in which `abs` was reached first.
    pub frame: i32,
    /// Unit of `abs`.
    #[serde(skip)]
    pub unit: &'static str,
}

fn or_infinite<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
}

/// How well two runs agree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Same bits.
    #[default]
    Exact,
    /// Everything that differs is within the bound of a policy's rule.
    WithinTolerance,
    /// More than that.
    Diverged,
}

impl MaxError {
    pub(super) fn new(frame: i32, error: Error, unit: &'static str) -> Self {
        Self {
            abs: error.abs,
            ulp: error.ulp,
            frame,
            unit,
        }
    }

    pub(super) fn include(&mut self, frame: i32, error: Error) {
        self.ulp = self.ulp.max(error.ulp);
        if error.abs > self.abs {
            self.abs = error.abs;
            self.frame = frame;
        }
    }
}

/// Distance of two floats that have different bits.
pub fn between(expected: f32, actual: f32) -> Error {
    Error {
        abs: distance(expected.into(), actual.into()),
        ulp: ordered(expected).abs_diff(ordered(actual)).into(),
    }
}

/// Distance of two doubles that have different bits.
pub fn between_doubles(expected: f64, actual: f64) -> Error {
    Error {
        abs: distance(expected, actual),
        ulp: ordered_double(expected).abs_diff(ordered_double(actual)),
    }
}

/// Distance of two numbers in JSON, counted in f32 when both are f32 widened.
pub fn between_values(expected: &Value, actual: &Value) -> Option<Error> {
    let (expected, actual) = (json::f64(expected)?, json::f64(actual)?);
    let narrow = |number: f64| f64::from(number as f32).to_bits() == number.to_bits();
    Some(if narrow(expected) && narrow(actual) {
        between(expected as f32, actual as f32)
    } else {
        between_doubles(expected, actual)
    })
}

fn distance(expected: f64, actual: f64) -> f64 {
    let distance = (expected - actual).abs();
    if distance.is_nan() {
        f64::INFINITY
    } else {
        distance
    }
}

/// Maps floats to integers in the same order, neighbours to neighbours; -0 lies next to +0.
fn ordered(number: f32) -> i32 {
    let bits = number.to_bits().cast_signed();
    if bits < 0 {
        i32::MIN.wrapping_sub(bits).wrapping_sub(1)
    } else {
        bits
    }
}

fn ordered_double(number: f64) -> i64 {
    let bits = number.to_bits().cast_signed();
    if bits < 0 {
        i64::MIN.wrapping_sub(bits).wrapping_sub(1)
    } else {
        bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_one_apart() {
        for number in [0.0f32, 1.0, -1.0, 1e-40, f32::MAX, -f32::MIN_POSITIVE] {
            assert_eq!(between(number, number.next_up()).ulp, 1, "{number}");
        }
        assert_eq!(between(0.0, -0.0), Error { abs: 0.0, ulp: 1 });
        assert_eq!(between_doubles(1.0, 1.0f64.next_down()).ulp, 1);
        assert_eq!(between(1.0, f32::NAN).abs, f64::INFINITY);
    }

    #[test]
    fn the_frame_is_that_of_the_largest_error() {
        let mut max = MaxError::new(3, between(1.0, 1.5), "m");
        max.include(4, between(1.0, 2.0));
        max.include(5, between(1.0, 2.0));
        assert_eq!((max.abs, max.frame), (1.0, 4));
    }
}
