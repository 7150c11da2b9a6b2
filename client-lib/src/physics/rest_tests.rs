//! Objects at rest: that they are not looked at changes nothing (`spec/06-physics-object.md`, B3).

use proptest::prelude::*;

use crate::frame::{NoHost, NoProbe, Pipeline};
use crate::math::{CellId, Position, Quat, Vec3};
use crate::physics::body::EntityId;
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::Profile;
use crate::world::{CellHandle, World};

const START: f64 = 1000.0;

fn world_with_object(profile: Profile) -> (World, EntityId) {
    let mut world = World::new(profile, START);
    let mut entity = world.entities.create(1, START);
    let id = entity.id;
    entity.body.cell = Some(CellHandle(0));
    world.entities.put(entity);
    world.entities.register(id, 1);
    (world, id)
}

fn run_frame(world: &mut World, seconds: f64) {
    let now = world.clock.now + seconds;
    Pipeline::default().run_frame_probed(world, now, &mut NoHost, &mut NoProbe);
}

/// Both clocks of the world and that of the object.
fn clocks(world: &mut World, id: EntityId) -> [u64; 3] {
    let clock = world.clock;
    let own = world.entity_mut(id).map_or(f64::NAN, |e| e.kin.update_time);
    [clock.now, clock.sim_time, own].map(f64::to_bits)
}

proptest! {
    #[test]
    fn clocks_pass_as_if_updated(
        frames in prop::collection::vec(
            prop_oneof![0.0..0.05f64, 0.0..0.5f64, 0.0..3.0f64, Just(0.0), Just(1.0 / 30.0), Just(0.2), Just(1e-4)],
            1..30,
        ),
        profile in prop_oneof![
            Just(Profile::retail()), Just(Profile::ace()), Just(Profile::gdle()),
        ],
    ) {
        let (mut at_rest, id) = world_with_object(profile.clone());
        let (mut touched, same) = world_with_object(profile);
        for seconds in frames {
            run_frame(&mut at_rest, seconds);
            // Whoever may change the object ends its rest: it is updated in full.
            touched.entity_mut(same);
            run_frame(&mut touched, seconds);
            prop_assert_eq!(at_rest.clock.sim_time.to_bits(), touched.clock.sim_time.to_bits());
        }
        prop_assert_eq!(clocks(&mut at_rest, id), clocks(&mut touched, same));
    }
}

/// The object and, before or after it in the table, a local player from whom far objects are culled.
fn world_with_player(
    profile: Profile,
    is_static: bool,
    player_first: bool,
) -> (World, EntityId, EntityId) {
    let profile = Profile {
        distance_culling: true,
        ..profile
    };
    let mut world = World::new(profile, START);
    let make = |world: &mut World, guid| {
        let mut entity = world.entities.create(guid, START);
        let id = entity.id;
        entity.body.cell = Some(CellHandle(0));
        entity.body.position = place(0.0);
        entity.kin.transient = TransientState::CONTACT | TransientState::ON_WALKABLE;
        entity
            .body
            .state
            .set(PhysicsState::STATIC, is_static && guid == 1);
        world.entities.put(entity);
        world.entities.register(id, guid);
        id
    };
    let first = make(&mut world, if player_first { 2 } else { 1 });
    let second = make(&mut world, if player_first { 1 } else { 2 });
    let (id, player) = if player_first {
        (second, first)
    } else {
        (first, second)
    };
    world.local_player = Some(player);
    (world, id, player)
}

fn place(x: f32) -> Position {
    Position::new(CellId(0x1020_0001), Vec3::new(x, 0.0, 0.0), Quat::IDENTITY)
}

proptest! {
    /// B3, 2: with a local player, an object beyond 96 m rests and is hardly looked at; nothing of it or of the clocks differs from an update in full.
    #[test]
    fn culled_objects_rest_as_if_updated(
        frames in prop::collection::vec((0.0..0.3f64, 80.0..110.0f32), 1..30),
        profile in prop_oneof![Just(Profile::retail()), Just(Profile::gdle())],
        is_static: bool, player_first: bool, culling_enabled: bool,
    ) {
        let (mut at_rest, id, player) = world_with_player(profile.clone(), is_static, player_first);
        let (mut touched, same, _) = world_with_player(profile, is_static, player_first);
        let mut rested = 0;
        for world in [&mut at_rest, &mut touched] {
            world.culling_enabled = culling_enabled;
        }
        for (seconds, x) in frames {
            for world in [&mut at_rest, &mut touched] {
                world.entity_mut(player).unwrap().body.position = place(x);
            }
            run_frame(&mut at_rest, seconds);
            touched.entity_mut(same);
            run_frame(&mut touched, seconds);
            rested += u32::from(at_rest.entities.resting_since(id).is_some());
            prop_assert_eq!(at_rest.clock.sim_time.to_bits(), touched.clock.sim_time.to_bits());
            let seen = |world: &World| {
                let e = world.entity(id).unwrap();
                let vector = e.player_vector.to_array().map(f32::to_bits);
                (vector, e.player_distance.to_bits(), e.kin.transient.bits())
            };
            prop_assert_eq!(seen(&at_rest), seen(&touched));
        }
        prop_assert!(rested > 0 || !is_static);
        prop_assert_eq!(clocks(&mut at_rest, id), clocks(&mut touched, same));
    }
}

#[test]
fn a_far_object_rests_until_the_player_comes() {
    let (mut world, id, player) = world_with_player(Profile::retail(), false, true);
    let mut step = |x| {
        world.entity_mut(player).unwrap().body.position = place(x);
        run_frame(&mut world, 0.05);
        let active = world
            .entity(id)
            .unwrap()
            .kin
            .transient
            .contains(TransientState::ACTIVE);
        (world.entities.resting_since(id).is_some(), active)
    };
    assert_eq!(step(120.0), (true, false));
    assert_eq!(step(97.0), (true, false));
    // Exactly 96 m is not beyond.
    assert_eq!(step(96.0), (false, true));
    assert_eq!(step(200.0), (true, false));
}

#[test]
fn whoever_changes_an_object_ends_its_rest() {
    let (mut world, id) = world_with_object(Profile::retail());
    run_frame(&mut world, 0.04);
    assert!(world.entities.resting_since(id).is_some());
    let entity = world.entity_mut(id).map(|e| e.kin.update_time);
    assert_eq!(entity, Some(world.clock.now));
    assert!(world.entities.resting_since(id).is_none());
    run_frame(&mut world, 0.04);
    assert!(world.with_entity(id, |_, _| ()).is_some());
    assert!(world.entities.resting_since(id).is_none());
}
