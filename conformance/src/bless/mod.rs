//! Expectations of this library's own: oracle `self`.
//!
//! An oracle says what the retail client did; nobody here may change that. But the profile `retail` chooses between the
//! oracles, so that no oracle meets it everywhere, and sessions of packets have no oracle at all. What `retail` does there is
//! recorded under the name `self`: a *golden* trace, true only in that it is what the library did when someone looked at it and
//! said yes. A run compares with it like with any other oracle, so that a change of behaviour shows; *blessing* is looking at
//! the change and saying yes to it.
//!
//! Where it lies: a trace that already has a channel `/expect/self` is rewritten in place, everything else in it untouched. For a
//! scene without one (the bundled ones, which belong to oracles) it is a trace of its own, `golden-traces/self/AREA/NAME.mcap`,
//! with scene and expectation.
//!
//! [`collect`] says what would change; [`write()`](write::write) makes it so.

mod diff;
mod report;
pub mod write;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use ac_client::{frame::FrameStates, profile::Profile};
use ac_golden_traces::{
    GoldenError, Scene, corpus,
    trace::{ChannelKind, TraceEvent, TraceReader, rewrite::Frame},
};
use ac_replayer::Simulator;
use rayon::prelude::*;

pub use diff::{Difference, FieldChange, Sample};
pub use report::human;

use crate::run::{Case, RunError, SELF};

/// The folder with the own expectations of the bundled scenes.
pub fn bundled() -> PathBuf {
    corpus::bundled().join("self")
}

/// One scene whose own expectation is not what the library does.
#[derive(Clone, Debug)]
pub struct Change {
    /// Name of the scene.
    pub scene: String,
    /// The case that it is run from.
    pub case: Case,
    /// The trace that has, or gets, the expectation.
    pub target: PathBuf,
    /// There is no expectation yet.
    pub new: bool,
    /// The trace has another scene of this name: it is written anew.
    pub other_scene: bool,
    /// What differs.
    pub difference: Difference,
}

/// What blessing everything would do.
#[derive(Debug, Default)]
pub struct Collected {
    /// Scenes looked at.
    pub scenes: usize,
    /// Those that differ, by name.
    pub changes: Vec<Change>,
    /// Cases that could not run.
    pub errors: Vec<RunError>,
}

/// Runs every scene under `retail` and compares with its own expectation. Scenes without one get theirs under `into`; where
/// that is not given, they are an error. `done` is called after each scene.
pub fn collect(
    simulator: &dyn Simulator,
    cases: &[Case],
    into: Option<&Path>,
    done: impl Fn() + Sync,
) -> Collected {
    let (scenes, errors) = by_scene(cases);
    let each: Vec<_> = scenes
        .par_iter()
        .map(|(name, own)| {
            let change = change(simulator, name, own, into);
            done();
            change
        })
        .collect();
    let mut collected = Collected {
        scenes: scenes.len(),
        errors,
        ..Collected::default()
    };
    for result in each {
        match result {
            Ok(change) => collected.changes.extend(change),
            Err(error) => collected.errors.push(error),
        }
    }
    collected
}

/// The cases of one scene.
#[derive(Debug)]
struct Own {
    /// The one to run.
    case: Case,
    /// The trace with the expectation, if there is one.
    trace: Option<PathBuf>,
}

/// Cases by the name of their scene: a scene may be in two traces, one with the oracles' expectations and one with its own.
fn by_scene(cases: &[Case]) -> (BTreeMap<String, Own>, Vec<RunError>) {
    let mut scenes: BTreeMap<String, Own> = BTreeMap::new();
    let mut errors = Vec::new();
    for case in cases {
        let (name, has_own) = match name_and_own(case) {
            Ok(found) => found,
            Err(error) => {
                errors.push(error);
                continue;
            }
        };
        let trace = has_own.then(|| case.path().to_owned());
        let own = scenes.entry(name).or_insert_with(|| Own {
            case: case.clone(),
            trace: None,
        });
        if own.trace.is_none() && trace.is_some() {
            own.trace = trace;
        }
    }
    (scenes, errors)
}

/// The name of a case's scene, and whether the case has an own expectation.
fn name_and_own(case: &Case) -> Result<(String, bool), RunError> {
    let Case::Trace(path) = case else {
        return Ok((Scene::open(case.path())?.name, false));
    };
    let mut reader = TraceReader::open(path)?;
    reader.select(is_own);
    let own = reader.next_event(&mut FrameStates::new())?.is_some();
    Ok((reader.scene().name.clone(), own))
}

fn is_own(kind: &ChannelKind) -> bool {
    matches!(kind, ChannelKind::Expect(oracle) if oracle == SELF)
}

fn change(
    simulator: &dyn Simulator,
    name: &str,
    own: &Own,
    into: Option<&Path>,
) -> Result<Option<Change>, RunError> {
    let target = match (&own.trace, into) {
        (Some(trace), _) => trace.clone(),
        (None, Some(folder)) => folder.join(format!("{name}{}", corpus::TRACE_SUFFIX)),
        (None, None) => {
            let reason = "has no expectation of its own, and those of oracles are not to be blessed; name the folder for \
                new ones with --into";
            return Err(RunError::Expectation {
                path: own.case.path().into(),
                reason: reason.into(),
            });
        }
    };
    let exists = own.trace.is_some() || target.is_file();
    let produced = produce(simulator, &own.case)?;
    let expected = if exists { read(&target)? } else { Vec::new() };
    let difference = Difference::between(&expected, &produced);
    // The scene may have been edited since: then the old trace is of another one.
    let other_scene = exists
        && own.case.path() != target
        && TraceReader::open(&target)?.scene() != &crate::hash::scene_of(&own.case)?;
    Ok(
        (!exists || other_scene || !difference.is_empty()).then(|| Change {
            scene: name.into(),
            case: own.case.clone(),
            target,
            new: !exists,
            other_scene,
            difference,
        }),
    )
}

/// What the profile `retail` does in a case, frame by frame.
///
/// # Errors
/// When the case cannot be read or run.
pub fn produce(simulator: &dyn Simulator, case: &Case) -> Result<Vec<Frame>, RunError> {
    let profile = Profile::retail();
    let scene = crate::hash::scene_of(case)?;
    let fail = |source| RunError::Simulation {
        path: case.path().into(),
        source,
    };
    let mut simulation = simulator.start(&scene, &profile).map_err(fail)?;
    let mut frames = Vec::new();
    let mut states = FrameStates::new();
    simulation.frame_minus_one(&mut states).map_err(fail)?;
    frames.push((-1, scene.start_time, states));
    for (frame, time) in (0..).zip(scene.times()) {
        let mut states = FrameStates::new();
        simulation
            .step(u32::try_from(frame).unwrap_or(0), &mut states)
            .map_err(fail)?;
        frames.push((frame, time, states));
    }
    Ok(frames)
}

/// The own expectation in a trace.
fn read(path: &Path) -> Result<Vec<Frame>, GoldenError> {
    let mut reader = TraceReader::open(path)?;
    reader.select(is_own);
    let mut frames = Vec::new();
    let mut states = FrameStates::new();
    while let Some(event) = reader.next_event(&mut states)? {
        if let TraceEvent::States { frame, time, .. } = event {
            let mut copy = FrameStates::new();
            copy.copy_from(&states);
            frames.push((frame, time, copy));
        }
    }
    Ok(frames)
}

#[cfg(test)]
mod tests;
