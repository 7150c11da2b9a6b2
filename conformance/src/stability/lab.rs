//! Runs everything that is about stability: the listed cases, the rules over the bundled scenes, the rules about whole scenes, the ensembles.

use std::{collections::BTreeMap, sync::Arc};

use ac_client::{
    dat::DatSet,
    frame::{FrameState, FrameStates, NoProbe},
    profile::Profile,
};
use ac_golden_traces::Scene;
use ac_replayer::{SimulationError, client::SceneRun};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    ensemble::{self, Change, Class, Ensemble},
    generators,
    invariants::{Invariant, Violation, Watch},
    stage::{FLOATS, GUID, Run, Stage, motion},
    trial::{CaseResult, Trial, Verdict},
    worlds::{self, Playground, halls, spots},
};

/// Runs that start a million seconds apart stay this near, m, unless the scene amplifies rounding.
const TIME_BOUND: f64 = 1e-3;

/// A bundled scene with what an oracle expects.
#[derive(Debug, Clone)]
pub struct Bundled {
    /// The scene.
    pub scene: Scene,
    /// Its world.
    pub source: Arc<DatSet>,
    /// The oracle; the scene runs under its profile.
    pub oracle: &'static str,
    /// What it expects.
    pub expected: Vec<FrameState>,
}

/// A scene under the rules.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneResult {
    /// Its name.
    pub scene: String,
    /// What came of it.
    pub verdict: Verdict,
    /// Checks made.
    pub checks: u64,
    /// Frames run.
    pub frames: u64,
    /// What does not hold.
    pub violations: Vec<Violation>,
}

impl SceneResult {
    fn new(scene: &str, checks: u64, frames: u64, violations: Vec<Violation>) -> Self {
        let verdict = if violations.iter().any(|v| v.retail.is_none()) {
            Verdict::Ours
        } else if violations.is_empty() {
            Verdict::Holds
        } else {
            Verdict::AsRetail
        };
        Self {
            scene: scene.into(),
            verdict,
            checks,
            frames,
            violations,
        }
    }
}

/// Everything.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Report {
    /// The cases that the specification lists.
    pub cases: Vec<CaseResult>,
    /// The bundled scenes, and generated ones for the rules about whole scenes.
    pub scenes: Vec<SceneResult>,
    /// How scenes take small changes.
    pub ensembles: Vec<Ensemble>,
}

impl Report {
    /// Cases and scenes with a violation that is ours.
    pub fn ours(&self) -> usize {
        let cases = self.cases.iter().map(|case| case.verdict);
        let scenes = self.scenes.iter().map(|scene| scene.verdict);
        cases.chain(scenes).filter(|v| *v == Verdict::Ours).count()
    }
}

/// Runs the listed cases.
pub fn cases(wanted: impl Fn(&str) -> bool + Sync) -> Vec<CaseResult> {
    generators::all()
        .into_par_iter()
        .filter(|case| wanted(&case.id()))
        .map(|case| {
            let mut trial = Trial::new();
            (case.run)(&mut trial);
            trial.result(case)
        })
        .collect()
}

/// Runs bundled scenes: their ensembles and the rules.
///
/// # Errors
/// When a scene cannot be set up.
pub fn bundled(
    scenes: &[Bundled],
    changes: &[Change],
    progress: impl Fn() + Sync,
) -> Result<(Vec<SceneResult>, Vec<Ensemble>), SimulationError> {
    let both: Vec<_> = scenes
        .par_iter()
        .map(|bundled| {
            let profile = Profile::named(bundled.oracle).unwrap_or_default();
            let ensemble = ensemble::run(&bundled.scene, &bundled.source, &profile, changes)?;
            let mut result = rules(bundled, &profile)?;
            time_of_day(bundled, &profile, &ensemble, &mut result)?;
            progress();
            let SceneResult {
                checks,
                frames,
                violations,
                ..
            } = result;
            let scene = SceneResult::new(&bundled.scene.name, checks, frames, violations);
            Ok((scene, ensemble))
        })
        .collect::<Result<_, SimulationError>>()?;
    Ok(both.into_iter().unzip())
}

/// A bundled scene under the rules; what its oracle's trace shows in the same frame with the same bits is retail's.
fn rules(bundled: &Bundled, profile: &Profile) -> Result<SceneResult, SimulationError> {
    let scene = &bundled.scene;
    let mut run = SceneRun::new(scene, Arc::clone(&bundled.source), profile)?;
    let mut watch = Watch::of(scene);
    let mut states = FrameStates::new();
    let mut places = BTreeMap::new();
    for frame in 0..scene.frame_count() {
        run.run_frame(frame, &mut NoProbe);
        run.write_records(i32::try_from(frame).unwrap_or(i32::MAX), &mut states);
        watch.frame(&run, &states);
        for state in states.iter() {
            places.insert((state.frame, state.guid), exact(state));
        }
    }
    let (checks, mut violations) = watch.done();
    let frames: BTreeMap<(i32, u32), [u32; 11]> = bundled
        .expected
        .iter()
        .map(|state| ((state.frame, state.guid), exact(state)))
        .collect();
    for violation in &mut violations {
        let Some(frame) = violation.frame else {
            continue;
        };
        let same = scene.track.iter().all(|guid| {
            let key = (frame, *guid);
            frames.get(&key) == places.get(&key) && frames.contains_key(&key)
        });
        violation.retail =
            same.then(|| format!("{}, scene {}, frame {frame}", bundled.oracle, scene.name));
    }
    Ok(SceneResult::new(
        &scene.name,
        checks,
        u64::from(scene.frame_count()),
        violations,
    ))
}

/// The bits of a state that a rule can be about.
fn exact(state: &FrameState) -> [u32; 11] {
    let [x, y, z] = state.origin.map(f32::to_bits);
    let [w, i, j, k] = state.rotation.map(f32::to_bits);
    let [a, b, c] = state.velocity.map(f32::to_bits);
    [state.cell, x, y, z, w, i, j, k, a, b, c]
}

/// The same scene at time 0 and a million seconds later.
fn time_of_day(
    bundled: &Bundled,
    profile: &Profile,
    ensemble: &Ensemble,
    result: &mut SceneResult,
) -> Result<(), SimulationError> {
    let at = |time: f64| {
        let scene = Scene {
            start_time: time,
            ..bundled.scene.clone()
        };
        record(&scene, &bundled.source, profile)
    };
    let (early, late) = (at(0.0)?, at(1e6)?);
    result.checks += 1;
    // What a scene makes of rounding in the length of a frame it also makes of rounding in the clock.
    let amplified = ensemble
        .members
        .iter()
        .filter(|m| matches!(m.change, Change::FrameUlps(_)))
        .map(|m| m.max)
        .fold(0.0, f64::max);
    let unstable = ensemble.class.max(ensemble.clock) >= Class::Growing;
    let (distance, frame) = furthest(&early, &late);
    if distance <= TIME_BOUND.max(4.0 * amplified) {
        return Ok(());
    }
    let quanta = |states: &[FrameState]| states.iter().map(|s| s.steps.len()).collect::<Vec<_>>();
    let retail = if quanta(&early) != quanta(&late) {
        Some("06 H4.1: a frame at the gate of 1/30 s is a quantum or not by rounding of the clock")
    } else if unstable {
        Some(
            "06 H4.1: remainders of the clock are rounded, and the scene amplifies rounding (see its ensemble)",
        )
    } else {
        None
    };
    result.violations.push(Violation {
        invariant: Invariant::TimeOfDay,
        frame: Some(frame),
        detail: format!("{distance:.4} m apart"),
        retail: retail.map(Into::into),
    });
    Ok(())
}

fn record(
    scene: &Scene,
    source: &Arc<DatSet>,
    profile: &Profile,
) -> Result<Vec<FrameState>, SimulationError> {
    let mut run = SceneRun::new(scene, Arc::clone(source), profile)?;
    let mut states = FrameStates::new();
    let mut all = Vec::new();
    for frame in 0..scene.frame_count() {
        run.run_frame(frame, &mut NoProbe);
        run.write_records(i32::try_from(frame).unwrap_or(i32::MAX), &mut states);
        all.extend(states.iter().cloned());
    }
    Ok(all)
}

/// Largest distance of states at the same place in both lists, and its frame.
fn furthest(a: &[FrameState], b: &[FrameState]) -> (f64, i32) {
    let mut worst = (0.0, -1);
    for (a, b) in a.iter().zip(b) {
        if a.cell == 0 || b.cell == 0 {
            continue;
        }
        let block = |cell: u32, shift: u32| f64::from(cell >> shift & 0xFF) * 192.0;
        let shift = [24, 16].map(|s| block(a.cell, s) - block(b.cell, s));
        let d: f64 = (0..3)
            .map(|i| {
                let off = shift.get(i).copied().unwrap_or(0.0);
                (f64::from(a.origin[i]) - f64::from(b.origin[i]) + off).powi(2)
            })
            .sum();
        if d.sqrt() > worst.0 {
            worst = (d.sqrt(), a.frame);
        }
    }
    worst
}

/// Plain scenes of every kind of contact.
pub fn plain(play: &Playground) -> Vec<(&'static str, Stage)> {
    let stage = || Stage::new(play).frames(0.04, 200);
    let inside = play.rooms | halls::CLOSED_CELL;
    vec![
        (
            "roll",
            stage().thrown(play.ball, spots::OPEN, [6.0, 3.0, 0.0]),
        ),
        (
            "fall",
            stage().thrown(play.ball, [30.0, 100.0, 20.0], [2.0, 0.0, 0.0]),
        ),
        ("walk", stage().walker(play, spots::OPEN, 45.0).walks(5)),
        ("wall", stage().walker(play, spots::WALL, 60.0).walks(5)),
        (
            "corner",
            stage().walker(play, [146.0, 56.0, 0.0], 30.0).walks(5),
        ),
        (
            "wedge",
            stage().walker(play, [150.0, 140.2, 0.0], 90.0).walks(5),
        ),
        (
            "step",
            stage().walker(play, [33.0, 20.0, 0.0], 90.0).walks(5),
        ),
        (
            "ramp",
            stage().walker(play, [9.0, 176.0, 0.0], 90.0).walks(5),
        ),
        (
            "spin",
            stage().entity(play.ball, [30.0, 100.0, 50.0], |spec| {
                spec.state = FLOATS;
                spec.omega = [0.5, 0.25, 2.0];
            }),
        ),
        (
            "room",
            stage().entity(play.ball, halls::CLOSED, |spec| {
                spec.position = super::stage::indoors(inside, [40.0, 40.0, -48.0]);
                spec.velocity = [9.0, 4.0, 2.0];
            }),
        ),
    ]
}

/// The rules about whole scenes: place on the map, order of entities.
pub fn whole_scenes() -> Vec<SceneResult> {
    let (play, moved) = match (worlds::play(), worlds::moved()) {
        (Ok(play), Ok(moved)) => (play, moved),
        (Err(error), _) | (_, Err(error)) => {
            return vec![failed("generated worlds", &error.to_string())];
        }
    };
    let mut results: Vec<SceneResult> = plain(play)
        .into_iter()
        .zip(plain(moved))
        .map(|((name, here), (_, there))| translated(name, &here, &there))
        .collect();
    results.push(reordered(play));
    results
}

fn failed(scene: &str, detail: &str) -> SceneResult {
    let violation = Violation {
        invariant: Invariant::Promise,
        frame: None,
        detail: detail.into(),
        retail: None,
    };
    SceneResult::new(scene, 1, 0, vec![violation])
}

fn run(stage: &Stage) -> Result<(Run, Watch), SimulationError> {
    let mut watch = Watch::new(stage);
    let run = stage.run(&Profile::retail(), &mut watch)?;
    Ok((run, watch))
}

/// The same scene in another landblock: the same bits, because coordinates are those of the landblock.
fn translated(name: &str, here: &Stage, there: &Stage) -> SceneResult {
    let name = format!("generated/{name}");
    let (found, other) = match (run(here), run(there)) {
        (Ok((found, _)), Ok((other, _))) => (found, other),
        (Err(error), _) | (_, Err(error)) => return failed(&name, &error.to_string()),
    };
    let (a, b) = (found.bits(0), other.bits(0));
    let differs = a.iter().zip(&b).position(|(a, b)| a != b);
    let violations = differs.map(|frame| Violation {
        invariant: Invariant::Translation,
        frame: i32::try_from(frame).ok().map(|f| f - 1),
        detail: "other bits in another landblock".into(),
        retail: None,
    });
    SceneResult::new(&name, 1, found.frames(), violations.into_iter().collect())
}

/// Two who never meet, created in either order.
fn reordered(play: &Playground) -> SceneResult {
    let name = "generated/order-of-entities";
    let stage = |swapped: bool| {
        let mut stage = Stage::new(play)
            .frames(0.04, 150)
            .walker(play, spots::OPEN, 45.0)
            .thrown(play.ball, [170.0, 20.0, 8.0], [-3.0, 2.0, 0.0])
            .at(5, 0, motion(super::stage::WALK, 1.0));
        if swapped {
            stage.scene.entities.reverse();
        }
        stage
    };
    let (one, two) = match (run(&stage(false)), run(&stage(true))) {
        (Ok((one, _)), Ok((two, _))) => (one, two),
        (Err(error), _) | (_, Err(error)) => return failed(name, &error.to_string()),
    };
    let violations = (0..2)
        .filter(|i| one.bits(*i) != two.bits(*i))
        .map(|i| Violation {
            invariant: Invariant::EntityOrder,
            frame: None,
            detail: format!(
                "{:#X} moves otherwise when created in another order",
                GUID + i as u32
            ),
            retail: None,
        });
    SceneResult::new(name, 2, one.frames(), violations.collect())
}
