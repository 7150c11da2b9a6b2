//! Creating an entity as a scene describes it (`spec/scene-format.md`, "Entity").

use ac_client::entity::{Child, Weenie};
use ac_client::math::{CellId, Frame, Position, Quat, Vec3};
use ac_client::physics::attachment::Attachment;
use ac_client::physics::body::{EntityId, WeenieFlags};
use ac_client::physics::state::PhysicsState;
use ac_client::world::World;
use ac_golden_traces::scene::{EntityKind, EntitySpec, PositionSpec};

/// A position of a scene.
pub(super) fn position(spec: &PositionSpec) -> Position {
    Position::new(
        CellId(spec.cell),
        Vec3::from(spec.origin),
        quat(spec.rotation),
    )
}

/// A rotation `[w, x, y, z]`.
pub(super) fn quat([w, x, y, z]: [f32; 4]) -> Quat {
    Quat::new(w, x, y, z)
}

/// What went otherwise than wanted while an entity was made; the run goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CreationNote {
    /// The setup cannot be had: there is no entity.
    NoObject,
    /// There was no room for it.
    DidNotEnter,
    /// It cannot be attached.
    ParentRefused,
}

/// Makes an entity, in the order of the format: object, weenie, object table, motion table, state word, scale, material, velocity, place.
/// `parent` is the object its `parent` names.
pub(super) fn create(
    spec: &EntitySpec,
    parent: Option<EntityId>,
    world: &mut World,
) -> (Option<EntityId>, Option<CreationNote>) {
    let Ok(id) = world.make_object(spec.setup, spec.guid, true) else {
        return (None, Some(CreationNote::NoObject));
    };
    attach_weenie(id, spec, world);
    world.entities.register(id, spec.guid);
    let note = world.with_entity(id, |entity, world| {
        if spec.motion_table != 0 {
            entity.set_motion_table(spec.motion_table, world);
            if world.profile.weenie_set_twice {
                entity.movement_weenie_changed(world);
            }
        }
        if world.profile.initial_state_assigned {
            entity.body.state = PhysicsState::from_bits_retain(spec.state);
        } else {
            entity.set_state(spec.state, world);
        }
        entity.set_scale_static(spec.scale);
        entity.kin.elasticity = spec.elasticity;
        entity.kin.friction = spec.friction;
        entity.set_velocity(Vec3::from(spec.velocity), world);
        entity.kin.omega = Vec3::from(spec.omega);
        let place = position(&spec.position);
        if spec.parent.is_none() {
            let entered = entity.enter_world_at(&place, true, world);
            return (!entered).then_some(CreationNote::DidNotEnter);
        }
        entity.store_position(&place, world);
        let at = Attachment::Part {
            part: Child::NO_PART,
            frame: Frame::IDENTITY,
        };
        let attached = parent.is_some_and(|parent| entity.set_parent(parent, at, world));
        (!attached).then_some(CreationNote::ParentRefused)
    });
    (Some(id), note.flatten())
}

/// The weenie that every entity of a scene has.
pub(super) fn attach_weenie(id: EntityId, spec: &EntitySpec, world: &mut World) {
    let Some(entity) = world.entity_mut(id) else {
        return;
    };
    let player = spec.kind == EntityKind::Player;
    entity.body.weenie = WeenieFlags {
        present: true,
        player,
        creature: player || spec.kind == EntityKind::Creature,
        ..WeenieFlags::default()
    };
    entity.weenie = Some(Weenie {
        run_rate: Some(spec.run_rate),
        jump_velocity: Some(spec.jump_velocity),
        can_jump: spec.jump_velocity > 0.0,
        jump_stamina_cost: Some(0),
        ..Weenie::default()
    });
}
