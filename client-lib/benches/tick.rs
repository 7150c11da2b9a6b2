//! Speed of one tick of one object: at rest, standing as a creature, sliding over terrain.

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use ac_client::dat::{DatSet, Strictness};
use ac_client::frame::NoProbe;
use ac_client::math::{CellId, Position, Quat, Vec3};
use ac_client::physics::body::EntityId;
use ac_client::profile::Profile;
use ac_client::world::World;
use criterion::{Criterion, criterion_group, criterion_main};

const FRAME: f64 = 0.04;
/// A solid object with one sphere and no motion table; a human with its motion table.
const BALL: u32 = 0x0200_000D;
const HUMAN: u32 = 0x0200_0001;
const HUMAN_MOTIONS: u32 = 0x0900_0001;
const SOLID: u32 = 0x408;

fn world() -> World {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden-traces/worlds/testbed");
    let source = Arc::new(DatSet::open(folder, Strictness::Lenient).expect("the bundled world"));
    World::with_source(Profile::retail(), 1000.0, source)
}

fn place(world: &mut World, guid: u32, setup: u32, motions: u32) -> EntityId {
    let id = world.make_object(setup, guid, true).expect("its setup");
    world.entities.register(id, guid);
    world.with_entity(id, |entity, world| {
        if motions != 0 {
            entity.set_motion_table(motions, world);
        }
        entity.set_state(SOLID, world);
        let at = Vec3::new(60.0 + 6.0 * guid as f32, 24.0, 20.0);
        let at = Position::new(CellId(0xA9B4_0011), at, Quat::IDENTITY);
        assert!(entity.enter_world_at(&at, true, world));
    });
    id
}

fn tick(world: &mut World, id: EntityId) {
    world.clock.now += FRAME;
    world.update_entity(id, &mut NoProbe);
    if let Some(entity) = world.entity_mut(id) {
        entity.begin_frame();
    }
}

fn rest(c: &mut Criterion) {
    let mut world = world();
    let ball = place(&mut world, 1, BALL, 0);
    let human = place(&mut world, 2, HUMAN, HUMAN_MOTIONS);
    for _ in 0..10 {
        tick(&mut world, ball);
        tick(&mut world, human);
    }
    c.bench_function("tick of a resting object", |b| {
        b.iter(|| tick(black_box(&mut world), ball));
    });
    c.bench_function("tick of a standing creature", |b| {
        b.iter(|| tick(black_box(&mut world), human));
    });
}

fn slide(c: &mut Criterion) {
    let mut world = world();
    let ball = place(&mut world, 1, BALL, 0);
    let mut count = 0_u32;
    c.bench_function("tick of an object sliding over terrain", |b| {
        b.iter(|| {
            count += 1;
            let speed = if count & 0x40 == 0 { 3.0 } else { -3.0 };
            world.with_entity(ball, |entity, world| {
                entity.set_velocity(Vec3::new(0.0, speed, 0.0), world);
            });
            tick(black_box(&mut world), ball);
        });
    });
}

criterion_group!(benches, rest, slide);
criterion_main!(benches);
