//! What a description says, in the terms of the physics (`spec/10-messages.md`, 4).

use crate::entity::{CollisionProfile, Entity, Timestamps, Weenie};
use crate::math::{Position, Vec3};
use crate::net::messages::common::WirePosition;
use crate::net::messages::movement::MovementData;
use crate::net::messages::obj_desc::ObjDesc;
use crate::net::messages::physics_desc::{Motion, PhysicsDesc};
use crate::net::messages::weenie_desc::{WeenieDesc, object_bits};
use crate::physics::body::WeenieFlags;
use crate::physics::network::PhysicsDescription;
use crate::world::World;

/// Item type of creatures: the only word of a description that tells one.
const CREATURE: u32 = 0x10;

pub(super) fn change_parts(entity: &mut Entity, appearance: &ObjDesc, world: &mut World) {
    let Some(parts) = entity.body.part_array.as_mut() else {
        return;
    };
    let setup = parts.setup().cloned();
    let original = setup
        .iter()
        .flat_map(|s| s.parts.iter().copied().enumerate());
    let changes = appearance
        .parts
        .iter()
        .map(|c| (usize::from(c.part), c.shape.0));
    // A new shape may be collided with where the part is.
    parts.settle_parts(&world.profile);
    let known = parts.set_parts(original.chain(changes), &mut world.resources);
    if !known {
        tracing::debug!(guid = entity.body.guid, "some changed part does not exist");
    }
    entity.cache_has_physics_bsp();
}

pub(super) fn valid_place(place: &WirePosition, world: &World) -> Option<Position> {
    let position = place.to_position();
    let finite = place.origin.iter().chain(&place.rotation);
    let valid = place.cell != 0
        && finite.copied().all(f32::is_finite)
        && position.frame.is_valid(&world.profile);
    valid.then_some(position)
}

/// Numbers of a description that physics takes.
pub(super) fn is_finite(p: &PhysicsDesc) -> bool {
    let f = &p.fields;
    let place = f.position.map(|p| {
        let [x, y, z] = p.origin;
        let [a, b, c, d] = p.rotation;
        [x, y, z, a, b, c, d]
    });
    let vectors = [f.velocity, f.acceleration, f.omega];
    let scalars = [f.scale, f.friction, f.elasticity, f.translucency];
    place.iter().flatten().all(|v| v.is_finite())
        && vectors.iter().flatten().flatten().all(|v| v.is_finite())
        && scalars.iter().flatten().all(|v| v.is_finite())
        && movement_of(p).is_none_or(|(data, _)| data.is_finite() || data.update().is_err())
}

pub(super) const fn movement_of(p: &PhysicsDesc) -> Option<(&MovementData, u32)> {
    match &p.motion {
        Motion::Movement {
            data: Some((data, autonomous)),
            ..
        } => Some((data, *autonomous)),
        _ => None,
    }
}

pub(super) fn physics_description(p: &PhysicsDesc) -> PhysicsDescription {
    let f = &p.fields;
    PhysicsDescription {
        state: p.state,
        motion_table: f.motion_table,
        autonomous: movement_of(p).map(|(_, autonomous)| autonomous != 0),
        placement: match p.motion {
            Motion::Placement(id) => Some(id),
            _ => None,
        },
        scale: f.scale,
        friction: f.friction,
        elasticity: f.elasticity,
        translucency: f.translucency,
        velocity: f.velocity.map(Vec3::from_array),
        default_script: f.default_script,
        default_script_intensity: f.default_script_intensity,
        timestamps: Timestamps(p.timestamps),
    }
}

/// What physics asks the game description (4.3).
pub(super) fn take_weenie(entity: &mut Entity, desc: &WeenieDesc) {
    let has = |bit: u32| desc.object_bits & bit != 0;
    let player = has(object_bits::PLAYER);
    let creature = player || desc.item_type & CREATURE != 0;
    entity.body.weenie = WeenieFlags {
        present: true,
        player,
        creature,
        pk: has(object_bits::PLAYER_KILLER),
        pk_lite: has(object_bits::PK_LITE),
        impenetrable: has(object_bits::FREE_PK),
        ..WeenieFlags::default()
    };
    let bit = |on: bool, bit: u32| if on { bit } else { 0 };
    let weenie = entity.weenie.get_or_insert_with(Weenie::default);
    weenie.corpse = has(object_bits::CORPSE);
    weenie.profile = Some(CollisionProfile {
        wcid: desc.class.0,
        item_type: desc.item_type,
        flags: bit(creature, 0x1)
            | bit(player, 0x2)
            | bit(has(object_bits::ATTACKABLE), 0x4)
            | bit(has(object_bits::DOOR), 0x40),
    });
}
