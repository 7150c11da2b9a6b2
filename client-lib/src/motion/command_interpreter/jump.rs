//! Charging and doing a jump (`spec/08-motion.md`, 13.9).

use super::{AutonomyLevel, CommandInterpreter, Outgoing, Scene, SequenceStamps};
use crate::motion::Command;
use crate::motion::constants::MIN_JUMP_EXTENT;

/// Seconds that a full charge takes.
const CHARGE_TIME: f64 = 1.0;
/// The same with a weapon in each hand.
const DUAL_WIELD_CHARGE_TIME: f64 = 0.8;

impl CommandInterpreter {
    /// The jump key is pressed: charging begins, unless the player cannot jump.
    pub fn commence_jump(&mut self, scene: &mut Scene<'_>) {
        let Some(player) = scene.player.as_deref_mut() else {
            return;
        };
        if self.jump_charged_since.is_some() {
            return;
        }
        match player.charge_jump(scene.world) {
            Ok(()) => self.jump_charged_since = Some(scene.world.clock.now),
            Err(error) => self.notices.push(error),
        }
    }

    /// How far the jump is charged, 0..=1; 0 without a charge.
    pub fn jump_level(&self, scene: &Scene<'_>) -> f32 {
        let Some(since) = self.jump_charged_since else {
            return 0.0;
        };
        let style = scene.player.as_deref().and_then(|player| player.style());
        let full = if style == Some(Command::DUAL_WIELD_COMBAT) {
            DUAL_WIELD_CHARGE_TIME
        } else {
            CHARGE_TIME
        };
        ((scene.world.clock.now - since) / full).clamp(0.0, 1.0) as f32
    }

    /// The jump key is released: the player jumps as far as it was charged.
    pub fn do_jump(&mut self, scene: &mut Scene<'_>) {
        if self.jump_charged_since.is_none() {
            return;
        }
        let extent = self.jump_level(scene).max(MIN_JUMP_EXTENT);
        // The flag is cleared before the jump; what it recorded still gives the direction.
        self.finish_jump(scene);
        if self.autonomy_level == AutonomyLevel::None {
            self.outbox.push(Outgoing::JumpNonAutonomous { extent });
            return;
        }
        let Some(player) = scene.player.as_deref_mut() else {
            return;
        };
        match player.jump(extent, scene.world) {
            Ok(_) => self.outbox.push(Outgoing::Jump {
                extent,
                velocity: player.local_velocity(scene.world),
                position: player.body.position,
                stamps: SequenceStamps::of(player),
            }),
            Err(error) => self.notices.push(error),
        }
    }

    /// Charging ends without a jump.
    pub fn finish_jump(&mut self, scene: &mut Scene<'_>) {
        self.jump_charged_since = None;
        if let Some(interp) = scene.player.as_deref_mut().and_then(|p| p.interp_mut()) {
            interp.standing_longjump = false;
        }
    }
}
