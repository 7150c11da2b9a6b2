//! Invariants of polygons (16.1 to 16.7).

use ac_client::math::{Plane, Sphere, Vec3};
use ac_client::physics::collision::{Polygon, make_plane};
use proptest::prelude::*;

use crate::support::{RETAIL, near, polygons, spheres, units, vectors};

/// A sphere near the polygon's plane and outline, where all cases occur.
fn polygon_and_sphere() -> impl Strategy<Value = (Vec<Vec3>, Sphere)> {
    (polygons(), vectors(3.0), 0.05f32..2.0, -1.2f32..1.2).prop_map(
        |(polygon, shift, radius, lift)| {
            let n = make_plane(&polygon, &RETAIL).n;
            let along = shift - n * n.dot(shift);
            let center = polygon[0] + along + n * (lift * radius);
            (polygon, Sphere::new(center, radius))
        },
    )
}

proptest! {
    #[test]
    fn planes_are_unit_and_hold_their_corners(corners in polygons()) {
        let plane = make_plane(&corners, &RETAIL);
        let size = corners.iter().map(|c| c.length()).fold(1.0, f32::max);
        prop_assert!(near(plane.n.length(), 1.0, 3e-7));
        for c in &corners {
            prop_assert!(plane.distance(*c).abs() <= 1e-5 * size);
        }
        let reversed: Vec<Vec3> = corners.iter().rev().copied().collect();
        let back = make_plane(&reversed, &RETAIL);
        prop_assert!((back.n + plane.n).length() <= 1e-5 && near(back.d, -plane.d, 1e-5 * size));
    }

    #[test]
    fn both_hit_tests_agree((corners, sphere) in polygon_and_sphere()) {
        let polygon = Polygon::new(&corners, &RETAIL);
        let (mut a, mut b) = (Vec3::ZERO, Vec3::ZERO);
        let slow = polygon.hits_sphere_precise(&sphere, &mut a);
        prop_assert_eq!(slow, polygon.hits_sphere_fast(&sphere, &mut b));
        prop_assert_eq!(a, b);
    }

    #[test]
    fn hits_reach_the_plane_and_inner_contacts_hit((corners, sphere) in polygon_and_sphere()) {
        let polygon = Polygon::new(&corners, &RETAIL);
        let h = polygon.plane.distance(sphere.center);
        let mut contact = Vec3::ZERO;
        let hit = polygon.hits_sphere_precise(&sphere, &mut contact);
        let reaches = h.abs() <= sphere.radius - 0.0002;
        prop_assert!(!hit || (reaches && polygon.plane.distance(contact).abs() < 1e-5));
        prop_assert!(hit || !(reaches && polygon.contains(contact)));
    }

    #[test]
    fn only_movement_against_the_normal_hits((corners, sphere) in polygon_and_sphere(), m in vectors(1.0)) {
        let polygon = Polygon::new(&corners, &RETAIL);
        let mut contact = Vec3::ZERO;
        let (touched, hit) = polygon.pos_hits_sphere(&sphere, m, &mut contact);
        let against = m.dot(polygon.plane.n) < 0.0;
        prop_assert!(!hit || (touched && against));
        prop_assert!(hit || !touched || !against);
    }

    #[test]
    fn adjusting_shortens_the_walk(
        (corners, start) in polygon_and_sphere(), m in vectors(2.0), old in 0.01f32..1.0,
    ) {
        let polygon = Polygon::new(&corners, &RETAIL);
        let s = m.dot(polygon.plane.n);
        let (mut sphere, mut walk_interp) = (start, old);
        if polygon.adjust_sphere_to_plane(&mut sphere, m, &mut walk_interp, &RETAIL) {
            prop_assert!(walk_interp < old && walk_interp >= -0.5);
            if s < -0.01 {
                let h = polygon.plane.distance(sphere.center);
                prop_assert!(near(h, start.radius, 1e-4), "{h}");
            }
        } else {
            prop_assert_eq!((sphere, walk_interp), (start, old));
        }
    }

    #[test]
    fn walkable_hits_adjust_only_against_the_normal(
        (corners, start) in polygon_and_sphere(), m in vectors(2.0), old in 0.01f32..1.0, up in units(),
    ) {
        let polygon = Polygon::new(&corners, &RETAIL);
        let (mut sphere, mut walk_interp) = (start, old);
        if m.dot(polygon.plane.n) > 0.0002 && polygon.walkable_hits_sphere(&sphere, up, 0.1) {
            prop_assert!(!polygon.adjust_sphere_to_plane(&mut sphere, m, &mut walk_interp, &RETAIL));
        }
    }

    #[test]
    fn crossed_edges_are_level_with_the_polygon(corners in polygons(), sphere in spheres(8.0), up in units()) {
        let polygon = Polygon::new(&corners, &RETAIL);
        let facing = polygon.plane.n.dot(up);
        prop_assume!(facing.abs() > 0.1);
        let below = sphere.center - up * (polygon.plane.distance(sphere.center) / facing);
        match polygon.find_crossed_edge(&sphere, up) {
            Some(normal) => {
                prop_assert!(near(normal.length(), 1.0, 1e-5));
                prop_assert!(normal.dot(polygon.plane.n).abs() < 1e-5);
                prop_assert!(!polygon.contains(below));
            }
            None => prop_assert!(polygon.contains(below)),
        }
    }

    #[test]
    fn half_a_footprint_needs_no_less_ground((corners, sphere) in polygon_and_sphere(), up in units()) {
        let polygon = Polygon::new(&corners, &RETAIL);
        let small = polygon.check_small_walkable(&sphere, up, &RETAIL);
        prop_assert!(!small || polygon.check_walkable(&sphere, up, &RETAIL));
    }

    #[test]
    fn prism_and_plan_agree_for_level_polygons(corners in polygons(), p in vectors(8.0)) {
        let level: Vec<Vec3> = corners.iter().map(|c| Vec3::new(c.x, c.y, 0.0)).collect();
        let plane = make_plane(&level, &RETAIL);
        prop_assume!(plane.n.z > 0.5);
        let polygon = Polygon { plane: Plane { n: Vec3::Z, d: 0.0 }, vertices: &level, single_sided: true };
        // Away from the outline, where rounding decides.
        let inner = polygon.check_walkable(&Sphere::new(p, 1e-3), Vec3::Z, &RETAIL);
        let contained = polygon.contains(p);
        if inner == contained {
            prop_assert_eq!(contained, polygon.contains_2d(p, ac_client::math::Sidedness::Positive));
        }
    }
}
