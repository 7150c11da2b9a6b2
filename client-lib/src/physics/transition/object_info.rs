//! What the transition knows about the mover, and the rules that depend on mover and target alone (`spec/05-transition.md`, 6.3 and 7).

use super::state::{ObjectInfo, ObjectInfoState};
use super::{DEFAULT_STEP_HEIGHT, FLOOR_Z, FLOOR_Z_F64, LANDING_Z};
use crate::math::Vec3;
use crate::physics::body::{Body, ObjectRef};
use crate::physics::state::PhysicsState;
use crate::profile::{Profile, Width};

/// Whether a surface with that normal can be walked on: at least floor z (7.1).
///
/// `T-12`: profile `gdle` compares with the unrounded f64 limit, so that the f32 nearest to it is not walkable there.
pub fn is_valid_walkable(normal: Vec3, profile: &Profile) -> bool {
    match profile.floor_z {
        Width::F32 => normal.z >= FLOOR_Z,
        Width::F64 => f64::from(normal.z) >= FLOOR_Z_F64,
    }
}

impl ObjectInfo {
    /// The mover `object`, whose body is `body`, with the bits that the caller has chosen (`get_object_info`, 6.9) and its step heights, m
    /// (6.3).
    pub fn of_body(
        object: ObjectRef,
        body: &Body,
        bits: ObjectInfoState,
        step_up_height: f32,
        step_down_height: f32,
        profile: &Profile,
    ) -> Self {
        let weenie = &body.weenie;
        let mut state = bits;
        if weenie.present {
            for (answer, bit) in [
                (weenie.impenetrable, ObjectInfoState::IS_IMPENETRABLE),
                (weenie.player, ObjectInfoState::IS_PLAYER),
                (weenie.pk, ObjectInfoState::IS_PK),
                (weenie.pk_lite, ObjectInfoState::IS_PK_LITE),
            ] {
                if answer {
                    state |= bit;
                }
            }
        }
        // T-11: profile `ace` asks the object itself, with or without a weenie.
        let knows_target = weenie.present || profile.missile_two_way;
        Self {
            object: Some(object),
            guid: body.guid,
            state,
            physics_state: body.state,
            scale: body.scale,
            step_up_height,
            step_down_height,
            ethereal: body.state.contains(PhysicsState::ETHEREAL),
            step_down: !body.state.contains(PhysicsState::MISSILE),
            target_id: if knows_target { body.target } else { 0 },
            creature: weenie.present && weenie.creature,
            bypasses_restrictions: weenie.present && weenie.bypasses_restrictions,
            barrier_passed: false,
            velocity_killed: false,
        }
    }

    /// Whether the mover is a camera probe.
    pub fn is_viewer(&self) -> bool {
        self.state.contains(ObjectInfoState::IS_VIEWER)
    }

    /// Whether the mover touches ground or a surface.
    pub fn in_contact(&self) -> bool {
        self.state.contains(ObjectInfoState::CONTACT)
    }

    /// Whether that surface is walkable.
    pub fn on_walkable(&self) -> bool {
        self.state.contains(ObjectInfoState::ON_WALKABLE)
    }

    /// The limit for the normal's z and the step height (m) that go with where the mover stands: its own `height` on walkable ground, else
    /// what is allowed while landing.
    pub(super) fn walking_limits(&self, height: f32) -> (f32, f32) {
        if self.on_walkable() {
            (FLOOR_Z, height)
        } else {
            (LANDING_Z, DEFAULT_STEP_HEIGHT)
        }
    }

    /// Whether the mover passes through `target` because one of the two is a missile (7.3). Depends on the pair only, never on positions.
    ///
    /// `T-10`: in profile `ace` a player passes through a missile only if that has another object for a target.
    pub fn missile_ignore(&self, target: &Body, profile: &Profile) -> bool {
        if target.state.contains(PhysicsState::MISSILE) {
            let player = self.state.contains(ObjectInfoState::IS_PLAYER);
            let aims_elsewhere = target.target != 0 && target.target != self.guid;
            if !profile.missile_two_way || !player || aims_elsewhere {
                return true;
            }
        }
        if !self.physics_state.contains(PhysicsState::MISSILE) || target.guid == self.target_id {
            return false;
        }
        let weenie = &target.weenie;
        weenie.present
            && (target.state.contains(PhysicsState::ETHEREAL)
                || (self.target_id != 0 && weenie.creature))
    }

    /// Whether mover and target are players who pass through each other (11.1, step 5).
    pub fn player_exempt(&self, target: &Body) -> bool {
        let weenie = &target.weenie;
        let mover = |bit| self.state.contains(bit);
        weenie.present
            && weenie.player
            && mover(ObjectInfoState::IS_PLAYER)
            && !mover(ObjectInfoState::IS_IMPENETRABLE)
            && !weenie.impenetrable
            && !(mover(ObjectInfoState::IS_PK) && weenie.pk)
            && !(mover(ObjectInfoState::IS_PK_LITE) && weenie.pk_lite)
    }
}
