//! Bounce, steps without progress, and contact records (`spec/06-physics-object.md`, C7, C8, H2, H3).

use proptest::prelude::*;

use crate::entity::{CollisionReport, Entity, Weenie};
use crate::math::Vec3;
use crate::physics::body::{EntityId, ObjectRef};
use crate::physics::state::{PhysicsState, TransientState};
use crate::physics::transition::CollisionInfo;
use crate::profile::Profile;
use crate::world::World;

fn world() -> World {
    World::new(Profile::retail(), 100.0)
}

fn object(world: &mut World, guid: u32, state: u32) -> EntityId {
    let mut entity = world.entities.create(guid, world.clock.now);
    entity.body.state = PhysicsState::from_bits_retain(state);
    entity.weenie = Some(Weenie {
        collects_reports: true,
        ..Weenie::default()
    });
    let id = entity.id;
    world.entities.put(entity);
    world.entities.register(id, guid);
    id
}

fn touched(objects: &[EntityId]) -> CollisionInfo {
    CollisionInfo {
        collide_object: objects.iter().map(|&id| ObjectRef::Entity(id)).collect(),
        ..CollisionInfo::default()
    }
}

fn handle(world: &mut World, id: EntityId, info: &CollisionInfo) -> bool {
    world
        .with_entity(id, |e, w| e.handle_all_collisions(info, false, false, w))
        .unwrap()
}

fn take_reports(world: &mut World, id: EntityId) -> Vec<CollisionReport> {
    std::mem::take(&mut world.entity_mut(id).unwrap().reports)
}

fn bounced(elasticity: f32, velocity: Vec3, normal: Vec3) -> Vec3 {
    let mut world = world();
    let mut entity = Entity::new(EntityId(0), 1, 0.0);
    entity.kin.velocity = velocity;
    entity.kin.elasticity = elasticity;
    let info = CollisionInfo {
        collision_normal_valid: true,
        collision_normal: normal,
        ..CollisionInfo::default()
    };
    entity.handle_all_collisions(&info, false, false, &mut world);
    entity.kin.velocity
}

#[test]
fn a_bounce_gives_back_its_elasticity() {
    let down = Vec3::new(0.0, 0.0, -5.0);
    assert_eq!(bounced(0.05, down, Vec3::Z).z, 0.25);
    assert_eq!(bounced(0.1, down, Vec3::Z).z, 0.5);
}

#[test]
fn three_steps_without_progress_end_the_count() {
    let mut world = world();
    let mut entity = Entity::new(EntityId(0), 1, 0.0);
    let mut stuck = |entity: &mut Entity, n| {
        entity.kin.velocity = Vec3::X;
        let info = CollisionInfo {
            frames_stationary_fall: n,
            ..CollisionInfo::default()
        };
        entity.handle_all_collisions(&info, false, false, &mut world);
        (entity.kin.transient.bits(), entity.kin.velocity.x)
    };
    assert_eq!(stuck(&mut entity, 1), (0x10, 1.0));
    assert_eq!(stuck(&mut entity, 2), (0x30, 0.0));
    assert_eq!(stuck(&mut entity, 3), (0x00, 0.0));
    assert_eq!(stuck(&mut entity, 2), (0x20, 0.0));
    assert_eq!(stuck(&mut entity, 0), (0x00, 1.0));
}

#[test]
fn a_contact_is_reported_once_and_ends_once() {
    let mut world = world();
    let (a, b) = (object(&mut world, 1, 0x408), object(&mut world, 2, 0x408));
    assert!(handle(&mut world, a, &touched(&[b])));
    assert!(!handle(&mut world, a, &touched(&[b])));
    assert!(matches!(
        take_reports(&mut world, a)[..],
        [CollisionReport::Object(r)] if r.guid == 2
    ));
    assert!(matches!(
        take_reports(&mut world, b)[..],
        [CollisionReport::Object(r)] if r.guid == 1
    ));
    world.clock.sim_time += 1.0;
    handle(&mut world, a, &touched(&[]));
    assert!(take_reports(&mut world, a).is_empty());
    world.clock.sim_time += 0.1;
    handle(&mut world, a, &touched(&[]));
    assert_eq!(take_reports(&mut world, a), [CollisionReport::End(2)]);
    assert_eq!(take_reports(&mut world, b), [CollisionReport::End(1)]);
    handle(&mut world, a, &touched(&[]));
    assert!(take_reports(&mut world, a).is_empty());
}

#[test]
fn a_destroyed_object_ends_its_contacts_for_the_own_weenie() {
    let mut world = world();
    let (a, b) = (object(&mut world, 1, 0x408), object(&mut world, 2, 0x408));
    handle(&mut world, a, &touched(&[b]));
    take_reports(&mut world, a);
    world.forget(b);
    world.clock.sim_time += 2.0;
    handle(&mut world, a, &touched(&[]));
    assert_eq!(take_reports(&mut world, a), [CollisionReport::End(2)]);
}

#[test]
fn a_missile_is_one_until_it_hits() {
    let mut world = world();
    let (arrow, wall) = (
        object(&mut world, 1, 0x0002_0748),
        object(&mut world, 2, 0x408),
    );
    handle(&mut world, arrow, &touched(&[wall]));
    let state = world.entity(arrow).unwrap().body.state.bits();
    assert_eq!(state, 0x0002_0748 & !0x340);
    assert!(matches!(
        take_reports(&mut world, arrow)[..],
        [CollisionReport::Attack(_)]
    ));
}

#[test]
fn hiding_ends_contacts_and_showing_reports_anew() {
    let mut world = world();
    let (a, b) = (object(&mut world, 1, 0x418), object(&mut world, 2, 0x408));
    handle(&mut world, a, &touched(&[b]));
    take_reports(&mut world, a);
    let hide = |world: &mut World, on| {
        world.with_entity(a, |e, w| e.set_hidden(on, w));
        world.entity(a).unwrap().body.state
    };
    let hidden = hide(&mut world, true);
    assert!(hidden.contains(PhysicsState::HIDDEN | PhysicsState::IGNORE_COLLISIONS));
    assert!(!hidden.contains(PhysicsState::REPORT_COLLISIONS));
    assert_eq!(take_reports(&mut world, a), [CollisionReport::End(2)]);
    let shown = hide(&mut world, false);
    assert_eq!(shown.bits(), 0x408);
}

#[test]
fn a_word_set_twice_changes_nothing_more() {
    let mut world = world();
    let a = object(&mut world, 1, 0x408);
    for word in [0x0040_4410, 0x0040_0408, 0x24, 0x0100_0000] {
        let set = |world: &mut World| {
            world.with_entity(a, |e, w| e.set_state(word, w));
            world.entity(a).unwrap().body.state.bits()
        };
        assert_eq!(set(&mut world), set(&mut world));
    }
}

proptest! {
    #[test]
    fn a_bounce_turns_the_normal_part_only(
        (x, y, z) in (-20.0_f32..20.0, -20.0_f32..20.0, -20.0_f32..20.0),
        angle in 0.0_f32..6.0, elasticity in 0.0_f32..0.1,
    ) {
        let velocity = Vec3::new(x, y, z);
        let normal = Vec3::new(angle.cos(), angle.sin(), 0.0);
        let after = bounced(elasticity, velocity, normal);
        let before = velocity.dot(normal);
        if before >= 0.0 {
            prop_assert_eq!(after, velocity);
        } else {
            prop_assert!((after.dot(normal) + elasticity * before).abs() < 1e-4);
            let tangential = |v: Vec3| v - normal * v.dot(normal);
            prop_assert!((tangential(after) - tangential(velocity)).length() < 1e-4);
        }
    }

    #[test]
    fn an_inactive_object_stays_so(transient in 0_u32..0x200) {
        let mut world = world();
        let mut entity = Entity::new(EntityId(0), 1, 0.0);
        entity.kin.transient = TransientState::from_bits_retain(transient);
        entity.clear_transient_states(&mut world);
        prop_assert!(entity.kin.transient.is_empty());
    }
}
