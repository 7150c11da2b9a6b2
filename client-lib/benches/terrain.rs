//! Height of the terrain and cell lists, outdoors and indoors.

use std::hint::black_box;
use std::path::PathBuf;
use std::sync::Arc;

use ac_client::dat::{DatSet, Strictness};
use ac_client::math::{CellId, Position, Quat, Sphere, Vec3};
use ac_client::physics::transition::CellArray;
use ac_client::profile::Profile;
use ac_client::world::{SpheresAt, World};
use criterion::{Criterion, criterion_group, criterion_main};

fn testbed() -> World {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../golden-traces/worlds/testbed");
    let dats = DatSet::open(folder, Strictness::Strict).expect("the world is in the repository");
    World::with_source(Profile::retail(), 0.0, Arc::new(dats))
}

fn at(cell: u32, x: f32, y: f32, z: f32) -> Position {
    Position::new(CellId(cell), Vec3::new(x, y, z), Quat::IDENTITY)
}

fn height(c: &mut Criterion) {
    let mut world = testbed();
    let block = CellId(0xA9B6_0001);
    world.ensure_loaded_around(&at(block.0, 1.0, 1.0, 0.0));
    c.bench_function("terrain/load_block", |b| {
        let mut lost = Vec::new();
        b.iter(|| {
            world.release_block(block, &mut lost);
            world.ensure_loaded_around(&at(block.0, 1.0, 1.0, 0.0));
        });
    });
    let mut k = 0_u32;
    c.bench_function("terrain/height", |b| {
        b.iter(|| {
            k = k.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let place = at(
                block.0,
                (k >> 16) as f32 * (192.0 / 65536.0),
                (k & 0xFFFF) as f32 * (192.0 / 65536.0),
                0.0,
            );
            world.land.terrain_height(black_box(&place), &world.profile)
        });
    });
}

fn cell_list(c: &mut Criterion) {
    let mut world = testbed();
    let mut array = CellArray::default();
    let cases = [
        ("outdoors_one_cell", at(0xA9B4_0012, 60.0, 36.0, 20.0)),
        ("outdoors_block_corner", at(0xA9B4_0001, 0.25, 0.25, 20.0)),
        ("at_the_door", at(0xA9B4_0025, 103.0, 101.8, 20.0)),
        ("indoors", at(0xA9B4_0100, 108.0, 108.0, 20.0)),
        ("dungeon", at(0x0D01_0100, 40.0, -40.0, -12.0)),
    ];
    for (name, position) in cases {
        let o = position.frame.origin;
        let spheres = [0.48, 1.32].map(|z| Sphere::new(o + Vec3::new(0.0, 0.0, z), 0.48));
        let at = SpheresAt {
            position: &position,
            spheres: &spheres,
            is_path: true,
            want_current: true,
        };
        world.with_loading(|land, profile, missing| {
            *missing = land.find_cell_list(at, &mut array, profile).missing;
        });
        c.bench_function(&format!("find_cell_list/{name}"), |b| {
            b.iter(|| {
                world
                    .land
                    .find_cell_list(black_box(at), &mut array, &world.profile)
                    .current
            });
        });
    }
}

criterion_group!(benches, height, cell_list);
criterion_main!(benches);
