//! Tests of the steps of a transition, on records without a landscape.

use super::object_info::is_valid_walkable;
use super::placement::Rings;
use super::slots::LeftFields;
use super::walkable::TerrainContact;
use super::*;
use crate::math::vector::normalize_check_small;
use crate::math::{CellId, EPSILON, Plane, Position, Quat, Sphere, Vec3};
use crate::physics::body::{Body, WeenieFlags};
use crate::physics::collision::Polygon;
use crate::physics::state::PhysicsState;
use crate::profile::{EdgeSlideOrder, Profile};
use crate::world::{CellHandle, World};
use proptest::prelude::*;

const CELL: CellId = CellId(0xA9B4_0011);

fn world(profile: Profile) -> World {
    World::new(profile, 0.0)
}

fn at(origin: Vec3) -> Position {
    Position::new(CELL, origin, Quat::IDENTITY)
}

/// A mover with one sphere of 0.48 m, centred 0.48 m above its origin, that stands at `origin`.
fn mover(world: &World, origin: Vec3) -> Transition<'_> {
    let mut t = Transition::new(world);
    t.init_sphere(&[Sphere::new(Vec3::new(0.0, 0.0, 0.48), 0.48)], 1.0);
    t.init_path(None, Some(at(origin)), at(origin));
    t.object.step_down = true;
    t.object.step_down_height = 1.5;
    t.check_pos_to_curr_pos();
    t
}

fn ground(n: Vec3, d: f32) -> ContactPlane {
    ContactPlane {
        valid: true,
        plane: Plane { n, d },
        cell_id: CELL,
        is_water: false,
    }
}

fn bits(v: Vec3) -> [u32; 3] {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits()]
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

#[test]
fn constants_have_the_bits_of_the_specification() {
    assert_eq!(FLOOR_Z.to_bits(), 0x3F2A_0751);
    assert_eq!(LANDING_Z.to_bits(), 0x3DB2_7EB0);
    assert_eq!(DEFAULT_STEP_HEIGHT.to_bits(), 0x3D23_D70A);
    assert_eq!((EPSILON * EPSILON).to_bits(), 0x332B_CC76);
}

#[test]
fn floor_z_itself_is_walkable_except_where_it_is_compared_in_f64() {
    let n = Vec3::new(0.0, 0.0, FLOOR_Z);
    assert!(is_valid_walkable(n, &Profile::retail()));
    assert!(!is_valid_walkable(n, &Profile::gdle()));
    let above = Vec3::new(0.0, 0.0, FLOOR_Z.next_up());
    assert!(is_valid_walkable(above, &Profile::gdle()));
}

mod steps {
    use super::*;

    fn plan(world: &World, radius: f32, way: Vec3, viewer: bool) -> movement::StepPlan {
        let mut t = Transition::new(world);
        t.object.state.set(ObjectInfoState::IS_VIEWER, viewer);
        t.init_sphere(&[Sphere::new(Vec3::ZERO, radius)], 1.0);
        t.init_path(None, Some(at(Vec3::ZERO)), at(way));
        t.calc_num_steps()
    }

    #[test]
    fn worked_example_of_the_specification() {
        let w = world(Profile::retail());
        let p = plan(&w, 0.48, Vec3::X, false);
        assert_eq!((p.steps, p.per_step.x), (3, 0.333_333_34));
    }

    #[test]
    fn short_and_empty_ways() {
        let w = world(Profile::retail());
        let short = Vec3::new(1e-5, 0.0, 0.0);
        assert_eq!(plan(&w, 0.48, short, false).steps, 1);
        assert_eq!(plan(&w, 0.48, Vec3::ZERO, false).steps, 0);
        assert_eq!(plan(&w, 0.48, Vec3::new(0.48, 0.0, 0.0), false).steps, 1);
        assert_eq!(plan(&w, 0.0, Vec3::X, false).steps, u32::MAX);
    }

    #[test]
    fn a_viewer_steps_by_its_radius() {
        let w = world(Profile::retail());
        let p = plan(&w, 0.3, Vec3::X, true);
        assert_eq!(p.steps, 4);
        assert!((p.per_step.length() - 0.3).abs() < 1e-6);
        assert_eq!(plan(&w, 0.3, Vec3::splat(1e-5), true).steps, 0);
    }

    proptest! {
        #[test]
        fn steps_add_up_and_are_at_most_a_radius(
            x in -50.0_f32..50.0, y in -50.0_f32..50.0, z in -50.0_f32..50.0, r in 0.1_f32..2.0,
        ) {
            let w = world(Profile::retail());
            let way = Vec3::new(x, y, z);
            let p = plan(&w, r, way, false);
            let sum = p.per_step * p.steps as f32;
            prop_assert!((sum - p.offset).length() <= 1e-5 * p.offset.length());
            prop_assert!(p.per_step.length() <= r * (1.0 + 1e-6));
        }
    }

    #[test]
    fn an_absurd_number_of_steps_and_nan_are_refused() {
        let ace = Profile {
            nan_goal_refused: true,
            ..Profile::ace()
        };
        for profile in [Profile::retail(), ace] {
            let w = world(profile);
            for end in [
                Vec3::new(1e9, 0.0, 0.0),
                Vec3::new(f32::NAN, 0.0, 0.0),
                Vec3::INFINITY,
            ] {
                let mut t = mover(&w, Vec3::ZERO);
                t.init_path(Some(CellHandle(0)), Some(at(Vec3::ZERO)), at(end));
                assert!(!t.find_valid_position());
                assert_eq!(t.progress.done, 0);
            }
        }
    }

    #[test]
    fn only_ace_refuses_more_than_a_thousand() {
        let limit = |p: Profile| if p.substep_limit { 1000 } else { MAX_SUB_STEPS };
        assert_eq!(limit(Profile::ace()), 1000);
        assert_eq!(limit(Profile::retail()), MAX_SUB_STEPS);
    }

    #[test]
    fn no_begin_cell_fails() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::ZERO);
        assert!(!t.find_valid_position());
    }
}

mod offsets {
    use super::*;

    #[test]
    fn without_ground_a_wall_takes_the_part_into_it() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::ZERO);
        t.info.init_sliding_normal(Vec3::new(-1.0, 0.0, 0.0));
        let o = t.adjust_offset(Vec3::new(0.3, 0.2, -0.1));
        assert_eq!(o, Vec3::new(0.0, 0.2, -0.1));
        assert!(t.info.sliding_normal_valid);
    }

    #[test]
    fn moving_away_from_a_wall_forgets_it() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::ZERO);
        t.info.init_sliding_normal(Vec3::new(1.0, 0.0, 0.0));
        let o = Vec3::new(0.3, 0.2, -0.1);
        assert_eq!(t.adjust_offset(o), o);
        assert!(!t.info.sliding_normal_valid);
    }

    #[test]
    fn uphill_keeps_the_horizontal_length_and_into_the_plane_does_not() {
        let w = world(Profile::retail());
        let n = normalize_check_small(Vec3::new(-0.3, 0.0, 1.0)).unwrap();
        let mut t = mover(&w, Vec3::ZERO);
        t.info.contact_plane = ground(n, 0.0);
        t.info.contact_plane.is_water = true;
        // Downhill: off the plane.
        let down = t.adjust_offset(Vec3::new(-0.4, 0.1, 0.0));
        assert_eq!((down.x, down.y), (-0.4, 0.1));
        assert!(down.dot(n).abs() < 1e-6);
        // Uphill: into the plane.
        let up = t.adjust_offset(Vec3::new(0.4, 0.1, 0.0));
        assert!(up.x < 0.4 && up.dot(n).abs() < 1e-6);
    }

    #[test]
    fn ground_and_wall_leave_their_crease() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::ZERO);
        t.info.contact_plane = ground(Vec3::Z, 0.0);
        t.info.init_sliding_normal(Vec3::new(-1.0, 0.0, 0.0));
        let o = t.adjust_offset(Vec3::new(0.3, 0.2, 0.0));
        assert_eq!(o, Vec3::new(0.0, 0.2, 0.0));
        // A vertical "ground" parallel to the wall leaves nothing.
        t.info.contact_plane = ground(Vec3::new(-1.0, 0.0, 0.0), 0.0);
        assert_eq!(t.adjust_offset(Vec3::new(0.3, 0.2, 0.0)), Vec3::ZERO);
    }

    #[test]
    fn a_sunk_sphere_rises_but_not_by_a_radius() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.1));
        t.info.contact_plane = ground(Vec3::Z, 0.0);
        t.adjust_offset(Vec3::ZERO);
        assert!((t.path.check_pos.frame.origin.z).abs() < 1e-6);
        let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.6));
        t.info.contact_plane = ground(Vec3::Z, 0.0);
        t.adjust_offset(Vec3::ZERO);
        assert_eq!(t.path.check_pos.frame.origin.z, -0.6);
        // Neither water nor a plane of unknown cell lifts.
        for (water, cell) in [(true, CELL), (false, CellId::NONE)] {
            let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.1));
            t.info.contact_plane = ground(Vec3::Z, 0.0);
            t.info.contact_plane.is_water = water;
            t.info.contact_plane.cell_id = cell;
            t.adjust_offset(Vec3::ZERO);
            assert_eq!(t.path.check_pos.frame.origin.z, -0.1);
        }
    }

    proptest! {
        #[test]
        fn the_step_stays_on_the_plane_and_off_the_wall(
            n in prop::array::uniform3(-1.0_f32..1.0), s in prop::array::uniform2(-1.0_f32..1.0),
            o in prop::array::uniform3(-0.5_f32..0.5), wall: bool,
        ) {
            let w = world(Profile::retail());
            let n = Vec3::new(n[0], n[1], n[2].abs() + 0.2).normalize();
            let mut t = mover(&w, Vec3::ZERO);
            t.info.contact_plane = ground(n, 0.0);
            t.info.contact_plane.is_water = true;
            let s = Vec3::new(s[0], s[1], 0.0);
            prop_assume!(s.length() > 0.1);
            if wall {
                t.info.init_sliding_normal(s);
            }
            let o = Vec3::from_array(o);
            let once = t.adjust_offset(o);
            prop_assert!(once.dot(n).abs() < 1e-5);
            if t.info.sliding_normal_valid {
                prop_assert!(once.dot(t.info.sliding_normal) >= -1e-5);
            } else if o.dot(n) > 0.0 {
                prop_assert_eq!((once.x, once.y), (o.x, o.y));
            }
            let twice = t.adjust_offset(once);
            prop_assert!((twice - once).length() < 1e-4);
        }

        #[test]
        fn away_from_the_wall_is_as_without_it(
            o in prop::array::uniform3(-0.5_f32..0.5), angle in 0.0_f32..6.0, contact: bool,
        ) {
            let w = world(Profile::retail());
            let s = Vec3::new(angle.cos(), angle.sin(), 0.0);
            let o = Vec3::from_array(o);
            prop_assume!(o.dot(s) >= 0.0);
            let result = |with_wall: bool| {
                let mut t = mover(&w, Vec3::ZERO);
                t.info.contact_plane = ContactPlane { valid: contact, ..ground(Vec3::Z, 0.0) };
                if with_wall {
                    t.info.sliding_normal_valid = true;
                    t.info.sliding_normal = s;
                }
                (bits(t.adjust_offset(o)), bits(t.path.check_pos.frame.origin))
            };
            prop_assert_eq!(result(true), result(false));
        }
    }
}

mod terrain {
    use super::*;

    const LEVEL: TerrainContact = TerrainContact {
        plane: Plane { n: Vec3::Z, d: 0.0 },
        is_water: false,
        water_depth: 0.0,
        cell_id: CELL,
    };

    fn steep() -> TerrainContact {
        TerrainContact {
            plane: Plane {
                n: Vec3::new(0.8, 0.0, 0.6),
                d: 0.0,
            },
            ..LEVEL
        }
    }

    fn touch(t: &mut Transition<'_>, terrain: &TerrainContact) -> TransitionState {
        let sphere = t.path.global_sphere[0];
        t.validate_walkable(&sphere, terrain)
    }

    #[test]
    fn above_touching_and_below() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::new(0.0, 0.0, 0.01));
        assert_eq!(touch(&mut t, &LEVEL), TransitionState::Ok);
        assert!(!t.info.contact_plane.valid);

        let mut t = mover(&w, Vec3::ZERO);
        assert_eq!(touch(&mut t, &LEVEL), TransitionState::Ok);
        assert!(t.info.contact_plane.valid && t.info.contact_plane.cell_id == CELL);
        assert!(t.info.collision_normal_valid && t.info.collided_with_environment);

        let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.25));
        assert_eq!(touch(&mut t, &LEVEL), TransitionState::Adjusted);
        assert!(t.path.check_pos.frame.origin.z.abs() < 1e-6);
    }

    #[test]
    fn in_contact_nothing_is_reported() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.25));
        t.object.state = ObjectInfoState::CONTACT | ObjectInfoState::ON_WALKABLE;
        assert_eq!(touch(&mut t, &LEVEL), TransitionState::Adjusted);
        assert!(!t.info.collision_normal_valid && !t.info.collided_with_environment);
    }

    #[test]
    fn water_is_stood_in() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.45));
        let water = TerrainContact {
            is_water: true,
            water_depth: 0.45,
            ..LEVEL
        };
        assert_eq!(touch(&mut t, &water), TransitionState::Ok);
        assert!(t.info.contact_plane.valid && t.info.contact_plane.is_water);
    }

    #[test]
    fn probing_for_ground_collides_with_it() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.25));
        t.path.check_walkable = true;
        assert_eq!(touch(&mut t, &LEVEL), TransitionState::Collided);
        assert!(!t.info.contact_plane.valid);
    }

    #[test]
    fn a_steep_slope_does_not_push_a_walker() {
        for (profile, answer) in [
            (Profile::retail(), TransitionState::Ok),
            (Profile::ace(), TransitionState::Adjusted),
        ] {
            let w = world(profile);
            let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.1));
            t.object.state = ObjectInfoState::CONTACT | ObjectInfoState::ON_WALKABLE;
            let before = t.path.check_pos.frame.origin;
            assert_eq!(touch(&mut t, &steep()), answer);
            assert_eq!(t.path.check_pos.frame.origin, before);
            assert!(!t.info.contact_plane.valid);
        }
    }

    #[test]
    fn a_step_down_lifts_only_within_its_height() {
        for profile in [Profile::retail(), Profile::gdle()] {
            let w = world(profile);
            let run = |depth: f32, amount: f32| {
                let mut t = mover(&w, Vec3::new(0.0, 0.0, -depth));
                t.path.step_down = true;
                t.path.step_down_amt = amount;
                t.path.walk_interp = 1.0;
                let ts = touch(&mut t, &LEVEL);
                (ts, t.path.walk_interp, t.info.contact_plane.valid)
            };
            let (ts, w1, valid) = run(0.25, 1.0);
            assert_eq!((ts, valid), (TransitionState::Adjusted, true));
            assert!((w1 - 0.75).abs() < 1e-6);
            // The plane that was refused stays.
            assert_eq!(run(0.25, 0.2), (TransitionState::Collided, 1.0, true));
            assert_eq!(run(0.25, 0.0).0, TransitionState::Collided);
            // Slightly more than the height is within the tolerance of -0.1.
            assert_eq!(run(0.25, 0.24).0, TransitionState::Adjusted);
        }
    }

    #[test]
    fn an_exhausted_walk_interp_passes_as_nan() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::new(0.0, 0.0, -0.25));
        t.path.step_down = true;
        t.path.step_down_amt = 1.0;
        t.path.walk_interp = 0.0;
        assert_eq!(touch(&mut t, &LEVEL), TransitionState::Adjusted);
        assert!(t.path.walk_interp.is_nan());
    }

    #[test]
    fn a_camera_is_stopped_by_terrain_and_passes_above_it() {
        let run = |profile: Profile, from: f32, to: f32| {
            let w = world(profile);
            let mut t = mover(&w, Vec3::new(0.0, 0.0, from));
            t.object.state = ObjectInfoState::IS_VIEWER;
            t.add_offset_to_check_pos(Vec3::new(0.0, 0.0, to - from));
            (touch(&mut t, &LEVEL), t.path.check_pos.frame.origin.z)
        };
        let (ts, z) = run(Profile::retail(), 2.0, -0.5);
        assert_eq!(ts, TransitionState::Adjusted);
        assert!(z.abs() < 1e-5);
        assert_eq!(run(Profile::retail(), 2.0, 1.0).0, TransitionState::Ok);
        // T-04: the references need an indoor start as well.
        assert_eq!(run(Profile::gdle(), 2.0, 1.0).0, TransitionState::Adjusted);
    }
}

mod exemptions {
    use super::*;

    fn body(state: PhysicsState, weenie: WeenieFlags, guid: u32) -> Body {
        Body {
            guid,
            position: at(Vec3::ZERO),
            cell: None,
            state,
            scale: 1.0,
            part_array: None,
            weenie,
            target: 0,
            parent: None,
            shadows: Default::default(),
        }
    }

    const PLAYER: WeenieFlags = WeenieFlags {
        present: true,
        player: true,
        creature: true,
        pk: false,
        pk_lite: false,
        bypasses_restrictions: false,
        impenetrable: false,
        storage: false,
    };

    fn info(of: &Body, profile: &Profile) -> ObjectInfo {
        let object = crate::physics::body::ObjectRef::Entity(crate::physics::body::EntityId(1));
        ObjectInfo::of_body(object, of, ObjectInfoState::empty(), 0.6, 1.5, profile)
    }

    #[test]
    fn player_killer_table() {
        let player = |pk, pk_lite| {
            body(
                PhysicsState::empty(),
                WeenieFlags {
                    pk,
                    pk_lite,
                    ..PLAYER
                },
                7,
            )
        };
        let profile = Profile::retail();
        let states = [(false, false), (true, false), (false, true), (true, true)];
        let passes: Vec<Vec<bool>> = states[..3]
            .iter()
            .map(|&(pk, lite)| {
                let mover = info(&player(pk, lite), &profile);
                states
                    .iter()
                    .map(|&(pk, lite)| mover.player_exempt(&player(pk, lite)))
                    .collect()
            })
            .collect();
        assert_eq!(
            passes,
            [
                [true, true, true, true],
                [true, false, true, false],
                [true, true, false, false],
            ]
        );
    }

    #[test]
    fn impenetrable_players_and_others_are_not_exempt() {
        let profile = Profile::retail();
        let plain = body(PhysicsState::empty(), PLAYER, 7);
        let free = body(
            PhysicsState::empty(),
            WeenieFlags {
                impenetrable: true,
                ..PLAYER
            },
            8,
        );
        assert!(!info(&plain, &profile).player_exempt(&free));
        assert!(!info(&free, &profile).player_exempt(&plain));
        let creature = body(
            PhysicsState::empty(),
            WeenieFlags {
                player: false,
                ..PLAYER
            },
            9,
        );
        assert!(!info(&plain, &profile).player_exempt(&creature));
        assert!(!info(&creature, &profile).player_exempt(&plain));
    }

    #[test]
    fn missiles() {
        let profile = Profile::retail();
        let mut missile = body(
            PhysicsState::MISSILE,
            WeenieFlags {
                present: true,
                ..Default::default()
            },
            1,
        );
        missile.target = 7;
        let mover = info(&missile, &profile);
        assert_eq!(mover.target_id, 7);
        assert!(!mover.step_down);
        let creature = WeenieFlags {
            player: false,
            ..PLAYER
        };
        let ask = |state, weenie, guid| mover.missile_ignore(&body(state, weenie, guid), &profile);
        assert!(ask(PhysicsState::MISSILE, WeenieFlags::default(), 9));
        assert!(!ask(PhysicsState::empty(), creature, 7), "its target");
        assert!(ask(PhysicsState::empty(), creature, 8), "another creature");
        assert!(ask(
            PhysicsState::ETHEREAL,
            WeenieFlags {
                present: true,
                ..Default::default()
            },
            8
        ));
        assert!(!ask(PhysicsState::ETHEREAL, WeenieFlags::default(), 8));
        assert!(!ask(PhysicsState::STATIC, WeenieFlags::default(), 0));
        // Without a target it hits creatures.
        missile.target = 0;
        let aimless = info(&missile, &profile);
        assert!(!aimless.missile_ignore(&body(PhysicsState::empty(), creature, 8), &profile));
        // Whoever is no missile passes through missiles only.
        let walker = info(&body(PhysicsState::empty(), PLAYER, 2), &profile);
        assert!(walker.missile_ignore(&missile, &profile));
        assert!(!walker.missile_ignore(&body(PhysicsState::empty(), creature, 8), &profile));
    }

    #[test]
    fn in_profile_ace_missiles_hit_the_player_they_aim_at() {
        let profile = Profile::ace();
        let walker = info(&body(PhysicsState::empty(), PLAYER, 2), &profile);
        let mut missile = body(PhysicsState::MISSILE, WeenieFlags::default(), 1);
        for (target, passes) in [(0, false), (2, false), (3, true)] {
            missile.target = target;
            assert_eq!(walker.missile_ignore(&missile, &profile), passes);
        }
    }

    #[test]
    fn an_object_is_noted_once_and_the_first_state_stays() {
        use crate::physics::body::{EntityId, ObjectRef};
        let mut info = CollisionInfo::default();
        let one = ObjectRef::Entity(EntityId(1));
        info.add_object(one, TransitionState::Ok);
        info.add_object(one, TransitionState::Collided);
        assert_eq!(
            (info.collide_object.len(), info.last_collided_object),
            (1, None)
        );
    }
}

mod rings {
    use super::*;

    #[test]
    fn worked_example_of_the_specification() {
        for wide in [false, true] {
            let r = Rings::around(0.48, wide).unwrap();
            assert_eq!((r.count, r.spacing), (9, 0.444_444_45));
            assert!((r.density - 2.9089).abs() < 1e-4);
            let mut sum = 0.0_f32;
            let counts: Vec<u32> = (0..r.count)
                .map(|_| {
                    sum += r.density;
                    2 * sum.ceil() as u32
                })
                .collect();
            assert_eq!((counts[0], counts[1], counts[8]), (6, 12, 54));
            assert_eq!(counts.iter().sum::<u32>(), 270);
        }
    }

    #[test]
    fn small_and_large_spheres() {
        assert_eq!(Rings::around(0.1, false).unwrap().count, 20);
        assert_eq!(Rings::around(0.125, false).unwrap().count, 9);
        assert!(Rings::around(4.0, false).is_none());
        assert_eq!(Rings::around(f32::NAN, false).unwrap().count, 9);
        assert_eq!(Rings::around(0.0, false).unwrap().count, u32::MAX);
    }
}

mod ground_checks {
    use super::*;

    const SQUARE: [Vec3; 4] = [
        Vec3::new(0.0, 0.0, 0.0),
        Vec3::new(2.0, 0.0, 0.0),
        Vec3::new(2.0, 2.0, 0.0),
        Vec3::new(0.0, 2.0, 0.0),
    ];

    fn stand_on_square(t: &mut Transition<'_>, center: Vec3) {
        let profile = t.profile();
        let polygon = Polygon::new(&SQUARE, profile);
        t.path.set_walkable(
            Sphere::new(center, 0.48),
            polygon,
            Vec3::Z,
            at(Vec3::ZERO),
            1.0,
        );
    }

    #[test]
    fn repeated_checks_halve_the_radius_again() {
        // 0.2 m beyond the edge: within half the radius, not within a quarter.
        let center = Vec3::new(2.2, 1.0, 0.48);
        for (profile, second) in [(Profile::retail(), false), (Profile::ace(), true)] {
            let w = world(profile);
            let mut t = mover(&w, Vec3::ZERO);
            stand_on_square(&mut t, center);
            assert!(t.check_walkables());
            assert_eq!(t.check_walkables(), second);
        }
    }

    #[test]
    fn without_a_polygon_every_check_is_good() {
        let w = world(Profile::retail());
        assert!(mover(&w, Vec3::ZERO).check_walkables());
    }

    #[test]
    fn a_precipice_slides_along_the_edge() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::new(1.9, 1.0, 0.0));
        t.info.last_known_contact_plane = ground(Vec3::Z, 0.0);
        t.add_offset_to_check_pos(Vec3::new(0.3, 0.3, 0.0));
        let center = t.path.global_sphere[0].center;
        stand_on_square(&mut t, center);
        assert_eq!(t.precipice_slide(), TransitionState::Slid);
        assert!(t.path.walkable.is_none());
        assert!(near(
            t.path.check_pos.frame.origin,
            Vec3::new(1.9, 1.3, 0.0)
        ));
        assert_eq!(t.info.collision_normal, Vec3::new(-1.0, 0.0, 0.0));
    }

    #[test]
    fn a_precipice_without_a_crossed_edge_blocks() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::new(1.0, 1.0, 0.0));
        stand_on_square(&mut t, Vec3::new(1.0, 1.0, 0.48));
        assert_eq!(t.precipice_slide(), TransitionState::Collided);
        assert!(t.path.walkable.is_none());
    }

    /// A walker that has gone 0.3 m east, into a slope that rises to the east.
    fn at_cliff(w: &World) -> Transition<'_> {
        let mut t = mover(w, Vec3::ZERO);
        t.object.state =
            ObjectInfoState::CONTACT | ObjectInfoState::ON_WALKABLE | ObjectInfoState::EDGE_SLIDE;
        t.info.last_known_contact_plane = ground(Vec3::Z, 0.0);
        t.info.contact_plane = ground(Vec3::new(-0.8, 0.0, 0.6), 0.0);
        t.add_offset_to_check_pos(Vec3::new(0.3, 0.1, 0.0));
        t.save_check_pos();
        t
    }

    #[test]
    fn running_into_a_cliff_goes_deeper_and_leaves_its_normal() {
        let w = world(Profile::retail());
        let mut t = at_cliff(&w);
        assert_eq!(
            t.edge_slide(1.5, FLOOR_Z),
            (TransitionState::Adjusted, false)
        );
        assert!(near(
            t.path.check_pos.frame.origin,
            Vec3::new(0.6, 0.1, 0.0)
        ));
        assert!(near(t.info.collision_normal, Vec3::new(-1.0, 0.0, 0.0)));
        assert!(!t.info.contact_plane.valid);
    }

    #[test]
    fn sliding_before_the_restore_undoes_the_move() {
        let mut profile = Profile::retail();
        profile.edge_slide_order = EdgeSlideOrder::BeforeRestore;
        let w = world(profile);
        let mut t = at_cliff(&w);
        let before = t.path.check_pos.frame.origin;
        assert_eq!(
            t.edge_slide(1.5, FLOOR_Z),
            (TransitionState::Adjusted, false)
        );
        assert_eq!(t.path.check_pos.frame.origin, before);
        assert!(near(t.info.collision_normal, Vec3::new(-1.0, 0.0, 0.0)));
    }

    #[test]
    fn parallel_normals_make_no_cliff() {
        let w = world(Profile::retail());
        let mut t = at_cliff(&w);
        t.info.last_known_contact_plane = t.info.contact_plane;
        assert_eq!(t.edge_slide(1.5, FLOOR_Z), (TransitionState::Ok, false));
        assert!(!t.info.contact_plane.valid);
    }

    #[test]
    fn without_edge_slide_one_walks_off() {
        let w = world(Profile::retail());
        let mut t = at_cliff(&w);
        t.object.state.remove(ObjectInfoState::EDGE_SLIDE);
        assert_eq!(t.edge_slide(1.5, FLOOR_Z), (TransitionState::Ok, true));
        assert!(!t.info.contact_plane.valid);
    }
}

mod validation {
    use super::*;

    #[test]
    fn an_accepted_step_sets_the_contact_bits() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::ZERO);
        t.add_offset_to_check_pos(Vec3::X);
        t.info.contact_plane = ground(Vec3::Z, 0.0);
        assert_eq!(
            t.validate_transition(TransitionState::Ok),
            TransitionState::Ok
        );
        assert_eq!(t.path.curr_pos.frame.origin, Vec3::X);
        assert!(t.object.in_contact() && t.object.on_walkable());
        assert_eq!(t.info.last_known_contact_plane, t.info.contact_plane);
        t.info.contact_plane = ground(Vec3::X, 0.0);
        t.validate_transition(TransitionState::Ok);
        assert!(t.object.in_contact() && !t.object.on_walkable());
    }

    #[test]
    fn falls_without_progress_end_on_invented_ground() {
        let w = world(Profile::retail());
        let mut t = mover(&w, Vec3::ZERO);
        t.object.physics_state = PhysicsState::GRAVITY;
        for expected in [1, 2] {
            t.validate_transition(TransitionState::Ok);
            assert_eq!(t.info.frames_stationary_fall, expected);
            assert!(!t.info.contact_plane.valid);
        }
        t.validate_transition(TransitionState::Ok);
        assert_eq!(t.info.frames_stationary_fall, 3);
        assert!(t.info.contact_plane.valid && t.object.on_walkable());
        assert_eq!(t.info.contact_plane.plane.n, Vec3::Z);
        assert!(t.info.contact_plane.plane.d.abs() < 1e-6);
        assert!(t.info.collided_with_environment);
        t.add_offset_to_check_pos(Vec3::X);
        t.validate_transition(TransitionState::Ok);
        assert_eq!(t.info.frames_stationary_fall, 0);
    }

    #[test]
    fn turning_in_place_is_progress_except_where_rotation_does_not_count() {
        for (profile, count) in [(Profile::retail(), 0), (Profile::ace(), 1)] {
            let w = world(profile);
            let mut t = mover(&w, Vec3::ZERO);
            t.object.physics_state = PhysicsState::GRAVITY;
            let turned = Quat::new(0.8, 0.0, 0.0, 0.6);
            t.path.check_pos.frame.set_rotation_raw(turned);
            t.validate_transition(TransitionState::Ok);
            assert_eq!(t.info.frames_stationary_fall, count);
        }
    }

    #[test]
    fn the_sliding_normal_comes_from_the_collision_normal() {
        let slope = Vec3::new(-0.6, 0.0, 0.8);
        for (profile, normal) in [
            (Profile::retail(), Vec3::new(-1.0, 0.0, 0.0)),
            (Profile::ace(), Vec3::new(-0.6, 0.0, 0.0)),
        ] {
            let w = world(profile);
            let mut t = mover(&w, Vec3::ZERO);
            t.set_collision_normal(slope);
            t.validate_transition(TransitionState::Ok);
            assert!(t.info.sliding_normal_valid);
            assert!(near(t.info.sliding_normal, normal));
        }
    }
}

mod beginning {
    use super::*;

    #[test]
    fn spheres_are_scaled_and_at_most_two() {
        let w = world(Profile::retail());
        let mut t = Transition::new(&w);
        t.init_sphere(&[Sphere::new(Vec3::new(0.0, 0.0, 1.0), 0.5); 3], 2.0);
        assert_eq!(t.path.num_sphere, 2);
        assert_eq!(
            t.path.local_sphere[1],
            Sphere::new(Vec3::new(0.0, 0.0, 2.0), 1.0)
        );
        assert_eq!(t.path.local_low_point, Vec3::new(0.0, 0.0, 1.0));
    }

    #[test]
    fn a_path_without_begin_is_a_placement() {
        let w = world(Profile::retail());
        let mut t = Transition::new(&w);
        t.init_path(None, None, at(Vec3::X));
        assert_eq!(t.path.insert_type, InsertType::Placement);
        assert_eq!(t.path.curr_pos.frame.origin, Vec3::X);
    }

    #[test]
    fn a_plane_that_is_left_keeps_a_stale_cell() {
        for (profile, contact_cell, known_cell) in [
            (Profile::retail(), CELL, CellId::NONE),
            (Profile::ace(), CellId::NONE, CELL),
        ] {
            let mut info = CollisionInfo::default();
            info.init_last_known_contact_plane(
                CELL,
                Plane {
                    n: Vec3::Z,
                    d: -1.0,
                },
                false,
                &profile,
            );
            assert!(!info.contact_plane.valid && info.last_known_contact_plane.valid);
            assert_eq!(info.contact_plane.cell_id, contact_cell);
            assert_eq!(info.last_known_contact_plane.cell_id, known_cell);
        }
    }

    #[test]
    fn dummy_spheres() {
        let (retail, gdle, ace) = (Profile::retail(), Profile::gdle(), Profile::ace());
        let radius = |purpose, profile: &Profile| {
            MoverSpheres::new(&[], 2.0, purpose, profile).as_slice()[0].radius
        };
        assert_eq!(radius(SphereUse::Move, &retail), 0.1);
        assert_eq!(radius(SphereUse::Move, &gdle), 0.0);
        assert_eq!(radius(SphereUse::Place, &gdle), 0.1);
        assert_eq!(radius(SphereUse::Check, &ace), 0.2);
        let own = MoverSpheres::new(&[Sphere::new(Vec3::Z, 1.0)], 2.0, SphereUse::Move, &gdle);
        assert_eq!(own.as_slice(), [Sphere::new(Vec3::new(0.0, 0.0, 2.0), 2.0)]);
    }

    #[test]
    fn at_most_ten_are_nested() {
        let retail = Profile::retail();
        let mut slots = TransitionSlots::default();
        let taken: Vec<_> = (0..11).map(|_| slots.make(&retail)).collect();
        assert!(taken[..10].iter().all(Option::is_some));
        assert!(taken[10].is_none());
        assert!(slots.make(&Profile::ace()).is_some());
        slots.cleanup();
        slots.cleanup();
        assert!(slots.make(&retail).is_some());
    }

    /// What a transition finds in its slot after one that touched a plane.
    fn second_finds(profile: &Profile) -> (Plane, CellId) {
        let w = world(profile.clone());
        let mut slots = TransitionSlots::default();
        let mut transit = slots.make(profile).unwrap();
        transit.result.info.init_contact_plane(
            CELL,
            Plane {
                n: Vec3::Z,
                d: -5.0,
            },
            false,
        );
        slots.keep_left_fields(&transit);
        slots.cleanup();
        slots.recycle(transit);
        let transit = slots.make(profile).unwrap();
        let mut t = Transition::new(&w);
        t.take_left_fields(&slots.left_fields(&transit));
        let known = t.info.last_known_contact_plane;
        assert!(!known.valid && !t.info.contact_plane.valid);
        assert_eq!(t.info.contact_plane.cell_id, CellId::NONE);
        (known.plane, known.cell_id)
    }

    #[test]
    fn only_gdle_remembers_the_last_use_of_a_slot() {
        let kept = (
            Plane {
                n: Vec3::Z,
                d: -5.0,
            },
            CELL,
        );
        assert_eq!(second_finds(&Profile::gdle()), kept);
        assert_eq!(
            second_finds(&Profile::retail()),
            (Plane::ZERO, CellId::NONE)
        );
        assert_eq!(LeftFields::ZERO.last_known_contact_plane, Plane::ZERO);
    }

    #[test]
    fn resetting_keeps_planes_and_the_last_known_cell() {
        let mut info = CollisionInfo::default();
        info.init_contact_plane(
            CELL,
            Plane {
                n: Vec3::Z,
                d: -5.0,
            },
            true,
        );
        info.collided_with_environment = true;
        info.reset();
        assert!(!info.contact_plane.valid && !info.last_known_contact_plane.valid);
        assert_eq!(info.contact_plane.cell_id, CellId::NONE);
        assert_eq!(info.last_known_contact_plane.cell_id, CELL);
        assert_eq!(info.contact_plane.plane.d, -5.0);
        assert!(info.contact_plane.is_water && !info.collided_with_environment);
    }
}
