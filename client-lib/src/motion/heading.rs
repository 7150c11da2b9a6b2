//! Differences of compass headings, as turns judge them (`spec/08-motion.md`, 3.2 and 3.3).

use super::Command;
use crate::math::EPSILON;
use crate::profile::{HeadingArithmetic, Profile};

/// `h1 − h2` in the sense of the turn `command`: [0, 360) for a right turn, 0 or (0, 360] for anything else.
///
/// A difference of exactly −ε passes unchanged. Profile `gdle` narrows only once (`D3`).
pub fn heading_diff(h1: f32, h2: f32, command: Command, profile: &Profile) -> f32 {
    let right = command == Command::TURN_RIGHT;
    match profile.heading_arithmetic {
        HeadingArithmetic::F64Factor => {
            let mut d = h1 - h2;
            if d.abs() < EPSILON {
                d = 0.0;
            }
            if d < -EPSILON {
                d += 360.0;
            }
            if d > EPSILON && !right {
                d = 360.0 - d;
            }
            d
        }
        HeadingArithmetic::F32Factor => {
            let epsilon = f64::from(EPSILON);
            let mut d = f64::from(h1 - h2);
            if d.abs() < epsilon {
                d = 0.0;
            }
            if d < -epsilon {
                d += 360.0;
            }
            if d > epsilon && !right {
                d = 360.0 - d;
            }
            d as f32
        }
    }
}

/// Whether a turn by `command` from somewhere has passed `h2` at heading `h1`.
///
/// There is no memory of the start: an overshoot of half a circle or more counts as not yet there.
pub fn heading_greater(h1: f32, h2: f32, command: Command) -> bool {
    let greater = if (h1 - h2).abs() <= 180.0 {
        h1 > h2
    } else {
        h2 > h1
    };
    if command == Command::TURN_RIGHT {
        greater
    } else {
        !greater
    }
}

/// A difference of two headings folded into [0, 360): tiny ones are 0, negative ones gain a circle (11.3, 11.10).
pub(super) fn fold(d: f32) -> f32 {
    if d.abs() < EPSILON {
        0.0
    } else if d < -EPSILON {
        d + 360.0
    } else {
        d
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const R: Command = Command::TURN_RIGHT;
    const L: Command = Command::TURN_LEFT;

    #[test]
    fn seam_and_half_circle() {
        let p = Profile::retail();
        assert_eq!(heading_diff(359.999_95, 0.0, R, &p), 359.999_94);
        assert_eq!(heading_diff(0.0001, 0.0, R, &p), 0.0);
        assert_eq!(heading_diff(180.0, 0.0, R, &p), 180.0);
        assert_eq!(heading_diff(0.0, EPSILON, R, &p), -EPSILON);
        assert!(!heading_greater(350.0, 10.0, R));
        assert!(!heading_greater(9.99, 10.0, R));
        assert!(heading_greater(10.01, 10.0, R));
        assert!(heading_greater(10.0, 10.0, L));
        assert!(!heading_greater(10.0, 10.0, R));
    }

    proptest! {
        #[test]
        fn differences(a in 0.0f32..360.0, b in 0.0f32..360.0) {
            for p in [Profile::retail(), Profile::gdle()] {
                prop_assert_eq!(heading_diff(a, a, R, &p), 0.0);
                prop_assert_eq!(heading_diff(a, a, L, &p), 0.0);
                if (a - b).abs() != EPSILON {
                    let sum = heading_diff(a, b, R, &p) + heading_diff(a, b, L, &p);
                    prop_assert!(sum == 0.0 || (sum - 360.0).abs() <= 3.1e-5, "{}", sum);
                }
            }
            prop_assert_eq!(heading_greater(a, b, R), !heading_greater(a, b, L));
        }
    }
}
