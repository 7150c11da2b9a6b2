//! A tick in the steady state allocates nothing.

use std::path::Path;
use std::sync::Arc;

use ac_client::dat::{DatSet, Strictness};
use ac_client::frame::{FrameState, NoHost, NoProbe, Pipeline};
use ac_client::math::{CellId, Position, Quat, Vec3};
use ac_client::motion::{Command, Movement, MovementParameters};
use ac_client::physics::body::EntityId;
use ac_client::profile::Profile;
use ac_client::world::World;

const FRAME: f64 = 0.04;

fn world() -> World {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden-traces/worlds/testbed");
    let source = Arc::new(DatSet::open(folder, Strictness::Lenient).unwrap());
    World::with_source(Profile::retail(), 1000.0, source)
}

fn place(world: &mut World, guid: u32, setup: u32, motions: u32, origin: Vec3) -> EntityId {
    let id = world.make_object(setup, guid, true).unwrap();
    world.entities.register(id, guid);
    world.with_entity(id, |entity, world| {
        if motions != 0 {
            entity.set_motion_table(motions, world);
        }
        entity.body.weenie.present = true;
        entity.body.weenie.creature = motions != 0;
        entity.set_state(0x0040_0C08, world);
        let at = Position::new(CellId(0xA9B4_0011), origin, Quat::IDENTITY);
        assert!(entity.enter_world_at(&at, true, world));
    });
    id
}

/// Allocations of 200 frames after 200 frames of warming up, with the records of the frames written.
fn allocations(world: &mut World, ids: &[EntityId], mut input: impl FnMut(&mut World, u32)) -> u64 {
    let mut pipeline = Pipeline::default();
    let mut record = FrameState::default();
    let mut run = |world: &mut World, frames: std::ops::Range<u32>| {
        for frame in frames {
            for &id in ids {
                if let Some(entity) = world.entity_mut(id) {
                    entity.begin_frame();
                }
            }
            input(world, frame);
            let now = world.clock.now + FRAME;
            pipeline.run_frame_probed(world, now, &mut NoHost, &mut NoProbe);
            for &id in ids {
                if let Some(entity) = world.entity(id) {
                    entity.frame_state(frame as i32, now, &mut record);
                }
            }
        }
    };
    run(world, 0..200);
    allocation_counter::measure(|| run(world, 200..400)).count_total
}

#[test]
fn standing_creatures_and_resting_objects() {
    let mut world = world();
    let ids = [
        place(
            &mut world,
            1,
            0x0200_0001,
            0x0900_0001,
            Vec3::new(60.0, 24.0, 20.0),
        ),
        place(&mut world, 2, 0x0200_000D, 0, Vec3::new(66.0, 24.0, 20.0)),
    ];
    assert_eq!(allocations(&mut world, &ids, |_, _| {}), 0);
}

#[test]
fn an_object_that_slides_to_and_fro() {
    let mut world = world();
    let ball = place(&mut world, 1, 0x0200_000D, 0, Vec3::new(60.0, 30.0, 20.0));
    let count = allocations(&mut world, &[ball], |world, frame| {
        let speed = if frame % 64 < 32 { 3.0 } else { -3.0 };
        world.with_entity(ball, |e, w| e.set_velocity(Vec3::new(0.0, speed, 0.0), w));
    });
    assert_eq!(count, 0);
}

#[test]
fn a_creature_that_walks() {
    let mut world = world();
    let human = place(
        &mut world,
        1,
        0x0200_0001,
        0x0900_0001,
        Vec3::new(60.0, 24.0, 20.0),
    );
    let count = allocations(&mut world, &[human], |world, frame| {
        if frame == 0 {
            let walk = MovementParameters::new(&world.profile);
            let walk = Movement::Interpreted(Command(0x4500_0005), walk);
            world.with_entity(human, |e, w| e.perform_movement(&walk, w).unwrap());
        }
        if frame % 50 == 0 {
            // Walks within one landblock: what is loaded on the way allocates.
            let place = Vec3::new(60.0, 24.0, 20.0);
            let at = Position::new(CellId(0xA9B4_0011), place, Quat::IDENTITY);
            world.with_entity(human, |e, w| e.set_position_simple(&at, true, w));
        }
    });
    assert_eq!(count, 0);
}
