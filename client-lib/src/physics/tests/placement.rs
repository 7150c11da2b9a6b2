//! Placing and teleporting (C3, C4; H3: 26; H4: 13 to 15).

use super::*;
use crate::physics::placement::{PlacementFlags, SetPosition, SetPositionError};

fn set(world: &mut World, id: EntityId, to: Position, flags: PlacementFlags) -> SetPositionError {
    world
        .with_entity(id, |e, w| e.set_position(&SetPosition::new(to, flags), w))
        .expect("there")
}

/// H3, 26: a refused placement changes neither place nor lists; and 13: solid rock with and without SLIDE.
#[test]
fn a_refused_placement_leaves_the_object() {
    for name in Profile::NAMES {
        let mut world = world_of(Profile::named(name).expect("a preset"));
        let id = walker(&mut world, at(30.0, 30.0, 0.0));
        let before = world.entity(id).expect("there").body.clone();
        // Inside the crate.
        let error = set(
            &mut world,
            id,
            at(60.0, 60.0, 0.5),
            PlacementFlags::TELEPORT,
        );
        assert_ne!(error, SetPositionError::Ok, "{name}");
        let body = &world.entity(id).expect("there").body;
        assert_eq!(body.cell, before.cell);
        assert_eq!(body.position, before.position);
        assert_eq!(body.shadows, before.shadows);
        // Beside the crate there is room.
        let error = set(&mut world, id, at(60.9, 60.0, 0.5), PlacementFlags::SLIDE);
        assert_eq!(error, SetPositionError::Ok, "{name}");
        let placed = world.entity(id).expect("there").body.position.frame.origin;
        assert!((placed.x - 60.0).abs().max((placed.y - 60.0).abs()) > 1.0 || placed.z >= 1.9);
    }
}

/// H4, 13 and 14: cells that do not exist lose the object; strange outdoor numbers are put right or lose it, and nothing panics.
#[test]
fn cells_that_are_not_there() {
    for (cell, lost) in [
        (0x0102_u32, true),
        (0xFFFE, true),
        (0x00FF, true),
        (0x0041, true),
        (0xFFFF, true),
    ] {
        let mut world = world();
        let id = walker(&mut world, at(30.0, 30.0, 0.0));
        let to = in_cell(0x1020_0000 | cell, 30.0, 30.0, 0.0);
        let error = set(&mut world, id, to, PlacementFlags::SLIDE);
        let entity = world.entity(id).expect("there");
        assert_eq!(error, SetPositionError::Ok, "{cell:#x}");
        assert_eq!(entity.body.cell.is_none(), lost, "{cell:#x}");
        assert_eq!(world.lost.contains(id), lost, "{cell:#x}");
        frame(&mut world, 100.1);
    }
    // Off the loaded land, and off the map.
    for block in [0x3030_0001_u32, 0xFE10_0001, 0x00FE_0040] {
        let mut world = world();
        let id = walker(&mut world, at(30.0, 30.0, 0.0));
        let to = in_cell(block, -5.0, 200.0, 0.0);
        set(&mut world, id, to, PlacementFlags::SLIDE);
        assert!(
            world.entity(id).expect("there").body.cell.is_none(),
            "{block:#x}"
        );
        frame(&mut world, 100.1);
        // And back.
        set(&mut world, id, at(30.0, 30.0, 0.0), PlacementFlags::SLIDE);
        assert!(world.entity(id).expect("there").body.cell.is_some());
        assert!(!world.lost.contains(id));
    }
}

#[test]
fn scatter_without_tries_fails_and_with_tries_finds_room() {
    let mut world = world();
    world.random = crate::world::Random::Seeded(3);
    let id = walker(&mut world, at(30.0, 30.0, 0.0));
    let scatter = |tries| SetPosition {
        range_x: 4.0,
        range_y: 4.0,
        tries,
        ..SetPosition::new(at(60.0, 60.0, 0.0), PlacementFlags::RANDOM_SCATTER)
    };
    let mut place = |tries| world.with_entity(id, |e, w| e.set_position(&scatter(tries), w));
    assert_eq!(place(0), Some(SetPositionError::GeneralFailure));
    assert_eq!(place(50), Some(SetPositionError::Ok));
    let origin = world.entity(id).expect("there").body.position.frame.origin;
    assert!(
        (origin - Vec3::new(60.0, 60.0, origin.z))
            .abs()
            .max_element()
            <= 4.5
    );
}

/// H4, 13: players stand in each other; a door that is passable is no obstacle.
#[test]
fn players_and_passable_objects_do_not_stop_a_teleport() {
    let mut world = world();
    let other = walker(&mut world, at(36.0, 36.0, 0.0));
    let id = walker(&mut world, at(30.0, 30.0, 0.0));
    let to = at(36.0, 36.0, 0.0);
    assert_ne!(
        set(&mut world, id, to, PlacementFlags::TELEPORT),
        SetPositionError::Ok
    );
    world.with_entity(other, |e, w| e.set_state(0x0040_040C, w));
    assert_eq!(
        set(&mut world, id, to, PlacementFlags::TELEPORT),
        SetPositionError::Ok
    );
    let back = at(30.0, 30.0, 0.0);
    assert_eq!(
        set(&mut world, id, back, PlacementFlags::TELEPORT),
        SetPositionError::Ok
    );
    world.with_entity(other, |e, w| e.set_state(0x0040_0408, w));
    for player in [other, id] {
        let entity = world.entity_mut(player).expect("there");
        entity.body.weenie.present = true;
        entity.body.weenie.player = true;
        entity.body.weenie.creature = true;
    }
    assert_eq!(
        set(&mut world, id, to, PlacementFlags::TELEPORT),
        SetPositionError::Ok
    );
}
