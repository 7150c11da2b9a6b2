//! Following the positions that the server sends for other objects (F2).

use std::collections::VecDeque;

use crate::math::{EPSILON, Frame, Position, Vec3};
use crate::profile::{Interpolation, Profile};

/// A node this near counts as reached, m.
const REACHED: f32 = 0.05;
/// Nodes beyond this many push the oldest out.
const QUEUE_LIMIT: usize = 20;
/// Distance to go while no progress was measured yet, m.
const NO_DISTANCE: f32 = 999_999.0;
/// Speed of an object whose motions give none, m/s.
const DEFAULT_SPEED: f32 = 7.5;
/// Failures after which the object is moved to the newest node at once.
const FAIL_LIMIT: u32 = 3;

/// What a node asks for. The client makes position nodes only; the others are specified for completeness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeKind {
    /// Go there.
    Position,
    /// Jump.
    Jump,
    /// Take a velocity.
    Velocity,
}

/// One thing to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterpolationNode {
    /// What.
    pub kind: NodeKind,
    /// Where.
    pub position: Position,
    /// World axes, m/s.
    pub velocity: Vec3,
}

/// What became of a new position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InterpolateOutcome {
    /// It waits in the queue.
    Queued,
    /// The object is there already; it turns to this heading, degrees, if there is one.
    Reached(Option<f32>),
}

/// Where an object that cannot follow is to be placed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blip {
    /// The place.
    pub target: Position,
    /// Velocity to take there, world axes, m/s.
    pub velocity: Option<Vec3>,
}

/// What following needs to know of the object.
#[derive(Debug, Clone, Copy)]
pub struct Follow<'a> {
    /// Where it is.
    pub position: &'a Position,
    /// It touches ground.
    pub contact: bool,
    /// It sticks to a target: progress is not demanded.
    pub sticky: bool,
    /// Adjusted maximum speed of its motions, m/s (`spec/08`, 8.18).
    pub max_speed: f32,
    /// s.
    pub quantum: f32,
}

/// The queue of server positions and how well they are followed.
#[derive(Debug, Clone, PartialEq)]
pub struct InterpolationManager {
    /// Things to do, next first.
    pub queue: VecDeque<InterpolationNode>,
    /// The object's heading stays as it is.
    pub keep_heading: bool,
    /// Quanta since progress was last measured.
    pub frame_counter: u32,
    /// Distance to go at that time, m.
    pub original_distance: f32,
    /// Time since then, s.
    pub progress_quantum: f32,
    /// Failures in a row.
    pub node_fail_counter: u32,
    /// Last node that could not be reached.
    pub blip_to: Option<Position>,
    /// The profile's interpolation does not work: the object is never updated again (`O-38`).
    pub broken: bool,
}

impl Default for InterpolationManager {
    fn default() -> Self {
        Self {
            queue: VecDeque::new(),
            keep_heading: false,
            frame_counter: 0,
            original_distance: NO_DISTANCE,
            progress_quantum: 0.0,
            node_fail_counter: 0,
            blip_to: None,
            broken: false,
        }
    }
}

impl InterpolationManager {
    /// A new position from the server. `own` is where the object is, `blip_distance` (m) the distance from which it is moved at once.
    pub fn interpolate_to(
        &mut self,
        target: &Position,
        keep_heading: bool,
        own: &Position,
        blip_distance: f32,
        profile: &Profile,
    ) -> InterpolateOutcome {
        if profile.interpolation == Interpolation::NotWorking {
            self.broken = true;
            return InterpolateOutcome::Queued;
        }
        let from = self.tail_position().unwrap_or(own);
        if from.distance(target) > blip_distance {
            // With the heading rule of the position before this one.
            self.append(target, self.keep_heading, own, profile);
            self.node_fail_counter = FAIL_LIMIT + 1;
        } else if own.distance(target) <= REACHED {
            self.stop();
            let heading = (!keep_heading).then(|| target.frame.heading(profile));
            return InterpolateOutcome::Reached(heading);
        } else {
            while self
                .tail_position()
                .is_some_and(|tail| tail.distance(target) < REACHED)
            {
                self.queue.pop_back();
            }
            while self.queue.len() >= QUEUE_LIMIT {
                self.queue.pop_front();
            }
            self.keep_heading = keep_heading;
            self.append(target, keep_heading, own, profile);
        }
        InterpolateOutcome::Queued
    }

    fn tail_position(&self) -> Option<&Position> {
        let tail = self.queue.back()?;
        (tail.kind == NodeKind::Position).then_some(&tail.position)
    }

    fn append(&mut self, target: &Position, keep_heading: bool, own: &Position, profile: &Profile) {
        let mut position = *target;
        if keep_heading {
            let heading = own.frame.heading(profile);
            position.frame.set_heading(heading, profile);
        }
        self.queue.push_back(InterpolationNode {
            kind: NodeKind::Position,
            position,
            velocity: Vec3::ZERO,
        });
    }

    /// Forgets everything but the heading rule and the last node that failed.
    pub fn stop(&mut self) {
        self.queue.clear();
        self.frame_counter = 0;
        self.original_distance = NO_DISTANCE;
        self.progress_quantum = 0.0;
        self.node_fail_counter = 0;
    }

    /// Whether positions are being followed.
    pub fn is_interpolating(&self) -> bool {
        !self.queue.is_empty()
    }

    /// The position that is followed, if following is possible now.
    fn followed(&self, contact: bool) -> Option<Position> {
        let head = self.queue.front().filter(|_| contact)?;
        (head.kind == NodeKind::Position).then_some(head.position)
    }

    /// Whether [`InterpolationManager::adjust_offset`] will want to know the object's speed. Asking for it can make a movement manager, so
    /// it is asked for only then.
    pub fn needs_speed(&self, position: &Position, contact: bool) -> bool {
        self.followed(contact)
            .is_some_and(|head| at_least(position.distance(&head), REACHED))
    }

    /// Replaces the offset (the object's own axes, m) of a quantum by a step towards the next position. Answers whether one is followed.
    pub fn adjust_offset(
        &mut self,
        offset: &mut Frame,
        object: &Follow<'_>,
        profile: &Profile,
    ) -> bool {
        let Some(head) = self.followed(object.contact) else {
            return false;
        };
        let distance = object.position.distance(&head);
        if distance < REACHED {
            self.node_completed(true, object.position);
            return true;
        }
        let mut speed = 2.0 * object.max_speed;
        if speed < EPSILON {
            speed = DEFAULT_SPEED;
        }
        self.progress_quantum += object.quantum;
        self.frame_counter = self.frame_counter.wrapping_add(1);
        if self.is_progressing(distance, speed, object.sticky) {
            self.step_towards(&head, distance, speed, offset, object, profile);
        } else if distance < 0.2 {
            self.node_completed(true, object.position);
        } else {
            self.node_fail_counter = self.node_fail_counter.wrapping_add(1);
            self.node_completed(false, object.position);
        }
        true
    }

    /// Progress is judged at every fifth quantum: three tenths of the speed are demanded.
    fn is_progressing(&self, distance: f32, speed: f32, sticky: bool) -> bool {
        let made = self.original_distance - distance;
        self.frame_counter < 5
            || sticky
            || (made >= EPSILON && (made / self.progress_quantum) / speed >= 0.3)
    }

    fn step_towards(
        &mut self,
        head: &Position,
        distance: f32,
        speed: f32,
        offset: &mut Frame,
        object: &Follow<'_>,
        profile: &Profile,
    ) {
        if self.frame_counter >= 5 {
            self.frame_counter = 0;
            self.progress_quantum = 0.0;
            self.original_distance = distance;
        }
        let mut way = self.way_to(head, object.position, profile);
        let step = speed * object.quantum;
        let length = way.origin.length();
        if length <= REACHED {
            self.node_completed(true, object.position);
        }
        if length > step {
            way.origin *= step / length;
        }
        if self.keep_heading {
            way.set_heading(0.0, profile);
        }
        *offset = way;
    }

    /// The next position as seen from the object. `01:F6`: one reference overwrites the node with it, and takes the object's frame off as if it
    /// undid a combine; blocks are not looked at.
    fn way_to(&mut self, head: &Position, own: &Position, profile: &Profile) -> Frame {
        if !profile.relative_mutates {
            return head.relative_to(own, profile);
        }
        let way = head.frame.subtract_animation(&own.frame, profile);
        if let Some(node) = self.queue.front_mut() {
            node.position.frame = way;
        }
        way
    }

    /// Drops the next node, reached or given up.
    fn node_completed(&mut self, reached: bool, own: &Position) {
        self.frame_counter = 0;
        self.progress_quantum = 0.0;
        let head = self.queue.front().map(|n| n.position);
        if let Some(second) = self.queue.get(1) {
            if second.kind == NodeKind::Position {
                self.original_distance = own.distance(&second.position);
            } else if !reached {
                self.blip_to = head;
            }
        } else {
            self.original_distance = NO_DISTANCE;
            if reached {
                self.stop();
            } else if head.is_some() {
                self.blip_to = head;
            }
        }
        self.queue.pop_front();
    }

    /// Where the object is to be placed because it cannot follow; the caller places it and, if that worked, calls
    /// [`InterpolationManager::stop`].
    pub fn blip(&self) -> Option<Blip> {
        if self.node_fail_counter == 0
            || (self.node_fail_counter <= FAIL_LIMIT && !self.queue.is_empty())
        {
            return None;
        }
        let at = |target| Blip {
            target,
            velocity: None,
        };
        let Some(tail) = self.queue.back() else {
            return self.blip_to.map(at);
        };
        if tail.kind == NodeKind::Position {
            return Some(at(tail.position));
        }
        let earlier = self
            .queue
            .iter()
            .rev()
            .find(|n| n.kind == NodeKind::Position);
        match earlier {
            Some(node) => Some(Blip {
                target: node.position,
                velocity: Some(tail.velocity),
            }),
            None => self.blip_to.map(at),
        }
    }

    /// Carries out a node that is no position (`UseTime`, step 2): a velocity to take, world axes, m/s.
    pub fn complete_head(&mut self, own: &Position) -> Option<Vec3> {
        let head = *self.queue.front()?;
        if head.kind == NodeKind::Position {
            return None;
        }
        self.node_completed(true, own);
        (head.kind == NodeKind::Velocity).then_some(head.velocity)
    }
}

/// Not less: true for NaN, which the client's strict test lets pass.
fn at_least(x: f32, limit: f32) -> bool {
    let less = x < limit;
    !less
}
