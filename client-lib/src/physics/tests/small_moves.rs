//! Moves too small to count, the top of a throw, and gaps in the clock (H3: 12, 19, 25; H4: 5, 7, 19).

use super::*;
use crate::dat::AnimFrame;
use crate::math::Frame;
use crate::physics::state::PhysicsState;
use crate::profile::Unmoved;

/// An object whose default animation moves it north by `step` m per frame, 30 frames a second.
pub(super) fn creeping(profile: Profile, step: f32) -> (World, EntityId) {
    let mut world = WorldBuilder::new();
    let cube = world.solid(&block(Vec3::new(-0.3, -0.3, 0.0), Vec3::new(0.3, 0.3, 1.8)));
    let frames = (0..30).map(|_| {
        let frame = AnimFrame {
            parts: vec![StoredFrame::at(Vec3::ZERO)],
            hooks: Vec::new(),
        };
        (frame, Some(StoredFrame::at(Vec3::Y * step)))
    });
    let creep = world.animation(1, frames);
    let setup = world.setup(SetupBuilder::humanoid(cube, 1.8, 0.48).animation(creep));
    world.block(0x10, 0x20);
    let dats = world.surround().build().expect("the world is well formed");
    let mut world = World::with_source(profile, 100.0, Arc::new(dats));
    let id = object(&mut world, setup, 0x0040_0408, Some(at(36.0, 36.0, 0.0)));
    world.with_entity(id, |e, w| e.make_movement_manager(true, w));
    (world, id)
}

fn crept(profile: Profile, step: f32, frames: u32) -> f32 {
    let (mut world, id) = creeping(profile, step);
    frame(&mut world, 100.04);
    let before = world.entity(id).expect("there").body.position.frame;
    for n in 1..=frames {
        frame(&mut world, 100.04 + f64::from(n) * 0.04);
    }
    let after = world.entity(id).expect("there").body.position.frame;
    if before.bits() == after.bits() {
        0.0
    } else {
        after.origin.y - before.origin.y
    }
}

/// H3, 12: less than ε per step never adds up, unless a profile keeps it (O-05); more does.
#[test]
fn moves_below_the_tolerance_never_add_up() {
    assert_eq!(crept(Profile::retail(), 0.000_06, 300), 0.0);
    let inclusive = Profile {
        unmoved: Unmoved::Inclusive,
        ..Profile::retail()
    };
    assert!(crept(inclusive, 0.000_06, 300) > 0.01);
    assert!(crept(Profile::retail(), 0.001, 100) > 0.1);
}

/// H4, 5: one step of f32 around ε on one axis; only rotating is not moving.
#[test]
fn displacements_around_the_tolerance() {
    let moved = |x: f32, unmoved: Unmoved| {
        let profile = Profile {
            unmoved,
            ..Profile::retail()
        };
        let to = Frame::from_origin(Vec3::new(x, 0.0, 0.0));
        !to.is_vector_equal(&Frame::IDENTITY, &profile)
    };
    let limit = 0.0002_f32;
    let around = [limit.next_down(), limit, limit.next_up()];
    assert_eq!(
        around.map(|x| moved(x, Unmoved::Strict)),
        [false, true, true]
    );
    assert_eq!(
        around.map(|x| moved(-x, Unmoved::Inclusive)),
        [false, false, true]
    );
    let mut turned = Frame::IDENTITY;
    turned.set_heading(90.0, &Profile::retail());
    assert!(turned.is_vector_equal(&Frame::IDENTITY, &Profile::retail()));
}

/// H4, 5: rotation without translation is taken at once, without a transition.
#[test]
fn turning_on_the_spot_is_no_transition() {
    let mut world = world();
    let id = walker(&mut world, at(36.0, 36.0, 5.0));
    world.with_entity(id, |e, w| {
        e.set_state(0x8, w);
        e.make_movement_manager(true, w);
        e.kin.calc_acceleration(e.body.state, &w.profile);
        e.kin.omega = Vec3::Z;
    });
    let before = world.entity(id).expect("there").body.position.frame;
    frame(&mut world, 100.1);
    let e = world.entity(id).expect("there");
    assert_eq!(e.body.position.frame.origin, before.origin);
    assert_ne!(e.body.position.frame.rotation(), before.rotation());
    assert!(
        e.steps
            .iter()
            .all(|s| s.outcome == crate::frame::state::Outcome::None)
    );
}

/// H4, 7: at the top of a throw what is left of the speed is lost, and the fall begins one step late.
#[test]
fn the_top_of_a_throw_takes_the_rest_of_the_speed() {
    let mut world = world();
    let id = walker(&mut world, at(36.0, 36.0, 5.0));
    world.with_entity(id, |e, w| e.set_velocity(Vec3::new(0.1, 0.0, 0.2), w));
    let height = world
        .entity(id)
        .expect("there")
        .body
        .position
        .frame
        .origin
        .z;
    frame(&mut world, 100.05);
    let e = world.entity(id).expect("there");
    let quantum = e.steps[0].dt;
    assert_eq!(e.kin.velocity, Vec3::new(0.0, 0.0, -9.8 * quantum));
    // Half the acceleration still counts.
    let fallen = height - e.body.position.frame.origin.z;
    assert!((fallen - 4.9 * quantum * quantum).abs() < 1e-5, "{fallen}");
}

/// H3, 25: whatever the two bits were, showing an object again sets them.
#[test]
fn showing_sets_the_report_bits() {
    for word in [0x8, 0x18, 0x10, 0x0] {
        let mut world = world();
        let id = object(&mut world, WALKER, word, Some(at(36.0, 36.0, 0.0)));
        world.with_entity(id, |e, w| {
            e.set_hidden(true, w);
            e.set_hidden(false, w);
        });
        let state = world.entity(id).expect("there").body.state;
        assert!(state.contains(PhysicsState::REPORT_COLLISIONS), "{word:#x}");
        assert!(
            !state.contains(PhysicsState::IGNORE_COLLISIONS)
                && !state.contains(PhysicsState::HIDDEN)
        );
    }
}

/// H3, 19: players pass through each other, and nobody notes it.
#[test]
fn exempt_objects_are_passed_without_a_note() {
    let mut world = world();
    let a = walker(&mut world, at(36.0, 36.0, 0.0));
    let b = walker(&mut world, at(36.0, 38.0, 0.0));
    for id in [a, b] {
        let body = &mut world.entity_mut(id).expect("there").body;
        (
            body.weenie.present,
            body.weenie.player,
            body.weenie.creature,
        ) = (true, true, true);
    }
    let target = bits(&world, b);
    for n in 1..=12 {
        world.with_entity(a, |e, w| e.set_velocity(Vec3::Y * 5.0, w));
        frame(&mut world, 100.0 + f64::from(n) * 0.1);
    }
    let e = world.entity(a).expect("there");
    assert!(e.body.position.frame.origin.y > 39.5);
    assert!(e.touched.is_empty() && e.collision_table.is_empty());
    // H3, 18: who is run into is left as he is, but for his clock.
    let after = bits(&world, b);
    assert_eq!((after.0, &after.1[3..]), (target.0, &target.1[3..]));
}

/// H4, 19: a gap of more than two seconds drops the time; a contact that was over by then ends at the next move that is committed.
#[test]
fn contacts_end_after_a_gap_in_the_clock() {
    let mut world = world();
    let a = walker(&mut world, at(36.0, 36.0, 0.0));
    walker(&mut world, at(36.0, 37.2, 0.0));
    world.with_entity(a, |e, w| e.set_velocity(Vec3::Y * 5.0, w));
    frame(&mut world, 100.1);
    let records = |world: &World| world.entity(a).expect("there").collision_table.len();
    assert_eq!(records(&world), 1);
    frame(&mut world, 103.0);
    assert_eq!(records(&world), 1, "nothing was done");
    world.with_entity(a, |e, w| e.set_velocity(Vec3::NEG_Y * 5.0, w));
    frame(&mut world, 103.1);
    assert_eq!(records(&world), 0);
}
