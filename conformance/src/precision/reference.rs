//! What the smooth phases converge to: the step of `spec/06-physics-object.md`, B6 in f64, Richardson extrapolation, and solutions in closed form.
//!
//! Smooth is: free flight under constant acceleration, sliding to a stop on a plane, turning with constant omega. Within them nothing is
//! decided, so the step can be refined at will. The thresholds of B6 (rest below 0.25 m/s, the limit of 50 m/s, the turn that is too small) are
//! left out on purpose: they are what a phase must not reach, and where a run reaches one the difference is the finding.

/// Position, velocity, orientation `[w, x, y, z]`; metres, seconds, world axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// m.
    pub place: [f64; 3],
    /// m/s.
    pub velocity: [f64; 3],
    /// Unit quaternion.
    pub rotation: [f64; 4],
}

/// What acts during a phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forces {
    /// m/s².
    pub acceleration: [f64; 3],
    /// rad/s.
    pub omega: [f64; 3],
    /// Share of the velocity that is left after one second (1 − friction); `None` in the air.
    pub kept: Option<f64>,
}

impl Forces {
    /// Nothing acts.
    pub const NONE: Self = Self {
        acceleration: [0.0; 3],
        omega: [0.0; 3],
        kept: None,
    };
}

/// `a + b·s`.
fn plus(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + b[i] * s)
}

/// Distance of two points.
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = plus(a, b, -1.0);
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

/// Angle between two orientations, rad; either sign of a quaternion is the same orientation.
pub fn angle(a: [f64; 4], b: [f64; 4]) -> f64 {
    let length = |q: [f64; 4]| q.iter().map(|c| c * c).sum::<f64>().sqrt();
    let (la, lb) = (length(a), length(b));
    let sign = if a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>() < 0.0 {
        -1.0
    } else {
        1.0
    };
    // By the chord: an arc cosine near 1 loses half the digits.
    let chord = (0..4)
        .map(|i| (a[i] / la - sign * b[i] / lb).powi(2))
        .sum::<f64>()
        .sqrt();
    4.0 * (chord / 2.0).min(1.0).asin()
}

/// Turns an orientation about a vector in world axes: by its length, rad (01, 8.3).
fn turned(q: [f64; 4], by: [f64; 3]) -> [f64; 4] {
    let angle = (by[0] * by[0] + by[1] * by[1] + by[2] * by[2]).sqrt();
    if angle == 0.0 {
        return q;
    }
    let (s, c) = (angle / 2.0).sin_cos();
    let [w, x, y, z] = [c, by[0] / angle * s, by[1] / angle * s, by[2] / angle * s];
    [
        w * q[0] - x * q[1] - y * q[2] - z * q[3],
        w * q[1] + x * q[0] + y * q[3] - z * q[2],
        w * q[2] - x * q[3] + y * q[0] + z * q[1],
        w * q[3] + x * q[2] - y * q[1] + z * q[0],
    ]
}

/// One step of `h` s: friction, translation with the new velocity, then acceleration, then rotation (06, B6 and B7).
pub fn step(mut motion: Motion, forces: &Forces, h: f64) -> Motion {
    if let Some(kept) = forces.kept {
        motion.velocity = motion.velocity.map(|v| v * kept.powf(h));
    }
    motion.place = plus(motion.place, forces.acceleration, 0.5 * h * h);
    motion.place = plus(motion.place, motion.velocity, h);
    motion.velocity = plus(motion.velocity, forces.acceleration, h);
    motion.rotation = turned(motion.rotation, forces.omega.map(|w| w * h));
    motion
}

/// `steps` equal steps over `seconds`.
pub fn integrate(motion: Motion, forces: &Forces, seconds: f64, steps: u32) -> Motion {
    let h = seconds / f64::from(steps);
    (0..steps).fold(motion, |motion, _| step(motion, forces, h))
}

/// The solution in closed form, where there is one: friction and acceleration do not act together in the client, because ground that slows
/// also takes the acceleration away (B7).
pub fn solution(motion: Motion, forces: &Forces, t: f64) -> Motion {
    let Some(kept) = forces.kept else {
        let place = plus(motion.place, motion.velocity, t);
        return Motion {
            place: plus(place, forces.acceleration, 0.5 * t * t),
            velocity: plus(motion.velocity, forces.acceleration, t),
            rotation: turned(motion.rotation, forces.omega.map(|w| w * t)),
        };
    };
    let way = if kept == 1.0 {
        t
    } else {
        (kept.powf(t) - 1.0) / kept.ln()
    };
    Motion {
        place: plus(motion.place, motion.velocity, way),
        velocity: motion.velocity.map(|v| v * kept.powf(t)),
        rotation: turned(motion.rotation, forces.omega.map(|w| w * t)),
    }
}

/// What small steps converge to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converged {
    /// The extrapolated place, m.
    pub place: [f64; 3],
    /// Observed order of the step; `None` where the step is exact, so that halving changes nothing but rounding.
    pub order: Option<f64>,
    /// How far the extrapolation may be off, m.
    pub uncertainty: f64,
}

/// Below this, m, a difference is rounding.
const ROUNDING: f64 = 1e-9;

/// Extrapolates the place after `seconds` from `steps`, twice and four times as many steps.
pub fn richardson(motion: Motion, forces: &Forces, seconds: f64, steps: u32) -> Converged {
    let [coarse, middle, fine] =
        [1, 2, 4].map(|factor| integrate(motion, forces, seconds, steps * factor).place);
    let (first, second) = (distance(coarse, middle), distance(middle, fine));
    if first < ROUNDING {
        return Converged {
            place: fine,
            order: None,
            uncertainty: first,
        };
    }
    let order = (first / second).log2();
    let place = plus(fine, plus(fine, middle, -1.0), 1.0 / (order.exp2() - 1.0));
    Converged {
        place,
        order: Some(order),
        // The next term of the error is one order higher.
        uncertainty: distance(place, fine) * seconds / f64::from(steps),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Motion = Motion {
        place: [1.0, 2.0, 300.0],
        velocity: [5.0, -3.0, 8.0],
        rotation: [1.0, 0.0, 0.0, 0.0],
    };

    #[test]
    fn the_step_is_exact_in_free_flight() {
        let forces = Forces {
            acceleration: [0.0, 0.0, -9.8],
            ..Forces::NONE
        };
        let exact = solution(START, &forces, 4.0);
        for steps in [1, 7, 120, 3840] {
            let found = integrate(START, &forces, 4.0, steps);
            assert!(distance(found.place, exact.place) < 1e-9, "{steps}");
        }
        assert_eq!(richardson(START, &forces, 4.0, 20).order, None);
    }

    #[test]
    fn the_step_is_of_first_order_under_friction() {
        let forces = Forces {
            kept: Some(0.8),
            ..Forces::NONE
        };
        let found = richardson(START, &forces, 6.0, 400);
        let order = found.order.unwrap();
        assert!((order - 1.0).abs() < 0.01, "{order}");
        let exact = solution(START, &forces, 6.0);
        assert!(distance(found.place, exact.place) < 1e-5);
        assert!(distance(found.place, exact.place) <= found.uncertainty);
    }

    #[test]
    fn turning_is_exact_for_constant_omega() {
        let forces = Forces {
            omega: [0.3, -0.2, 1.0],
            ..Forces::NONE
        };
        let exact = solution(START, &forces, 10.0);
        let found = integrate(START, &forces, 10.0, 300);
        assert!(angle(found.rotation, exact.rotation) < 1e-9);
    }

    #[test]
    fn angles_of_near_orientations_keep_their_digits() {
        let turn = 1e-7_f64;
        let q = [(turn / 2.0).cos(), 0.0, 0.0, (turn / 2.0).sin()];
        assert!((angle(q, [1.0, 0.0, 0.0, 0.0]) / turn - 1.0).abs() < 1e-6);
        assert!((angle([-1.0, 0.0, 0.0, 0.0], q) / turn - 1.0).abs() < 1e-6);
    }
}
