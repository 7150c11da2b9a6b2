//! More stiff cases (section 17): limits of reach, of movement along a plane, of what is left of a walk, and of parallel normals.

use ac_client::math::{EPSILON, Plane, Sphere, Vec3};
use ac_client::physics::collision::{CylSphere, Polygon};
use ac_client::physics::transition::TransitionState;

use crate::support::{Mover, RETAIL, v, world};

const FLOOR: [Vec3; 4] = [
    Vec3::new(0.0, 0.0, 0.0),
    Vec3::new(10.0, 0.0, 0.0),
    Vec3::new(10.0, 10.0, 0.0),
    Vec3::new(0.0, 10.0, 0.0),
];

fn floor() -> Polygon<'static> {
    Polygon::new(&FLOOR, &RETAIL)
}

fn ball(z: f32) -> Sphere {
    Sphere::new(v(5.0, 5.0, z), 0.5)
}

/// Grazing: between the radius and the radius less ε nothing is hit; the limit itself is a hit.
#[test]
fn a_grazing_sphere_does_not_touch() {
    let limit = 0.5 - EPSILON;
    let hits = |z: f32| floor().hits_sphere(&ball(z));
    assert_eq!(
        [limit.next_down(), limit, limit.next_up(), 0.5].map(hits),
        [true, true, false, false]
    );
    assert_eq!([-limit, (-limit).next_down()].map(hits), [true, false]);
}

/// A movement along the plane, or off it by ε per step and no more, moves no sphere onto it.
#[test]
fn movements_along_the_plane_adjust_nothing() {
    let adjusts = |m: f32| {
        let (mut sphere, mut left) = (ball(0.1), 1.0);
        let along = v(3.0, 0.0, m);
        floor().adjust_sphere_to_plane(&mut sphere, along, &mut left, &RETAIL)
    };
    for m in [0.0, EPSILON, -EPSILON] {
        assert!(!adjusts(m), "{m}");
    }
    // One step of f32 beyond, the way back is far longer than the movement may be.
    assert!(!adjusts(-EPSILON.next_up()));
    assert!(adjusts(-0.4));
}

/// Nothing left of the walk: nothing is adjusted. Less than nothing: the other way round.
#[test]
fn a_walk_that_is_used_up() {
    let adjust = |z: f32, left: f32| {
        let (mut sphere, mut left) = (ball(z), left);
        let ok = floor().adjust_sphere_to_plane(&mut sphere, Vec3::NEG_Z, &mut left, &RETAIL);
        (ok, sphere.center.z, left)
    };
    assert_eq!(adjust(0.1, 0.0), (false, 0.1, 0.0));
    assert_eq!(adjust(0.1, -0.2), (false, 0.1, -0.2));
    let (ok, z, left) = adjust(0.9, -0.2);
    assert!(ok && z == 0.5 && (left + 0.28).abs() < 1e-6);
    assert_eq!(
        adjust(0.9, f32::NAN).1,
        0.5,
        "not a number passes every limit"
    );
}

/// `04:S10`: during a landing retry a mover with one sphere is solved for although it does not overlap; one with two is not.
#[test]
fn one_sphere_beside_a_sphere_lands_without_touching() {
    let world = world();
    let obstacle = Sphere::new(Vec3::ZERO, 1.0);
    let outcome = |upper| {
        let mut mover = Mover::new(0.5, Vec3::Z * 1.8, Vec3::Z * 1.6);
        mover.upper = upper;
        let mut t = mover.transition(&world);
        t.path.collide = true;
        obstacle.intersects_sphere(&mut t, false)
    };
    assert_eq!(outcome(None), TransitionState::Collided);
    assert_eq!(outcome(Some(0.6)), TransitionState::Ok);
}

/// A sphere smaller than ε touches no polygon but is inside a cylinder.
#[test]
fn a_tiny_sphere_is_inside_a_cylinder() {
    let world = world();
    let cylinder = CylSphere {
        low: Vec3::ZERO,
        radius: 1.0,
        height: 1.0,
    };
    let outcome = |z: f32| {
        let mut t = Mover::new(0.0001, Vec3::Z * z, Vec3::Z * z).transition(&world);
        t.path.check_walkable = true;
        cylinder.intersects_sphere(&mut t)
    };
    assert_eq!(outcome(0.5), TransitionState::Collided);
    assert_eq!(outcome(1.1), TransitionState::Ok);
}

/// Normals closer than 0.81 degrees count as parallel: the movement loses its part against the surface instead of following the crease.
#[test]
fn nearly_parallel_normals_have_no_crease() {
    let world = world();
    let slide = |degrees: f32| {
        let (from, to) = (v(0.0, 0.0, 0.5), v(1.0, 1.0, 0.5));
        let mut mover = Mover::new(0.5, from, to);
        mover.ground = Some(Plane { n: Vec3::Z, d: 0.0 });
        let mut t = mover.transition(&world);
        let (s, c) = degrees.to_radians().sin_cos();
        let mut normal = v(s, 0.0, c);
        assert_eq!(t.slide_sphere(to, &mut normal, from), TransitionState::Slid);
        t.path.check_pos.frame.origin - to
    };
    let parallel = slide(0.80);
    assert!(
        parallel.x.abs() < 0.001 && parallel.y == 0.0 && parallel.z < -0.01,
        "{parallel}"
    );
    let crease = slide(0.82);
    assert!((crease - v(-1.0, 0.0, 0.0)).length() < 1e-5, "{crease}");
}
