//! Paths of entities: how they are recorded, and how far one is from another.
//!
//! A client shows at clock time t what it simulated up to its own time s ≤ t. Both are kept, because they answer different questions: what is
//! *shown* at the same clock time (against an oracle's trace), and which *path* is taken (against a converged reference), where lagging
//! behind the clock is no error.

use std::sync::Arc;

use ac_client::{
    dat::DatSet,
    entity::Entity,
    frame::{
        FrameState, NoProbe,
        plan::{Outputs, WorldIndex},
        state::Fields,
    },
    physics::state::TransientState,
    profile::Profile,
};
use ac_golden_traces::Scene;
use ac_replayer::{
    SimulationError,
    client::{ScenePlan, SceneRun, planning},
};
use serde::Serialize;

use super::{
    grid::Setting,
    reference::{angle, distance},
};
use crate::report_html::series::Sample as Drawn;

/// Side of a landblock, m.
const BLOCK: f64 = 192.0;
/// Faster than this, m/s, an entity is moved, not moving: it was placed.
const PLACED: f64 = 60.0;
/// Samples this near, s, to a placing are not compared: inputs come up to a quantum earlier or later.
const PLACED_WINDOW: f64 = 0.3;

/// A world, and what belongs together in it.
#[derive(Debug, Clone, Copy)]
pub struct Ground<'a> {
    /// Its records.
    pub source: &'a Arc<DatSet>,
    /// What a plan needs to know of it.
    pub index: Option<&'a Arc<WorldIndex>>,
}

/// One entity after one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Frame clock, s since the start.
    pub clock: f64,
    /// Time up to which it is simulated, s since the start.
    pub time: f64,
    /// From the south-west corner of the map, m.
    pub place: [f64; 3],
    /// `[w, x, y, z]`.
    pub rotation: [f64; 4],
    /// m/s.
    pub velocity: [f64; 3],
    /// m/s².
    pub acceleration: [f64; 3],
    /// rad/s.
    pub omega: [f64; 3],
    /// Normal of the plane that it slides on; `None` in the air.
    pub ground: Option<[f32; 3]>,
    /// Something was touched in this frame.
    pub touched: bool,
    /// Animations move it, or managers.
    pub driven: bool,
}

/// The samples of one entity, where it was somewhere.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Track {
    /// The entity.
    pub guid: u32,
    /// In order of time.
    pub samples: Vec<Sample>,
}

/// Runs a scene under a setting and records every tracked entity.
///
/// # Errors
/// When the scene cannot be set up.
pub fn record(
    scene: &Scene,
    ground: Ground<'_>,
    setting: &Setting,
) -> Result<Vec<Track>, SimulationError> {
    let mut run = start(scene, ground, setting)?;
    let mut tracks: Vec<Track> = scene
        .track
        .iter()
        .map(|guid| Track {
            guid: *guid,
            samples: Vec::new(),
        })
        .collect();
    for frame in 0..scene.frame_count() {
        run.run_frame(frame, &mut NoProbe);
        if setting.plan.is_some() {
            run.settle();
        }
        let now = run.world.clock.now;
        for track in &mut tracks {
            let entity = run.object(track.guid).and_then(|id| run.world.entity(id));
            let sample = entity.and_then(|entity| sample(entity, now, scene.start_time));
            track.samples.extend(sample);
        }
    }
    Ok(tracks)
}

/// A scene that stands before its first frame under a setting.
///
/// # Errors
/// When the scene cannot be set up.
pub fn start(
    scene: &Scene,
    ground: Ground<'_>,
    setting: &Setting,
) -> Result<SceneRun, SimulationError> {
    let mut profile = setting.profile();
    let fidelity = setting.fidelity();
    fidelity.apply(&mut profile);
    let plan = plan(scene, ground, setting, &profile)?;
    let mut run = SceneRun::planned(scene, Arc::clone(ground.source), &profile, plan)?;
    run.set_fidelity(fidelity);
    Ok(run)
}

fn plan(
    scene: &Scene,
    ground: Ground<'_>,
    setting: &Setting,
    profile: &Profile,
) -> Result<Option<ScenePlan>, SimulationError> {
    let (Some(used), Some(index)) = (setting.plan, ground.index) else {
        return Ok(None);
    };
    let outline = planning::outline(scene, Outputs::default());
    let plan = used
        .choice()
        .plan_for(&outline, ground.source, index, profile)
        .map_err(|reason| SimulationError::Plan {
            scene: scene.name.clone(),
            reason,
        })?;
    Ok(plan.map(|plan| ScenePlan {
        plan,
        index: Arc::clone(index),
        outline,
    }))
}

fn sample(entity: &Entity, now: f64, start: f64) -> Option<Sample> {
    entity.body.cell?;
    let (kin, position) = (&entity.kin, &entity.body.position);
    let [x, y, z] = position.frame.origin.to_array().map(f64::from);
    let place = [
        x + f64::from(position.cell.block_x()) * BLOCK,
        y + f64::from(position.cell.block_y()) * BLOCK,
        z,
    ];
    let q = position.frame.rotation();
    let active = kin.transient.contains(TransientState::ACTIVE);
    let wide = |v: ac_client::math::Vec3| v.to_array().map(f64::from);
    place.iter().all(|c| c.is_finite()).then_some(Sample {
        clock: now - start,
        // The clock of what rests is not kept up.
        time: if active { kin.update_time } else { now } - start,
        place,
        rotation: [q.w, q.x, q.y, q.z].map(f64::from),
        velocity: wide(kin.velocity),
        acceleration: wide(kin.acceleration),
        omega: wide(kin.omega),
        ground: kin
            .transient
            .contains(TransientState::CONTACT)
            .then_some(kin.contact_plane.n.to_array()),
        touched: !entity.touched.is_empty() || entity.touched_environment,
        driven: entity.position_manager.is_some() || entity.movement.is_some(),
    })
}

/// What an oracle expects, frame by frame, as a track per entity.
pub fn expected(states: &[FrameState], scene: &Scene) -> Vec<Track> {
    let of = |guid: u32| Track {
        guid,
        samples: states
            .iter()
            .filter(|state| state.guid == guid && state.frame >= 0)
            .filter_map(|state| {
                let place = Drawn::of(state).place?;
                let rotation = state.has.contains(Fields::ROTATION);
                Some(Sample {
                    clock: state.time - scene.start_time,
                    time: state.time - scene.start_time,
                    place,
                    rotation: if rotation {
                        state.rotation.map(f64::from)
                    } else {
                        [1.0, 0.0, 0.0, 0.0]
                    },
                    velocity: [0.0; 3],
                    acceleration: [0.0; 3],
                    omega: [0.0; 3],
                    ground: None,
                    touched: false,
                    driven: false,
                })
            })
            .collect(),
    };
    scene.track.iter().map(|guid| of(*guid)).collect()
}

/// How far one run is from another.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Distance {
    /// Largest, m.
    pub max: f64,
    /// Root of the mean square, m.
    pub rms: f64,
    /// Largest angle, rad.
    pub angle: f64,
    /// Samples compared.
    pub samples: u64,
}

/// Collects distances.
#[derive(Debug, Default)]
struct Sum {
    found: Distance,
    squares: f64,
}

impl Sum {
    fn add(&mut self, a: ([f64; 3], [f64; 4]), b: ([f64; 3], [f64; 4])) {
        let apart = distance(a.0, b.0);
        self.found.max = self.found.max.max(apart);
        self.found.angle = self.found.angle.max(angle(a.1, b.1));
        self.found.samples += 1;
        self.squares += apart * apart;
    }

    fn done(mut self) -> Option<Distance> {
        if self.found.samples == 0 {
            return None;
        }
        self.found.rms = (self.squares / self.found.samples as f64).sqrt();
        Some(self.found)
    }
}

/// What is shown at the frames of `expected`, up to `horizon` s: the last sample of `actual` that is not later. `None` without a common one.
pub fn shown(expected: &[Track], actual: &[Track], horizon: f64) -> Option<Distance> {
    let mut sum = Sum::default();
    for want in expected {
        let Some(have) = actual.iter().find(|track| track.guid == want.guid) else {
            continue;
        };
        for sample in want.samples.iter().take_while(|s| s.clock <= horizon) {
            let after = have
                .samples
                .partition_point(|s| s.clock <= sample.clock + 1e-6);
            // What has not been shown for a second is gone, not late.
            let last = have.samples[..after].last();
            if let Some(last) = last.filter(|s| sample.clock - s.clock < 1.0) {
                sum.add((sample.place, sample.rotation), (last.place, last.rotation));
            }
        }
    }
    sum.done()
}

/// The path of `actual` against that of `reference`, at the times up to which `actual` is simulated and up to `horizon` s. Samples beside a
/// placing are left out. `None` without a common time.
pub fn path(reference: &[Track], actual: &[Track], horizon: f64) -> Option<Distance> {
    let mut sum = Sum::default();
    for want in reference {
        let Some(have) = actual.iter().find(|track| track.guid == want.guid) else {
            continue;
        };
        let placings = placings(&want.samples);
        for sample in have.samples.iter().take_while(|s| s.time <= horizon) {
            let near = |t: &f64| (sample.time - t).abs() < PLACED_WINDOW;
            if placings.iter().any(near) {
                continue;
            }
            if let Some(at) = between(&want.samples, sample.time) {
                sum.add(at, (sample.place, sample.rotation));
            }
        }
    }
    sum.done()
}

/// Seconds in the air without speed, under gravity, that are no apex any more.
const HANGING: f64 = 0.4;
/// Square of the speed below which the rest rule stops an object (06, B6), m²/s².
const REST: f64 = 0.0625;

/// Whether something hangs in the air although gravity pulls it.
pub fn hangs(tracks: &[Track]) -> bool {
    tracks.iter().any(|track| {
        let mut since: Option<f64> = None;
        track.samples.iter().any(|sample| {
            let squared: f64 = sample.velocity.iter().map(|v| v * v).sum();
            let hanging =
                sample.ground.is_none() && sample.acceleration[2] < -1.0 && squared < REST;
            since = hanging.then(|| since.unwrap_or(sample.time));
            since.is_some_and(|since| sample.time - since > HANGING)
        })
    })
}

/// Times at which something was placed elsewhere.
fn placings(samples: &[Sample]) -> Vec<f64> {
    samples
        .windows(2)
        .filter(|pair| {
            let dt = (pair[1].clock - pair[0].clock).max(1e-3);
            distance(pair[0].place, pair[1].place) > PLACED * dt + 0.5
        })
        .map(|pair| pair[1].time)
        .collect()
}

/// Place and orientation at a time between two samples, linearly in place.
fn between(samples: &[Sample], time: f64) -> Option<([f64; 3], [f64; 4])> {
    let after = samples.partition_point(|s| s.time < time);
    let next = samples.get(after)?;
    let last = samples[..after].last().unwrap_or(next);
    let gap = next.time - last.time;
    if time < last.time - 1e-9 || gap > 1.0 {
        return None;
    }
    let share = if gap > 0.0 {
        (time - last.time) / gap
    } else {
        0.0
    };
    // The parabola through both places with the speeds at both ends: between samples of free flight nothing is lost.
    let bow = share * (1.0 - share) * gap * 0.5;
    let place = std::array::from_fn(|i| {
        let line = last.place[i] + (next.place[i] - last.place[i]) * share;
        let bend = last.velocity[i] - next.velocity[i];
        let falls = last.ground.is_none() && next.ground.is_none();
        line + if falls && bend.abs() <= 10.0 * gap {
            bend * bow
        } else {
            0.0
        }
    });
    let rotation = if share < 0.5 {
        last.rotation
    } else {
        next.rotation
    };
    Some((place, rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn falling(every: f64, count: u32) -> Vec<Track> {
        let sample = |i: u32| {
            let t = f64::from(i) * every;
            Sample {
                clock: t,
                time: t,
                place: [3.0 * t, 0.0, -4.9 * t * t],
                rotation: [1.0, 0.0, 0.0, 0.0],
                velocity: [3.0, 0.0, -9.8 * t],
                acceleration: [0.0, 0.0, -9.8],
                omega: [0.0; 3],
                ground: None,
                touched: false,
                driven: false,
            }
        };
        vec![Track {
            guid: 1,
            samples: (0..count).map(sample).collect(),
        }]
    }

    #[test]
    fn a_parabola_is_met_between_its_samples() {
        let found = path(&falling(0.1, 40), &falling(0.03, 100), 10.0).unwrap();
        assert!(found.max < 1e-9, "{found:?}");
        assert_eq!(found.samples, 100);
    }

    #[test]
    fn what_hangs_is_seen() {
        let mut tracks = falling(0.1, 40);
        assert!(!hangs(&tracks));
        for sample in &mut tracks[0].samples[10..16] {
            sample.velocity = [0.0, 0.0, -0.01];
        }
        assert!(hangs(&tracks));
    }

    #[test]
    fn what_is_shown_lags() {
        let found = shown(&falling(0.1, 10), &falling(0.3, 4), 10.0).unwrap();
        // At 0.8 s it shows 0.6 s.
        assert!(found.max > 0.6, "{found:?}");
        assert_eq!(shown(&falling(0.1, 10), &[], 10.0), None);
    }

    #[test]
    fn a_placing_is_not_compared() {
        let mut moved = falling(0.1, 40);
        for sample in &mut moved[0].samples[20..] {
            sample.place[0] += 1000.0;
        }
        assert_eq!(placings(&moved[0].samples).len(), 1);
        let found = path(&moved, &falling(0.1, 18), 10.0).unwrap();
        assert!(found.max < 1e-9);
    }
}
