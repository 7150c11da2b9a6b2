//! Collision with cells.

use super::*;
use crate::entity::{HouseAccess, Weenie};
use crate::physics::body::{EntityId, ObjectRef};
use crate::physics::state::PhysicsState;
use crate::physics::transition::{ObjectInfoState, Transition, TransitionState};
use crate::profile::HouseBarriers;
use crate::world::CellRef;

/// A mover of one sphere that stands at a place, nobody's entity.
fn mover<'w>(world: &'w World, place: Position, center: Vec3, radius: f32) -> Transition<'w> {
    let mut t = Transition::new(world);
    t.object.object = Some(ObjectRef::Entity(EntityId(1000)));
    t.object.scale = 1.0;
    t.path.num_sphere = 1;
    t.path.local_sphere[0] = Sphere::new(center, radius);
    t.path.curr_pos = place;
    t.path.check_pos = place;
    t.path.cache_global_curr_center(&world.profile);
    t.path.cache_global_sphere(&world.profile);
    t
}

fn collide(
    world: &mut World,
    place: Position,
    prepare: impl Fn(&mut Transition<'_>),
) -> (TransitionState, Option<Vec3>) {
    let cell = loaded(world, place.cell.0);
    let mut t = mover(world, place, Vec3::new(0.0, 0.0, 0.48), 0.48);
    prepare(&mut t);
    let state = t.find_cell_collisions(cell);
    (
        state,
        t.info
            .collision_normal_valid
            .then_some(t.info.collision_normal),
    )
}

#[test]
fn a_cell_that_is_not_below_the_mover_does_nothing() {
    let mut world = testbed(Profile::retail());
    let cell = loaded(&mut world, 0xA9B4_0012);
    let place = at(0xA9B4_0012, 30.0, 30.0, 20.0);
    let mut t = mover(&world, place, Vec3::new(0.0, 0.0, 0.48), 0.48);
    let before = format!("{:?}{:?}", t.path, t.info);
    assert_eq!(t.find_cell_collisions(cell), TransitionState::Ok);
    assert_eq!(format!("{:?}{:?}", t.path, t.info), before);
}

#[test]
fn flooded_blocks_keep_everyone_out_but_missiles_and_viewers() {
    let mut world = testbed(Profile::retail());
    let place = at(0xA8B6_0001, 10.0, 10.0, 50.0);
    assert_eq!(
        collide(&mut world, place, |_| {}).0,
        TransitionState::Collided
    );
    let missile = collide(&mut world, place, |t| {
        t.object.physics_state |= PhysicsState::MISSILE
    });
    assert_eq!(missile.0, TransitionState::Ok);
}

#[test]
fn a_released_cell_answers_invalid() {
    let mut world = testbed(Profile::retail());
    let cell = loaded(&mut world, 0xA9B4_0012);
    world.release_block(CellId(0xA9B4_0012), &mut Vec::new());
    let mut t = mover(&world, at(0xA9B4_0012, 60.0, 36.0, 20.0), Vec3::ZERO, 0.5);
    assert_eq!(t.find_cell_collisions(cell), TransitionState::Invalid);
    assert!(t.world.land.cell(cell).is_none());
}

#[test]
fn the_building_flag_is_set_only_inside_the_building_test() {
    let mut world = testbed(Profile::retail());
    // Against the front wall of the house.
    let place = at(0xA9B4_0025, 108.0, 101.6, 20.0);
    let cell = loaded(&mut world, 0xA9B4_0025);
    let mut t = mover(&world, place, Vec3::new(0.0, 0.0, 1.0), 0.48);
    t.path.insert_type = crate::physics::transition::InsertType::Placement;
    let state = t.find_cell_collisions(cell);
    assert_eq!(state, TransitionState::Collided);
    assert!(!t.path.bldg_check && t.info.collided_with_environment);
}

/// A world in which the restricted cell's house object is entity 0 or absent.
fn barred(profile: Profile, house: Option<HouseAccess>) -> World {
    let mut world = testbed(profile);
    if let Some(house) = house {
        let mut entity = world.entities.create(0x7AB3_0001, 0.0);
        entity.weenie = Some(Weenie {
            house: Some(house),
            ..Weenie::default()
        });
        world.entities.register(entity.id, 0x7AB3_0001);
        world.entities.put(entity);
    }
    world
}

#[test]
fn house_barriers() {
    let outside = at(0xABB3_0040, 180.0, 160.0, 30.0);
    let as_player = |t: &mut Transition<'_>| {
        t.object.state |= ObjectInfoState::IS_PLAYER;
        t.object.guid = 0x5000_0001;
    };
    let closed = || Some(HouseAccess::default());
    let open = || {
        Some(HouseAccess {
            open: true,
            guests: Vec::new(),
        })
    };
    let guest = || {
        Some(HouseAccess {
            open: false,
            guests: vec![0x5000_0001],
        })
    };
    let ask = |house, profile, prepare: &dyn Fn(&mut Transition<'_>)| {
        collide(&mut barred(profile, house), outside, prepare)
    };
    let (state, normal) = ask(closed(), Profile::retail(), &as_player);
    assert_eq!(
        (state, normal),
        (TransitionState::Collided, Some(Vec3::NEG_Y))
    );
    assert_eq!(
        ask(None, Profile::retail(), &as_player).0,
        TransitionState::Collided
    );
    assert_eq!(
        ask(open(), Profile::retail(), &as_player).0,
        TransitionState::Ok
    );
    assert_eq!(
        ask(guest(), Profile::retail(), &as_player).0,
        TransitionState::Ok
    );
    assert_eq!(
        ask(closed(), Profile::retail(), &|_| {}).0,
        TransitionState::Ok,
        "not a player"
    );
    let absent = Profile {
        house_barriers: HouseBarriers::Absent,
        ..Profile::retail()
    };
    assert_eq!(ask(closed(), absent, &as_player).0, TransitionState::Ok);
    let once = Profile {
        house_barriers: HouseBarriers::PlayersOnce,
        ..Profile::retail()
    };
    assert_eq!(ask(closed(), once, &as_player).0, TransitionState::Collided);
    let bypass = |t: &mut Transition<'_>| {
        as_player(t);
        t.object.bypasses_restrictions = true;
    };
    assert_eq!(
        ask(closed(), Profile::retail(), &bypass).0,
        TransitionState::Ok
    );
}

#[test]
fn the_barrier_normal_is_a_horizontal_axis() {
    for (x, y, expected) in [
        (180.0, 150.0, Vec3::NEG_Y),
        (160.0, 180.0, Vec3::NEG_X),
        (180.0, 180.0, Vec3::X),
        (185.0, 193.0, Vec3::Y),
    ] {
        let mut world = barred(Profile::retail(), Some(HouseAccess::default()));
        let cell = loaded(&mut world, 0xABB3_0040);
        let place = at(0xABB3_0040, x, y, 20.0);
        let mut t = mover(&world, place, Vec3::ZERO, 0.5);
        t.object.state |= ObjectInfoState::IS_PLAYER;
        assert_eq!(t.find_cell_collisions(cell), TransitionState::Collided);
        assert_eq!(t.info.collision_normal, expected, "({x}, {y})");
    }
}

#[test]
fn the_ground_lifts_a_mover_that_is_in_it() {
    let mut world = testbed(Profile::retail());
    let place = at(0xA9B4_0012, 60.0, 36.0, 19.9);
    let cell = loaded(&mut world, 0xA9B4_0012);
    let mut t = mover(&world, place, Vec3::new(0.0, 0.0, 0.48), 0.48);
    assert_eq!(t.find_cell_collisions(cell), TransitionState::Adjusted);
    assert!((t.path.check_pos.frame.origin.z - 20.0).abs() < 1e-5);
    assert!(matches!(world.land.cell(cell), Some(CellRef::Land(_))));
}
