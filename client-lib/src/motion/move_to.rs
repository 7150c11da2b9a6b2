//! The move-to manager's data: one activity of walking or turning to a place or an object, as a list of nodes.
//!
//! What it does is in [`super::move_to_start`] (beginning and ending an activity) and [`super::move_to_tick`] (steering).
//!
//! Source: `spec/08-motion.md`, 2.3, 11.15 and 11.16.

use std::collections::VecDeque;

use super::{Command, MovementFlags, MovementParameters};
use crate::entity::Entity;
use crate::math::{Position, UprightCylinder};
use crate::profile::Profile;

/// What a move-to manager is doing; the numbers are those of the protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum MoveToKind {
    /// Nothing.
    #[default]
    Idle = 0,
    /// Walking to an object.
    Object = 6,
    /// Walking to a place.
    Position = 7,
    /// Turning to an object.
    TurnToObject = 8,
    /// Turning to a heading.
    TurnToHeading = 9,
}

/// One leg of a move-to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MoveToNode {
    /// Walk until the distance is right.
    Move,
    /// Turn to this heading.
    Turn(f32),
}

/// A distance (m) and when it was measured (s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DistanceSample {
    /// m.
    pub distance: f32,
    /// s on the frame clock.
    pub time: f64,
}

/// One activity of moving to something. Retail: `MoveToManager`.
#[derive(Debug, Clone)]
pub struct MoveToManager {
    /// Present activity.
    pub kind: MoveToKind,
    /// Walking to an object: its extrapolated place. Turning: the heading is the goal.
    pub sought_position: Position,
    /// Last reported place of the target.
    pub current_target_position: Position,
    /// Where the activity began.
    pub starting_position: Position,
    /// Parameters; the flags outlive the activity.
    pub params: MovementParameters,
    /// Last heading, or at the start of a turn the difference to its goal, degrees.
    pub previous_heading: f32,
    /// Last sample with progress.
    pub previous: DistanceSample,
    /// First sample.
    pub original: DistanceSample,
    /// Ticks without progress; never read.
    pub fail_progress_count: u32,
    /// GUID asked for, 0 for none.
    pub sought_object_id: u32,
    /// GUID whose place counts, 0 for none.
    pub top_level_object_id: u32,
    /// m.
    pub sought_object_radius: f32,
    /// m.
    pub sought_object_height: f32,
    /// Command of the running node, before normalising.
    pub current_command: Command,
    /// Corrective turn of a walk.
    pub aux_command: Command,
    /// The distance is to grow.
    pub moving_away: bool,
    /// The target has been heard of.
    pub initialized: bool,
    /// Legs to go, the running one first.
    pub nodes: VecDeque<MoveToNode>,
}

impl MoveToManager {
    /// Whether there is nothing to do in a quantum.
    pub(crate) fn is_idle(&self) -> bool {
        self.nodes.is_empty()
    }

    /// An idle manager; `now` in s.
    pub fn new(now: f64) -> Self {
        let sample = DistanceSample {
            distance: f32::MAX,
            time: now,
        };
        Self {
            kind: MoveToKind::Idle,
            sought_position: Position::default(),
            current_target_position: Position::default(),
            starting_position: Position::default(),
            params: MovementParameters::default(),
            previous_heading: 0.0,
            previous: sample,
            original: sample,
            fail_progress_count: 0,
            sought_object_id: 0,
            top_level_object_id: 0,
            sought_object_radius: 0.0,
            sought_object_height: 0.0,
            current_command: Command::NONE,
            aux_command: Command::NONE,
            moving_away: false,
            initialized: false,
            nodes: VecDeque::new(),
        }
    }

    /// Whether there is an activity.
    pub fn is_active(&self) -> bool {
        self.kind != MoveToKind::Idle
    }

    /// Forgets the activity. Starting place, samples, nodes and most parameters stay (`InitializeLocalVars`, 2.3).
    pub(super) fn reset(&mut self, now: f64) {
        self.kind = MoveToKind::Idle;
        self.sought_position = Position::default();
        self.current_target_position = Position::default();
        self.params.distance_to_object = 0.0;
        self.params.context_id = 0;
        self.previous_heading = 0.0;
        self.previous.time = now;
        self.original.time = now;
        self.fail_progress_count = 0;
        self.sought_object_id = 0;
        self.top_level_object_id = 0;
        self.sought_object_radius = 0.0;
        self.sought_object_height = 0.0;
        self.current_command = Command::NONE;
        self.aux_command = Command::NONE;
        self.moving_away = false;
        self.initialized = false;
    }

    /// Distance (m) from an object to the target's reported place: between the cylinders, or between the origins (11.15).
    pub(super) fn distance_from(&self, object: &Entity, profile: &Profile) -> f32 {
        let (own, target) = (&object.body.position, &self.current_target_position);
        if !self.params.has(MovementFlags::USE_SPHERES) {
            return own.distance(target);
        }
        let body = UprightCylinder {
            radius: object.radius(),
            height: object.height(),
            position: own,
        };
        let target = UprightCylinder {
            radius: self.sought_object_radius,
            height: self.sought_object_height,
            position: target,
        };
        body.distance(&target, profile) as f32
    }

    /// Takes the same sample as the first and as the last.
    pub(super) fn restart_progress(&mut self, distance: f32, now: f64) {
        let sample = DistanceSample {
            distance,
            time: now,
        };
        self.previous = sample;
        self.original = sample;
    }

    /// Whether the distance changes fast enough (11.11). Within one second of the last good sample it always does.
    pub(super) fn check_progress(&mut self, distance: f32, now: f64) -> bool {
        let elapsed = now - self.previous.time;
        if elapsed <= super::constants::PROGRESS_INTERVAL {
            return true;
        }
        if self.rate(distance, &self.previous, now) < super::constants::MIN_PROGRESS {
            return false;
        }
        self.previous = DistanceSample {
            distance,
            time: now,
        };
        let overall = self.rate(distance, &self.original, now);
        let too_slow = overall < super::constants::MIN_PROGRESS;
        !too_slow
    }

    fn rate(&self, distance: f32, since: &DistanceSample, now: f64) -> f64 {
        let gained = if self.moving_away {
            distance - since.distance
        } else {
            since.distance - distance
        };
        f64::from(gained) / (now - since.time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_is_judged_after_a_second() {
        let mut m = MoveToManager::new(10.0);
        m.restart_progress(20.0, 10.0);
        assert!(m.check_progress(25.0, 11.0));
        assert!(!m.check_progress(19.8, 11.1));
        assert_eq!(m.previous.time, 10.0);
        assert!(m.check_progress(19.0, 12.0));
        assert_eq!(
            m.previous,
            DistanceSample {
                distance: 19.0,
                time: 12.0
            }
        );
        m.moving_away = true;
        assert!(!m.check_progress(18.0, 13.5));
    }

    #[test]
    fn fleeing_from_a_target_that_moves_never_progresses() {
        let mut m = MoveToManager::new(0.0);
        m.moving_away = true;
        m.restart_progress(f32::MAX, 0.0);
        assert!(m.check_progress(5.0, 1.0));
        assert!(!m.check_progress(9.0, 1.1));
    }

    #[test]
    fn a_reset_keeps_flags_and_samples() {
        let mut m = MoveToManager::new(0.0);
        m.kind = MoveToKind::Object;
        m.params.flags.remove(MovementFlags::USE_SPHERES);
        m.params.context_id = 7;
        m.restart_progress(3.0, 1.0);
        m.nodes.push_back(MoveToNode::Move);
        m.reset(2.0);
        assert!(!m.is_active() && !m.params.has(MovementFlags::USE_SPHERES));
        assert_eq!((m.params.context_id, m.params.distance_to_object), (0, 0.0));
        assert_eq!((m.previous.distance, m.previous.time), (3.0, 2.0));
        assert_eq!(m.nodes.len(), 1);
    }
}
