//! Section 16, and the switches that sequences read.

use crate::animation::fixtures::*;
use crate::animation::{AnimationError, MotionTableError};
use crate::dat::{AnimRange, motion_key};
use crate::math::{EPSILON, Frame, Vec3};
use crate::profile::{AnimationBounds, ModifierKey, Profile, Width};

const A: u32 = 0x0300_0001;
const B: u32 = 0x0300_0002;

fn playing(frames: u32, rate: f32) -> Player {
    playing_as(frames, rate, Profile::retail())
}

fn playing_as(frames: u32, rate: f32, profile: Profile) -> Player {
    let mut p = Player::new(vec![animation(A, frames, None, &[])], profile);
    p.append(whole(A, rate));
    p
}

/// Plays a table in which Ready leads to an action through a link of animation B.
fn waver(link_anims: &[(u32, f32)]) -> Player {
    let table = table(TableParts {
        cycles: vec![(NON_COMBAT, READY, motion(&[(A, 10.0)]))],
        links: vec![(
            motion_key(NON_COMBAT, READY),
            vec![(WAVE, motion(link_anims))],
        )],
        ..TableParts::default()
    });
    let animations = vec![animation(A, 2, None, &[]), animation(B, 3, None, &[])];
    Player::with_table(animations, table, Profile::retail())
}

#[test]
fn a_rate_a_hair_below_one_frame_crosses_a_step_later() {
    for rate in [25.0_f32, 29.0, 31.0, 43.0, 49.0, 50.0, 58.0] {
        let dt = f64::from(1.0 / rate);
        if f64::from(rate) * dt >= 1.0 {
            continue;
        }
        let mut wide = playing(10, rate);
        wide.update(dt).unwrap();
        assert_eq!(wide.sequence.current_frame(), 0);
        let mut profile = Profile::retail();
        profile.frame_number = Width::F32;
        let mut narrow = playing_as(10, rate, profile);
        narrow.update(dt).unwrap();
        assert_eq!(narrow.sequence.frame_number(), 1.0);
    }
}

#[test]
fn an_end_on_the_boundary_enters_the_next_node_at_its_start() {
    let mut p = playing(4, 8.0);
    p.append(whole(A, 8.0));
    p.update(0.5).unwrap();
    assert_eq!(p.sequence.frame_number(), 0.0);
    assert_eq!(p.list().len(), 1);
    assert_eq!(p.hooks.len(), 1);
}

#[test]
fn long_animations_lose_the_hair_and_play_a_frame_that_is_none() {
    let mut short = Player::new(
        vec![animation(A, 4096, Some(Vec3::Y), &[])],
        Profile::retail(),
    );
    short.append(whole(A, -10.0));
    assert!(short.sequence.frame_number() < 4096.0);
    let mut long = Player::new(
        vec![animation(A, 4097, Some(Vec3::Y), &[])],
        Profile::retail(),
    );
    long.sequence.velocity = Vec3::X;
    long.append(whole(A, -10.0));
    assert_eq!(long.sequence.frame_number(), 4097.0);
    // Crosses index 4097: no root motion, but the velocity of a frame.
    let offset = long.update(0.05).unwrap();
    assert_eq!(offset.origin, Vec3::X * 0.1);
}

#[test]
fn tiny_turns_are_lost() {
    let mut p = playing(4, 10.0);
    p.sequence.omega = Vec3::new(0.0, 0.0, EPSILON * 9.0);
    let offset = p.update(0.15).unwrap();
    assert_eq!(offset, Frame::IDENTITY);
    p.sequence.omega = Vec3::new(0.0, 0.0, EPSILON * 11.0);
    let offset = p.update(0.1).unwrap();
    assert_ne!(offset.rotation(), Frame::IDENTITY.rotation());
}

#[test]
fn endless_inputs_are_errors() {
    let endless = Err(AnimationError::Endless { animation: A });
    // With an infinite rate what is left is ∞/∞: not endless, but nothing ever ends again.
    let mut p = playing(4, f32::INFINITY);
    assert_eq!(p.update(0.1), Ok(Frame::IDENTITY));
    assert!(p.sequence.frame_number().is_nan());
    let mut p = playing(4, 10.0);
    assert_eq!(p.update(f64::INFINITY), endless);
    let mut p = playing(1, 1e30);
    assert_eq!(p.update(1.0), endless);
    // What is left is still a sequence.
    assert_eq!(p.list(), [A]);
    assert!(playing(1, 1e5).update(2.0).is_ok());
}

#[test]
fn hooks_of_a_damaged_animation_are_limited() {
    let hooks: Vec<_> = (0..1000).map(|i| (0, i + 100, 1)).collect();
    let mut p = Player::new(vec![animation(A, 2, None, &hooks)], Profile::retail());
    p.append(whole(A, 1000.0));
    assert!(matches!(
        p.update(1.0),
        Err(AnimationError::TooManyHooks { animation: A, .. })
    ));
    assert_eq!(p.hooks.len(), 1 << 16);
}

#[test]
fn nan_ends_nothing() {
    let mut p = playing(4, 10.0);
    p.sequence.velocity = Vec3::Y;
    assert_eq!(p.update(f64::NAN).unwrap(), Frame::IDENTITY);
    assert!(p.sequence.frame_number().is_nan());
    let mut p = playing(4, f32::NAN);
    p.sequence.velocity = Vec3::Y;
    assert_eq!(p.update(0.5).unwrap().origin, Vec3::Y * 0.5);
}

#[test]
fn an_empty_list_moves_continuously_for_any_time() {
    let mut p = Player::new(Vec::new(), Profile::retail());
    p.sequence.velocity = Vec3::Y;
    assert_eq!(p.update(1e-6).unwrap().origin, Vec3::Y * 1e-6);
    // With a standing node times within ε do nothing.
    let mut p = playing(4, 0.0);
    p.sequence.velocity = Vec3::Y;
    assert_eq!(p.update(1e-6).unwrap().origin, Vec3::ZERO);
    assert_eq!(p.update(1e-3).unwrap().origin, Vec3::Y * 1e-3);
}

#[test]
fn a_slow_node_advances_without_velocity() {
    let mut p = playing(4, EPSILON);
    p.sequence.velocity = Vec3::Y;
    let offset = p.update(5001.0).unwrap();
    assert_eq!(offset, Frame::IDENTITY);
    assert_eq!(p.sequence.current_frame(), 1);
}

#[test]
fn bounds_are_fitted_to_the_frames() {
    let fitted = |low_frame, high_frame, profile: Profile| {
        let mut p = Player::new(vec![animation(A, 5, None, &[])], profile);
        p.append(AnimRange {
            low_frame,
            high_frame,
            ..whole(A, 1.0)
        });
        let node = p.sequence.current_node().unwrap().clone();
        (node.low, node.high)
    };
    let retail = Profile::retail;
    assert_eq!(fitted(0, -1, retail()), (0, 4));
    assert_eq!(fitted(-2, -1, retail()), (4, 4));
    assert_eq!(fitted(7, 9, retail()), (4, 4));
    assert_eq!(fitted(3, 1, retail()), (3, 3));
    let mut kept = retail();
    kept.animation_bounds = AnimationBounds::Kept;
    assert_eq!(fitted(-2, -1, kept.clone()), (-2, 4));
    assert_eq!(fitted(7, 9, kept), (4, 4));
}

#[test]
fn an_animation_without_frames_plays_nothing() {
    let mut p = playing(0, 10.0);
    let node = p.sequence.current_node().unwrap();
    assert_eq!((node.low, node.high), (-1, -1));
    assert!(p.update(0.35).is_ok());
    assert!(p.sequence.current_pose().is_none());
}

#[test]
fn a_missing_animation_is_counted_but_not_appended() {
    let mut p = waver(&[(0x0300_0FFF, 30.0), (B, 30.0)]);
    p.step(STEP);
    p.start(WAVE, 1.0).unwrap();
    assert_eq!(p.list(), [B, A]);
    assert_eq!(p.pending(), [(WAVE, 2)]);
    let mut kept = Profile::retail();
    kept.animation_bounds = AnimationBounds::Kept;
    p.profile = kept;
    p.start(WAVE, 1.0).unwrap();
    assert_eq!(p.list(), [B, 0, B, A]);
}

#[test]
fn a_motion_without_animations_is_stuck_until_the_world_is_entered() {
    let table = table(TableParts {
        cycles: vec![(NON_COMBAT, READY, motion(&[]))],
        ..TableParts::default()
    });
    let mut p = Player::with_table(Vec::new(), table, Profile::retail());
    assert_eq!(p.pending(), [(READY, u32::MAX)]);
    for _ in 0..3 {
        assert!(p.step(STEP).done.is_empty());
    }
    let mut run = p.manager.handle_exit_world();
    let notice = p.manager.next_completion(&mut run).unwrap();
    assert_eq!((notice.motion, notice.success), (READY, false));
    assert!(p.manager.next_completion(&mut run).is_none());
    assert_eq!((p.pending().len(), p.manager.animation_counter), (0, 0));
}

#[test]
fn speed_zero_blocks_a_link_for_ever() {
    let mut p = waver(&[(B, 30.0)]);
    p.step(STEP);
    p.start(WAVE, 0.0).unwrap();
    for _ in 0..100 {
        p.step(STEP);
    }
    assert_eq!(p.list(), [B, A]);
    assert_eq!(p.pending(), [(WAVE, 1)]);
}

#[test]
fn a_cycle_at_rate_zero_is_not_revived() {
    let mut p = waver(&[(B, 30.0)]);
    p.start(READY, 0.0).unwrap();
    assert_eq!(p.rates(), [0.0]);
    p.start(READY, 2.0).unwrap();
    assert_eq!(p.rates(), [0.0]);
    assert_eq!(p.manager.state.substate_speed, 2.0);
    // Where zero has a sign of its own, this is a new motion.
    p.profile = Profile::ace();
    p.start(READY, 0.0).unwrap();
    p.start(READY, 2.0).unwrap();
    assert_eq!(p.rates().last(), Some(&20.0));
}

#[test]
fn modifiers_that_are_substates_recurse_to_an_error() {
    let cycle = |bits| moving((A, 10.0), bits, Vec3::ZERO, Vec3::ZERO);
    let table = table(TableParts {
        cycles: vec![
            (NON_COMBAT, READY, cycle(0)),
            (NON_COMBAT, TURN, cycle(0)),
            (NON_COMBAT, SIDE, cycle(0)),
        ],
        modifiers: vec![(0x0D, cycle(0)), (0x0F, cycle(0))],
        ..TableParts::default()
    });
    let mut p = Player::with_table(vec![animation(A, 1, None, &[])], table, Profile::retail());
    p.start(TURN, 1.0).unwrap();
    let answer = p.start(SIDE, 1.0);
    assert_eq!(answer, Err(MotionTableError::Endless { table: TABLE }));
    assert_eq!(MotionTableError::Endless { table: TABLE }.code(), 0x43);
}

#[test]
fn a_modifier_that_the_table_lacks_does_not_stop_the_stop() {
    let mut p = waver(&[(B, 30.0)]);
    p.manager.state.add_modifier(TURN, 1.0);
    let answer = p.perform(crate::animation::MotionRequest::StopCompletely);
    assert!(answer.is_err());
    assert!(p.modifiers().is_empty());
    assert_eq!(p.pending().last(), Some(&(READY, 0)));
}

#[test]
fn modifiers_of_a_style_are_found_by_style_and_index() {
    let cycle = |omega| moving((A, 10.0), 0, Vec3::ZERO, omega);
    let make = |profile| {
        let table = table(TableParts {
            cycles: vec![(NON_COMBAT, READY, cycle(Vec3::ZERO))],
            modifiers: vec![
                (motion_key(NON_COMBAT, TURN), cycle(Vec3::Z)),
                (0x0D, cycle(Vec3::X)),
            ],
            ..TableParts::default()
        });
        let mut p = Player::with_table(vec![animation(A, 1, None, &[])], table, profile);
        p.start(TURN, 1.0).unwrap();
        let playing = p.sequence.omega;
        p.stop(TURN).unwrap();
        (playing, p.sequence.omega)
    };
    assert_eq!(make(Profile::retail()), (Vec3::Z, Vec3::ZERO));
    let mut by_motion = Profile::retail();
    by_motion.modifier_key = ModifierKey::ByMotion;
    assert_eq!(make(by_motion), (Vec3::X, Vec3::ZERO));
}

#[test]
fn missing_tables_answer_by_profile() {
    use crate::profile::MissingTables;
    let mut p = Player::new(Vec::new(), Profile::retail());
    let mut answer = |profile: Profile| {
        p.manager = crate::animation::MotionTableManager::new(TABLE, &mut p.shelf, &profile);
        let answer = p.start(WALK, 1.0);
        answer.map_err(MotionTableError::code)
    };
    assert_eq!(answer(Profile::retail()), Err(0x07));
    let mut empty = Profile::retail();
    empty.missing_tables = MissingTables::Empty;
    assert_eq!(answer(empty), Err(0x43));
}
