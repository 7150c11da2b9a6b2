//! Runs one case: its files as a stream, one simulation per oracle and mode along with it.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use ac_client::{
    frame::{FrameState, FrameStates},
    profile::Profile,
};
use ac_golden_traces::{
    Scene,
    expect::{ExpectReader, StageReader},
    trace::{ChannelKind, TraceEvent, TraceReader},
};
use ac_replayer::{Simulation, SimulationError, Simulator};
use serde_json::{Value, value::RawValue};

use super::{Case, Mode, Options, Outcome, RunError, RunResult, StageCount, profile_of};
use crate::{
    compare::{
        Comparison,
        policy::{Policy, Rule},
    },
    report_html::Series,
    vectors::json,
};

/// Runs a case in all modes with all oracles that the options name. What could not run is in the errors; the results of the
/// rest stand beside it.
pub(super) fn run_case(
    simulator: &dyn Simulator,
    case: &Case,
    options: &Options,
    policy: &Policy,
) -> Outcome {
    let outcome = match case {
        Case::Trace(path) => run_trace(simulator, path, options, policy),
        Case::Files {
            scene,
            expect,
            stages,
        } => run_files(simulator, scene, expect, stages, options, policy),
    };
    outcome.unwrap_or_else(|error| Outcome {
        errors: vec![error],
        ..Outcome::default()
    })
}

fn run_trace(
    simulator: &dyn Simulator,
    path: &Path,
    options: &Options,
    policy: &Policy,
) -> Result<Outcome, RunError> {
    let mut reader = TraceReader::open(path)?;
    let states_wanted = options.modes.iter().any(|mode| *mode != Mode::Stage);
    let stages_wanted = options.modes.contains(&Mode::Stage);
    reader.select(match (states_wanted, stages_wanted) {
        (true, true) => |kind| matches!(kind, ChannelKind::Expect(_) | ChannelKind::Stages(_)),
        (true, false) => |kind| matches!(kind, ChannelKind::Expect(_)),
        (false, _) => |kind| matches!(kind, ChannelKind::Stages(_)),
    });
    let scene = reader.scene().clone();
    let mut run = CaseRun::new(simulator, path, &scene, options, policy);
    let mut states = FrameStates::new();
    while let Some(event) = reader.next_event(&mut states)? {
        match event {
            TraceEvent::States {
                kind: ChannelKind::Expect(oracle),
                frame,
                ..
            } => run.states(oracle, frame, &states)?,
            TraceEvent::Stages { oracle, message } => {
                run.stages(oracle, message.frame, &message.records)?
            }
            _ => {}
        }
    }
    run.finish()
}

fn run_files(
    simulator: &dyn Simulator,
    path: &Path,
    expect: &[PathBuf],
    stages: &[PathBuf],
    options: &Options,
    policy: &Policy,
) -> Result<Outcome, RunError> {
    let scene = Scene::open(path)?;
    let mut run = CaseRun::new(simulator, path, &scene, options, policy);
    if options.modes.iter().any(|mode| *mode != Mode::Stage) {
        if expect.is_empty() {
            let reason = "no expectations for this scene: put NAME.expect.jsonl beside it or name their folder with --expect";
            return Err(RunError::Expectation {
                path: path.into(),
                reason: reason.into(),
            });
        }
        for file in expect {
            expectation_file(&scene, file, |oracle, frame, states| {
                run.states(oracle, frame, states)
            })?;
        }
    }
    if options.modes.contains(&Mode::Stage) {
        for file in stages {
            stage_file(&mut run, &scene, file)?;
        }
    }
    run.finish()
}

fn check_scene(path: &Path, scene: &Scene, named: &str) -> Result<(), RunError> {
    if named == scene.name {
        return Ok(());
    }
    let reason = format!("is of scene `{named}`, not of `{}`", scene.name);
    Err(RunError::Expectation {
        path: path.into(),
        reason,
    })
}

/// Hands the states of an expected-state trace to `visit`, frame by frame: oracle, frame, states.
pub(super) fn expectation_file(
    scene: &Scene,
    file: &Path,
    mut visit: impl FnMut(&str, i32, &FrameStates) -> Result<(), RunError>,
) -> Result<(), RunError> {
    let mut reader = ExpectReader::open(file)?;
    check_scene(file, scene, &reader.header.scene)?;
    let oracle = reader.header.oracle.clone();
    let mut states = FrameStates::new();
    let mut next = FrameState::default();
    let mut more = reader.next_into(&mut next)?;
    while more {
        states.clear();
        let frame = next.frame;
        while more && next.frame == frame {
            std::mem::swap(states.push(frame, next.time, next.guid), &mut next);
            more = reader.next_into(&mut next)?;
        }
        visit(&oracle, frame, &states)?;
    }
    Ok(())
}

/// Refuses a frame that is not in the scene, or comes before `next`, the first that has not been run yet.
pub(super) fn check_frame(
    path: &Path,
    scene: &Scene,
    oracle: &str,
    frame: i32,
    next: i32,
) -> Result<(), RunError> {
    let reason = if i64::from(frame) >= scene.frame_count().into() {
        format!("oracle {oracle} has frame {frame}, the scene ends before it")
    } else if frame < next {
        format!("oracle {oracle} has frame {frame} out of order")
    } else {
        return Ok(());
    };
    Err(RunError::Expectation {
        path: path.into(),
        reason,
    })
}

fn stage_file(run: &mut CaseRun<'_>, scene: &Scene, file: &Path) -> Result<(), RunError> {
    let mut reader = StageReader::open(file)?;
    check_scene(file, scene, &reader.header.scene)?;
    let oracle = reader.header.oracle.clone();
    let mut records: Vec<Box<RawValue>> = Vec::new();
    let mut frame = None;
    while let Some((head, text)) = reader.next_record()? {
        let text = text.to_owned();
        if let Some(of) = frame.filter(|of| *of != head.frame) {
            run.stages(&oracle, of, &records)?;
            records.clear();
        }
        frame = Some(head.frame);
        records.push(text);
    }
    match frame {
        Some(frame) => run.stages(&oracle, frame, &records),
        None => Ok(()),
    }
}

/// A case while it runs.
struct CaseRun<'a> {
    simulator: &'a dyn Simulator,
    path: &'a Path,
    scene: &'a Scene,
    options: &'a Options,
    policy: &'a Policy,
    frame_runs: BTreeMap<String, Vec<FrameRun>>,
    /// `None`: a record could not be understood, the rest is not run.
    stage_runs: BTreeMap<String, Option<StageRun>>,
    errors: Vec<RunError>,
}

impl<'a> CaseRun<'a> {
    fn new(
        simulator: &'a dyn Simulator,
        path: &'a Path,
        scene: &'a Scene,
        options: &'a Options,
        policy: &'a Policy,
    ) -> Self {
        Self {
            simulator,
            path,
            scene,
            options,
            policy,
            frame_runs: BTreeMap::new(),
            stage_runs: BTreeMap::new(),
            errors: Vec::new(),
        }
    }

    /// Expected states of a frame.
    fn states(&mut self, oracle: &str, frame: i32, expected: &FrameStates) -> Result<(), RunError> {
        if !self.frame_runs.contains_key(oracle) {
            let runs = self.start_frame_runs(oracle)?;
            self.frame_runs.insert(oracle.into(), runs);
        }
        let (path, scene) = (self.path, self.scene);
        for run in self.frame_runs.get_mut(oracle).into_iter().flatten() {
            check_frame(path, scene, oracle, frame, run.next_frame)?;
            run.advance(frame, expected)
                .map_err(|source| RunError::Simulation {
                    path: path.into(),
                    source,
                })?;
        }
        Ok(())
    }

    fn start_frame_runs(&self, oracle: &str) -> Result<Vec<FrameRun>, RunError> {
        if self
            .options
            .oracle
            .as_deref()
            .is_some_and(|wanted| wanted != oracle)
        {
            return Ok(Vec::new());
        }
        let modes = self
            .options
            .modes
            .iter()
            .filter(|mode| **mode != Mode::Stage);
        modes
            .map(|mode| {
                let (profile, simulation) = self.start(oracle)?;
                let rules = self.policy.rules_for(&self.scene.name, oracle);
                let track = &self.scene.track;
                let mut run = FrameRun::new(*mode, profile, simulation, track, &rules);
                if self.options.series {
                    run.keep_series(&self.scene.name, oracle);
                }
                Ok(run)
            })
            .collect()
    }

    /// A simulation under the profile for this oracle, and the profile's name.
    fn start(&self, oracle: &str) -> Result<(String, Box<dyn Simulation>), RunError> {
        let name = self
            .options
            .profile
            .clone()
            .unwrap_or_else(|| profile_of(oracle).to_owned());
        let profile = Profile::named(&name).ok_or_else(|| RunError::Profile {
            path: self.path.into(),
            name: name.clone(),
        })?;
        let simulation = self.simulator.start(self.scene, &profile);
        let simulation = simulation.map_err(|source| RunError::Simulation {
            path: self.path.into(),
            source,
        })?;
        Ok((name, simulation))
    }

    /// Stage checkpoints of a frame.
    fn stages(
        &mut self,
        oracle: &str,
        frame: i32,
        records: &[Box<RawValue>],
    ) -> Result<(), RunError> {
        // An independent model wrote them in the name of this oracle.
        let oracle = oracle.strip_prefix("model-").unwrap_or(oracle);
        if self
            .options
            .oracle
            .as_deref()
            .is_some_and(|wanted| wanted != oracle)
        {
            return Ok(());
        }
        if !self.stage_runs.contains_key(oracle) {
            let (profile, simulation) = self.start(oracle)?;
            self.stage_runs.insert(
                oracle.into(),
                Some(StageRun {
                    profile,
                    simulation,
                    rules: self.policy.rules_for(&self.scene.name, oracle),
                    entities: Vec::new(),
                }),
            );
        }
        let run = self.stage_runs.get_mut(oracle);
        if let Some(slot) = run
            && let Some(stage_run) = slot
            && let Err(source) = stage_run.frame(frame, records)
        {
            *slot = None;
            self.errors.push(RunError::Simulation {
                path: self.path.into(),
                source,
            });
        }
        Ok(())
    }

    fn finish(self) -> Result<Outcome, RunError> {
        let mut results = Vec::new();
        let mut series = Vec::new();
        for (oracle, runs) in self.frame_runs {
            for run in runs {
                series.extend(run.series);
                for (guid, comparison) in run.entities {
                    if comparison.frames_compared == 0 {
                        let reason = format!(
                            "oracle {oracle} has no record of the tracked entity 0x{guid:X}"
                        );
                        return Err(RunError::Expectation {
                            path: self.path.into(),
                            reason,
                        });
                    }
                    results.push(RunResult::new(
                        &self.scene.name,
                        &oracle,
                        &run.profile,
                        run.mode,
                        guid,
                        comparison,
                    ));
                }
            }
        }
        for (oracle, run) in self.stage_runs {
            for (guid, comparison, stages) in run.into_iter().flat_map(|run| {
                let profile = run.profile;
                run.entities
                    .into_iter()
                    .map(move |(guid, comparison, stages)| {
                        ((guid, profile.clone()), comparison, stages)
                    })
            }) {
                let (guid, profile) = guid;
                let mut result = RunResult::new(
                    &self.scene.name,
                    &oracle,
                    &profile,
                    Mode::Stage,
                    guid,
                    comparison,
                );
                result.stages = stages;
                results.push(result);
            }
        }
        Ok(Outcome {
            results,
            errors: self.errors,
            series,
        })
    }
}

/// One simulation beside one oracle's states.
struct FrameRun {
    mode: Mode,
    profile: String,
    simulation: Box<dyn Simulation>,
    produced: FrameStates,
    /// Expected records of the frame before, for [`Mode::Resync`].
    previous: FrameStates,
    next_frame: i32,
    entities: Vec<(u32, Comparison)>,
    /// One per entity, or none at all.
    series: Vec<Series>,
}

impl FrameRun {
    fn new(
        mode: Mode,
        profile: String,
        simulation: Box<dyn Simulation>,
        track: &[u32],
        rules: &[Arc<Rule>],
    ) -> Self {
        Self {
            mode,
            profile,
            simulation,
            produced: FrameStates::new(),
            previous: FrameStates::new(),
            next_frame: -1,
            entities: track
                .iter()
                .map(|guid| (*guid, with_rules(rules)))
                .collect(),
            series: Vec::new(),
        }
    }

    /// Keeps what a report draws from now on.
    fn keep_series(&mut self, scene: &str, oracle: &str) {
        let entities = self.entities.iter();
        self.series = entities
            .map(|(guid, _)| Series::new(scene, oracle, self.mode, *guid))
            .collect();
    }

    /// Runs up to `frame` and compares it.
    fn advance(&mut self, frame: i32, expected: &FrameStates) -> Result<(), SimulationError> {
        while self.next_frame <= frame {
            self.run_next()?;
        }
        for (index, expected) in expected.iter().enumerate() {
            // Both lists are in the order of `track`, so the record is usually at the same place.
            let actual = self
                .produced
                .get(index)
                .filter(|actual| actual.guid == expected.guid);
            let actual = actual.or_else(|| self.produced.of(expected.guid));
            let is_it = |(guid, _): &(u32, Comparison)| *guid == expected.guid;
            let place = if self.entities.get(index).is_some_and(is_it) {
                index
            } else if let Some(place) = self.entities.iter().position(is_it) {
                place
            } else {
                continue;
            };
            let (_, comparison) = &mut self.entities[place];
            let exact_before = comparison.frames_exact;
            comparison.frame(expected, actual);
            if let Some(series) = self.series.get_mut(place) {
                series.frame(expected, actual, comparison.frames_exact > exact_before);
            }
        }
        if self.mode == Mode::Resync {
            self.previous.copy_from(expected);
        }
        Ok(())
    }

    fn run_next(&mut self) -> Result<(), SimulationError> {
        self.produced.clear();
        if let Ok(frame) = u32::try_from(self.next_frame) {
            if self.mode == Mode::Resync {
                for expected in self
                    .previous
                    .iter()
                    .filter(|state| state.frame == self.next_frame - 1)
                {
                    self.simulation.load_state(expected)?;
                }
            }
            self.simulation.step(frame, &mut self.produced)?;
        } else {
            self.simulation.frame_minus_one(&mut self.produced)?;
        }
        self.next_frame += 1;
        Ok(())
    }
}

fn with_rules(rules: &[Arc<Rule>]) -> Comparison {
    Comparison {
        rules: rules.to_vec(),
        ..Comparison::default()
    }
}

/// Records per stage.
type StageCounts = BTreeMap<String, StageCount>;

/// One simulation that runs stages alone.
struct StageRun {
    profile: String,
    simulation: Box<dyn Simulation>,
    rules: Vec<Arc<Rule>>,
    entities: Vec<(u32, Comparison, StageCounts)>,
}

impl StageRun {
    fn frame(&mut self, frame: i32, records: &[Box<RawValue>]) -> Result<(), SimulationError> {
        let bad = |reason: String| SimulationError::Stage {
            reason: format!("frame {frame}: {reason}"),
        };
        let records: Vec<Value> = records
            .iter()
            .map(|record| {
                serde_json::from_str(record.get()).map_err(|error| bad(error.to_string()))
            })
            .collect::<Result<_, _>>()?;
        for (index, record) in records.iter().enumerate() {
            let guid = record
                .get("guid")
                .and_then(json::id)
                .ok_or_else(|| bad("a record has no guid".into()))?;
            let stage = record
                .get("stage")
                .and_then(Value::as_str)
                .ok_or_else(|| bad("a record has no stage".into()))?;
            let expected = record
                .get("out")
                .ok_or_else(|| bad("a record has no out".into()))?;
            let actual = self.simulation.run_stage(&records, index)?;
            let place = self
                .entities
                .iter()
                .position(|(of, ..)| *of == guid)
                .unwrap_or_else(|| {
                    self.entities
                        .push((guid, with_rules(&self.rules), StageCounts::new()));
                    self.entities.len() - 1
                });
            let (_, comparison, stages) = &mut self.entities[place];
            let before = (comparison.frames_compared, comparison.frames_exact);
            comparison.stage(frame, stage, expected, actual.as_ref());
            let counts = stages.entry(stage.to_owned()).or_default();
            counts.compared += comparison.frames_compared - before.0;
            counts.exact += comparison.frames_exact - before.1;
            counts.not_run += u64::from(actual.is_none());
        }
        Ok(())
    }
}
