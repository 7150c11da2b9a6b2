//! Animated objects of the dat files (B9).

use super::*;
use crate::dat::AnimFrame;
use crate::dat::worldgen::yaw;

/// A lift: a crate that its default animation moves up by a metre and down again.
fn world_with_lift(profile: Profile) -> World {
    let mut world = WorldBuilder::new();
    let cube = world.solid(&block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0)));
    world.setup(SetupBuilder::humanoid(cube, 1.8, 0.48));
    let pose = |z: f32| {
        let frame = StoredFrame {
            origin: Vec3::Z * z,
            rotation: yaw(0.0),
        };
        let frame = AnimFrame {
            parts: vec![frame],
            hooks: Vec::new(),
        };
        (frame, None)
    };
    // Thirty frames a second: a second below, a second above.
    let frames = (0..60).map(|n| pose(if n < 30 { 0.0 } else { 1.0 }));
    let lift = world.animation(1, frames);
    let lift = world.setup(SetupBuilder::of_shape(cube).animation(lift));
    world
        .block(0x10, 0x20)
        .object(lift, Vec3::new(60.0, 60.0, 0.0), 0.0);
    let dats = world.surround().build().expect("the world is well formed");
    World::with_source(profile, 100.0, Arc::new(dats))
}

fn height(world: &World) -> f32 {
    let id = world.land.animated_statics()[0];
    let parts = world
        .land
        .static_body(id)
        .and_then(|b| b.part_array.as_ref());
    let part = parts.and_then(|p| p.parts[0].as_ref());
    part.expect("a part").position.frame.origin.z
}

#[test]
fn a_default_animation_moves_the_parts() {
    for name in Profile::NAMES {
        let mut world = world_with_lift(Profile::named(name).expect("a preset"));
        world.visible_cell(CellId(0x1020_0013));
        assert_eq!(world.land.animated_statics().len(), 1);
        let mut heights = Vec::new();
        for n in 1..=40 {
            frame(&mut world, 100.0 + f64::from(n) * 0.05);
            heights.push(height(&world));
        }
        assert!(
            heights[..18].iter().all(|&z| z == 0.0),
            "{name}: {heights:?}"
        );
        // Profile `ace` gives the default animation no frame rate (N-09).
        let above = if name == "ace" { 0.0 } else { 1.0 };
        assert!(
            heights[21..38].iter().all(|&z| z == above),
            "{name}: {heights:?}"
        );
        assert_eq!(world.clock.sim_time, world.clock.now);
    }
}

/// The gates of O-41: short frames add up, and a long pause is dropped, but in profile `gdle`.
#[test]
fn gaps_of_static_animations() {
    for (name, played) in [("retail", false), ("ace", false), ("gdle", true)] {
        let mut world = world_with_lift(Profile::named(name).expect("a preset"));
        world.visible_cell(CellId(0x1020_0013));
        frame(&mut world, 103.3);
        assert_eq!(height(&world) == 1.0, played, "{name}");
    }
    let mut world = world_with_lift(Profile::retail());
    world.visible_cell(CellId(0x1020_0013));
    for n in 1..=150 {
        frame(&mut world, 100.0 + f64::from(n) * 0.01);
    }
    assert_eq!(height(&world), 1.0);
}

/// A mover is stopped where the moved part is.
#[test]
fn moved_parts_are_collided_with() {
    let mut world = world_with_lift(Profile::retail());
    let id = walker(&mut world, at(60.0, 57.0, 0.0));
    let top = |world: &mut World, now| {
        frame(world, now);
        let place = at(60.0, 60.0, 2.5);
        let to = crate::physics::placement::SetPosition::new(
            place,
            crate::physics::placement::PlacementFlags::TELEPORT,
        );
        world.with_entity(id, |e, w| e.set_position(&to, w))
    };
    let ok = Some(crate::physics::placement::SetPositionError::Ok);
    // Above the crate there is room; once it is lifted there is none.
    assert_eq!(top(&mut world, 100.5), ok);
    world.with_entity(id, |e, w| {
        e.set_position_simple(&at(60.0, 57.0, 0.0), true, w)
    });
    assert_ne!(top(&mut world, 101.5), ok);
}
