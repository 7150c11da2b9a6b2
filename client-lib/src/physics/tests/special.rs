//! Objects of a single cell, of particles, without parts, and copies for the interface (03 8.3, 8.21; 06 D2.8, G1), and what the ways of making
//! parts mean for collision.

use super::*;
use crate::math::Sphere;
use crate::physics::body::ObjectRef;
use crate::physics::state::PhysicsState;
use crate::world::{CellHandle, CellRef};

/// A shape, not a setup.
const CUBE: u32 = 0x0100_0001;

fn cell_at(world: &mut World, place: Position) -> CellHandle {
    world.visible_cell(place.cell).expect("there")
}

/// Whether a cell has the object at home, and how many shadows it throws there.
fn presence(world: &World, cell: CellHandle, id: EntityId) -> (usize, usize) {
    let base = world.land.cell(cell).map(CellRef::base).expect("loaded");
    let count = |list: &[ObjectRef]| list.iter().filter(|&&o| o == ObjectRef::Entity(id)).count();
    (count(&base.objects), count(&base.shadows))
}

/// 03, 8.21: in one cell at a time, with one shadow, however large the object is and however often it is put there.
#[test]
fn an_object_of_a_single_cell_throws_one_shadow() {
    let mut world = world();
    let corner = at(47.9, 47.9, 0.0);
    let a = cell_at(&mut world, corner);
    let b = cell_at(&mut world, at(60.0, 47.9, 0.0));
    for setup in [WALKER, CRATE] {
        let id = object(&mut world, setup, 0x0001_0008, None);
        world.with_entity(id, |e, w| {
            e.set_frame(corner.frame, w);
            e.add_to_single_cell(Some(a), w);
            e.add_to_single_cell(Some(a), w);
        });
        assert_eq!(
            (presence(&world, a, id), presence(&world, b, id)),
            ((1, 1), (0, 0))
        );
        let body = &world.entity(id).expect("there").body;
        assert_eq!((body.position.cell, body.shadows.len()), (corner.cell, 1));
        world.with_entity(id, |e, w| e.add_to_single_cell(Some(b), w));
        assert_eq!(
            (presence(&world, a, id), presence(&world, b, id)),
            ((0, 0), (1, 1))
        );
        world.with_entity(id, |e, w| e.remove_from_single_cell(w));
        world.with_entity(id, |e, w| e.remove_from_single_cell(w));
        assert_eq!(
            (presence(&world, a, id), presence(&world, b, id)),
            ((0, 0), (0, 0))
        );
        let body = &world.entity(id).expect("there").body;
        assert_eq!((body.cell, body.position.cell), (None, CellId::NONE));
        world.with_entity(id, |e, w| e.add_to_single_cell(None, w));
        assert!(world.entity(id).expect("there").body.cell.is_none());
    }
}

/// 06, D2.1 and G1: an emitter of particles has a shadow in its own cell only, and nothing collides with it.
#[test]
fn particles_are_in_one_cell_and_in_nobodys_way() {
    let mut world = world();
    let large = Sphere::new(Vec3::ZERO, 30.0);
    assert!(world.make_particle_object(0, large).is_err());
    assert!(world.make_particle_object(usize::MAX, large).is_err());
    let id = world.make_particle_object(3, large).expect("parts");
    let place = at(36.0, 36.0, 0.0);
    let cell = cell_at(&mut world, place);
    world.with_entity(id, |e, w| {
        assert_eq!(e.guid(), 0);
        let wanted = PhysicsState::PARTICLE_EMITTER | PhysicsState::STATIC;
        assert!(e.body.state.contains(wanted));
        e.set_frame(place.frame, w);
        e.change_cell(Some(cell), w);
        e.calc_cross_cells(w);
    });
    let body = &world.entity(id).expect("there").body;
    assert_eq!(body.shadows.len(), 1, "whatever its size");
    assert!(
        body.part_array
            .as_ref()
            .is_some_and(|p| p.existing_parts().count() == 0)
    );
    // A walker stands in it.
    let walker = walker(&mut world, place);
    assert_eq!(world.entity(walker).expect("there").body.position, place);
    world.delete_entity(id);
    assert_eq!(presence(&world, cell, id), (0, 0));
}

/// 06, G1: nothing without parts can be in a cell; parts that come later make it an object like any other.
#[test]
fn an_object_without_parts_is_in_no_cell() {
    let mut world = world();
    let id = world.make_null_object(0x8000_0077, true);
    world.entities.register(id, 0x8000_0077);
    let place = at(36.0, 36.0, 0.0);
    let cell = cell_at(&mut world, place);
    world.with_entity(id, |e, w| e.add_to_single_cell(Some(cell), w));
    assert_eq!(presence(&world, cell, id), (0, 0));
    let parts = |world: &mut World, data: u32| {
        world.with_entity(id, |e, w| e.init_null_object(data, w).is_ok())
    };
    assert_eq!(parts(&mut world, 0x0200_0099), Some(false));
    assert_eq!(parts(&mut world, WALKER), Some(true));
    assert_eq!(
        world.with_entity(id, |e, w| e.enter_world_at(&place, false, w)),
        Some(true)
    );
    assert_eq!(presence(&world, cell, id), (1, 1));
    // Other parts for an object that has some.
    assert_eq!(parts(&mut world, CRATE), Some(true));
    let body = &world.entity(id).expect("there").body;
    assert!(body.state.contains(PhysicsState::HAS_PHYSICS_BSP));
}

/// The interface shows a copy: the same parts, outside the world, moved by nobody.
#[test]
fn a_copy_for_the_interface_stays_outside() {
    let mut world = world();
    let original = walker(&mut world, at(36.0, 36.0, 0.0));
    let copy = world.make_examination_object(original).expect("a copy");
    frame(&mut world, 100.1);
    let (a, b) = (
        world.entity(original).expect("there"),
        world.entity(copy).expect("there"),
    );
    assert!(
        b.examination_object && b.guid() == 0 && b.body.cell.is_none() && b.body.shadows.is_empty()
    );
    let shapes = |e: &crate::entity::Entity| {
        let parts = e.body.part_array.as_ref().expect("parts");
        parts
            .existing_parts()
            .map(|p| Arc::as_ptr(&p.shape))
            .collect::<Vec<_>>()
    };
    assert_eq!(shapes(a), shapes(b));
    assert!(world.make_examination_object(EntityId(999)).is_none());
}

/// The three ways of making parts, as obstacles: a shape and a setup with a shape are hit by their trees, a setup with spheres by these, and
/// without the flag of the tree (a state word has it or not) by spheres only.
#[test]
fn what_stops_a_walker_by_how_it_was_made() {
    let way = |data: u32, state: u32| {
        let mut world = world();
        object(&mut world, data, state, Some(at(36.0, 40.0, 0.0)));
        let id = walker(&mut world, at(36.0, 36.0, 0.0));
        for n in 1..=20 {
            world.with_entity(id, |e, w| e.set_velocity(Vec3::Y * 5.0, w));
            frame(&mut world, 100.0 + f64::from(n) * 0.1);
        }
        world
            .entity(id)
            .expect("there")
            .body
            .position
            .frame
            .origin
            .y
    };
    // The crate begins at 39; the walker's radius is 0.48, and a step that would touch is taken back.
    let by_tree = 38.521;
    for data in [CUBE, CRATE] {
        let y = way(data, 0x0001_0408);
        assert!((by_tree - 0.5..by_tree).contains(&y), "{data:#x}: {y}");
        assert!(way(data, 0x408) > 40.5, "{data:#x} without the flag");
    }
    let y = way(WALKER, 0x408);
    assert!(
        (38.5..39.041).contains(&y),
        "two radii before the middle: {y}"
    );
    assert!(way(WALKER, 0x040C) > 40.5, "passable");
}

/// 03, 8.3: a building's cell knows who is in its rooms, an indoor cell only its own.
#[test]
fn objects_are_found_in_their_cells() {
    let mut world = world();
    let room = in_cell(0x1020_0100, 96.0, 96.0, -50.0);
    let inside = walker(&mut world, room);
    let outside = walker(&mut world, at(36.0, 36.0, 0.0));
    let guid = |world: &World, id: EntityId| world.entity(id).expect("there").guid();
    let (a, b) = (guid(&world, inside), guid(&world, outside));
    let indoors = cell_at(&mut world, room);
    let outdoors = cell_at(&mut world, at(36.0, 36.0, 0.0));
    assert_eq!(world.object_in_cell(indoors, a), Some(inside));
    assert_eq!(world.object_in_cell(indoors, b), None);
    assert_eq!(world.object_in_cell(outdoors, b), Some(outside));
    assert_eq!(world.object_in_cell(outdoors, a), None);
    assert_eq!(
        world.object_in_cell(outdoors, 0),
        None,
        "objects of the dat files are nobody"
    );
}

/// B9: an object of the interface is advanced by one step of any length, without cell and collision; tiny gaps are dropped, short ones wait, and
/// a long pause is dropped (but in profile `ace`, whose gate is disabled).
#[test]
fn objects_of_the_interface_turn_outside_the_world() {
    for (profile, pauses) in [(Profile::retail(), true), (Profile::ace(), false)] {
        let mut world = world_of(profile);
        let original = walker(&mut world, at(36.0, 36.0, 0.0));
        let copy = world.make_examination_object(original).expect("a copy");
        world.with_entity(copy, |e, _| e.kin.omega = Vec3::Z);
        let mut turned = |now: f64| {
            world.clock.now = now;
            let turn = world.with_entity(copy, |e, w| {
                let before = e.heading(w);
                e.update_outside_world(w);
                before - e.heading(w)
            });
            let turn = turn.expect("there").rem_euclid(360.0);
            if turn > 359.99 {
                0.0
            } else {
                turn.to_radians()
            }
        };
        assert_eq!(turned(100.0001), 0.0);
        assert_eq!(turned(100.03), 0.0, "too short: it waits");
        assert!(
            (turned(100.3001) - 0.3).abs() < 1e-3,
            "also longer than a step may be"
        );
        let after_a_pause = turned(103.3001);
        assert_eq!(after_a_pause == 0.0, pauses, "{after_a_pause}");
        assert!((turned(103.4001) - 0.1).abs() < 1e-3);
        assert_eq!(world.clock.sim_time, world.clock.now);
    }
}
