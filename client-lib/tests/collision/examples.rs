//! Worked examples (section 19), exact to the bit.

use ac_client::math::{Plane, Sphere, Vec3};
use ac_client::physics::collision::{
    CylSphere, PlacementSolidity, Polygon, find_time_of_collision, make_plane,
};
use ac_client::physics::transition::TransitionState;
use ac_client::profile::Profile;

use crate::support::{CELL, Mover, RETAIL, v, world};

const Q: [Vec3; 4] = [
    Vec3::new(0.0, 0.0, 0.0),
    Vec3::new(10.0, 0.0, 0.0),
    Vec3::new(10.0, 10.0, 0.0),
    Vec3::new(0.0, 10.0, 0.0),
];
const P: [Vec3; 4] = [
    Vec3::new(0.0, 0.0, 0.0),
    Vec3::new(10.0, 0.0, 0.0),
    Vec3::new(10.0, 10.0, 5.0),
    Vec3::new(0.0, 10.0, 5.0),
];

fn square() -> Polygon<'static> {
    Polygon::new(&Q, &RETAIL)
}

fn ball(x: f32, y: f32, z: f32) -> Sphere {
    Sphere::new(v(x, y, z), 0.5)
}

#[test]
fn planes() {
    let q = make_plane(&Q, &RETAIL);
    assert_eq!((q.n, q.d.to_bits()), (Vec3::Z, (-0.0_f32).to_bits()));
    let p = make_plane(&P, &RETAIL);
    assert_eq!(p.n, v(0.0, -0.447_213_6, 0.894_427_2));
    assert_eq!(p.d, 0.0);
}

#[test]
fn hits_of_a_square() {
    let hit = |c: Sphere| {
        let mut contact = Vec3::splat(7.0);
        (square().hits_sphere_precise(&c, &mut contact), contact)
    };
    assert_eq!(hit(ball(5.0, 5.0, 0.4998)), (true, v(5.0, 5.0, 0.0)));
    assert!(!hit(ball(5.0, 5.0, 0.5)).0);
    assert_eq!(hit(ball(10.3, 5.0, 0.2)), (true, v(10.3, 5.0, 0.0)));
    assert!(hit(ball(10.4, 10.2, 0.0)).0);
    assert!(!hit(ball(10.4, 10.3, 0.0)).0);
    assert!(!hit(ball(10.5, 5.0, 0.0)).0);
}

#[test]
fn footprints() {
    let corner = ball(10.2, 10.2, 1.0);
    assert!(square().check_walkable(&corner, Vec3::Z, &RETAIL));
    assert!(!square().check_walkable(&corner, Vec3::Z, &Profile::ace()));
    assert!(!square().check_small_walkable(&corner, Vec3::Z, &RETAIL));
    let edge = square().find_crossed_edge(&corner, Vec3::Z);
    assert_eq!(edge, Some(v(-1.0, 0.0, 0.0)));
    assert!(!square().check_walkable(&ball(10.6, 5.0, 1.0), Vec3::Z, &RETAIL));
}

#[test]
fn adjusting_to_a_plane() {
    let adjust = |polygon: Polygon<'_>, z: f32, m: f32| {
        let (mut sphere, mut walk_interp) = (ball(5.0, 5.0, z), 1.0);
        let m = v(0.0, 0.0, m);
        let ok = polygon.adjust_sphere_to_plane(&mut sphere, m, &mut walk_interp, &RETAIL);
        (ok, sphere.center.z, walk_interp)
    };
    assert_eq!(adjust(square(), 0.1, -1.0), (true, 0.5, 0.6));
    assert_eq!(adjust(square(), 0.1, -0.6), (true, 0.5, 0.333_333_37));
    assert_eq!(adjust(square(), -0.1, 0.6), (false, -0.1, 1.0));
    let ramp = Polygon::new(&P, &RETAIL);
    assert_eq!(adjust(ramp, 2.8, -0.75), (true, 3.059_017_2, 0.654_643_65));
}

/// Slides a sphere from `from` to `to` along `normal` on ground with normal `ground`: outcome, offset, normal afterwards.
fn slide(from: Vec3, to: Vec3, normal: Vec3, ground: Vec3) -> (TransitionState, Vec3, Vec3) {
    let world = world();
    let mut mover = Mover::new(0.5, from, to);
    mover.ground = Some(Plane { n: ground, d: 0.0 });
    let mut t = mover.transition(&world);
    let mut normal = normal;
    let result = t.slide_sphere(to, &mut normal, from);
    (result, t.path.check_pos.frame.origin - to, normal)
}

#[test]
fn slides_along_a_surface() {
    let (from, west) = (v(0.0, 0.0, 0.5), Vec3::NEG_X);
    let (result, offset, _) = slide(from, v(1.0, 1.0, 0.5), west, Vec3::Z);
    assert_eq!((result, offset), (TransitionState::Slid, v(-1.0, 0.0, 0.0)));
    let (result, ..) = slide(from, v(1.0, 0.0, 0.5), west, Vec3::Z);
    assert_eq!(result, TransitionState::Collided);
    let (result, offset, _) = slide(from, v(1.0, 1.0, 0.5), west, Vec3::ZERO);
    assert_eq!((result, offset), (TransitionState::Slid, v(-1.0, 0.0, 0.0)));
    let (result, offset, normal) = slide(from, v(0.0, 0.0, 0.6), Vec3::NEG_Z, Vec3::Z);
    assert_eq!((result, offset), (TransitionState::Ok, Vec3::ZERO));
    assert_eq!(normal, Vec3::NEG_Z);
}

#[test]
fn times_of_collision() {
    let time = |disp| find_time_of_collision(v(2.0, 0.0, 0.0), disp, 1.0, &RETAIL);
    assert_eq!(time(v(-2.0, 0.0, 0.0)), 0.5);
    assert_eq!(time(v(-2.0, 0.5, 0.0)), 0.566_987_298_107_780_7);
    assert_eq!(time(v(2.0, 0.0, 0.0)), -0.5);
    assert_eq!(time(v(-1.0, 0.0, 0.0)), -1.0);
}

#[test]
fn steps_down_onto_objects() {
    let world = world();
    let start = v(0.1, 0.0, 1.3);
    let mut t = Mover::new(0.5, start, start).transition(&world);
    t.path.step_down = true;
    let result = ball(0.0, 0.0, 0.5).intersects_sphere(&mut t, false);
    assert_eq!(result, TransitionState::Adjusted);
    assert_eq!(t.path.global_sphere[0].center.z, 1.3 + 0.194_987_49);
    assert_eq!(t.path.walk_interp, 0.675_020_9);
    let plane = t.info.contact_plane;
    assert_eq!(plane.plane.n, v(0.1, 0.0, 0.994_987_4));
    assert_eq!(plane.plane.d, -0.997_493_74);
    assert!(plane.is_water && plane.cell_id == CELL);

    let start = v(0.2, 0.0, 1.3);
    let mut t = Mover::new(0.48, start, start).transition(&world);
    t.path.step_down = true;
    let cylinder = CylSphere {
        low: Vec3::ZERO,
        radius: 0.5,
        height: 1.0,
    };
    assert_eq!(cylinder.reach(0.48, &RETAIL), 0.979_8);
    assert_eq!(
        cylinder.intersects_sphere(&mut t),
        TransitionState::Adjusted
    );
    assert_eq!(t.path.global_sphere[0].center.z, 1.3 + 0.180_000_07);
    assert_eq!(t.path.walk_interp, 0.699_999_9);
    let plane = t.info.contact_plane.plane;
    assert_eq!((plane.n, plane.d), (Vec3::Z, -1.0));
}

#[test]
fn landings_on_objects() {
    let world = world();
    let mut t = Mover::new(0.5, v(0.0, 0.0, 1.8), v(0.0, 0.0, 1.3)).transition(&world);
    t.path.collide = true;
    let sphere = Sphere::new(Vec3::ZERO, 1.0);
    assert_eq!(
        sphere.intersects_sphere(&mut t, false),
        TransitionState::Adjusted
    );
    assert_eq!(t.path.check_pos.frame.origin.z, 1.3 + 0.200_000_05);
    assert_eq!(t.path.walk_interp, 0.599_999_9);
    let plane = t.info.contact_plane.plane;
    assert_eq!((plane.n, plane.d), (Vec3::Z, -0.799_999_95));

    let mut t = Mover::new(0.5, v(0.2, 0.0, 1.7), v(0.2, 0.0, 1.2)).transition(&world);
    t.path.collide = true;
    let cylinder = CylSphere {
        low: Vec3::ZERO,
        radius: 0.5,
        height: 1.0,
    };
    assert_eq!(
        cylinder.intersects_sphere(&mut t),
        TransitionState::Adjusted
    );
    assert_eq!(t.path.check_pos.frame.origin.z, 1.2 + 0.299_999_95);
    assert_eq!(t.path.walk_interp, 0.400_000_1);
    let plane = t.info.contact_plane.plane;
    assert_eq!((plane.n, plane.d), (Vec3::Z, -1.0));
}

#[test]
fn placements_at_a_square() {
    let place = |center_solid, h: f32, profile: &Profile| {
        let solidity = PlacementSolidity {
            center_solid,
            solid_check: true,
        };
        h + square()
            .placement_offset(v(5.0, 5.0, h), 0.5, solidity, profile)
            .z
    };
    assert_eq!(place(false, -0.1, &RETAIL), -0.5);
    assert_eq!(place(true, -0.1, &RETAIL), 0.5);
    assert_eq!(place(true, -0.1, &Profile::ace()), -0.5);
    assert_eq!(place(false, 0.1, &RETAIL), 0.5);
    assert_eq!(place(true, 0.1, &RETAIL), -0.5);
}

/// 04, 7.8: nothing depends on it, but it is there: the share of a movement that is left until a sphere touches a plane. The side is taken from
/// the length of the movement, not from where the sphere is.
#[test]
fn times_of_touching_a_plane() {
    let square = square();
    let time =
        |z: f32, movement: f32| square.touching_time(0.5, v(5.0, 5.0, z), v(0.0, 0.0, movement));
    assert_eq!(time(0.4, -1.0), 1.0, "touches already");
    assert_eq!(
        square.touching_time(0.5, v(5.0, 5.0, 2.0), v(1.0, 0.0, 0.0)),
        0.0
    );
    assert_eq!(time(2.0, -3.0), 0.5);
    // A movement not longer than the radius aims at the other side.
    assert_eq!(time(2.0, -0.5), 5.0);
    assert_eq!(time(-2.0, 2.0), 1.25);
}
