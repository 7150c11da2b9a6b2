//! Smooth phases of a run, and how far the client strays from what they converge to.
//!
//! A phase is found in the samples themselves: in the air while velocity changes by nothing but the acceleration, or on one plane while it
//! only shrinks by friction. Whatever else happens (an input, a contact, a landing) ends it.

use super::{
    reference::{Forces, Motion, distance, richardson, solution},
    track::Sample,
};

/// A phase of fewer samples says little.
const LEAST: usize = 8;
/// Speed² at which the rest rule of B6 takes over, with room, m²/s².
const REST: f64 = 0.07;
/// How exactly a change of velocity must be explained, m/s.
const EXPLAINED: f64 = 2e-3;

/// The worst phase of some tracks.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SmoothError {
    /// Largest distance from the reference at the end of a phase, m.
    pub max: f64,
    /// Phases found.
    pub phases: u32,
    /// Seconds in them.
    pub seconds: f64,
    /// What extrapolation and solution in closed form disagree by, m.
    pub uncertainty: f64,
}

/// Looks for phases and compares the end of each with f64; `friction` as the entity has it. `None` without a phase.
pub fn worst(samples: &[Sample], friction: f64) -> Option<SmoothError> {
    let mut found: Option<SmoothError> = None;
    let mut first = 0;
    while first + LEAST < samples.len() {
        let forces = forces(&samples[first], friction);
        let mut last = first;
        while samples
            .get(last + 1)
            .is_some_and(|next| follows(&samples[last], next, &forces))
        {
            last += 1;
        }
        if last - first >= LEAST {
            let phase = error(&samples[first], &samples[last], &forces);
            found = Some(match found {
                None => phase,
                Some(sum) => SmoothError {
                    max: sum.max.max(phase.max),
                    phases: sum.phases + 1,
                    seconds: sum.seconds + phase.seconds,
                    uncertainty: sum.uncertainty.max(phase.uncertainty),
                },
            });
        }
        first = last.max(first + 1);
    }
    found
}

fn forces(sample: &Sample, friction: f64) -> Forces {
    Forces {
        acceleration: sample.acceleration,
        omega: sample.omega,
        kept: sample.ground.map(|_| 1.0 - friction),
    }
}

/// Whether `next` is what the forces alone make of `last`.
fn follows(last: &Sample, next: &Sample, forces: &Forces) -> bool {
    let dt = next.time - last.time;
    let squared = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>();
    let kept = forces.kept.map_or(1.0, |kept| kept.powf(dt));
    let explained = (0..3).all(|i| {
        let wanted = last.velocity[i] * kept + forces.acceleration[i] * dt;
        (next.velocity[i] - wanted).abs() < EXPLAINED
    });
    (0.0..0.5).contains(&dt)
        && explained
        && !next.touched
        && !(last.driven && last.ground.is_some())
        && last.ground == next.ground
        && last.acceleration == next.acceleration
        && last.omega == next.omega
        && squared(last.velocity) > REST
        && squared(next.velocity) > REST
        // Within one block nothing jumps; a placing does.
        && distance(last.place, next.place) < 60.0 * dt + 1e-3
}

fn error(first: &Sample, last: &Sample, forces: &Forces) -> SmoothError {
    let start = Motion {
        place: first.place,
        velocity: first.velocity,
        rotation: first.rotation,
    };
    let seconds = last.time - first.time;
    let converged = richardson(
        start,
        forces,
        seconds,
        (seconds * 240.0).ceil().max(8.0) as u32,
    );
    SmoothError {
        max: distance(last.place, converged.place),
        phases: 1,
        seconds,
        uncertainty: distance(converged.place, solution(start, forces, seconds).place),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flight(jumps: bool) -> Vec<Sample> {
        let sample = |i: u32| {
            let t = f64::from(i) * 0.05;
            let kick = if jumps && i >= 20 { 3.0 } else { 0.0 };
            Sample {
                clock: t,
                time: t,
                place: [
                    4.0 * t + kick * (t - 1.0).max(0.0),
                    0.0,
                    100.0 - 4.9 * t * t,
                ],
                rotation: [1.0, 0.0, 0.0, 0.0],
                velocity: [4.0 + kick, 0.0, -9.8 * t],
                acceleration: [0.0, 0.0, -9.8],
                omega: [0.0; 3],
                ground: None,
                touched: false,
                driven: false,
            }
        };
        (0..40).map(sample).collect()
    }

    #[test]
    fn flight_is_one_phase_and_an_input_ends_it() {
        let whole = worst(&flight(false), 0.0).unwrap();
        assert_eq!(whole.phases, 1);
        assert!(whole.max < 1e-9 && whole.uncertainty < 1e-9, "{whole:?}");
        let kicked = worst(&flight(true), 0.0).unwrap();
        assert_eq!(kicked.phases, 2);
        assert!(kicked.max < 0.2, "{kicked:?}");
        assert_eq!(worst(&flight(false)[..5], 0.0), None);
    }
}
