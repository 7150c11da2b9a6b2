//! What the server says about the player's abilities, as far as they move it (`spec/10-messages.md`, 7; `spec/08-motion.md`, 12).

use super::{GameEntities, Verdict};
use crate::motion::Character;
use crate::net::messages::PropertyUpdate;
use crate::net::messages::player_description::PlayerDescription;
use crate::net::messages::property::{Attribute, PropertyValue, Skill};
use crate::world::World;

/// Skill ids.
const JUMP: u32 = 22;
const RUN: u32 = 24;
/// Keys of properties.
const STRENGTH: u32 = 1;
const ENCUMBRANCE: u32 = 5;
const STAMINA: u32 = 4;

fn level(skill: &Skill) -> i32 {
    // What enchantments and attributes add is in tables that this library does not read: the trained part stands for the skill.
    let ranks = i32::from(skill.ranks);
    i32::try_from(skill.start)
        .unwrap_or(i32::MAX)
        .saturating_add(ranks)
}

fn value(attribute: &Attribute) -> i32 {
    i32::try_from(attribute.ranks.saturating_add(attribute.start)).unwrap_or(i32::MAX)
}

impl GameEntities {
    /// The player's abilities, once the server has told them.
    pub const fn character(&self) -> Option<&Character> {
        self.character.as_ref()
    }

    /// PlayerDescription (7.2).
    pub(super) fn take_character(&mut self, about: &PlayerDescription, world: &mut World) {
        let vectors = &about.vectors;
        let attributes = vectors.attributes.as_ref().map(|a| &a.fields);
        let skill = |id: u32| {
            let table = vectors.skills.as_ref()?;
            let (_, skill) = table.entries.iter().find(|(key, _)| *key == id)?;
            Some(level(skill))
        };
        let int = |key: u32| {
            let table = about.properties.ints.as_ref()?;
            table.entries.iter().find(|(k, _)| *k == key).map(|e| e.1)
        };
        let defaults = Character::default();
        self.character = Some(Character {
            local_player: true,
            strength: attributes
                .and_then(|a| a.strength.as_ref())
                .map_or(defaults.strength, value),
            encumbrance: int(ENCUMBRANCE).unwrap_or(defaults.encumbrance),
            run_skill: skill(RUN),
            jump_skill: skill(JUMP),
            stamina: attributes
                .and_then(|a| a.stamina.as_ref())
                .map(|vital| vital.current),
            ..defaults
        });
        self.give_character(world);
    }

    /// A change of one of the player's properties (7.1).
    pub(super) fn take_property(&mut self, update: &PropertyUpdate, world: &mut World) -> Verdict {
        let (Some(character), None) = (&mut self.character, update.guid) else {
            return Verdict::Other;
        };
        match (&update.value, update.key) {
            (PropertyValue::Int(v), ENCUMBRANCE) => character.encumbrance = *v,
            (PropertyValue::Attribute(v), STRENGTH) => character.strength = value(v),
            (PropertyValue::Skill(v), RUN) => character.run_skill = Some(level(v)),
            (PropertyValue::Skill(v), JUMP) => character.jump_skill = Some(level(v)),
            (PropertyValue::Vital(v), STAMINA) => character.stamina = Some(v.current),
            (PropertyValue::VitalCurrent(v), STAMINA) => character.stamina = Some(*v),
            _ => return Verdict::Other,
        }
        self.give_character(world);
        Verdict::Applied
    }

    /// Lets the player's companion answer by what is known.
    pub(super) fn give_character(&self, world: &mut World) {
        let Some(character) = self.character else {
            return;
        };
        if let Some(player) = world.local_player.and_then(|id| world.entity_mut(id)) {
            player.weenie.get_or_insert_default().character = Some(character);
        }
    }
}
