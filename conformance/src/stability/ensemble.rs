//! Ensembles: the same scene, a little different at the start, and what becomes of the difference.

use std::{collections::BTreeMap, sync::Arc};

use ac_client::{
    dat::DatSet,
    frame::{FrameState, FrameStates, NoProbe, state::Fields},
    profile::Profile,
};
use ac_golden_traces::Scene;
use ac_replayer::{SimulationError, client::SceneRun};
use serde::Serialize;

/// Side of a landblock, m.
const BLOCK: f64 = 192.0;
/// A jump in one frame by this factor, and beyond this distance, m, is a discontinuity.
const JUMP: f64 = 30.0;
const FAR: f64 = 5e-3;
/// Differences that grow by more than this are growing, and that shrink below that are contractive.
const GROWN: f64 = 10.0;
const SHRUNK: f64 = 0.5;
/// A discrete difference this many frames before a jump, or fewer, is its cause.
const RECENT: usize = 30;
/// What rounding in the clock may move something, m.
const CLOCK: f64 = 1e-5;
/// Points that a plot keeps.
const POINTS: usize = 160;

/// What is changed at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "what", content = "by")]
pub enum Change {
    /// x of every entity, by units in the last place.
    PlaceUlps(u32),
    /// x of every entity, m.
    Place(f32),
    /// The length of every frame, by units in the last place of an f32.
    FrameUlps(u32),
}

impl Change {
    /// The whole ensemble.
    pub const ALL: [Self; 10] = [
        Self::PlaceUlps(1),
        Self::PlaceUlps(2),
        Self::PlaceUlps(4),
        Self::PlaceUlps(8),
        Self::Place(1e-6),
        Self::Place(1e-5),
        Self::Place(1e-4),
        Self::Place(1e-3),
        Self::FrameUlps(1),
        Self::FrameUlps(4),
    ];

    /// Whether it is the clock that is changed, not a place.
    pub const fn is_of_frames(self) -> bool {
        matches!(self, Self::FrameUlps(_))
    }

    /// The change in few words.
    pub fn name(self) -> String {
        match self {
            Self::PlaceUlps(n) => format!("x + {n} ulp"),
            Self::Place(m) => format!("x + {m:e} m"),
            Self::FrameUlps(n) => format!("dt + {n} ulp"),
        }
    }

    /// The scene with the change.
    pub fn apply(self, scene: &Scene) -> Scene {
        let mut changed = scene.clone();
        match self {
            Self::PlaceUlps(n) => {
                for spec in &mut changed.entities {
                    let x = &mut spec.position.origin[0];
                    *x = (0..n).fold(*x, |x, _| x.next_up());
                }
            }
            Self::Place(m) => {
                for spec in &mut changed.entities {
                    spec.position.origin[0] += m;
                }
            }
            Self::FrameUlps(n) => {
                for run in &mut changed.frames {
                    run.dt *= 1.0 + f64::from(n) * f64::from(f32::EPSILON) / 2.0;
                }
            }
        }
        changed
    }
}

/// How a scene takes small changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// It forgets them.
    Contractive,
    /// It keeps them.
    Neutral,
    /// It amplifies them.
    Growing,
    /// Something is decided differently, and the runs part in one frame.
    Discontinuous,
}

impl Class {
    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Contractive => "contractive",
            Self::Neutral => "neutral",
            Self::Growing => "growing",
            Self::Discontinuous => "discontinuous",
        }
    }
}

/// What parted two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Event {
    /// The frame.
    pub frame: i32,
    /// What is different: quanta, cell, contact, outcome, collision, motion, frame of the
    /// animation, plane touched, or nothing that is discrete.
    pub kind: &'static str,
    /// Distance before, m.
    pub before: f64,
    /// Distance after, m.
    pub after: f64,
}

/// One changed run against the unchanged one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Member {
    /// What was changed.
    pub change: Change,
    /// How the scene took it.
    pub class: Class,
    /// Distance at the start, m; for frames: after the first frame that shows one, at most 10 µm.
    pub start: f64,
    /// Largest distance, m.
    pub max: f64,
    /// Distance at the end, m.
    pub end: f64,
    /// Factor per frame, fitted while nothing discrete differs.
    pub growth: Option<f64>,
    /// What parted the runs.
    pub event: Option<Event>,
    /// Distances over the frames, thinned out.
    #[serde(skip)]
    pub series: Vec<(i32, f64)>,
}

/// A scene and its ensemble.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ensemble {
    /// Name of the scene.
    pub scene: String,
    /// The worst class of the changes of place.
    pub class: Class,
    /// The worst class of the changes of the length of frames.
    pub clock: Class,
    /// One per change.
    pub members: Vec<Member>,
}

/// Runs a scene with every change.
///
/// # Errors
/// When the scene cannot be set up.
pub fn run(
    scene: &Scene,
    source: &Arc<DatSet>,
    profile: &Profile,
    changes: &[Change],
) -> Result<Ensemble, SimulationError> {
    let base = states(scene, source, profile)?;
    let mut members = Vec::new();
    for change in changes {
        let other = states(&change.apply(scene), source, profile)?;
        members.push(member(*change, &base, &other));
    }
    let worst = |frames: bool| {
        let of = members.iter().filter(|m| m.change.is_of_frames() == frames);
        of.map(|m| m.class).max().unwrap_or(Class::Neutral)
    };
    Ok(Ensemble {
        scene: scene.name.clone(),
        class: worst(false),
        clock: worst(true),
        members,
    })
}

/// Per frame the states of the tracked entities.
fn states(
    scene: &Scene,
    source: &Arc<DatSet>,
    profile: &Profile,
) -> Result<Vec<Vec<FrameState>>, SimulationError> {
    let mut run = SceneRun::new(scene, Arc::clone(source), profile)?;
    let mut states = FrameStates::new();
    run.write_records(-1, &mut states);
    let mut all = vec![states.iter().cloned().collect()];
    for frame in 0..scene.frame_count() {
        run.run_frame(frame, &mut NoProbe);
        run.write_records(i32::try_from(frame).unwrap_or(i32::MAX), &mut states);
        all.push(states.iter().cloned().collect());
    }
    Ok(all)
}

/// Largest distance of two entities with the same place in the list, and what discrete things differ first.
fn apart(a: &[FrameState], b: &[FrameState]) -> (f64, Option<&'static str>) {
    let mut distance = 0.0_f64;
    let mut kind = None;
    for (a, b) in a.iter().zip(b) {
        if let (Some(pa), Some(pb)) = (place(a), place(b)) {
            let d: f64 = pa.iter().zip(pb).map(|(x, y)| (x - y) * (x - y)).sum();
            distance = distance.max(d.sqrt());
        }
        kind = kind.or_else(|| discrete(a, b));
    }
    (distance, kind)
}

fn place(state: &FrameState) -> Option<[f64; 3]> {
    let here = state.cell != 0 && state.has.contains(Fields::ORIGIN);
    let block = |shift: u32| f64::from(state.cell >> shift & 0xFF) * BLOCK;
    let [x, y, z] = state.origin.map(f64::from);
    here.then_some([x + block(24), y + block(16), z])
}

/// What is decided differently, the earliest cause first.
fn discrete(a: &FrameState, b: &FrameState) -> Option<&'static str> {
    let outcomes = |s: &FrameState| s.steps.iter().map(|s| s.outcome).collect::<Vec<_>>();
    if a.steps.len() != b.steps.len() {
        return Some("quanta");
    }
    if a.cell != b.cell {
        return Some("cell");
    }
    if a.contact_plane.is_some() != b.contact_plane.is_some() || a.transient != b.transient {
        return Some("contact");
    }
    if outcomes(a) != outcomes(b) || a.sliding_normal.is_some() != b.sliding_normal.is_some() {
        return Some("outcome");
    }
    if a.collisions != b.collisions {
        return Some("collision");
    }
    let moving = |s: &FrameState| {
        let motion = s
            .motion
            .map(|m| (m.style, m.substate, m.forward, m.sidestep, m.turn));
        (motion, s.anim.as_ref().map(|a| (a.id, a.queue.len())))
    };
    if moving(a) != moving(b) || a.events != b.events {
        return Some("motion");
    }
    let frame = |s: &FrameState| s.anim.as_ref().map(|anim| anim.frame_number.floor());
    if frame(a) != frame(b) {
        return Some("animation frame");
    }
    // The same kind of contact with something else.
    let other = |a: Option<[f32; 3]>, b: Option<[f32; 3]>| match (a, b) {
        (Some(a), Some(b)) => a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.01),
        _ => false,
    };
    let plane = |s: &FrameState| s.contact_plane.map(|plane| plane.n);
    (other(plane(a), plane(b)) || other(a.sliding_normal, b.sliding_normal)).then_some("plane")
}

fn member(change: Change, base: &[Vec<FrameState>], other: &[Vec<FrameState>]) -> Member {
    let apart: Vec<(f64, Option<&'static str>)> =
        base.iter().zip(other).map(|(a, b)| apart(a, b)).collect();
    let start = apart
        .iter()
        .map(|(d, _)| *d)
        .find(|d| *d > 0.0)
        .unwrap_or(0.0);
    // A clock that is off by rounding moves nothing farther than this by itself.
    let start = if change.is_of_frames() {
        start.min(CLOCK)
    } else {
        start
    };
    let max = apart.iter().map(|(d, _)| *d).fold(0.0, f64::max);
    let end = apart.last().map_or(0.0, |(d, _)| *d);
    let event = event(&apart, start);
    let until = event
        .as_ref()
        .map_or(apart.len(), |e| (e.frame + 1).max(0) as usize);
    let class = if event.is_some() {
        Class::Discontinuous
    } else if max > start * GROWN && max > 1e-5 {
        Class::Growing
    } else if end < start * SHRUNK {
        Class::Contractive
    } else {
        Class::Neutral
    };
    let every = apart.len().div_ceil(POINTS).max(1);
    Member {
        change,
        class,
        start,
        max,
        end,
        growth: growth(&apart[..until.min(apart.len())]),
        event,
        series: apart
            .chunks(every)
            .enumerate()
            .map(|(i, chunk)| {
                let largest = chunk.iter().map(|(d, _)| *d).fold(0.0, f64::max);
                (i32::try_from(i * every).unwrap_or(i32::MAX) - 1, largest)
            })
            .collect(),
    }
}

/// The first frame in which the distance jumps, and the nearest discrete difference at or before it.
fn event(apart: &[(f64, Option<&'static str>)], start: f64) -> Option<Event> {
    let mut highest = start;
    for (index, (distance, kind)) in apart.iter().enumerate() {
        if *distance > FAR && *distance > highest * JUMP {
            let recent = apart[index.saturating_sub(RECENT)..=index].iter();
            let kind = kind.or_else(|| recent.rev().find_map(|(_, kind)| *kind));
            return Some(Event {
                frame: i32::try_from(index).unwrap_or(i32::MAX) - 1,
                kind: kind.unwrap_or("none"),
                before: highest,
                after: *distance,
            });
        }
        highest = highest.max(*distance);
    }
    None
}

/// Factor per frame of the exponential that fits best; `None` of fewer than eight distances.
fn growth(apart: &[(f64, Option<&'static str>)]) -> Option<f64> {
    let points: Vec<(f64, f64)> = apart
        .iter()
        .enumerate()
        .filter(|(_, (d, _))| *d > 0.0)
        .map(|(i, (d, _))| (i as f64, d.ln()))
        .collect();
    if points.len() < 8 {
        return None;
    }
    let n = points.len() as f64;
    let (mx, my) = (
        points.iter().map(|p| p.0).sum::<f64>() / n,
        points.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let xx: f64 = points.iter().map(|p| (p.0 - mx) * (p.0 - mx)).sum();
    let xy: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    Some((xy / xx).exp())
}

/// How many scenes are of each class.
pub fn counts(ensembles: &[Ensemble]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for ensemble in ensembles {
        *counts.entry(ensemble.class.name()).or_default() += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_the_factor_of_an_exponential() {
        let apart: Vec<_> = (0..20).map(|i| (1e-6 * 1.5f64.powi(i), None)).collect();
        assert!((growth(&apart).unwrap() - 1.5).abs() < 1e-9);
        assert_eq!(growth(&apart[..5]), None);
    }

    #[test]
    fn a_jump_names_what_was_decided() {
        let mut apart = vec![(1e-6, None); 10];
        apart.push((1e-6, Some("contact")));
        apart.push((0.2, None));
        let found = event(&apart, 1e-6).unwrap();
        assert_eq!((found.frame, found.kind), (10, "contact"));
        assert_eq!(event(&apart[..11], 1e-6), None);
    }
}
