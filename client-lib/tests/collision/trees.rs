//! Invariants of collision trees (16.4, 16.11 to 16.14, 16.18, 16.19, 16.21).

use ac_client::math::{Quat, Sphere, Vec3};
use ac_client::physics::collision::{
    PhysicsTree, Polygon, PolygonList, SolidSearch, SourceNode, TouchedPolygon, TreeError,
    WalkableSearch,
};
use ac_client::physics::transition::{InsertType, ObjectInfoState, Transition, TransitionState};
use proptest::prelude::*;

use crate::soup::{cuboid, hills, tree};
use crate::support::{Mover, RETAIL, at, near, polygons, records, spheres, vectors, world};

fn soups() -> impl Strategy<Value = Vec<Vec<Vec3>>> {
    prop_oneof![
        proptest::collection::vec(polygons(), 1..14),
        (vectors(2.0), 0.5f32..3.0, any::<bool>()).prop_map(|(c, r, inwards)| {
            cuboid(c - Vec3::splat(r), c + Vec3::new(r, r, r * 0.5), inwards)
        })
    ]
}

/// A soup and a mover beside its first polygon.
fn soups_and_movers() -> impl Strategy<Value = (Vec<Vec<Vec3>>, Mover)> {
    let mover = (
        vectors(1.0),
        vectors(0.8),
        0.1f32..1.0,
        proptest::option::of(0.2f32..1.0),
        0u32..0x50,
    );
    (soups(), mover).prop_map(|(soup, (near, step, radius, upper, bits))| {
        let mut mover = Mover::new(radius, soup[0][0] + near, soup[0][0] + near + step);
        mover.upper = upper;
        mover.state = ObjectInfoState::from_bits_retain(bits & 0x4B);
        mover.walkable_allowance = 0.1;
        (soup, mover)
    })
}

/// Puts the tree into the world at the origin of the mover's landblock, with that scale, and expresses the mover in its space.
fn prepare<'w>(t: &mut Transition<'w>, turn: f32, scale: f32) {
    let mut place = at(Vec3::ZERO);
    place.frame.set_rotation(
        Quat::new((turn * 0.5).cos(), 0.0, 0.0, (turn * 0.5).sin()),
        &RETAIL,
    );
    t.cache_localspace_sphere(&place, scale);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_tree_finds_what_its_polygons_say(soup in soups(), sphere in spheres(6.0), m in vectors(1.0)) {
        let tree = tree(&soup, &RETAIL);
        let mut touched = TouchedPolygon::default();
        let hit = tree.sphere_intersects_poly(&sphere, m, &mut touched, &RETAIL);
        let mut contact = Vec3::ZERO;
        let each: Vec<(bool, bool)> = soup
            .iter()
            .map(|p| Polygon::new(p, &RETAIL).pos_hits_sphere(&sphere, m, &mut contact))
            .collect();
        prop_assert_eq!(hit, each.iter().any(|&(_, hit)| hit));
        prop_assert_eq!(touched.polygon.is_some(), each.iter().any(|&(touched, _)| touched));
        if let Some(polygon) = touched.polygon.and_then(|i| tree.polygon(i)) {
            prop_assert!(polygon.hits_sphere(&sphere));
            prop_assert_eq!(hit, m.dot(polygon.plane.n) < 0.0);
        }
        let touches = each.iter().any(|&(touched, _)| touched);
        prop_assert_eq!(tree.sphere_intersects_solid(&sphere, false, &RETAIL), touches);
        prop_assert!(!touches || tree.sphere_intersects_solid(&sphere, true, &RETAIL));
    }

    #[test]
    fn ground_is_allowed_ground(soup in soups(), sphere in spheres(6.0), depth in 0.1f32..2.0, allowance in 0.0f32..1.0) {
        let tree = tree(&soup, &RETAIL);
        let mut search = WalkableSearch {
            sphere,
            movement: Vec3::NEG_Z * depth,
            up: Vec3::Z,
            walkable_allowance: allowance,
            walk_interp: 1.0,
            found: None,
        };
        tree.find_walkable(&mut search, &RETAIL);
        match search.found.and_then(|i| tree.polygon(i)) {
            Some(polygon) => {
                prop_assert!(polygon.plane.n.z > allowance && search.walk_interp < 1.0);
                prop_assert!(near(polygon.plane.distance(search.sphere.center), sphere.radius, 1e-3));
            }
            None => prop_assert_eq!((search.sphere, search.walk_interp), (sphere, 1.0)),
        }
        if tree.hits_walkable(&sphere, Vec3::Z, allowance, &RETAIL) {
            prop_assert!(tree.sphere_intersects_solid(&sphere, false, &RETAIL));
        }
    }

    #[test]
    fn an_airborne_mover_is_not_moved((soup, mut mover) in soups_and_movers(), scale in 0.5f32..2.0, turn in -3.0f32..3.0) {
        mover.state = ObjectInfoState::empty();
        let (world, tree) = (world(), tree(&soup, &RETAIL));
        let mut t = mover.transition(&world);
        prepare(&mut t, turn, scale);
        let before = t.clone();
        let result = tree.find_collisions(&mut t, scale);
        prop_assert_eq!(t.path.check_pos.frame.bits(), before.path.check_pos.frame.bits());
        prop_assert_eq!(t.path.global_sphere, before.path.global_sphere);
        prop_assert_eq!(t.info.contact_plane, before.info.contact_plane);
        prop_assert_eq!(t.path.collide, result == TransitionState::Adjusted);
        prop_assert_eq!(t.info.collision_normal_valid, result == TransitionState::Collided);
    }

    #[test]
    fn solid_tests_write_nothing((soup, mover) in soups_and_movers(), which in 0usize..3) {
        let (world, tree) = (world(), tree(&soup, &RETAIL));
        let mut t = mover.transition(&world);
        prepare(&mut t, 0.0, 1.0);
        match which {
            0 => t.path.insert_type = InsertType::Placement,
            1 => t.path.obstruction_ethereal = true,
            _ => t.path.check_walkable = true,
        }
        let before = records(&t);
        tree.find_collisions(&mut t, 1.0);
        prop_assert_eq!(records(&t), before);
    }

    #[test]
    fn ground_carries_the_sphere_that_was_put_on_it((soup, mover) in soups_and_movers(), landing: bool) {
        let (world, tree) = (world(), tree(&soup, &RETAIL));
        let mut t = mover.transition(&world);
        prepare(&mut t, 0.5, 1.0);
        (t.path.collide, t.path.step_down) = (landing, !landing);
        let before = t.clone();
        match tree.find_collisions(&mut t, 1.0) {
            TransitionState::Adjusted => {
                let polygon = t.path.walkable.expect("ground was found");
                let h = polygon.plane.distance(t.path.walkable_check_pos.center);
                prop_assert!(near(h, t.path.walkable_check_pos.radius, 1e-3));
                prop_assert!(t.info.contact_plane.valid && !t.info.contact_plane.is_water);
                prop_assert!(t.path.walk_interp < before.path.walk_interp);
                prop_assert!(t.path.localspace_z.dot(polygon.plane.n) > t.path.walkable_allowance);
            }
            TransitionState::Ok => prop_assert_eq!(records(&t), records(&before)),
            other => prop_assert!(false, "{:?}", other),
        }
    }

    #[test]
    fn placements_end_free_or_where_they_began((soup, mover) in soups_and_movers()) {
        let (world, tree) = (world(), tree(&soup, &RETAIL));
        let mut t = mover.transition(&world);
        t.path.insert_type = InsertType::InitialPlacement;
        prepare(&mut t, 0.0, 1.0);
        let before = records(&t);
        match tree.placement_insert(&mut t) {
            TransitionState::Ok | TransitionState::Collided => prop_assert_eq!(records(&t), before),
            TransitionState::Adjusted => prop_assert!(t.path.check_pos.frame.origin.is_finite()),
            other => prop_assert!(false, "{:?}", other),
        }
    }

    #[test]
    fn the_same_call_gives_the_same_bits((soup, mover) in soups_and_movers(), mode in 0usize..4) {
        let (world, tree) = (world(), tree(&soup, &RETAIL));
        let run = || {
            let mut t = mover.transition(&world);
            prepare(&mut t, 1.0, 1.5);
            match mode {
                0 => t.path.step_down = true,
                1 => t.path.collide = true,
                2 => t.path.insert_type = InsertType::Placement,
                _ => {}
            }
            (tree.find_collisions(&mut t, 1.5), records(&t))
        };
        prop_assert_eq!(run(), run());
    }
}

fn leaf(polygons: &[u16]) -> SourceNode<'_> {
    SourceNode::Leaf {
        solid: 1,
        sphere: Sphere::new(Vec3::ZERO, 1.0),
        polygons,
    }
}

fn inner(positive: Option<usize>, negative: Option<usize>) -> SourceNode<'static> {
    SourceNode::Inner {
        plane: ac_client::math::Plane { n: Vec3::Z, d: 0.0 },
        sphere: Sphere::new(Vec3::ZERO, 1e9),
        positive,
        negative,
    }
}

#[test]
fn impossible_trees_are_refused() {
    let none = PolygonList::default();
    let build = |nodes: &[SourceNode<'_>]| PhysicsTree::new(nodes, &none).map(drop);
    assert_eq!(build(&[]), Ok(()));
    assert_eq!(
        build(&[leaf(&[3])]),
        Err(TreeError::NoPolygon { node: 0, key: 3 })
    );
    assert_eq!(
        build(&[inner(Some(0), None)]),
        Err(TreeError::BadChild { node: 0, child: 0 })
    );
    assert_eq!(
        build(&[inner(Some(9), None)]),
        Err(TreeError::BadChild { node: 0, child: 9 })
    );
    let shared = [inner(Some(1), Some(1)), leaf(&[])];
    assert_eq!(
        build(&shared),
        Err(TreeError::BadChild { node: 0, child: 1 })
    );
}

#[test]
fn the_deepest_tree_is_searched_and_a_deeper_one_refused() {
    let none = PolygonList::default();
    let chain = |levels: usize| -> Vec<SourceNode<'_>> {
        (1..levels)
            .map(|i| inner(None, Some(i)))
            .chain([leaf(&[])])
            .collect()
    };
    let deepest = PhysicsTree::new(&chain(512), &none).expect("512 levels are allowed");
    // Straddles every node.
    let sphere = Sphere::new(Vec3::ZERO, 1.0);
    assert!(!deepest.sphere_intersects_solid(&sphere, true, &RETAIL));
    let mut search = SolidSearch::default();
    assert!(!deepest.sphere_intersects_solid_poly(&sphere, 1.0, &mut search, true, &RETAIL));
    let error = PhysicsTree::new(&chain(513), &none).map(drop);
    assert_eq!(error, Err(TreeError::TooDeep { node: 512 }));
}

#[test]
fn a_large_floor_is_found_everywhere() {
    let floor = tree(&hills(24), &RETAIL);
    for i in 0..100 {
        let (x, y) = ((i % 10) as f32 * 2.3 - 11.0, (i / 10) as f32 * 2.3 - 11.0);
        let mut search = WalkableSearch {
            sphere: Sphere::new(Vec3::new(x, y, 0.3), 2.0),
            movement: Vec3::NEG_Z * 2.0,
            up: Vec3::Z,
            walkable_allowance: 0.5,
            walk_interp: 1.0,
            found: None,
        };
        floor.find_walkable(&mut search, &RETAIL);
        assert!(search.found.is_some(), "({x}, {y})");
    }
}
