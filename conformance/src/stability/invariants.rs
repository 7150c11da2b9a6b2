//! What must hold in every frame of every scene, and who watches it.

use std::collections::{BTreeMap, BTreeSet};

use ac_client::{
    entity::Entity,
    frame::{FrameState, FrameStates, state::Fields},
    physics::state::{PhysicsState, TransientState},
};
use ac_golden_traces::{Scene, scene::Action};
use ac_replayer::client::SceneRun;
use serde::Serialize;

use super::stage::{Run, Stage};

/// Speed limit of the integrator, m/s, and what one quantum of gravity may add after it.
const SPEED: f64 = 50.0;
const SPEED_ROOM: f64 = 9.8 * 0.2 + 1e-3;
/// Frames without any change after which something rests.
const SETTLED: u32 = 60;
/// How deep something may stand in the ground, m: twice the epsilon of collisions, and rounding.
const DEPTH: f32 = 2e-3;
/// Deepest water that one can stand in, m.
const WATER: f32 = 0.9;
/// Energy per mass, m²/s², that rounding and the resolution of contacts may add in a frame.
const ENERGY: f64 = 0.05;
/// This near to a border of cells, m, either cell is right.
const BORDER: f32 = 1e-3;

/// A rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Invariant {
    /// Finite inputs give finite states.
    Finite,
    /// Nothing is faster than the limit of the integrator.
    Speed,
    /// Nothing gets through a closed wall at a legal speed.
    Tunnel,
    /// What rests goes on resting, bit for bit, until something happens to it.
    Rest,
    /// Nothing sinks into the ground.
    Depth,
    /// Contact does not add energy.
    Energy,
    /// The cell is the one of the position.
    Cell,
    /// The frame number is inside its animation.
    AnimationFrame,
    /// The time of day does not matter.
    TimeOfDay,
    /// The place on the map does not matter.
    Translation,
    /// The order of creation does not matter to those who never meet.
    EntityOrder,
    /// The same scene gives the same bits.
    Repeat,
    /// What the specification says about the case happens.
    Promise,
}

impl Invariant {
    /// Every rule.
    pub const ALL: [Self; 13] = [
        Self::Finite,
        Self::Speed,
        Self::Tunnel,
        Self::Rest,
        Self::Depth,
        Self::Energy,
        Self::Cell,
        Self::AnimationFrame,
        Self::TimeOfDay,
        Self::Translation,
        Self::EntityOrder,
        Self::Repeat,
        Self::Promise,
    ];

    /// The rule in few words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Finite => "finite in, finite out",
            Self::Speed => "speed limit",
            Self::Tunnel => "no way through closed walls",
            Self::Rest => "rest stays rest",
            Self::Depth => "not into the ground",
            Self::Energy => "contact adds no energy",
            Self::Cell => "cell agrees with position",
            Self::AnimationFrame => "frame number inside its animation",
            Self::TimeOfDay => "independent of the time of day",
            Self::Translation => "independent of the landblock",
            Self::EntityOrder => "independent of the order of entities",
            Self::Repeat => "same bits every time",
            Self::Promise => "what the specification says",
        }
    }
}

/// A rule that does not hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Violation {
    /// The rule.
    pub invariant: Invariant,
    /// The frame, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<i32>,
    /// What was found.
    pub detail: String,
    /// What proves that retail does the same: a section, or a scene and frame of an oracle's trace.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retail: Option<String>,
}

/// What is known of an entity.
#[derive(Debug, Default)]
struct Known {
    last: Option<FrameState>,
    still: u32,
    energy: Option<f64>,
    broken: BTreeSet<Invariant>,
}

/// Watches a scene while it runs.
#[derive(Debug)]
pub struct Watch {
    closed: Option<[[f32; 3]; 2]>,
    finite: bool,
    legal: bool,
    scripted: BTreeSet<u32>,
    known: BTreeMap<u32, Known>,
    checks: u64,
    violations: Vec<Violation>,
}

impl Watch {
    /// For a generated scene.
    pub fn new(stage: &Stage) -> Self {
        Self {
            closed: stage.closed,
            ..Self::of(&stage.scene)
        }
    }

    /// For any scene.
    pub fn of(scene: &Scene) -> Self {
        let numbers = inputs(scene);
        Self {
            closed: None,
            finite: numbers.iter().all(|n| n.is_finite()),
            // Rounding of huge coordinates is not what the rules are about.
            legal: numbers.iter().all(|n| n.abs() < 1e6),
            scripted: scene.script.iter().map(|step| step.frame).collect(),
            known: BTreeMap::new(),
            checks: 0,
            violations: Vec::new(),
        }
    }

    /// Looks at every tracked entity after a frame.
    pub fn frame(&mut self, run: &SceneRun, states: &FrameStates) {
        for state in states.iter() {
            let entity = run.object(state.guid).and_then(|id| run.world.entity(id));
            let here = state.cell != 0 && state.has.contains(Fields::ORIGIN);
            let Some(entity) = entity.filter(|_| here) else {
                self.known.remove(&state.guid);
                continue;
            };
            let mut known = self.known.remove(&state.guid).unwrap_or_default();
            let found = [
                self.finite(state),
                speed(state),
                self.tunnel(state),
                self.rest(state, entity, &mut known),
                self.depth(state, entity, run),
                self.energy(state, entity, &mut known),
                self.cell(state, entity, run),
                animation_frame(entity).filter(|_| self.finite),
            ];
            let rules = &Invariant::ALL[..found.len()];
            for (rule, found) in rules.iter().zip(found) {
                let Some(result) = found else {
                    continue;
                };
                self.checks += 1;
                if let Err(detail) = result
                    && known.broken.insert(*rule)
                {
                    self.violations.push(Violation {
                        invariant: *rule,
                        frame: Some(state.frame),
                        detail: format!("{:#X}: {detail}", state.guid),
                        retail: None,
                    });
                }
            }
            known.last = Some(state.clone());
            self.known.insert(state.guid, known);
        }
    }

    /// Checks made and violations found.
    pub fn finish(self, _run: &Run) -> (u64, Vec<Violation>) {
        self.done()
    }

    /// Checks made and violations found.
    pub fn done(self) -> (u64, Vec<Violation>) {
        (self.checks, self.violations)
    }

    fn finite(&self, state: &FrameState) -> Check {
        let all = [
            state.origin,
            state.velocity,
            state.acceleration,
            state.omega,
        ];
        let finite = all
            .iter()
            .flatten()
            .chain(&state.rotation)
            .all(|n| n.is_finite());
        self.finite.then(|| {
            ensure(finite, || {
                format!("origin {:?}, velocity {:?}", state.origin, state.velocity)
            })
        })
    }

    fn tunnel(&self, state: &FrameState) -> Check {
        let [low, high] = self.closed?;
        let inside = (0..3).all(|i| (low[i]..=high[i]).contains(&state.origin[i]));
        Some(ensure(inside, || {
            format!("outside the closed room at {:?}", state.origin)
        }))
    }

    /// What has not changed for long changes by an input or a touch only.
    fn rest(&self, state: &FrameState, entity: &Entity, known: &mut Known) -> Check {
        let last = known.last.as_ref()?;
        let bits = |s: &FrameState| (s.origin.map(f32::to_bits), s.rotation.map(f32::to_bits));
        let same = bits(last) == bits(state) && last.cell == state.cell;
        let frame = u32::try_from(state.frame).unwrap_or(0);
        let disturbed = self.scripted.contains(&frame)
            || !state.collisions.is_empty()
            || !last.collisions.is_empty()
            || entity.position_manager.is_some()
            || entity.body.parent.is_some()
            || state
                .motion
                .is_some_and(|m| !is_ready(m.forward) || m.turn != 0 || m.sidestep != 0)
            || state.velocity != [0.0; 3]
            || state.omega != [0.0; 3];
        let settled = known.still >= SETTLED;
        known.still = if same && !disturbed {
            known.still + 1
        } else {
            0
        };
        (settled && !disturbed).then(|| {
            ensure(same, || {
                format!(
                    "moved from {:?} to {:?} by itself",
                    last.origin, state.origin
                )
            })
        })
    }

    fn depth(&self, state: &FrameState, entity: &Entity, run: &SceneRun) -> Check {
        let outdoors = state.cell & 0xFFFF < 0x100;
        let solid = !entity
            .body
            .state
            .intersects(PhysicsState::ETHEREAL | PhysicsState::STATIC);
        let spheres = entity
            .body
            .part_array
            .as_ref()
            .is_some_and(|p| !p.spheres().is_empty());
        if !(outdoors && solid && spheres && self.legal) || entity.body.parent.is_some() {
            return None;
        }
        let world = &run.world;
        let height = world
            .land
            .terrain_height(&entity.body.position, &world.profile)?;
        let wet = entity.kin.transient.contains(TransientState::WATER_CONTACT);
        let room = DEPTH + if wet { WATER } else { 0.0 };
        let z = state.origin[2];
        Some(ensure(z >= height - room, || {
            format!("{} m below the ground", height - z)
        }))
    }

    /// Kinetic and potential energy of what nobody drives.
    fn energy(&self, state: &FrameState, entity: &Entity, known: &mut Known) -> Check {
        let frame = u32::try_from(state.frame).unwrap_or(0);
        let falls = entity.body.state.contains(PhysicsState::GRAVITY);
        let [vx, vy, vz] = state.velocity.map(f64::from);
        let height = if falls {
            9.8 * f64::from(state.origin[2])
        } else {
            0.0
        };
        let now = 0.5 * (vx * vx + vy * vy + vz * vz) + height;
        let before = known.energy.replace(now);
        let alone = entity.movement.is_none()
            && entity.position_manager.is_none()
            && entity.body.parent.is_none()
            && self.legal
            && !self.scripted.contains(&frame)
            && state
                .collisions
                .iter()
                .all(|c| *c == ac_client::frame::state::Collision::Environment);
        let touched = !state.collisions.is_empty() || state.contact_plane.is_some();
        let step = entity
            .body
            .part_array
            .as_ref()
            .map_or(0.0, |p| p.step_up_height());
        let room = ENERGY + 9.8 * f64::from(step) + 1e-3 * now.abs();
        let before = before.filter(|_| alone && touched)?;
        Some(ensure(now <= before + room, || {
            format!("from {before:.3} to {now:.3} J/kg")
        }))
    }

    /// The current cell is that of the first sphere's centre (03, 9.1).
    fn cell(&self, state: &FrameState, entity: &Entity, run: &SceneRun) -> Check {
        let low = state.cell & 0xFFFF;
        let free = entity.body.parent.is_none();
        if low >= 0x100 || low == 0 || !self.legal || !free {
            return None;
        }
        let parts = entity.body.part_array.as_ref();
        let center = parts.and_then(|p| p.spheres().first()).map(|s| s.center);
        let center = center.unwrap_or_default() * entity.body.scale;
        let at = entity
            .body
            .position
            .frame
            .local_to_global(center, &run.world.profile);
        let column = |c: u32| c as f32 * 24.0;
        let (x, y) = (column((low - 1) / 8), column((low - 1) % 8));
        let within = |p: f32, from: f32| (from - BORDER..=from + 24.0 + BORDER).contains(&p);
        let agrees = within(at.x, x) && within(at.y, y);
        Some(ensure(agrees, || {
            format!("cell {:#X}, centre {at}", state.cell)
        }))
    }
}

/// A check that could be made, and what was found when it does not hold.
type Check = Option<Result<(), String>>;

fn ensure(holds: bool, detail: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(detail()) }
}

fn speed(state: &FrameState) -> Check {
    let [x, y, z] = state.velocity.map(f64::from);
    let speed = (x * x + y * y + z * z).sqrt();
    // Not-a-number is the business of another rule.
    Some(ensure(
        speed.is_nan() || speed <= SPEED + SPEED_ROOM,
        || format!("{speed} m/s"),
    ))
}

fn animation_frame(entity: &Entity) -> Check {
    let sequence = &entity.body.part_array.as_ref()?.sequence;
    let node = sequence.current_node()?;
    let (low, high) = (f64::from(node.low), f64::from(node.high) + 1.0);
    let number = sequence.frame_number();
    Some(ensure((low..=high).contains(&number), || {
        format!("{number} in {low}..{high} of {:#X}", node.animation_id())
    }))
}

fn is_ready(command: u32) -> bool {
    command == 0x4100_0003 || command == 0
}

/// Every number that a scene puts in.
fn inputs(scene: &Scene) -> Vec<f32> {
    let mut numbers = Vec::new();
    for spec in &scene.entities {
        numbers.extend(spec.position.origin);
        numbers.extend(spec.position.rotation);
        numbers.extend(spec.velocity);
        numbers.extend(spec.omega);
        numbers.extend([
            spec.scale,
            spec.friction,
            spec.elasticity,
            spec.run_rate,
            spec.jump_velocity,
        ]);
    }
    for step in &scene.script {
        match &step.action {
            Action::SetVelocity { velocity } => numbers.extend(velocity),
            Action::SetPosition { position, .. }
            | Action::InterpolateTo { position, .. }
            | Action::MoveToPosition { position, .. } => {
                numbers.extend(position.origin);
                numbers.extend(position.rotation);
            }
            Action::ConstrainTo {
                position, start, ..
            } => {
                numbers.extend(position.origin);
                numbers.push(*start);
            }
            Action::DoMotion { speed, .. } | Action::DoInterpretedMotion { speed, .. } => {
                numbers.push(*speed)
            }
            Action::SetHeading { heading } | Action::TurnToHeading { heading, .. } => {
                numbers.push(*heading)
            }
            Action::Create { entity } => numbers.extend(entity.velocity),
            _ => {}
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use ac_client::{frame::state::ContactPlane, physics::body::EntityId};

    use super::*;
    use crate::stability::{stage::Stage, trial::Trial, worlds};

    fn state(origin: [f32; 3], velocity: [f32; 3]) -> FrameState {
        FrameState {
            has: Fields::ORIGIN,
            guid: 1,
            cell: 0x2020_0001,
            frame: 7,
            origin,
            rotation: [1.0, 0.0, 0.0, 0.0],
            velocity,
            contact_plane: Some(ContactPlane::default()),
            ..FrameState::default()
        }
    }

    fn watch() -> Watch {
        let play = worlds::play().unwrap();
        Watch::new(&Stage::new(play).closed([0.0; 3], [10.0; 3]))
    }

    fn broken(check: Check) -> bool {
        check.expect("it can be checked").is_err()
    }

    #[test]
    fn what_is_not_finite_too_fast_or_outside_is_seen() {
        let fine = state([1.0; 3], [3.0, 0.0, 0.0]);
        assert!(
            !broken(watch().finite(&fine))
                && !broken(speed(&fine))
                && !broken(watch().tunnel(&fine))
        );
        assert!(broken(
            watch().finite(&state([f32::NAN, 0.0, 0.0], [0.0; 3]))
        ));
        assert!(broken(
            watch().finite(&state([0.0; 3], [f32::INFINITY, 0.0, 0.0]))
        ));
        assert!(broken(speed(&state([0.0; 3], [40.0, 40.0, 0.0]))));
        assert!(broken(watch().tunnel(&state([1.0, 11.0, 1.0], [0.0; 3]))));
    }

    #[test]
    fn what_moves_by_itself_is_seen() {
        let entity = Entity::new(EntityId(0), 1, 0.0);
        let still = state([1.0; 3], [0.0; 3]);
        let moved = state([1.0, 1.0, 1.0_f32.next_up()], [0.0; 3]);
        let settled = || Known {
            last: Some(still.clone()),
            still: SETTLED,
            ..Known::default()
        };
        assert!(!broken(watch().rest(&still, &entity, &mut settled())));
        assert!(broken(watch().rest(&moved, &entity, &mut settled())));
        let mut young = settled();
        young.still = 5;
        assert!(watch().rest(&moved, &entity, &mut young).is_none());
    }

    #[test]
    fn energy_from_nowhere_is_seen() {
        let entity = Entity::new(EntityId(0), 1, 0.0);
        let mut known = Known::default();
        assert!(
            watch()
                .energy(&state([1.0; 3], [3.0, 0.0, 0.0]), &entity, &mut known)
                .is_none()
        );
        assert!(!broken(watch().energy(
            &state([1.0; 3], [2.0, 0.0, 0.0]),
            &entity,
            &mut known
        )));
        assert!(broken(watch().energy(
            &state([1.0; 3], [4.0, 0.0, 0.0]),
            &entity,
            &mut known
        )));
    }

    #[test]
    fn leaving_a_closed_room_is_a_violation_of_ours() {
        let play = worlds::play().unwrap();
        let mut trial = Trial::new();
        let room = Stage::new(play)
            .frames(0.04, 40)
            .closed([0.0; 3], [50.0; 3]);
        trial.scene(&room.thrown(play.ball, [45.0, 45.0, 5.0], [30.0, 0.0, 0.0]));
        let case = crate::stability::Case {
            section: "00",
            number: 1,
            title: "a room that is none",
            run: |_| (),
        };
        let result = trial.result(&case);
        assert_eq!(result.verdict, crate::stability::Verdict::Ours);
        assert_eq!(result.violations[0].invariant, Invariant::Tunnel);
    }
}
