//! How finely time is cut: what a client may choose without changing any rule.
//!
//! The retail client has one choice: quanta longer than 1/30 s and of at most 0.2 s (profile `ace`: 0.1 s), an entity tick in every frame,
//! every entity in every tick. [`Fidelity::RETAIL`] is that choice and changes no bit. Everything else trades work against distance from what
//! retail shows; `ac-conform precision` measures both.

use crate::math::Vec3;
use crate::physics::body::EntityId;
use crate::profile::Profile;
use crate::world::World;

/// Share of a quantum by which the gate opens early: quanta of a fixed length must pass a gate that is exclusive.
const GATE_SHARE: f64 = 1e-9;
/// Slack of the tick gate, s: sums of frame lengths are not exact.
const TICK_SLACK: f64 = 1e-6;

/// How finely time is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fidelity {
    /// Shortest quantum (exclusive), s; `None`: that of the profile (O-02).
    pub min_quantum: Option<f64>,
    /// Longest quantum, s; `None`: that of the profile (O-01).
    pub max_quantum: Option<f64>,
    /// Entity ticks per second at most; `None`: one in every frame.
    pub frame_rate: Option<f64>,
    /// Remote entities are updated in every so many frames, in turns; they catch up with the time that passed. 0 and 1: in every frame.
    pub remote_update_every: u32,
    /// Entities nearer to the local player than this, m, are never remote. Without a local player all are.
    pub remote_distance: f32,
}

impl Fidelity {
    /// The constants of the retail client.
    pub const RETAIL: Self = Self {
        min_quantum: None,
        max_quantum: None,
        frame_rate: None,
        remote_update_every: 1,
        remote_distance: 0.0,
    };

    /// Quanta of one length, s, instead of the profile's two limits.
    #[must_use]
    pub fn with_quantum(mut self, seconds: f64) -> Self {
        self.min_quantum = Some(seconds - seconds * GATE_SHARE);
        self.max_quantum = Some(seconds);
        self
    }

    /// Writes the limits of a quantum into a profile, where the tick reads them.
    pub fn apply(&self, profile: &mut Profile) {
        profile.min_quantum = self.min_quantum.unwrap_or(profile.min_quantum);
        profile.max_quantum = self.max_quantum.unwrap_or(profile.max_quantum);
    }

    /// Whether the entity tick is left out of a frame at `now`, s, when it last ran at `last`, s.
    pub(super) fn skips_tick(&self, last: Option<f64>, now: f64) -> bool {
        match (self.frame_rate, last) {
            (Some(rate), Some(last)) => now - last + TICK_SLACK < 1.0 / rate,
            _ => false,
        }
    }

    /// Whether an entity is left out of tick number `tick`.
    pub(super) fn skips_entity(&self, id: EntityId, tick: u64, world: &World) -> bool {
        let every = u64::from(self.remote_update_every);
        every > 1
            && (tick + u64::from(id.0)).checked_rem(every) != Some(0)
            && self.is_remote(id, world)
    }

    fn is_remote(&self, id: EntityId, world: &World) -> bool {
        let Some(player) = world.local_player else {
            return true;
        };
        if player == id {
            return false;
        }
        let offset = match (world.entity(player), world.entity(id)) {
            (Some(player), Some(entity)) => player.body.position.offset_to(&entity.body.position),
            _ => Vec3::ZERO,
        };
        offset.length() > self.remote_distance
    }
}

impl Default for Fidelity {
    fn default() -> Self {
        Self::RETAIL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_leaves_a_profile_as_it_is() {
        for preset in [Profile::retail(), Profile::ace(), Profile::gdle()] {
            let mut profile = preset.clone();
            Fidelity::default().apply(&mut profile);
            assert_eq!(profile, preset);
        }
    }

    #[test]
    fn a_fixed_quantum_passes_its_own_gate() {
        let mut profile = Profile::retail();
        Fidelity::RETAIL.with_quantum(0.01).apply(&mut profile);
        assert_eq!(profile.max_quantum, 0.01);
        assert!(profile.min_quantum < 0.01 && profile.min_quantum > 0.0099);
    }

    #[test]
    fn the_tick_rate_is_a_limit() {
        let slow = Fidelity {
            frame_rate: Some(10.0),
            ..Fidelity::RETAIL
        };
        assert!(!slow.skips_tick(None, 0.0));
        assert!(slow.skips_tick(Some(0.0), 0.05));
        assert!(!slow.skips_tick(Some(0.0), 0.1));
        assert!(!Fidelity::RETAIL.skips_tick(Some(0.0), 0.0));
    }

    #[test]
    fn remote_entities_take_turns() {
        let mut world = World::new(Profile::retail(), 0.0);
        let mut ids = Vec::new();
        for guid in 1..=2 {
            let entity = world.entities.create(guid, 0.0);
            ids.push(entity.id);
            world.entities.put(entity);
        }
        let rare = Fidelity {
            remote_update_every: 2,
            ..Fidelity::RETAIL
        };
        for tick in 0..4 {
            let skipped = ids
                .iter()
                .filter(|id| rare.skips_entity(**id, tick, &world));
            assert_eq!(skipped.count(), 1);
        }
        world.local_player = Some(ids[0]);
        assert!((0..4).all(|tick| !rare.skips_entity(ids[0], tick, &world)));
        assert!((0..4).all(|tick| !Fidelity::RETAIL.skips_entity(ids[1], tick, &world)));
    }
}
