//! Which numbered points of difference a scene is sensitive to.
//!
//! A scene that is met under the profile of its oracle runs again, once for every switch in which that profile and `retail`
//! differ, with this one switch set to the choice of `retail`. A scene is *sensitive* to a switch when any frame of the free
//! run changes; the run stops at the first one. What no scene is sensitive to, no comparison here can tell apart.
//!
//! One switch at a time shows no pair that only acts together, and a switch that another one hides. Expectations of a case
//! are held in memory while its runs go over them.

mod report;

use std::collections::BTreeMap;

use ac_client::{
    frame::FrameStates,
    profile::{Profile, Switch},
};
use ac_golden_traces::{
    Scene,
    trace::{ChannelKind, TraceEvent, TraceReader},
};
use ac_replayer::{SimulationError, Simulator};
use rayon::prelude::*;
use serde::Serialize;

pub use report::{SwitchCount, human, json, switch_counts};

use super::{Case, RunError, SELF, runner};
use crate::compare::{Comparison, Divergence};

/// What came of all cases.
#[derive(Debug, Default)]
pub struct Outcome {
    /// By scene and oracle.
    pub scenes: Vec<SceneSensitivity>,
    /// Cases that could not run.
    pub errors: Vec<RunError>,
}

/// What one scene with the expectations of one oracle is sensitive to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneSensitivity {
    /// Name of the scene.
    pub scene: String,
    /// Who expects.
    pub oracle: String,
    /// Switches that were set, one at a time: all in which the oracle's profile and `retail` differ.
    pub tried: usize,
    /// Where the run under the oracle's own profile parts from it. Then nothing was tried: no change could be told from that.
    pub unmet: Option<Change>,
    /// The switches that change a frame, in the order of the specification's index.
    pub sensitive: Vec<Sensitive>,
}

/// A switch that changes a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitive {
    /// Name of the switch: its field in [`Profile`].
    pub switch: &'static str,
    /// Identifiers in the specification.
    pub id: &'static str,
    /// Choice of the oracle's profile.
    pub oracle_choice: String,
    /// Choice of `retail`, with which the scene was run.
    pub retail_choice: String,
    /// The first change.
    #[serde(flatten)]
    pub change: Change,
}

/// The first place where a run parts from the expectation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The entity.
    pub guid: String,
    /// Frame, field and values.
    #[serde(flatten)]
    pub divergence: Divergence,
}

/// Measures all cases on the current thread pool, with `oracle` or with every oracle that they name. `done` is called after
/// each case.
pub fn run(
    simulator: &dyn Simulator,
    cases: &[Case],
    oracle: Option<&str>,
    done: impl Fn() + Sync,
) -> Outcome {
    let each: Vec<_> = cases
        .par_iter()
        .map(|case| {
            let result = run_case(simulator, case, oracle);
            done();
            result
        })
        .collect();
    let mut outcome = Outcome::default();
    for case in each {
        match case {
            Ok(scenes) => outcome.scenes.extend(scenes),
            Err(error) => outcome.errors.push(error),
        }
    }
    outcome
        .scenes
        .sort_by(|a, b| (&a.scene, &a.oracle).cmp(&(&b.scene, &b.oracle)));
    outcome
}

/// The switches in which the profile of an oracle and `retail` differ.
fn differing<'a>(own: &'a Profile, retail: &'a Profile) -> impl Iterator<Item = &'static Switch> {
    Profile::SWITCHES
        .iter()
        .filter(|switch| (switch.differs)(own, retail))
}

fn run_case(
    simulator: &dyn Simulator,
    case: &Case,
    oracle: Option<&str>,
) -> Result<Vec<SceneSensitivity>, RunError> {
    let expected = Expected::read(case, oracle)?;
    expected
        .oracles
        .iter()
        .map(|(oracle, frames)| {
            let own = Profile::named(oracle).ok_or_else(|| RunError::Profile {
                path: case.path().into(),
                name: oracle.clone(),
            })?;
            scene_with_oracle(simulator, &expected.scene, oracle, frames, &own).map_err(|source| {
                RunError::Simulation {
                    path: case.path().into(),
                    source,
                }
            })
        })
        .collect()
}

fn scene_with_oracle(
    simulator: &dyn Simulator,
    scene: &Scene,
    oracle: &str,
    frames: &Frames,
    own: &Profile,
) -> Result<SceneSensitivity, SimulationError> {
    let retail = Profile::retail();
    let mut result = SceneSensitivity {
        scene: scene.name.clone(),
        oracle: oracle.into(),
        tried: 0,
        unmet: first_change(simulator, scene, frames, own)?,
        sensitive: Vec::new(),
    };
    if result.unmet.is_some() {
        return Ok(result);
    }
    let switches: Vec<&Switch> = differing(own, &retail).collect();
    let changes = switches
        .par_iter()
        .map(|switch| {
            let mut profile = own.clone();
            (switch.copy)(&mut profile, &retail);
            first_change(simulator, scene, frames, &profile)
        })
        .collect::<Result<Vec<_>, _>>()?;
    result.tried = switches.len();
    for (switch, change) in switches.iter().zip(changes) {
        result.sensitive.extend(change.map(|change| Sensitive {
            switch: switch.field,
            id: switch.id,
            oracle_choice: (switch.show)(own),
            retail_choice: (switch.show)(&retail),
            change,
        }));
    }
    Ok(result)
}

/// Runs a scene freely, up to the first frame in which a tracked entity is not as expected.
fn first_change(
    simulator: &dyn Simulator,
    scene: &Scene,
    frames: &Frames,
    profile: &Profile,
) -> Result<Option<Change>, SimulationError> {
    let mut simulation = simulator.start(scene, profile)?;
    let mut produced = FrameStates::new();
    let mut next_frame = -1;
    for (frame, expected) in frames {
        while next_frame <= *frame {
            produced.clear();
            match u32::try_from(next_frame) {
                Ok(next) => simulation.step(next, &mut produced)?,
                Err(_) => simulation.frame_minus_one(&mut produced)?,
            }
            next_frame += 1;
        }
        for record in expected
            .iter()
            .filter(|record| scene.track.contains(&record.guid))
        {
            let mut comparison = Comparison::default();
            comparison.frame(record, produced.of(record.guid));
            if let Some(divergence) = comparison.first_divergence {
                return Ok(Some(Change {
                    guid: format!("0x{:X}", record.guid),
                    divergence,
                }));
            }
        }
    }
    Ok(None)
}

/// Expected states in the order of their frames.
type Frames = Vec<(i32, FrameStates)>;

/// The expectations of a case.
struct Expected {
    scene: Scene,
    oracles: BTreeMap<String, Frames>,
}

impl Expected {
    fn read(case: &Case, oracle: Option<&str>) -> Result<Self, RunError> {
        match case {
            Case::Trace(path) => {
                let mut reader = TraceReader::open(path)?;
                reader.select(|kind| matches!(kind, ChannelKind::Expect(_)));
                let mut read = Self::new(reader.scene().clone());
                let mut states = FrameStates::new();
                while let Some(event) = reader.next_event(&mut states)? {
                    if let TraceEvent::States {
                        kind: ChannelKind::Expect(of),
                        frame,
                        ..
                    } = event
                    {
                        read.add(case, oracle, of, frame, &states)?;
                    }
                }
                Ok(read)
            }
            Case::Files { scene, expect, .. } => {
                let scene = Scene::open(scene)?;
                let mut read = Self::new(scene.clone());
                for file in expect {
                    runner::expectation_file(&scene, file, |of, frame, states| {
                        read.add(case, oracle, of, frame, states)
                    })?;
                }
                Ok(read)
            }
        }
    }

    fn new(scene: Scene) -> Self {
        Self {
            scene,
            oracles: BTreeMap::new(),
        }
    }

    fn add(
        &mut self,
        case: &Case,
        wanted: Option<&str>,
        oracle: &str,
        frame: i32,
        states: &FrameStates,
    ) -> Result<(), RunError> {
        // What the library itself expects is of `retail`: there is no switch to set.
        if oracle == SELF || wanted.is_some_and(|wanted| wanted != oracle) {
            return Ok(());
        }
        let frames = match self.oracles.get_mut(oracle) {
            Some(frames) => frames,
            None => self.oracles.entry(oracle.into()).or_default(),
        };
        let next = frames.last().map_or(-1, |(last, _)| *last + 1);
        runner::check_frame(case.path(), &self.scene, oracle, frame, next)?;
        let mut copy = FrameStates::new();
        copy.copy_from(states);
        frames.push((frame, copy));
        Ok(())
    }
}

#[cfg(test)]
mod tests;
