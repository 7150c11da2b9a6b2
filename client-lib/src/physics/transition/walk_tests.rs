//! Whole transitions on the synthetic world: the invariants of `spec/05-transition.md`, section 17, along random walks.
//!
//! Every walk is placed first and then carries what it knows of ground and wall from one transition to the next, as an object does.

use std::sync::{Arc, OnceLock};

use super::*;
use crate::dat::{DatSet, Strictness};
use crate::math::{CellId, EPSILON, Position, Quat, Sphere, Vec3};
use crate::physics::body::{EntityId, ObjectRef};
use crate::physics::state::PhysicsState;
use crate::profile::Profile;
use crate::world::{CellHandle, World};
use proptest::prelude::*;

/// Flat ground.
const OUTDOORS: u32 = 0xA9B4_0011;

/// Where walks start: slopes, cliffs, shores, blocks of objects, a house, a dungeon, corners of the map.
#[rustfmt::skip]
const STARTS: [(u32, [f32; 3]); 36] = [
    (0xA9B4_0012, [60.0, 24.0, 20.0]), (0xA8B4_000A, [36.0, 31.0, 20.0]), (0xA8B5_000D, [32.0, 96.0, 30.7]),
    (0xA8B5_0025, [104.0, 96.0, 70.0]), (0xA9B4_0104, [113.0, 111.0, 16.0]), (0xA9B4_0100, [103.0, 108.0, 20.0]),
    (0xA9B4_0025, [103.0, 98.0, 20.0]), (0xA9B4_0102, [113.0, 110.0, 20.0]), (0xA9B4_0101, [117.5, 103.0, 20.0]),
    (0xA9B4_0103, [106.0, 105.0, 24.0]), (0xA9B5_0016, [62.4, 120.4, 20.0]), (0x0D01_0101, [25.0, -40.0, -12.0]),
    (0x0D01_0100, [40.0, -42.0, -12.0]), (0x0D01_0103, [18.0, -37.0, -12.0]), (0x0D01_0105, [18.0, -43.0, -12.0]),
    (0x0D01_010A, [40.0, -29.5, -12.0]), (0x0D01_0110, [132.21, -44.5, -6.0]), (0xA8B4_0035, [156.0, 103.0, 20.0]),
    (0xA8B4_0015, [60.0, 102.0, 20.0]), (0xA8B4_0016, [60.0, 126.0, 20.0]), (0xA8B4_002A, [132.0, 28.0, 20.0]),
    (0xA8B4_001A, [77.0, 36.0, 20.0]), (0xA8B4_0022, [107.2, 36.0, 21.8]), (0xA8B4_002E, [130.0, 136.0, 20.0]),
    (0xA8B4_000B, [36.0, 52.0, 20.0]), (0xA9B3_0023, [108.0, 48.0, 60.0]), (0xA9B3_0013, [60.0, 48.0, 20.0]),
    (0xA7B3_0025, [96.0, 96.0, 20.25]), (0xAAB4_0002, [12.0, 36.0, 20.0]), (0xFEFE_0040, [180.0, 180.0, 10.0]),
    (0xAAB3_0013, [60.0, 60.0, 0.0]), (0xAAB3_000B, [24.0, 60.0, 100.0]), (0xA9B6_000D, [36.0, 96.0, 20.0]),
    (0xA8B5_0008, [12.0, 184.0, 20.0]), (0xABB6_0025, [96.0, 96.0, 16.0]), (0xA7B6_0025, [96.0, 96.0, 22.0]),
];

fn testbed(profile: Profile) -> World {
    static DATS: OnceLock<Arc<DatSet>> = OnceLock::new();
    let open = || {
        let folder = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../golden-traces/worlds/testbed"
        );
        DatSet::open(folder, Strictness::Strict).expect("the world is in the repository")
    };
    let dats = Arc::clone(DATS.get_or_init(|| Arc::new(open())));
    World::with_source(profile, 0.0, dats)
}

fn at(cell: u32, origin: Vec3) -> Position {
    Position::new(CellId(cell), origin, Quat::IDENTITY)
}

/// A walker like a player: two spheres, 0.6 m up, 1.5 m down, keeps to edges.
fn walker() -> ObjectInfo {
    ObjectInfo {
        // No entity of the world: nothing is taken for the mover itself.
        object: Some(ObjectRef::Entity(EntityId(u32::MAX))),
        guid: 0x5000_0001,
        state: ObjectInfoState::EDGE_SLIDE | ObjectInfoState::IS_PLAYER,
        physics_state: PhysicsState::GRAVITY | PhysicsState::EDGE_SLIDE,
        scale: 1.0,
        step_up_height: 0.6,
        step_down_height: 1.5,
        step_down: true,
        ..ObjectInfo::NONE
    }
}

fn spheres(count: usize) -> MoverSpheres {
    let both = [0.48, 1.32].map(|z| Sphere::new(Vec3::new(0.0, 0.0, z), 0.48));
    MoverSpheres::of_scaled(&both[..count])
}

/// What an object carries from one transition to the next.
#[derive(Clone, Copy)]
struct Walk {
    position: Position,
    cell: Option<CellHandle>,
    contact: ContactSeed,
    state: ObjectInfoState,
    sliding: Option<Vec3>,
    stationary: u32,
    sphere_count: usize,
}

impl Walk {
    fn step_input(&self, step: Vec3) -> TransitionInput {
        let mut end = self.position;
        end.frame.origin += step;
        let mut mover = walker();
        mover.state |= self.state;
        TransitionInput {
            mover,
            spheres: spheres(self.sphere_count),
            begin_cell: self.cell,
            path: Path::Move {
                begin: self.position,
                end,
            },
            contact: self.contact,
            sliding_normal: self.sliding,
            frames_stationary_fall: self.stationary,
        }
    }

    /// Takes over a result as the object does; `false` when it has left all cells.
    fn take(&mut self, result: &TransitionResult) -> bool {
        let info = &result.info;
        self.position = result.position;
        self.cell = result.cell;
        self.contact = if info.contact_plane.valid {
            ContactSeed::Contact(info.contact_plane)
        } else {
            ContactSeed::None
        };
        // As the object does, from the plane alone: a placement sets no bits.
        self.state = ObjectInfoState::empty();
        (self.state).set(ObjectInfoState::CONTACT, info.contact_plane.valid);
        let walkable = info.contact_plane.valid
            && is_valid_walkable(info.contact_plane.plane.n, &Profile::retail());
        self.state.set(ObjectInfoState::ON_WALKABLE, walkable);
        self.sliding = info.sliding_normal_valid.then_some(info.sliding_normal);
        self.stationary = info.frames_stationary_fall;
        self.cell.is_some()
    }
}

/// Places a walker; `None` if there is no room.
fn place(world: &mut World, position: Position, sphere_count: usize) -> Option<Walk> {
    let begin_cell = world.visible_cell(position.cell);
    let input = TransitionInput {
        mover: walker(),
        spheres: spheres(sphere_count),
        begin_cell,
        path: Path::Place {
            at: position,
            slide: true,
            do_not_load_cells: false,
        },
        contact: ContactSeed::None,
        sliding_normal: None,
        frames_stationary_fall: 0,
    };
    let result = run(world, &input);
    let mut walk = Walk {
        position,
        cell: None,
        contact: ContactSeed::None,
        state: ObjectInfoState::empty(),
        sliding: None,
        stationary: 0,
        sphere_count,
    };
    (result.valid && walk.take(&result)).then_some(walk)
}

fn run(world: &mut World, input: &TransitionInput) -> TransitionResult {
    let mut transit = world.slots.make(&world.profile).expect("none is nested");
    world.run_transition(&mut transit, input);
    world.slots.cleanup();
    let result = transit.result.clone();
    world.slots.recycle(transit);
    result
}

/// Everything of a result that others can see, as bits.
fn seen(r: &TransitionResult) -> impl PartialEq + std::fmt::Debug + use<> {
    let plane = |p: &ContactPlane| {
        let n = p.plane.n;
        let bits = [n.x, n.y, n.z, p.plane.d].map(f32::to_bits);
        (p.valid, bits, p.cell_id, p.is_water)
    };
    let normal = |valid, n: Vec3| (valid, n.to_array().map(f32::to_bits));
    (
        (
            r.valid,
            r.outcome,
            r.progress,
            r.velocity_killed,
            r.object_info,
        ),
        (r.position.cell, r.position.frame.bits()),
        (
            plane(&r.info.contact_plane),
            plane(&r.info.last_known_contact_plane),
        ),
        normal(r.info.sliding_normal_valid, r.info.sliding_normal),
        normal(r.info.collision_normal_valid, r.info.collision_normal),
        (
            r.info.frames_stationary_fall,
            r.info.collided_with_environment,
        ),
        r.cells.entries().map(|e| e.id).collect::<Vec<_>>(),
    )
}

fn unit_or_zero(v: Vec3) -> bool {
    v == Vec3::ZERO || (v.length() - 1.0).abs() < 1e-6
}

/// Invariants 1, 7 to 10 and 15 of section 17.
fn check(world: &World, before: u32, result: &TransitionResult) {
    let info = &result.info;
    if let Some(cell) = result.cell {
        assert_eq!(world.cell_id(cell), result.position.cell);
    }
    assert!(info.frames_stationary_fall <= 3);
    assert!(info.frames_stationary_fall <= before + result.progress.done);
    if world.profile.sliding_normal_normalized {
        assert!(!info.sliding_normal_valid || unit_or_zero(info.sliding_normal));
        assert!(!info.sliding_normal_valid || info.sliding_normal.z == 0.0);
        assert!(!info.collision_normal_valid || unit_or_zero(info.collision_normal));
    }
    if result.progress.done > 0 && result.valid {
        let contact = result.object_info.contains(ObjectInfoState::CONTACT);
        let walkable = result.object_info.contains(ObjectInfoState::ON_WALKABLE);
        assert!(contact || !walkable);
        assert_eq!(contact, info.contact_plane.valid);
        assert_eq!(contact, info.last_known_contact_plane.valid);
    }
    let objects = &info.collide_object;
    for (i, object) in objects.iter().enumerate() {
        assert!(matches!(object, ObjectRef::Entity(_)));
        assert!(!objects[..i].contains(object));
    }
    assert!(result.progress.done <= result.progress.planned);
}

/// Invariants 11, 16 and 18: what a transition leaves in its path.
fn check_path(world: &World, input: &TransitionInput) {
    let mut t = Transition::new(world);
    input.prepare(&mut t);
    let valid = t.find_valid_position();
    assert!(
        t.missing.is_none(),
        "everything was loaded by the run before"
    );
    let p = &t.path;
    let flags = [
        p.step_up,
        p.step_down,
        p.collide,
        p.check_walkable,
        p.bldg_check,
        p.obstruction_ethereal,
    ];
    assert_eq!(flags, [false; 6]);
    // A step that ended before validation (its projection came to nothing) may have lifted the check position.
    if valid && t.progress.done == t.progress.planned && t.info.frames_stationary_fall == 0 {
        assert_eq!(p.check_pos.frame.bits(), p.curr_pos.frame.bits());
        assert_eq!(p.check_cell, p.curr_cell);
        for i in 0..p.num_sphere {
            let local = p.local_sphere[i].center;
            let global = p.curr_pos.frame.local_to_global(local, &world.profile);
            assert_eq!(p.global_sphere[i].center, global);
        }
    }
}

/// A walk: directions (rad) and paces (m per step), each kept for some steps.
fn turns() -> impl Strategy<Value = Vec<(f32, f32, u32)>> {
    prop::collection::vec((0.0_f32..6.3, 0.01_f32..0.9, 1_u32..15), 1..5)
}

fn profiles() -> impl Strategy<Value = Profile> {
    prop_oneof![
        Just(Profile::retail()),
        Just(Profile::ace()),
        Just(Profile::gdle()),
        Just(Profile::gdle_repaired()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn walks_keep_the_invariants(
        profile in profiles(), start in prop::sample::select(&STARTS[..]), aside in prop::array::uniform2(-2.0_f32..2.0),
        sphere_count in 1_usize..=2, turns in turns(), fall in 0.05_f32..0.6,
    ) {
        let mut world = testbed(profile);
        let (cell, [x, y, z]) = start;
        let start = at(cell, Vec3::new(x + aside[0], y + aside[1], z + 0.01));
        let Some(mut walk) = place(&mut world, start, sphere_count) else {
            return Ok(());
        };
        for (direction, pace, count) in turns {
            for _ in 0..count {
                let mut step = Vec3::new(direction.cos() * pace, direction.sin() * pace, 0.0);
                if !walk.state.contains(ObjectInfoState::CONTACT) {
                    step.z -= fall;
                }
                let input = walk.step_input(step);
                let result = run(&mut world, &input);
                check(&world, walk.stationary, &result);
                eprintln!("WALK {} {:?} {:x} {}", result.valid, result.outcome, result.object_info.bits(), result.position.cell.is_indoor());
                if world.profile.cell_array_emptied && !world.profile.left_fields_from_slot {
                    check_path(&world, &input);
                    // The same again, with everything loaded: the same bits.
                    prop_assert_eq!(seen(&run(&mut world, &input)), seen(&result));
                }
                if result.valid && !walk.take(&result) {
                    return Ok(());
                }
            }
        }
    }

    #[test]
    fn random_rubbish_ends(
        profile in profiles(), bits in prop::array::uniform6(prop::num::f32::ANY), radius in prop::num::f32::ANY,
        heights in prop::array::uniform2(prop::num::f32::ANY), state in any::<u32>(), physics in any::<u32>(), placed: bool,
    ) {
        let mut world = testbed(profile);
        let begin = at(OUTDOORS, Vec3::new(60.0, 24.0, 20.0));
        let end = at(OUTDOORS, Vec3::new(bits[0], bits[1], bits[2]));
        let mut mover = walker();
        mover.state = ObjectInfoState::from_bits_retain(state);
        mover.physics_state = PhysicsState::from_bits_retain(physics);
        [mover.step_up_height, mover.step_down_height] = heights;
        let center = Vec3::new(bits[3], bits[4], bits[5]);
        // A way of so many steps that it takes minutes, though not for ever, is no subject of this test.
        prop_assume!(!(radius > 0.0 && begin.distance(&end) / radius > 1000.0 && begin.distance(&end) / radius <= 1e6));
        prop_assume!(!placed || radius.is_nan() || radius <= 0.0 || radius > 0.05);
        let input = TransitionInput {
            mover,
            spheres: MoverSpheres::of_scaled(&[Sphere::new(center, radius)]),
            begin_cell: world.visible_cell(CellId(OUTDOORS)),
            path: if placed {
                Path::Place { at: end, slide: true, do_not_load_cells: false }
            } else {
                Path::Move { begin, end }
            },
            contact: ContactSeed::None,
            sliding_normal: None,
            frames_stationary_fall: 0,
        };
        run(&mut world, &input);
    }
}

/// Invariants 3 and 4: in free air the position is the begin plus the step as often as there are steps.
#[test]
fn free_flight_adds_its_steps() {
    let mut world = testbed(Profile::retail());
    let cell = world.visible_cell(CellId(OUTDOORS));
    let begin = at(OUTDOORS, Vec3::new(60.0, 24.0, 120.0));
    let walk = Walk {
        position: begin,
        cell,
        contact: ContactSeed::None,
        state: ObjectInfoState::empty(),
        sliding: None,
        stationary: 0,
        sphere_count: 2,
    };
    let way = Vec3::new(3.1, -2.3, 0.7);
    let result = run(&mut world, &walk.step_input(way));
    let k = (way.length() / 0.48).ceil();
    let per_step = ((begin.frame.origin + way) - begin.frame.origin) * (1.0 / k);
    let mut expected = begin.frame.origin;
    for _ in 0..k as u32 {
        expected += per_step;
    }
    assert_eq!(result.progress.done, k as u32);
    assert_eq!(result.position.frame.origin, expected);
    assert_eq!(result.outcome, Outcome::Step(TransitionState::Ok));
}

/// Invariant 2: a move of no length succeeds, tests nothing and stays; one shorter than ε fails.
#[test]
fn moves_of_no_length() {
    let mut world = testbed(Profile::retail());
    let mut walk = place(&mut world, at(OUTDOORS, Vec3::new(60.0, 24.0, 21.0)), 2).unwrap();
    let result = run(&mut world, &walk.step_input(Vec3::ZERO));
    assert!(result.valid && result.outcome == Outcome::None);
    assert_eq!(result.position.frame.bits(), walk.position.frame.bits());
    assert_eq!(result.cell, walk.cell);
    assert!(!result.cells.cells.is_empty());
    walk.contact = ContactSeed::None;
    let result = run(
        &mut world,
        &walk.step_input(Vec3::new(EPSILON / 2.0, 0.0, 0.0)),
    );
    assert!(!result.valid && result.outcome == Outcome::Failed);
}

/// Invariant 12: walking on flat ground keeps height, plane and pace.
#[test]
fn walking_on_flat_ground() {
    for profile in [Profile::retail(), Profile::gdle()] {
        let mut world = testbed(profile);
        let mut walk = place(&mut world, at(OUTDOORS, Vec3::new(60.0, 24.0, 21.0)), 2).unwrap();
        assert_eq!(walk.position.frame.origin.z, 20.0);
        for _ in 0..20 {
            let result = run(&mut world, &walk.step_input(Vec3::new(0.07, 0.02, 0.0)));
            assert_eq!(result.outcome, Outcome::Step(TransitionState::Ok));
            assert_eq!(result.progress.done, 1);
            assert_eq!(result.position.frame.origin.z, 20.0);
            assert_eq!(result.info.contact_plane.plane.n, Vec3::Z);
            assert!(!result.info.collision_normal_valid);
            walk.take(&result);
        }
        assert!((walk.position.frame.origin.x - 61.4).abs() < 1e-4);
    }
}

/// Invariant 17: with free space at the start a placement moves nothing sideways.
#[test]
fn a_free_place_is_taken_as_it_is() {
    let mut world = testbed(Profile::retail());
    let walk = place(&mut world, at(OUTDOORS, Vec3::new(60.25, 24.5, 20.5)), 1).unwrap();
    assert_eq!(
        walk.position.frame.origin.truncate(),
        crate::math::Vec2::new(60.25, 24.5)
    );
}

/// A transition without a begin cell, or nested too deep, is a failed operation.
#[test]
fn no_cell_and_no_slot() {
    let mut world = testbed(Profile::retail());
    let mut walk = place(&mut world, at(OUTDOORS, Vec3::new(60.0, 24.0, 21.0)), 2).unwrap();
    walk.cell = None;
    assert!(!run(&mut world, &walk.step_input(Vec3::X)).valid);
    for _ in 0..10 {
        assert!(world.slots.make(&world.profile).is_some());
    }
    assert!(world.slots.make(&world.profile).is_none());
}
