//! Watching another object, and being watched (F5).

use crate::math::{Position, Vec3, vector};

/// What is known about a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "the names say it")]
pub enum TargetStatus {
    #[default]
    Undefined = 0,
    Ok = 1,
    ExitWorld = 2,
    Teleported = 3,
    Contained = 4,
    Parented = 5,
    TimedOut = 6,
}

/// The target as last heard of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TargetInfo {
    /// Who wants to know; 0 for movement.
    pub context_id: u32,
    /// GUID of the target.
    pub object_id: u32,
    /// The target tells again when it has moved this far, m.
    pub radius: f32,
    /// How far ahead it predicts its place, s.
    pub quantum: f64,
    /// Where it was.
    pub target_position: Position,
    /// Where it predicted to be.
    pub interpolated_position: Position,
    /// Unit vector to the predicted place, world axes.
    pub interpolated_heading: Vec3,
    /// World axes, m/s.
    pub velocity: Vec3,
    /// What is known.
    pub status: TargetStatus,
    /// When it was heard of, s on the frame clock.
    pub last_update_time: f64,
}

/// Someone who watches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Voyeur {
    /// GUID.
    pub object_id: u32,
    /// It is told again after this way, m.
    pub radius: f32,
    /// How far ahead to predict, s.
    pub quantum: f64,
    /// What it was told last.
    pub last_sent_position: Position,
}

/// Whom an object watches, and who watches it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TargetManager {
    /// The target.
    pub target: Option<TargetInfo>,
    /// Watchers, in the order they came.
    pub voyeurs: Vec<Voyeur>,
    /// When the watchers were last looked through, s.
    pub last_update: f64,
}

/// What a target says of itself to its voyeurs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Report<'a> {
    pub guid: u32,
    pub position: &'a Position,
    pub velocity: Vec3,
}

impl TargetManager {
    /// Quantum of the target, s; 0 without one.
    pub fn target_quantum(&self) -> f64 {
        self.target.map_or(0.0, |t| t.quantum)
    }

    /// Enters a watcher, or changes its radius and quantum. A new one is to be told the place at once: the update to deliver.
    pub(super) fn add_voyeur(
        &mut self,
        object_id: u32,
        radius: f32,
        quantum: f64,
        own: &Report<'_>,
    ) -> Option<TargetInfo> {
        if let Some(known) = self.voyeurs.iter_mut().find(|v| v.object_id == object_id) {
            known.radius = radius;
            known.quantum = quantum;
            return None;
        }
        self.voyeurs.push(Voyeur {
            object_id,
            radius,
            quantum,
            last_sent_position: Position::default(),
        });
        let new = self.voyeurs.last_mut()?;
        Some(new.update(*own.position, own, TargetStatus::Ok))
    }

    /// Takes a watcher off the list; `false` if it was not on it.
    pub fn remove_voyeur(&mut self, object_id: u32) -> bool {
        let before = self.voyeurs.len();
        self.voyeurs.retain(|v| v.object_id != object_id);
        self.voyeurs.len() != before
    }

    /// Takes news of the target, heard at `now` (s) by an object at `own`; the info to hand on, if it is about the target.
    pub(super) fn receive_update(
        &mut self,
        update: &TargetInfo,
        own: &Position,
        now: f64,
    ) -> Option<TargetInfo> {
        let target = self.target.as_mut()?;
        if target.object_id != update.object_id {
            return None;
        }
        let way = own.offset_to(&update.interpolated_position);
        *target = TargetInfo {
            last_update_time: now,
            interpolated_heading: vector::normalize_check_small(way).unwrap_or(Vec3::Z),
            ..*update
        };
        Some(*target)
    }
}

impl Voyeur {
    /// What to tell this watcher; it counts as told.
    pub(super) fn update(
        &mut self,
        interpolated: Position,
        own: &Report<'_>,
        status: TargetStatus,
    ) -> TargetInfo {
        self.last_sent_position = interpolated;
        TargetInfo {
            context_id: 0,
            object_id: own.guid,
            radius: self.radius,
            quantum: self.quantum,
            target_position: *own.position,
            interpolated_position: interpolated,
            interpolated_heading: Vec3::ZERO,
            velocity: own.velocity,
            status,
            last_update_time: 0.0,
        }
    }

    /// Where the watched object will be after this watcher's quantum, if that is worth telling.
    pub(super) fn due(&self, own: &Report<'_>) -> Option<Position> {
        let mut ahead = *own.position;
        ahead.frame.origin += own.velocity * (self.quantum as f32);
        (ahead.distance(&self.last_sent_position) > self.radius).then_some(ahead)
    }
}
