//! Stiff and extreme cases (section 17).

use ac_client::math::{Plane, Sphere, Vec3};
use ac_client::physics::collision::{
    CellTree, CylSphere, PhysicsTree, Polygon, TouchedPolygon, find_part_collisions, make_plane,
};
use ac_client::physics::collision::{GfxShape, PlacedPart, WalkableSearch};
use ac_client::physics::transition::{ObjectInfoState, TransitionState};
use ac_client::profile::Profile;
use ac_client::world::World;

use crate::soup::{cuboid, tree};
use crate::support::{Mover, RETAIL, at, v, world};

#[test]
fn degenerate_polygons_are_never_hit_and_contain_everything() {
    let line = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(2.0, 0.0, 0.0)];
    let point = [Vec3::ONE; 4];
    for corners in [&line[..], &point[..], &line[..2], &[]] {
        let polygon = Polygon::new(corners, &RETAIL);
        assert!(polygon.plane.n.is_nan() && polygon.plane.d.is_nan());
        let sphere = Sphere::new(Vec3::ZERO, 5.0);
        assert!(!polygon.hits_sphere(&sphere));
        assert!(polygon.contains(v(100.0, 3.0, -7.0)));
        assert!(polygon.find_crossed_edge(&sphere, Vec3::Z).is_none());
    }
}

#[test]
fn repeated_corners_do_no_harm() {
    let corners = [
        v(0.0, 0.0, 0.0),
        v(0.0, 0.0, 0.0),
        v(4.0, 0.0, 0.0),
        v(0.0, 4.0, 0.0),
    ];
    let polygon = Polygon::new(&corners, &RETAIL);
    assert_eq!(polygon.plane.n, Vec3::Z);
    assert!(polygon.hits_sphere(&Sphere::new(v(1.0, 1.0, 0.2), 0.5)));
    assert!(!polygon.hits_sphere(&Sphere::new(v(-0.6, 1.0, 0.2), 0.5)));
}

#[test]
fn not_a_number_is_a_hit_in_the_fast_form_only() {
    let corners = [v(0.0, 0.0, 0.0), v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0)];
    let polygon = Polygon::new(&corners, &RETAIL);
    let nowhere = Sphere::new(Vec3::NAN, 2.0);
    let mut contact = Vec3::ZERO;
    assert!(!polygon.hits_sphere_precise(&nowhere, &mut contact));
    assert!(polygon.hits_sphere_fast(&nowhere, &mut contact) && contact.is_nan());
}

#[test]
fn spheres_smaller_than_the_tolerance_hit_no_polygon() {
    let corners = [v(0.0, 0.0, 0.0), v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0)];
    let polygon = Polygon::new(&corners, &RETAIL);
    assert!(!polygon.hits_sphere(&Sphere::new(v(1.0, 1.0, 0.0), 0.0001)));
}

#[test]
fn an_empty_tree_answers_no() {
    let (world, empty) = (world(), PhysicsTree::default());
    let sphere = Sphere::new(Vec3::ZERO, 1.0);
    assert!(empty.is_empty() && empty.sphere().is_none());
    assert!(!empty.sphere_intersects_solid(&sphere, true, &RETAIL));
    assert!(!empty.point_intersects_solid(Vec3::ZERO, &RETAIL));
    let mut t = Mover::new(1.0, Vec3::Z, Vec3::ZERO).transition(&world);
    t.cache_localspace_sphere(&at(Vec3::ZERO), 1.0);
    assert_eq!(empty.find_collisions(&mut t, 1.0), TransitionState::Ok);
    assert_eq!(empty.placement_insert(&mut t), TransitionState::Ok);
    assert!(CellTree::default().contains(Vec3::ONE));
}

#[test]
fn not_a_number_goes_through_a_tree() {
    let tree = tree(&cuboid(Vec3::NEG_ONE, Vec3::ONE, false), &RETAIL);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for sphere in [
            Sphere::new(Vec3::splat(bad), 1.0),
            Sphere::new(Vec3::ZERO, bad),
        ] {
            let mut touched = TouchedPolygon::default();
            tree.sphere_intersects_poly(&sphere, Vec3::splat(bad), &mut touched, &RETAIL);
            tree.sphere_intersects_solid(&sphere, true, &RETAIL);
            let mut search = WalkableSearch {
                sphere,
                movement: Vec3::splat(bad),
                up: Vec3::Z,
                walkable_allowance: 0.0,
                walk_interp: bad,
                found: None,
            };
            tree.find_walkable(&mut search, &RETAIL);
        }
    }
}

#[test]
fn a_scale_of_zero_hits_nothing() {
    let world = world();
    let shape = GfxShape::new(
        Some(tree(&cuboid(Vec3::NEG_ONE, Vec3::ONE, false), &RETAIL)),
        None,
        [],
    );
    let mut t = Mover::new(0.5, Vec3::Z * 2.0, Vec3::ZERO).transition(&world);
    let position = at(Vec3::ZERO);
    let part = PlacedPart {
        shape: Some(&shape),
        position: &position,
        scale: Vec3::ZERO,
    };
    assert_eq!(find_part_collisions([part], &mut t), TransitionState::Ok);
}

#[test]
fn parts_are_tested_in_order_and_absent_ones_skipped() {
    let world = world();
    let shape = GfxShape::new(
        Some(tree(&cuboid(Vec3::NEG_ONE, Vec3::ONE, false), &RETAIL)),
        None,
        [],
    );
    let (far, here) = (at(Vec3::X * 50.0), at(Vec3::ZERO));
    let part = |shape, position| PlacedPart {
        shape,
        position,
        scale: Vec3::ONE,
    };
    let run = |parts: Vec<PlacedPart<'_>>| {
        let mut t = Mover::new(0.5, Vec3::Z * 2.0, Vec3::Z * 1.2).transition(&world);
        find_part_collisions(parts, &mut t)
    };
    assert_eq!(
        run(vec![part(None, &here), part(Some(&shape), &far)]),
        TransitionState::Ok
    );
    assert_eq!(
        run(vec![part(Some(&shape), &far), part(Some(&shape), &here)]),
        TransitionState::Adjusted
    );
}

#[test]
fn resting_exactly_at_the_radius_is_no_contact() {
    let tree = tree(
        &cuboid(v(-5.0, -5.0, -1.0), v(5.0, 5.0, 0.0), false),
        &RETAIL,
    );
    let world = world();
    let mut mover = Mover::new(0.5, Vec3::Z * 0.8, Vec3::Z * 0.2);
    mover.walk_interp = 1.0;
    let mut t = mover.transition(&world);
    t.path.walkable_allowance = 0.66;
    t.path.collide = true;
    t.cache_localspace_sphere(&at(Vec3::ZERO), 1.0);
    assert_eq!(tree.find_collisions(&mut t, 1.0), TransitionState::Adjusted);
    assert_eq!(t.path.global_sphere[0].center.z, 0.5);
    t.cache_localspace_sphere(&at(Vec3::ZERO), 1.0);
    assert_eq!(tree.find_collisions(&mut t, 1.0), TransitionState::Ok);
}

#[test]
fn a_short_slide_along_a_crease_is_a_collision() {
    let world = world();
    for (length, outcome) in [
        (0.0141, TransitionState::Collided),
        (0.0143, TransitionState::Slid),
    ] {
        let (from, to) = (v(0.0, 0.0, 0.5), v(0.1, length, 0.5));
        let mut mover = Mover::new(0.5, from, to);
        mover.ground = Some(Plane { n: Vec3::Z, d: 0.0 });
        let mut t = mover.transition(&world);
        let mut normal = Vec3::NEG_X;
        assert_eq!(t.slide_sphere(to, &mut normal, from), outcome);
    }
}

#[test]
fn a_zero_normal_goes_back_half_way() {
    let world = world();
    let (from, to) = (Vec3::ZERO, v(1.0, 0.0, 0.0));
    let mut t = Mover::new(0.5, from, to).transition(&world);
    let mut normal = Vec3::ZERO;
    assert_eq!(
        t.slide_sphere(to, &mut normal, from),
        TransitionState::Adjusted
    );
    assert_eq!(t.path.check_pos.frame.origin, v(0.5, 0.0, 0.0));
    assert!(!t.info.collision_normal_valid);
}

/// The upper sphere overlaps, the lower is horizontally out of reach: the root is not a number.
#[test]
fn a_sphere_beside_the_obstacle_does_not_step_down_on_it() {
    let obstacle = Sphere::new(v(0.0, 0.0, 1.0), 0.3);
    let outcome = |profile: Profile| {
        let world = World::new(profile, 0.0);
        let mut mover = Mover::new(0.1, v(0.35, 0.0, 0.7), v(0.35, 0.0, 0.7));
        mover.upper = Some(0.3);
        let mut t = mover.transition(&world);
        t.path.local_sphere[1].center.x = -0.35;
        t.path.cache_global_sphere(&world.profile);
        t.path.local_sphere[0].center.x = 0.4;
        t.path.cache_global_sphere(&world.profile);
        t.path.step_down = true;
        (
            obstacle.intersects_sphere(&mut t, false),
            t.path.check_pos.frame.origin.z,
        )
    };
    assert_eq!(outcome(Profile::retail()), (TransitionState::Collided, 0.7));
    let (result, z) = outcome(Profile::ace());
    assert!(result == TransitionState::Adjusted && z.is_nan());
}

#[test]
fn a_tiny_step_down_is_a_collision_with_objects() {
    let world = world();
    let mut mover = Mover::new(0.5, Vec3::Z, Vec3::Z);
    mover.step_down_amt = 0.0001;
    let cylinder = CylSphere {
        low: Vec3::ZERO,
        radius: 1.0,
        height: 1.0,
    };
    let mut t = mover.transition(&world);
    t.path.step_down = true;
    assert_eq!(
        cylinder.intersects_sphere(&mut t),
        TransitionState::Collided
    );
    assert_eq!(
        Sphere::new(Vec3::ZERO, 1.0).intersects_sphere(&mut t, false),
        TransitionState::Collided
    );
}

#[test]
fn a_touched_polygon_without_movement_is_noted_by_two_spheres_only() {
    let tree = tree(
        &cuboid(v(-5.0, -5.0, -1.0), v(5.0, 5.0, 0.0), false),
        &RETAIL,
    );
    let world = world();
    for upper in [None, Some(1.0)] {
        let mut mover = Mover::new(0.5, Vec3::Z * 0.4, Vec3::Z * 0.4);
        mover.upper = upper;
        mover.state = ObjectInfoState::CONTACT;
        let mut t = mover.transition(&world);
        t.cache_localspace_sphere(&at(Vec3::ZERO), 1.0);
        assert_eq!(tree.find_collisions(&mut t, 1.0), TransitionState::Ok);
        assert_eq!(t.path.neg_poly_hit, upper.is_some());
        if upper.is_some() {
            assert!(t.path.neg_step_up);
            assert_eq!(t.path.neg_collision_normal, Vec3::NEG_Z);
        }
    }
}

#[test]
fn mean_distance_fits_a_bent_polygon() {
    let bent = [
        v(0.0, 0.0, 0.0),
        v(2.0, 0.0, 0.0),
        v(2.0, 2.0, 0.1),
        v(0.0, 2.0, 0.0),
    ];
    let plane = make_plane(&bent, &RETAIL);
    let sum: f32 = bent.iter().map(|p| plane.distance(*p)).sum();
    assert!(sum.abs() < 1e-6);
}
