//! Missiles inside their owner, against each other, and without their target (C6, O-24; H4: 24).

use super::*;
use crate::physics::state::PhysicsState;

/// The state word of an arrow in flight, without gravity: REPORT_COLLISIONS, MISSILE, ALIGN_PATH, PATH_CLIPPED, INELASTIC.
const ARROW: u32 = 0x0002_0348;

fn creature(world: &mut World, place: Position) -> EntityId {
    let id = walker(world, place);
    let body = &mut world.entity_mut(id).expect("there").body;
    (body.weenie.present, body.weenie.creature) = (true, true);
    id
}

fn guid(world: &World, id: EntityId) -> u32 {
    world.entity(id).expect("there").guid()
}

/// A missile that flies north at 10 m/s from a place, for `target` (0: for nobody); `None` if there was no room for it.
fn shot(world: &mut World, place: Position, target: u32) -> Option<EntityId> {
    let id = object(world, ARROW_SETUP, ARROW, None);
    world.with_entity(id, |e, w| {
        e.body.weenie.present = true;
        e.body.target = target;
        let entered = e.enter_world_at(&place, false, w);
        e.set_velocity(Vec3::Y * 10.0, w);
        entered.then_some(id)
    })?
}

/// Flies for a second, and answers how far it came and whether it is a missile still.
fn fly(world: &mut World, id: EntityId) -> (f32, bool) {
    let start = world.entity(id).expect("there").body.position;
    let now = world.clock.now;
    for n in 1..=20 {
        frame(world, now + f64::from(n) * 0.05);
    }
    let e = world.entity(id).expect("there");
    let way = start.offset_to(&e.body.position);
    (way.y, e.body.state.contains(PhysicsState::MISSILE))
}

#[test]
fn a_missile_starts_inside_its_owner() {
    let mut world = world();
    let owner = creature(&mut world, at(36.0, 20.0, 0.0));
    let prey = creature(&mut world, at(36.0, 26.0, 0.0));
    let inside = at(36.0, 20.0, 0.4);
    // With a target other than the owner, the owner is not in the way.
    let prey_guid = guid(&world, prey);
    let id = shot(&mut world, inside, prey_guid).expect("room");
    assert_eq!(
        world.entity(id).expect("there").body.position.frame.origin,
        inside.frame.origin
    );
    let (way, flies) = fly(&mut world, id);
    assert!(
        (4.5..5.6).contains(&way) && !flies,
        "it hits its target: {way}"
    );
    // Without a target it hits creatures, its owner first: there is no room for it.
    assert_eq!(shot(&mut world, inside, 0), None);
    // An owner who is his own missile's target is in its way, too.
    let owner_guid = guid(&world, owner);
    assert_eq!(shot(&mut world, inside, owner_guid), None);
}

#[test]
fn missiles_pass_through_each_other() {
    let mut world = world();
    let a = shot(&mut world, at(36.0, 20.0, 1.0), 0).expect("room");
    let b = shot(&mut world, at(36.0, 25.0, 1.0), 0).expect("room");
    let inside = shot(&mut world, at(36.0, 25.0, 1.0), 0).expect("missiles take no room");
    world.with_entity(b, |e, w| e.set_velocity(Vec3::Y * -10.0, w));
    let (way, flies) = fly(&mut world, a);
    assert!(flies && (way - 10.0).abs() < 0.01, "{way}");
    for id in [b, inside] {
        assert!(world.entity(id).expect("there").touched.is_empty());
    }
}

/// The id stays: the missile goes on flying through every other creature, and is stopped by scenery.
#[test]
fn the_target_of_a_missile_vanishes() {
    let mut world = world();
    let prey = creature(&mut world, at(60.0, 70.0, 0.0));
    creature(&mut world, at(60.0, 54.0, 0.0));
    let prey_guid = guid(&world, prey);
    let id = shot(&mut world, at(60.0, 50.0, 0.5), prey_guid).expect("room");
    world.delete_entity(prey);
    let (way, flies) = fly(&mut world, id);
    // Through the creature at 54; the crate's wall is at 59.
    assert!((8.0..9.0).contains(&way) && !flies, "{way}");
    assert!(world.entity(id).expect("there").touched.is_empty());
    assert!(world.entity(id).expect("there").touched_environment);
}
