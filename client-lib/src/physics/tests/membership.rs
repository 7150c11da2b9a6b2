//! Cells, shadows, and what objects carry over when they leave (D1, D2, G3; H3: 8 to 11, 13; H4: 9, 10, 23).

use proptest::prelude::*;

use super::*;
use crate::physics::fuzzing::check_membership;
use crate::physics::placement::{PlacementFlags, SetPosition};
use crate::physics::state::{PhysicsState, TransientState};
use crate::world::CellRef;

/// All cells of the middle block that name an object in one of their lists.
fn mentions(world: &World, id: EntityId) -> usize {
    let own = world.entity(id).expect("there").object_ref();
    let lows = (1..=64).chain(0x100..=0x101);
    lows.filter_map(|low| world.land.loaded(CellId(0x1020_0000 | low)))
        .filter_map(|handle| world.land.cell(handle).map(CellRef::base))
        .map(|base| {
            base.objects
                .iter()
                .chain(&base.shadows)
                .filter(|&&o| o == own)
                .count()
        })
        .sum()
}

#[test]
fn leaving_takes_every_mention_back() {
    for setup in [WALKER, CRATE] {
        let mut world = world();
        // At a corner of four cells.
        let id = object(&mut world, setup, 0x0041_0408, Some(at(48.1, 48.1, 0.0)));
        assert!(mentions(&world, id) >= 5, "one home and four shadows");
        check_membership(&world, id);
        world.with_entity(id, |e, w| e.leave_world(w));
        assert_eq!(mentions(&world, id), 0);
        let entity = world.entity(id).expect("there");
        assert!(entity.kin.transient.is_empty() && entity.body.shadows.is_empty());
        assert_eq!(
            (entity.body.cell, entity.body.position.cell),
            (None, CellId::NONE)
        );
    }
}

#[test]
fn moving_on_takes_the_shadows_along() {
    let mut world = world();
    let id = walker(&mut world, at(48.1, 36.0, 0.0));
    let before = world.entity(id).expect("there").body.shadows.len();
    assert_eq!(before, 2);
    world.with_entity(id, |e, w| {
        let to = SetPosition::new(at(36.0, 36.0, 0.0), PlacementFlags::SLIDE);
        e.set_position(&to, w);
    });
    check_membership(&world, id);
    assert_eq!(world.entity(id).expect("there").body.shadows.len(), 1);
    assert_eq!(mentions(&world, id), 2);
}

/// H3, 10: the cached velocity is the way of the step, also into another block; H4, 23: and the map ends somewhere.
#[test]
fn the_cached_velocity_crosses_borders() {
    let mut world = world();
    let id = walker(&mut world, at(191.5, 30.0, 5.0));
    world.with_entity(id, |e, w| e.set_velocity(Vec3::new(20.0, 0.0, 3.0), w));
    for n in 1..=4 {
        let before = world.entity(id).expect("there").body.position;
        frame(&mut world, 100.0 + f64::from(n) * 0.1);
        let entity = world.entity_mut(id).expect("there");
        let moved = before.offset_to(&entity.body.position);
        let dt = entity.steps.drain(..).map(|s| s.dt).sum::<f32>();
        assert!((entity.kin.cached_velocity * dt - moved).length() < 1e-3);
        check_membership(&world, id);
    }
    assert_eq!(
        world.entity(id).expect("there").body.position.cell.0 >> 16,
        0x1120
    );
}

/// H4, 9: shapes without size and of giants, and 10: velocities that are no numbers. Nothing is demanded but an end.
#[test]
fn strange_sizes_and_velocities_end() {
    let strange = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        1e-38,
        -0.0,
    ];
    for name in Profile::NAMES {
        for (scale, value) in [0.0, 100.0, -1.0, 1e20, f32::NAN, 1.0]
            .into_iter()
            .zip(strange)
        {
            let mut world = world_of(Profile::named(name).expect("a preset"));
            let id = walker(&mut world, at(30.0, 30.0, 0.5));
            world.with_entity(id, |e, w| {
                e.set_scale_static(scale);
                e.set_velocity(Vec3::new(1.0, 2.0, 1.0), w);
            });
            frame(&mut world, 100.1);
            world.with_entity(id, |e, w| {
                e.set_velocity(Vec3::new(value, 1.0, 0.0), w);
                e.kin.omega = Vec3::new(0.0, value, 0.0);
            });
            frame(&mut world, 100.2);
            frame(&mut world, 100.3);
            let mut strange_place = at(30.0, 30.0, 0.5);
            strange_place.frame.origin.x = value;
            world.with_entity(id, |e, w| e.set_position_simple(&strange_place, true, w));
            frame(&mut world, 100.4);
        }
    }
}

/// H4, 12: more than a turn in one step.
#[test]
fn more_than_a_turn_in_a_step() {
    let mut world = world();
    let id = walker(&mut world, at(30.0, 30.0, 6.0));
    world.with_entity(id, |e, _| e.kin.omega = Vec3::new(0.0, 0.0, 70.0));
    frame(&mut world, 100.1);
    let heading = world.with_entity(id, |e, w| e.heading(w)).expect("there");
    // 7 rad counter-clockwise from north.
    let expected = (360.0 - 7.0_f32.to_degrees() % 360.0) % 360.0;
    assert!((heading - expected).abs() < 0.01, "{heading}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// H3, 8, 9, 11 along random ways over the ground, crates and cell borders.
    #[test]
    fn lists_and_ground_agree(
        steps in prop::collection::vec((-12.0_f32..12.0, -12.0_f32..12.0, -2.0_f32..5.0, 0.035_f64..0.3), 1..12),
    ) {
        let mut world = world();
        let id = walker(&mut world, at(58.0, 56.0, 0.0));
        let mut now = 100.0;
        for (x, y, z, dt) in steps {
            world.with_entity(id, |e, w| e.set_velocity(Vec3::new(x, y, z), w));
            now += dt;
            frame(&mut world, now);
            check_membership(&world, id);
            let kin = &world.entity(id).expect("there").kin;
            let contact = kin.transient.contains(TransientState::CONTACT);
            let walkable = kin.transient.contains(TransientState::ON_WALKABLE);
            prop_assert!(contact || !walkable);
            if contact {
                prop_assert_eq!(walkable, kin.contact_plane.n.z >= 0.664_172_8);
            }
            let falls = if walkable { 0.0 } else { -9.8 };
            prop_assert_eq!(kin.acceleration.to_array(), [0.0, 0.0, falls]);
            prop_assert!(!world.entity(id).expect("there").body.state.contains(PhysicsState::HIDDEN));
        }
    }

    /// H3, 16: a hidden object stays, and keeps its velocity.
    #[test]
    fn hidden_objects_stay(velocity in (-9.0_f32..9.0, -9.0_f32..9.0, -9.0_f32..9.0), frames in 1_u32..10) {
        let mut world = world();
        let id = walker(&mut world, at(36.0, 36.0, 4.0));
        let velocity = Vec3::new(velocity.0, velocity.1, velocity.2);
        world.with_entity(id, |e, w| {
            e.set_hidden(true, w);
            e.set_velocity(velocity, w);
            e.kin.omega = Vec3::X;
        });
        let before = world.entity(id).expect("there").body.position.frame.bits();
        for n in 1..=frames {
            frame(&mut world, 100.0 + f64::from(n) * 0.1);
        }
        let entity = world.entity(id).expect("there");
        prop_assert_eq!(entity.body.position.frame.bits(), before);
        prop_assert_eq!((entity.kin.velocity, entity.kin.omega), (velocity, Vec3::X));
    }
}
