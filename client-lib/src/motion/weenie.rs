//! What the motion layer asks an object's game-logic companion (`spec/08-motion.md`, 12.1).

use super::formulas;
use crate::entity::Weenie;
use crate::profile::{Profile, WeenieAnswers};

/// Questions of the motion layer. `None` is "does not answer", which is not the same as 0.
pub trait MotionCallbacks {
    /// Run rate; 1 is 4 m/s (`InqRunRate`).
    fn run_rate(&self, profile: &Profile) -> Option<f32>;
    /// Vertical launch speed in m/s for an extent in 0..=1 (`InqJumpVelocity`).
    fn jump_velocity(&self, extent: f32, profile: &Profile) -> Option<f32>;
    /// Whether the burden allows a jump (`CanJump`).
    fn can_jump(&self, extent: f32, profile: &Profile) -> bool;
    /// Stamina that a jump would cost; the extent is not clamped (`JumpStaminaCost`).
    fn jump_stamina_cost(&self, extent: f32, profile: &Profile) -> Option<i32>;
}

/// A character whose answers follow from its attributes by the formulas of 12.2 to 12.4.
///
/// Only the local player answers, except where the profile says that all do (`D22`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Character {
    /// This is the player of this client.
    pub local_player: bool,
    /// Strength; 10 if it is not known.
    pub strength: i32,
    /// Number of carrying augmentations.
    pub burden_augmentations: i32,
    /// Burden carried.
    pub encumbrance: i32,
    /// Buffed Run skill, if known.
    pub run_skill: Option<i32>,
    /// Buffed Jump skill, if known.
    pub jump_skill: Option<i32>,
    /// Present stamina, if known.
    pub stamina: Option<u32>,
    /// A player killer who has attacked a player within the last 20 s.
    pub recent_player_fight: bool,
}

impl Default for Character {
    fn default() -> Self {
        Self {
            local_player: false,
            strength: 10,
            burden_augmentations: 0,
            encumbrance: 0,
            run_skill: None,
            jump_skill: None,
            stamina: None,
            recent_player_fight: false,
        }
    }
}

impl Character {
    /// Burden in units of the capacity.
    pub fn load(&self) -> f32 {
        let capacity = formulas::encumbrance_capacity(self.strength, self.burden_augmentations);
        formulas::load(capacity, self.encumbrance)
    }

    fn answers(&self, profile: &Profile) -> bool {
        self.local_player || profile.weenie_answers == WeenieAnswers::All
    }
}

impl MotionCallbacks for Character {
    fn run_rate(&self, profile: &Profile) -> Option<f32> {
        self.stamina.filter(|_| self.answers(profile))?;
        Some(formulas::run_rate(self.load(), self.run_skill?, profile))
    }

    fn jump_velocity(&self, extent: f32, profile: &Profile) -> Option<f32> {
        let stamina = self.stamina.filter(|_| self.answers(profile))?;
        let skill = if stamina == 0 { 0 } else { self.jump_skill? };
        let height = formulas::jump_height(self.load(), skill, extent, profile);
        Some(formulas::jump_velocity(height))
    }

    fn can_jump(&self, _extent: f32, _profile: &Profile) -> bool {
        self.load() < 2.0
    }

    fn jump_stamina_cost(&self, extent: f32, profile: &Profile) -> Option<i32> {
        self.stamina.filter(|_| self.answers(profile))?;
        let pk = self.recent_player_fight;
        Some(formulas::jump_stamina_cost(
            extent,
            self.load(),
            pk,
            profile,
        ))
    }
}

impl MotionCallbacks for Weenie {
    fn run_rate(&self, profile: &Profile) -> Option<f32> {
        match &self.character {
            Some(character) => character.run_rate(profile),
            None => self.run_rate,
        }
    }

    fn jump_velocity(&self, extent: f32, profile: &Profile) -> Option<f32> {
        match &self.character {
            Some(character) => character.jump_velocity(extent, profile),
            None => self.jump_velocity.map(|velocity| extent * velocity),
        }
    }

    fn can_jump(&self, extent: f32, profile: &Profile) -> bool {
        match &self.character {
            Some(character) => character.can_jump(extent, profile),
            None => self.can_jump,
        }
    }

    fn jump_stamina_cost(&self, extent: f32, profile: &Profile) -> Option<i32> {
        match &self.character {
            Some(character) => character.jump_stamina_cost(extent, profile),
            None => self.jump_stamina_cost,
        }
    }
}

#[cfg(test)]
#[allow(
    clippy::excessive_precision,
    reason = "digits as the specification prints them"
)]
mod tests {
    use super::*;

    #[test]
    fn only_the_local_player_answers_in_retail() {
        let other = Character {
            run_skill: Some(200),
            jump_skill: Some(300),
            stamina: Some(50),
            strength: 100,
            ..Character::default()
        };
        let player = Character {
            local_player: true,
            ..other
        };
        let (retail, gdle) = (Profile::retail(), Profile::gdle());
        assert_eq!(other.run_rate(&retail), None);
        assert_eq!(other.run_rate(&gdle), Some(2.375));
        assert_eq!(player.run_rate(&retail), Some(2.375));
        assert_eq!(player.jump_velocity(1.0, &retail), Some(9.086_528_6));
        assert_eq!(player.jump_stamina_cost(1.0, &retail), Some(6));
        let tired = Character {
            stamina: Some(0),
            ..player
        };
        assert_eq!(tired.jump_velocity(1.0, &retail), Some(2.619_160_2));
        let laden = Character {
            encumbrance: 30_000,
            ..player
        };
        assert!(!laden.can_jump(1.0, &retail) && player.can_jump(1.0, &retail));
        let unknown = Character {
            stamina: None,
            ..player
        };
        assert_eq!(unknown.run_rate(&retail), None);
    }

    #[test]
    fn fixed_answers_scale_with_the_extent() {
        let weenie = Weenie {
            jump_velocity: Some(8.0),
            ..Weenie::default()
        };
        let p = Profile::retail();
        assert_eq!(weenie.jump_velocity(0.5, &p), Some(4.0));
        assert_eq!(MotionCallbacks::run_rate(&weenie, &p), None);
    }
}
