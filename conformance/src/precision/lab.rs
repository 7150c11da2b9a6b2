//! Runs subjects over the grid and collects what they cost and how far they are off.

use std::{collections::BTreeMap, sync::Arc};

use ac_client::{dat::DatSet, frame::plan::WorldIndex};
use ac_golden_traces::Scene;
use ac_replayer::SimulationError;
use rayon::prelude::*;
use serde::Serialize;

use super::{
    cases::Analytic,
    cost,
    grid::{Axis, Setting},
    reference::{angle, distance, solution},
    resample,
    smooth::{self, SmoothError},
    summary,
    track::{self, Distance, Ground, Track},
};

/// Quanta per second of the converged reference, and of the run that tells how far it can be trusted.
const REFERENCE: [u32; 2] = [960, 480];

/// A scene to measure.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The scene.
    pub scene: Scene,
    /// Its world.
    pub source: Arc<DatSet>,
    /// What a plan needs to know of it.
    pub index: Option<Arc<WorldIndex>>,
    /// What the oracle expects, if there is one.
    pub expected: Vec<Track>,
    /// What really happens, if that is known in closed form.
    pub analytic: Option<Analytic>,
}

impl Subject {
    /// The world and its index.
    pub fn ground(&self) -> Ground<'_> {
        Ground {
            source: &self.source,
            index: self.index.as_ref(),
        }
    }
}

/// How to measure.
#[derive(Debug, Clone)]
pub struct Options {
    /// Whose profile and constants are the own setting.
    pub profile: &'static str,
    /// The settings.
    pub grid: Vec<Setting>,
    /// Timed runs of each setting; 0: no times.
    pub repeats: u32,
    /// Errors are looked at up to here, s.
    pub horizon: f64,
}

/// One setting of one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The setting.
    pub setting: Setting,
    /// Median run time per simulated second, ns.
    pub ns_per_second: Option<f64>,
    /// Instructions per simulated second.
    pub instructions_per_second: Option<f64>,
    /// What is shown, against the oracle.
    pub oracle: Option<Distance>,
    /// The path, against the converged reference.
    pub reference: Option<Distance>,
    /// The path, against the solution in closed form.
    pub solution: Option<Distance>,
    /// Smooth phases, against f64.
    pub smooth: Option<SmoothError>,
    /// It is the converged reference itself, which has no distance from it.
    pub is_reference: bool,
    /// No other setting is both cheaper and nearer.
    pub pareto: bool,
}

impl Row {
    /// The error against the truth if it is known, else against the converged reference.
    pub fn error(&self) -> Option<f64> {
        self.solution.or(self.reference).map(|found| found.max)
    }

    /// The error that a plot shows: where there is no truth, that against the oracle.
    pub fn plotted(&self) -> Option<f64> {
        let shown = self.oracle.filter(|_| !self.is_reference);
        self.error().or(shown.map(|found| found.max))
    }
}

/// One scene under every setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneLab {
    /// Its name.
    pub scene: String,
    /// Its class: the area.
    pub class: String,
    /// Simulated seconds.
    pub seconds: f64,
    /// How far the converged reference moves when its quanta are twice as long, m.
    pub uncertainty: Option<f64>,
    /// With the quanta of the reference something hangs in the air: the rest rule takes away what gravity gives. There is no reference.
    pub hangs: bool,
    /// Errors are angles, rad.
    pub turns: bool,
    /// Observed convergence over the quanta.
    pub order: summary::Order,
    /// One per setting.
    pub rows: Vec<Row>,
}

/// Measures all subjects: errors in parallel, then times one after the other. `progress` is called twice per subject.
///
/// # Errors
/// When a scene cannot be set up.
pub fn run(
    subjects: &[Subject],
    options: &Options,
    progress: impl Fn() + Sync,
) -> Result<Vec<SceneLab>, SimulationError> {
    let mut labs: Vec<SceneLab> = subjects
        .par_iter()
        .map(|subject| {
            let lab = errors(subject, options);
            progress();
            lab
        })
        .collect::<Result<_, _>>()?;
    for (subject, lab) in subjects.iter().zip(&mut labs) {
        times(subject, lab, options)?;
        progress();
        summary::mark_pareto(&mut lab.rows);
    }
    Ok(labs)
}

fn errors(subject: &Subject, options: &Options) -> Result<SceneLab, SimulationError> {
    let converged = REFERENCE
        .map(|quanta| record(subject, &Setting::quanta(options.profile, quanta)))
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?;
    let (fine, half) = (&converged[0], &converged[1]);
    let hangs = track::hangs(fine);
    let uncertainty = track::path(fine, half, options.horizon)
        .filter(|_| !hangs)
        .map(|found| found.max);
    let mut of_profile: BTreeMap<&str, Vec<Track>> = BTreeMap::new();
    let mut rows = Vec::new();
    for setting in &options.grid {
        let Some(scene) = scene_of(&subject.scene, setting) else {
            continue;
        };
        let tracks = track::record(&scene, subject.ground(), setting)?;
        // Another profile converges to something else.
        let reference = if setting.profile == options.profile {
            fine
        } else {
            if !of_profile.contains_key(setting.profile) {
                let finest = Setting::quanta(setting.profile, REFERENCE[0]);
                of_profile.insert(setting.profile, record(subject, &finest)?);
            }
            &of_profile[setting.profile]
        };
        let finest = setting.quanta_per_second == Some(REFERENCE[0]);
        let is_reference = finest && setting.frame_rate.is_none();
        rows.push(Row {
            setting: setting.clone(),
            ns_per_second: None,
            instructions_per_second: None,
            oracle: track::shown(&subject.expected, &tracks, options.horizon),
            reference: track::path(reference, &tracks, options.horizon)
                .filter(|_| !hangs && !is_reference),
            solution: subject
                .analytic
                .as_ref()
                .and_then(|case| against(case, &tracks, options.horizon)),
            smooth: smooth(&scene, &tracks),
            is_reference: is_reference && !hangs,
            pareto: false,
        });
    }
    let turns = subject.analytic.as_ref().is_some_and(|case| case.turns);
    Ok(SceneLab {
        scene: subject.scene.name.clone(),
        class: subject.scene.area().into(),
        seconds: seconds(&subject.scene),
        uncertainty,
        hangs,
        turns,
        order: summary::order(&rows),
        rows,
    })
}

fn record(subject: &Subject, setting: &Setting) -> Result<Vec<Track>, SimulationError> {
    track::record(&subject.scene, subject.ground(), setting)
}

/// The scene at the frame rate of a setting; `None` where it has none.
pub fn scene_of(scene: &Scene, setting: &Setting) -> Option<Scene> {
    match setting.frame_rate {
        Some(rate) => resample::at_rate(scene, rate),
        None => Some(scene.clone()),
    }
}

/// Seconds that a scene lasts.
pub fn seconds(scene: &Scene) -> f64 {
    let run = |run: &ac_golden_traces::scene::FrameRun| run.dt * f64::from(run.count);
    scene.frames.iter().map(run).sum()
}

/// The paths against the solution in closed form.
fn against(case: &Analytic, tracks: &[Track], horizon: f64) -> Option<Distance> {
    let samples = &tracks.first()?.samples;
    let mut found = Distance::default();
    let mut squares = 0.0;
    for sample in samples.iter().take_while(|sample| sample.time <= horizon) {
        let truth = solution(case.start, &case.forces, sample.time);
        let turn = angle(sample.rotation, truth.rotation);
        let apart = if case.turns {
            turn
        } else {
            distance(sample.place, truth.place)
        };
        found.max = found.max.max(apart);
        found.angle = found.angle.max(turn);
        found.samples += 1;
        squares += apart * apart;
    }
    found.rms = (squares / found.samples.max(1) as f64).sqrt();
    (found.samples > 0).then_some(found)
}

fn smooth(scene: &Scene, tracks: &[Track]) -> Option<SmoothError> {
    tracks
        .iter()
        .filter_map(|track| {
            let spec = scene.entities.iter().find(|spec| spec.guid == track.guid)?;
            smooth::worst(&track.samples, f64::from(spec.friction))
        })
        .max_by(|a, b| a.max.total_cmp(&b.max))
}

/// Medians of interleaved runs: what disturbs the machine for a while disturbs all settings.
fn times(subject: &Subject, lab: &mut SceneLab, options: &Options) -> Result<(), SimulationError> {
    let scenes: Vec<Option<Scene>> = lab
        .rows
        .iter()
        .map(|row| scene_of(&subject.scene, &row.setting))
        .collect();
    let mut found = vec![Vec::new(); lab.rows.len()];
    for _ in 0..options.repeats {
        for (index, row) in lab.rows.iter().enumerate() {
            let scene = scenes[index].as_ref().unwrap_or(&subject.scene);
            found[index].push(cost::time(scene, subject.ground(), &row.setting)?);
        }
    }
    let seconds = lab.seconds.max(f64::MIN_POSITIVE);
    for (row, found) in lab.rows.iter_mut().zip(found) {
        row.ns_per_second = cost::median(found).map(|ns| ns / seconds);
    }
    Ok(())
}

/// Whether the setting belongs to the series over which convergence is observed.
pub fn converges(setting: &Setting) -> bool {
    setting.axis == Axis::Quantum
}
