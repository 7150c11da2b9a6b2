//! Invariants of spheres, cylinders and slides (16.8 to 16.12, 16.19, 16.20).

use ac_client::math::{CellId, Plane, Sphere, Vec3};
use ac_client::physics::collision::{CylSphere, find_time_of_collision};
use ac_client::physics::transition::{InsertType, ObjectInfoState, Transition, TransitionState};
use proptest::prelude::*;

use crate::support::{
    Mover, RETAIL, near, records, records_without_caches, spheres, units, vectors, world,
};

/// A mover close to the origin, with any state that decides which rule applies.
fn movers() -> impl Strategy<Value = Mover> {
    let place = (
        vectors(1.6),
        vectors(0.7),
        0.1f32..0.6,
        proptest::option::of(0.2f32..1.0),
    );
    let state = (0u32..0x50, 0.0f32..1.0, 0.05f32..1.5, 0.01f32..1.0);
    (place, state, proptest::option::of(units())).prop_map(
        |((from, step, radius, upper), (bits, height, amount, interp), ground)| {
            let mut mover = Mover::new(radius, from, from + step);
            mover.upper = upper;
            mover.state = ObjectInfoState::from_bits_retain(bits & 0x4B);
            mover.step_up_height = height;
            mover.step_down_amt = amount;
            mover.walk_interp = interp;
            mover.walkable_allowance = 0.0872;
            mover.ground = ground.map(|n| Plane { n, d: 0.0 });
            mover
        },
    )
}

/// Which of the modes of an insertion is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Move,
    Placement,
    Ethereal,
    CheckWalkable,
    StepDown,
    Landing,
}

fn modes() -> impl Strategy<Value = Mode> {
    prop_oneof![
        Just(Mode::Move),
        Just(Mode::Placement),
        Just(Mode::Ethereal),
        Just(Mode::CheckWalkable),
        Just(Mode::StepDown),
        Just(Mode::Landing)
    ]
}

fn set_mode(t: &mut Transition<'_>, mode: Mode) {
    match mode {
        Mode::Move => {}
        Mode::Placement => t.path.insert_type = InsertType::Placement,
        Mode::Ethereal => t.path.obstruction_ethereal = true,
        Mode::CheckWalkable => t.path.check_walkable = true,
        Mode::StepDown => t.path.step_down = true,
        Mode::Landing => t.path.collide = true,
    }
}

#[derive(Debug, Clone, Copy)]
enum Obstacle {
    Sphere(Sphere),
    Cylinder(CylSphere),
}

impl Obstacle {
    fn test(&self, t: &mut Transition<'_>) -> TransitionState {
        match self {
            Self::Sphere(s) => s.intersects_sphere(t, false),
            Self::Cylinder(c) => c.intersects_sphere(t),
        }
    }
}

fn obstacles() -> impl Strategy<Value = Obstacle> {
    prop_oneof![
        (vectors(0.5), 0.1f32..1.0).prop_map(|(c, r)| Obstacle::Sphere(Sphere::new(c, r))),
        (vectors(0.5), 0.1f32..1.0, 0.1f32..2.0).prop_map(|(low, radius, height)| {
            Obstacle::Cylinder(CylSphere {
                low,
                radius,
                height,
            })
        })
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn intersection_is_symmetric(a in spheres(2.0), b in spheres(2.0)) {
        prop_assert_eq!(a.intersects(&b, &RETAIL), b.intersects(&a, &RETAIL));
    }

    #[test]
    fn times_put_the_spheres_in_touch(m in vectors(4.0), d in vectors(4.0), sum in 0.1f32..2.0) {
        let time = find_time_of_collision(m, d, sum, &RETAIL);
        if time != -1.0 {
            prop_assert!(near((d + m * time as f32).length(), sum, 2e-2 + 1e-4 * time.abs() as f32));
        }
    }

    #[test]
    fn slides_follow_the_crease_or_the_surface(from in vectors(3.0), step in vectors(1.0), normal in units(), ground in units()) {
        let world = world();
        let mut mover = Mover::new(0.5, from, from + step);
        mover.ground = Some(Plane { n: ground, d: 0.0 });
        let mut t = mover.transition(&world);
        let mut given = normal;
        let result = t.slide_sphere(from + step, &mut given, from);
        let crease = normal.cross(ground);
        let left = t.path.check_pos.frame.origin - from;
        let parallel = crease.length_squared() < 0.0002;
        match result {
            TransitionState::Slid if parallel => prop_assert!(left.dot(normal).abs() < 1e-4),
            TransitionState::Slid => prop_assert!(left.cross(crease.normalize()).length() < 1e-3),
            TransitionState::Ok => prop_assert!(parallel && normal.dot(ground) < 0.0),
            TransitionState::Collided => {}
            other => prop_assert!(false, "{:?}", other),
        }
        prop_assert!(t.info.collision_normal_valid);
    }

    #[test]
    fn adjusted_means_on_the_ground(mover in movers(), obstacle in obstacles(), mode in modes()) {
        let world = world();
        let mut t = mover.transition(&world);
        set_mode(&mut t, mode);
        let before = t.path.walk_interp;
        let result = obstacle.test(&mut t);
        if result == TransitionState::Adjusted && matches!(mode, Mode::StepDown | Mode::Landing) {
            prop_assert!(t.info.contact_plane.valid && t.info.contact_plane.is_water);
            prop_assert!(t.path.walk_interp < before);
            prop_assert_eq!(t.info.contact_plane.cell_id, t.path.check_pos.cell);
            prop_assert!(t.info.contact_plane.plane.n.z > t.path.walkable_allowance);
        }
        prop_assert!(result != TransitionState::Invalid);
    }

    #[test]
    fn solid_tests_write_nothing(mover in movers(), obstacle in obstacles(), mode in modes()) {
        prop_assume!(matches!(mode, Mode::Placement | Mode::Ethereal | Mode::CheckWalkable));
        let world = world();
        let mut t = mover.transition(&world);
        set_mode(&mut t, mode);
        let before = records(&t);
        let result = obstacle.test(&mut t);
        prop_assert_eq!(records(&t), before);
        prop_assert!(matches!(result, TransitionState::Ok | TransitionState::Collided));
    }

    #[test]
    fn the_same_call_gives_the_same_bits(mover in movers(), obstacle in obstacles(), mode in modes()) {
        let world = world();
        let run = || {
            let mut t = mover.transition(&world);
            set_mode(&mut t, mode);
            (obstacle.test(&mut t), records(&t))
        };
        prop_assert_eq!(run(), run());
    }

    #[test]
    fn other_landblocks_give_the_same_bits(mover in movers(), obstacle in obstacles(), mode in modes(), dx in -40i32..40, dy in -40i32..40) {
        let world = world();
        let id = |dx: i32, dy: i32| CellId(((0xA9 + dx) as u32) << 24 | ((0xB4 + dy) as u32) << 16 | 1);
        // The check position is in the next block to the east: offsets between blocks take part.
        let run = |dx: i32, dy: i32| {
            let mut own = mover.clone();
            own.current.cell = id(dx, dy);
            own.check.cell = id(dx + 1, dy);
            own.check.frame.origin.x -= 192.0;
            let mut t = own.transition(&world);
            set_mode(&mut t, mode);
            let result = match obstacle {
                Obstacle::Sphere(mut s) => {
                    s.center.x -= 192.0;
                    s.intersects_sphere(&mut t, false)
                }
                Obstacle::Cylinder(mut c) => {
                    c.low.x -= 192.0;
                    c.intersects_sphere(&mut t)
                }
            };
            let text = records_without_caches(&t);
            (result, text.replace(&format!("{:?}", id(dx, dy)), "A").replace(&format!("{:?}", id(dx + 1, dy)), "B"))
        };
        prop_assert_eq!(run(0, 0), run(dx, dy));
    }
}

#[test]
fn a_creature_is_neither_stepped_onto_nor_landed_on() {
    let world = world();
    let obstacle = Sphere::new(Vec3::ZERO, 1.0);
    for mode in [Mode::StepDown, Mode::Landing] {
        let mut t = Mover::new(0.5, Vec3::Z * 1.8, Vec3::Z * 1.3).transition(&world);
        set_mode(&mut t, mode);
        assert_eq!(
            obstacle.intersects_sphere(&mut t, true),
            TransitionState::Ok
        );
    }
}
