//! Vector helpers with the engine's one tolerance (`spec/01`, section 5).

use super::Vec3;
use crate::profile::{Normalize, Profile};

/// The one tolerance of the engine: 0.0002 m (or whatever is compared).
pub const EPSILON: f32 = 0.0002;

/// Whether no component is NaN. Infinities are valid.
pub fn is_valid(v: Vec3) -> bool {
    !(v.x.is_nan() || v.y.is_nan() || v.z.is_nan())
}

/// Whether every component is within [`EPSILON`] of zero (strictly).
pub fn is_zero(v: Vec3) -> bool {
    v.x.abs() < EPSILON && v.y.abs() < EPSILON && v.z.abs() < EPSILON
}

/// Whether two scalars differ by less than [`EPSILON`]. A NaN difference is not equal, except where the profile says so (`01:F16`).
pub fn near(a: f32, b: f32, profile: &Profile) -> bool {
    let difference = (a - b).abs();
    if profile.nan_is_equal {
        let apart = difference >= EPSILON;
        !apart
    } else {
        difference < EPSILON
    }
}

/// Whether two vectors differ by less than [`EPSILON`] in every component.
pub fn is_equal(a: Vec3, b: Vec3, profile: &Profile) -> bool {
    near(a.x, b.x, profile) && near(a.y, b.y, profile) && near(a.z, b.z, profile)
}

/// Unit vector of `v`; NaN for the zero vector (`01:V1` for the arithmetic).
pub fn normalize(v: Vec3, profile: &Profile) -> Vec3 {
    let length = v.length();
    match profile.normalize {
        Normalize::Reciprocal => v * (1.0 / length),
        Normalize::Division => Vec3::new(v.x / length, v.y / length, v.z / length),
    }
}

/// Unit vector of `v`, or `None` if `v` is shorter than [`EPSILON`] (`normalize_check_small` answered "too small").
///
/// A NaN length is not small: the result is then NaN.
pub fn normalize_check_small(v: Vec3) -> Option<Vec3> {
    let length = v.length();
    if length < EPSILON {
        None
    } else {
        Some(v * (1.0 / length))
    }
}

/// Dot product of the horizontal components.
pub fn dot2d(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y
}
