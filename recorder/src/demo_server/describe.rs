//! Entities of the simulation in the words of the protocol (`spec/10-messages.md`, 4 and 5).

use ac_client::entity::Entity;
use ac_client::motion::{Action, Command, InterpretedMotionState, MovementUpdate, UpdateKind};
use ac_client::net::messages::common::Table;
use ac_client::net::messages::common::{Text, WirePosition};
use ac_client::net::messages::movement::MovementData;
use ac_client::net::messages::object::ObjectDescription;
use ac_client::net::messages::physics_desc::{Motion, PhysicsDesc, PhysicsFields};
use ac_client::net::messages::player_description::{
    AttributeFields, Attributes, PlayerDescription, Properties, Vectors,
};
use ac_client::net::messages::position::{PositionPack, PositionStamps};
use ac_client::net::messages::property::{Attribute, Skill, Vital};
use ac_client::net::messages::weenie_desc::{WeenieDesc, object_bits};
use ac_client::physics::network::Stamp;
use ac_client::world::World;
use ac_golden_traces::scene::{EntityKind, EntitySpec};

/// The nine counters of an object, as this server keeps them.
pub(super) type Stamps = [u16; 9];

/// Item type of creatures and of everything else.
const CREATURE: u32 = 0x10;
const MISCELLANEOUS: u32 = 0x80;

/// What an interpreter does now, without its actions.
pub(super) fn state_of(entity: &Entity) -> Option<InterpretedMotionState> {
    let mut state = entity.interp()?.interpreted.clone();
    state.actions = Default::default();
    Some(state)
}

/// A movement that sets a state, plays actions, and sticks to an object.
pub(super) fn movement(
    state: &InterpretedMotionState,
    actions: &[Action],
    stick_to: Option<u32>,
    standing_longjump: bool,
) -> MovementData {
    let mut state = state.clone();
    actions.iter().for_each(|&action| state.actions.add(action));
    MovementData::new(MovementUpdate {
        style: state.style,
        standing_longjump,
        kind: UpdateKind::State(state, stick_to),
    })
}

/// A movement of another kind, in the stance that the object has.
pub(super) fn server_movement(entity: &Entity, kind: UpdateKind) -> MovementData {
    MovementData::new(MovementUpdate {
        style: entity.style().unwrap_or(Command::NON_COMBAT),
        standing_longjump: false,
        kind,
    })
}

/// Where an object is.
pub(super) fn position_pack(entity: &Entity, stamps: &Stamps) -> PositionPack {
    let place = WirePosition::of(&entity.body.position);
    let stamps = PositionStamps {
        instance: stamps[Stamp::Instance as usize],
        position: stamps[Stamp::Position as usize],
        teleport: stamps[Stamp::Teleport as usize],
        force: stamps[Stamp::ForcePosition as usize],
    };
    PositionPack::new(place, entity.kin.on_ground(), stamps)
}

/// The first place at which an object can hold another; 0 if there is none.
pub(super) fn holding_location(entity: &Entity) -> u32 {
    let setup = entity.part_array().and_then(|parts| parts.setup());
    let first = setup.and_then(|setup| setup.holding_locations.iter().next());
    first.map_or(0, |(location, _)| *location as u32)
}

/// Everything about an object.
pub(super) fn describe(
    entity: &Entity,
    spec: &EntitySpec,
    stamps: &Stamps,
    world: &World,
) -> ObjectDescription {
    ObjectDescription {
        guid: spec.guid,
        physics: physics(entity, spec, stamps, world),
        weenie: weenie(spec),
        ..ObjectDescription::default()
    }
}

fn physics(entity: &Entity, spec: &EntitySpec, stamps: &Stamps, world: &World) -> PhysicsDesc {
    let parent = entity.parent().and_then(|id| world.entity(id));
    let parent = parent.map(|parent| (parent.guid(), holding_location(parent)));
    let in_world = entity.body.cell.is_some() && parent.is_none();
    let velocity = entity.kin.velocity.to_array();
    let motion = state_of(entity).map_or(Motion::Absent, |state| Motion::Movement {
        data: Some((movement(&state, &[], None, false), 0)),
        shadows: false,
    });
    PhysicsDesc {
        state: entity.body.state.bits(),
        motion,
        fields: PhysicsFields {
            position: in_world.then(|| WirePosition::of(&entity.body.position)),
            motion_table: (spec.motion_table != 0).then_some(spec.motion_table),
            setup: Some(spec.setup),
            parent,
            scale: (entity.body.scale != 1.0).then_some(entity.body.scale),
            friction: Some(entity.kin.friction),
            elasticity: Some(entity.kin.elasticity),
            velocity: (velocity != [0.0; 3]).then_some(velocity),
            ..PhysicsFields::default()
        },
        timestamps_bit: false,
        timestamps: *stamps,
    }
}

fn weenie(spec: &EntitySpec) -> WeenieDesc {
    let (kind, item_type, bits) = match spec.kind {
        EntityKind::Player => (
            "Player",
            CREATURE,
            object_bits::PLAYER | object_bits::ATTACKABLE,
        ),
        EntityKind::Creature => ("Creature", CREATURE, object_bits::ATTACKABLE),
        EntityKind::Object => ("Object", MISCELLANEOUS, 0),
        EntityKind::Missile => ("Missile", MISCELLANEOUS, 0),
    };
    let mut weenie = WeenieDesc {
        name: Text::new(&format!("{kind} {:X}", spec.guid)),
        item_type,
        object_bits: bits,
        ..WeenieDesc::default()
    };
    weenie.class.0 = 1;
    weenie
}

/// Abilities of a guest: run and jump as these skills say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Abilities {
    /// Run skill.
    pub run: u16,
    /// Jump skill.
    pub jump: u16,
}

impl Default for Abilities {
    fn default() -> Self {
        Self {
            run: 200,
            jump: 300,
        }
    }
}

/// Strength and stamina of every character here.
pub(super) const STRENGTH: u32 = 100;
pub(super) const STAMINA: u32 = 100;

/// A character with these abilities, as its player is told.
pub(super) fn player_description(abilities: Abilities) -> PlayerDescription {
    let skill = |ranks| Skill {
        ranks,
        training: 2,
        ..Skill::default()
    };
    let fields = AttributeFields {
        strength: Some(Attribute {
            start: STRENGTH,
            ..Attribute::default()
        }),
        stamina: Some(Vital {
            current: STAMINA,
            ..Vital::default()
        }),
        ..AttributeFields::default()
    };
    PlayerDescription {
        weenie_type: 1,
        properties: Properties::default(),
        has_health: 1,
        vectors: Vectors {
            attributes: Some(Attributes {
                other_bits: 0,
                fields,
            }),
            skills: Some(Table {
                buckets: 32,
                entries: vec![(22, skill(abilities.jump)), (24, skill(abilities.run))],
            }),
            ..Vectors::default()
        },
        ..PlayerDescription::default()
    }
}
