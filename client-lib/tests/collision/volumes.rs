//! Invariants of cell volumes and boxes (16.15 to 16.17).

use ac_client::math::{BoundingBox, Plane, Position, Quat, Sphere, Vec3};
use ac_client::physics::collision::{BoundingType, CellTree};
use proptest::prelude::*;

use crate::support::{CELL, RETAIL, at, spheres, units, vectors};

fn volumes() -> impl Strategy<Value = CellTree> {
    let planes = proptest::collection::vec((units(), -1.0f32..4.0), 0..10);
    (planes, any::<bool>()).prop_map(|(planes, leaf)| {
        CellTree::new(planes.into_iter().map(|(n, d)| Plane { n, d }), leaf)
    })
}

fn boxes() -> impl Strategy<Value = BoundingBox> {
    (vectors(4.0), vectors(4.0)).prop_map(|(a, b)| BoundingBox {
        min: a.min(b),
        max: a.max(b),
    })
}

proptest! {
    #[test]
    fn a_sphere_around_an_inner_point_is_not_outside(volume in volumes(), sphere in spheres(5.0), radius in 0.0f32..3.0) {
        if volume.contains(sphere.center) {
            let around = Sphere::new(sphere.center, radius);
            prop_assert_ne!(volume.intersects_sphere(&around), BoundingType::Outside);
        }
    }

    #[test]
    fn what_a_sphere_misses_its_inner_boxes_miss(volume in volumes(), sphere in spheres(5.0), size in vectors(1.0)) {
        // Every corner of the box is within the radius.
        let half = size.abs() / 3.0_f32.sqrt() * sphere.radius * 0.99;
        let bounds = BoundingBox { min: sphere.center - half, max: sphere.center + half };
        if volume.intersects_sphere(&sphere) == BoundingType::Outside {
            prop_assert!(!volume.intersects_box(&bounds));
        }
    }

    #[test]
    fn a_missed_box_has_no_inner_point(volume in volumes(), bounds in boxes(), share in vectors(1.0)) {
        if !volume.intersects_box(&bounds) {
            let p = bounds.min + (bounds.max - bounds.min) * (share * 0.5 + 0.5);
            prop_assert!(!volume.contains(p));
        }
    }

    #[test]
    fn transformed_boxes_hold_their_corners(bounds in boxes(), axis in units(), angle in -3.0f32..3.0, from in vectors(90.0), to in vectors(90.0)) {
        let (s, c) = ((angle * 0.5).sin(), (angle * 0.5).cos());
        let from = Position::new(CELL, from, Quat::new(c, axis.x * s, axis.y * s, axis.z * s));
        let to = at(to);
        let moved = bounds.local_to_local(&from, &to, &RETAIL);
        for corner in bounds.corners() {
            prop_assert!(moved.contains(to.local_to_local(&from, corner, &RETAIL)));
        }
        let same = at(Vec3::ZERO);
        prop_assert_eq!(bounds.local_to_local(&same, &same, &RETAIL), bounds);
    }
}

#[test]
fn a_tree_that_ends_in_a_leaf_holds_nothing_entirely() {
    let floor = Plane { n: Vec3::Z, d: 0.0 };
    let high = Sphere::new(Vec3::Z * 9.0, 1.0);
    let open = CellTree::new([floor], false);
    assert_eq!(open.intersects_sphere(&high), BoundingType::EntirelyInside);
    let closed = CellTree::new([floor], true);
    assert_eq!(
        closed.intersects_sphere(&high),
        BoundingType::PartiallyInside
    );
    assert!(closed.contains(high.center));
    // 1 cm of margin, closed.
    let touching = Sphere::new(Vec3::Z * -1.01, 1.0);
    assert_eq!(open.intersects_sphere(&touching), BoundingType::Outside);
}
