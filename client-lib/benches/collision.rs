//! Searches of collision trees: a room of six walls, and a hilly floor of 8192 triangles.

use std::hint::black_box;

use ac_client::math::{CellId, Position, Quat, Sphere, Vec3};
use ac_client::physics::collision::{
    GfxShape, PhysicsTree, PlacedPart, TouchedPolygon, WalkableSearch, find_part_collisions,
};
use ac_client::physics::transition::Transition;
use ac_client::profile::Profile;
use ac_client::world::World;
use criterion::{Criterion, criterion_group, criterion_main};

#[path = "../tests/collision/soup.rs"]
mod soup;

/// A sphere of human size on the ground of both trees.
const BALL: Sphere = Sphere::new(Vec3::new(1.3, 0.7, 0.3), 0.48);

fn searches(c: &mut Criterion, name: &str, tree: &PhysicsTree) {
    let profile = Profile::retail();
    let movement = Vec3::new(0.1, 0.2, -0.3);
    let mut group = c.benchmark_group(name);
    group.bench_function("sphere_intersects_poly", |b| {
        b.iter(|| {
            let mut touched = TouchedPolygon::default();
            tree.sphere_intersects_poly(black_box(&BALL), movement, &mut touched, &profile)
        });
    });
    group.bench_function("sphere_intersects_solid", |b| {
        b.iter(|| tree.sphere_intersects_solid(black_box(&BALL), true, &profile));
    });
    group.bench_function("find_walkable", |b| {
        b.iter(|| {
            let mut search = WalkableSearch {
                sphere: black_box(BALL),
                movement,
                up: Vec3::Z,
                walkable_allowance: 0.66,
                walk_interp: 1.0,
                found: None,
            };
            tree.find_walkable(&mut search, &profile);
            search.walk_interp
        });
    });
    group.finish();
}

fn part(c: &mut Criterion, tree: PhysicsTree) {
    let world = World::new(Profile::retail(), 0.0);
    let shape = GfxShape::new(Some(tree), None, []);
    let position = Position::new(CellId(0xA9B4_0001), Vec3::ZERO, Quat::IDENTITY);
    let mut t = Transition::new(&world);
    t.path.num_sphere = 2;
    t.path.local_sphere = [BALL, Sphere::new(BALL.center + Vec3::Z * 0.9, BALL.radius)];
    t.path.curr_pos = position;
    t.path.check_pos = position;
    t.path.cache_global_sphere(&world.profile);
    t.path.cache_global_curr_center(&world.profile);
    t.path.obstruction_ethereal = true;
    c.bench_function("part of 8192 triangles, solid test of two spheres", |b| {
        b.iter(|| {
            let part = PlacedPart {
                shape: Some(&shape),
                position: &position,
                scale: Vec3::ONE,
            };
            find_part_collisions([part], black_box(&mut t))
        });
    });
}

fn trees(c: &mut Criterion) {
    let profile = Profile::retail();
    let (low, high) = (Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0));
    let room = soup::tree(&soup::cuboid(low, high, true), &profile);
    searches(c, "room of 6 polygons", &room);
    let hills = soup::tree(&soup::hills(64), &profile);
    searches(c, "hills of 8192 triangles", &hills);
    part(c, hills);
}

criterion_group!(benches, trees);
criterion_main!(benches);
