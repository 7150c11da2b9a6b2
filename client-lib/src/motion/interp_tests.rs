//! Numbers of `spec/08-motion.md`, section 9, and invariants of section 17 that need no object.

#![allow(
    clippy::excessive_precision,
    reason = "digits as the specification prints them"
)]

use proptest::prelude::*;

use super::*;
use crate::entity::Weenie;
use crate::math::{EPSILON, Frame, Quat, Vec3};
use crate::physics::state::TransientState;
use crate::profile::Profile;

const GROUND: TransientState = TransientState::CONTACT.union(TransientState::ON_WALKABLE);

fn runner(rate: f32) -> Weenie {
    Weenie {
        run_rate: Some(rate),
        jump_velocity: Some(8.0),
        ..Weenie::default()
    }
}

fn creature<'a>(weenie: &'a Weenie, profile: &'a Profile) -> Mover<'a> {
    Mover {
        profile,
        weenie: Some(weenie),
        creature: true,
        gravity: true,
        transient: GROUND,
    }
}

/// Speed and state velocity of one raw command alone.
fn perform(command: Command, key: HoldKey, rate: f32) -> (Motion, Vec3) {
    let (weenie, profile) = (runner(rate), Profile::retail());
    let mover = creature(&weenie, &profile);
    let mut interp = MotionInterp::default();
    let motion = Motion {
        command,
        speed: 1.0,
    };
    let adjusted = interp.adjust_motion(motion, key, &mover);
    let params = MovementParameters {
        speed: adjusted.speed,
        ..MovementParameters::default()
    };
    interp.interpreted.apply_motion(adjusted.command, &params);
    (adjusted, interp.state_velocity(&mover))
}

#[test]
fn speeds_of_section_9() {
    use Command as C;
    for (rate, run, back, back_y, side, side_x) in [
        (1.0, 4.0, -0.65, -2.027_999_9, 1.247_999_9, 1.559_999_9),
        (1.5, 6.0, -0.974_999_96, -3.041_999_8, 1.871_999_9, 2.34),
        (2.0, 8.0, -1.3, -4.055_999_8, 2.495_999_8, 3.119_999_9),
        (
            2.375,
            9.5,
            -1.543_749_9,
            -4.816_499_7,
            2.963_999_7,
            3.704_999_7,
        ),
        (3.0, 12.0, -1.949_999_9, -6.083_999_6, 3.0, 3.75),
        (4.5, 18.0, -2.925, -9.125_999_5, 3.0, 3.75),
    ] {
        let (walk, v) = perform(C::WALK_FORWARD, HoldKey::None, rate);
        assert_eq!((walk.command, v.y), (C::WALK_FORWARD, 3.12));
        let (m, v) = perform(C::WALK_FORWARD, HoldKey::Run, rate);
        assert_eq!((m.command, m.speed, v.y), (C::RUN_FORWARD, rate, run));
        let (m, v) = perform(C::WALK_BACKWARDS, HoldKey::None, rate);
        assert_eq!((m.command, m.speed), (C::WALK_FORWARD, -0.65));
        assert_eq!(v.y.to_bits(), (-2.027_999_9f32).to_bits());
        let (m, v) = perform(C::WALK_BACKWARDS, HoldKey::Run, rate);
        assert_eq!((m.speed, v.y), (back, back_y), "backwards at {rate}");
        let (m, v) = perform(C::SIDE_STEP_RIGHT, HoldKey::None, rate);
        assert_eq!((m.speed, v.x), (1.247_999_9, 1.559_999_9));
        for (command, sign) in [(C::SIDE_STEP_RIGHT, 1.0), (C::SIDE_STEP_LEFT, -1.0)] {
            let (m, v) = perform(command, HoldKey::Run, rate);
            assert_eq!(m.command, C::SIDE_STEP_RIGHT);
            assert_eq!(
                (m.speed * sign, v.x * sign),
                (side, side_x),
                "side at {rate}"
            );
        }
        let (m, _) = perform(C::TURN_LEFT, HoldKey::Run, rate);
        assert_eq!((m.command, m.speed), (C::TURN_RIGHT, -1.5));
        let (m, v) = perform(C::RUN_FORWARD, HoldKey::Run, rate);
        assert_eq!((m.speed, v.y), (1.0, 4.0));
    }
}

#[test]
fn diagonals_are_capped() {
    let profile = Profile::retail();
    for (rate, x, y) in [
        (1.0, 1.453_380_9, 3.726_618),
        (3.0, 3.579_299_4, 11.453_759),
    ] {
        let weenie = runner(rate);
        let mover = creature(&weenie, &profile);
        let mut interp = MotionInterp::default();
        interp.interpreted.forward_command = Command::RUN_FORWARD;
        interp.interpreted.forward_speed = rate;
        interp.interpreted.sidestep_command = Command::SIDE_STEP_RIGHT;
        interp.interpreted.sidestep_speed = perform(Command::SIDE_STEP_RIGHT, HoldKey::Run, rate)
            .0
            .speed;
        let v = interp.state_velocity(&mover);
        assert!((v.x - x).abs() < 1e-6 && (v.y - y).abs() < 2e-6, "{v}");
    }
}

#[test]
fn extreme_speeds() {
    let (weenie, profile) = (runner(2.403_846), Profile::retail());
    let mover = creature(&weenie, &profile);
    let interp = MotionInterp::default();
    let run =
        |command, speed| interp.adjust_motion(Motion { command, speed }, HoldKey::Run, &mover);
    for speed in [0.0, -0.0, f32::NAN] {
        assert_eq!(
            run(Command::WALK_FORWARD, speed).command,
            Command::WALK_FORWARD
        );
    }
    assert!(run(Command::SIDE_STEP_RIGHT, f32::NAN).speed.is_nan());
    assert_eq!(run(Command::SIDE_STEP_RIGHT, 1.0).speed, 2.999_999_5);
}

#[test]
fn leaving_the_ground() {
    let (weenie, profile) = (runner(1.0), Profile::retail());
    let mover = creature(&weenie, &profile);
    let mut interp = MotionInterp::default();
    interp.interpreted.sidestep_command = Command::SIDE_STEP_RIGHT;
    interp.interpreted.sidestep_speed = 0.000_152;
    let own = Vec3::new(0.0, 2.0, 0.0);
    let launch = |interp: &MotionInterp, profile| {
        interp.leave_ground_velocity(&Mover { profile, ..mover }, &Frame::IDENTITY, own)
    };
    assert_eq!(launch(&interp, &profile), own);
    interp.interpreted.sidestep_speed = 0.00017;
    assert_eq!(launch(&interp, &profile).y, 0.0);
    let turned = Frame::new(Vec3::ZERO, Quat::new(0.0, 0.0, 0.0, 1.0));
    interp.interpreted.sidestep_speed = 1.0;
    let gdle = Profile::gdle();
    let v = interp.leave_ground_velocity(
        &Mover {
            profile: &gdle,
            ..mover
        },
        &turned,
        own,
    );
    assert_eq!(v.x, -1.25);
    interp.interpreted.sidestep_command = Command::NONE;
    assert_eq!(launch(&interp, &gdle), Vec3::ZERO);
    interp.jump_extent = 2.0;
    assert_eq!(launch(&interp, &gdle).z, 8.0);
    let alone = Mover {
        weenie: None,
        ..mover
    };
    assert_eq!(interp.jump_v_z(&alone), 10.0);
    interp.jump_extent = 0.000_19;
    assert_eq!(interp.jump_v_z(&mover), 0.0);
}

#[test]
fn postures_that_forbid_a_jump() {
    let (retail, ace) = (Profile::retail(), Profile::ace());
    for (command, allowed) in [
        (0x4000_0015, true),
        (0x4000_0016, false),
        (0x4000_0018, false),
        (0x4000_0019, true),
        (0x1000_0127, true),
        (0x1000_0128, false),
        (0x1000_0131, false),
        (0x1000_0132, true),
        (0x1000_006E, true),
        (0x1000_006F, false),
        (0x1000_0078, false),
        (0x4100_0012, false),
        (0x4100_0014, false),
        (0x4000_001D, true),
        (0x4000_001E, false),
        (0x4000_0039, false),
        (0x4000_0008, false),
        (0x4100_0003, true),
    ] {
        assert_eq!(
            motion_allows_jump(Command(command), &retail),
            allowed,
            "{command:#x}"
        );
    }
    assert!(
        motion_allows_jump(Command::FALLEN, &ace) && !motion_allows_jump(Command::FALLING, &ace)
    );
}

fn any_command() -> impl Strategy<Value = Command> {
    prop_oneof![
        (0u16..412).prop_map(Command::from_index),
        (3u16..0x15).prop_map(Command::from_index),
        Just(Command::NONE)
    ]
}

fn any_key() -> impl Strategy<Value = HoldKey> {
    prop_oneof![
        Just(HoldKey::Invalid),
        Just(HoldKey::None),
        Just(HoldKey::Run)
    ]
}

proptest! {
    #[test]
    fn adjusting_normalises(command in any_command(), speed in -5.0f32..5.0, key in any_key(), current in any_key(), rate in 0.1f32..5.0) {
        let (weenie, profile) = (runner(rate), Profile::retail());
        let mover = creature(&weenie, &profile);
        let mut interp = MotionInterp::default();
        interp.raw.current_hold_key = current;
        let motion = Motion { command, speed };
        let out = interp.adjust_motion(motion, key, &mover);
        use Command as C;
        prop_assert!(![C::WALK_BACKWARDS, C::TURN_LEFT, C::SIDE_STEP_LEFT].contains(&out.command));
        if !command.is_turn() && !command.is_sidestep() && command != C::WALK_FORWARD && command != C::WALK_BACKWARDS {
            prop_assert_eq!(out, motion);
        }
        for (left, right) in [(C::TURN_LEFT, C::TURN_RIGHT), (C::SIDE_STEP_LEFT, C::SIDE_STEP_RIGHT)] {
            let a = interp.adjust_motion(Motion { command: left, speed }, key, &mover);
            let b = interp.adjust_motion(Motion { command: right, speed: -speed }, key, &mover);
            prop_assert_eq!((a.command, a.speed.to_bits()), (b.command, b.speed.to_bits()));
        }
        let side = interp.adjust_motion(Motion { command: C::SIDE_STEP_RIGHT, speed }, HoldKey::Run, &mover);
        prop_assert!(side.speed.abs() <= 3.0);
        let side = interp.adjust_motion(Motion { command: C::SIDE_STEP_LEFT, speed }, HoldKey::None, &mover);
        prop_assert_eq!(side.speed, -speed * constants::SIDESTEP_RATE);
        let object = Mover { creature: false, ..mover };
        prop_assert_eq!(interp.adjust_motion(motion, key, &object), motion);
    }

    #[test]
    fn state_velocity_is_capped(forward in any_command(), side: bool, fs in -5.0f32..5.0, ss in -5.0f32..5.0, rate in 0.01f32..5.0) {
        let (weenie, profile) = (runner(rate), Profile::retail());
        let mover = creature(&weenie, &profile);
        let mut interp = MotionInterp::default();
        interp.interpreted.forward_command = forward;
        interp.interpreted.forward_speed = fs;
        interp.interpreted.sidestep_command = if side { Command::SIDE_STEP_RIGHT } else { Command::NONE };
        interp.interpreted.sidestep_speed = ss;
        let v = interp.state_velocity(&mover);
        prop_assert!(v.length() <= 4.0 * rate * (1.0 + 4.0 * 2.0f32.powi(-24)));
        prop_assert_eq!(v.z, 0.0);
    }

    #[test]
    fn no_jump_no_lift(extent in 0.0f32..EPSILON) {
        let profile = Profile::retail();
        let weenie = Weenie { jump_velocity: None, ..runner(1.0) };
        let mover = creature(&weenie, &profile);
        let mut interp = MotionInterp { jump_extent: extent, ..MotionInterp::default() };
        prop_assert_eq!(interp.jump_v_z(&mover), 0.0);
        interp.jump_extent = 1.0;
        prop_assert_eq!(interp.jump_v_z(&mover), 0.0);
    }

    #[test]
    fn contact_is_monotone(command in any_command(), creature: bool, gravity: bool, bits in 0u32..4) {
        let profile = Profile::retail();
        let weenie = runner(1.0);
        let mover = Mover { profile: &profile, weenie: Some(&weenie), creature, gravity, transient: TransientState::from_bits_retain(bits) };
        if contact_allows_move(command, &mover) {
            let better = Mover { transient: mover.transient | TransientState::ON_WALKABLE, ..mover };
            prop_assert!(contact_allows_move(command, &better));
            let floating = Mover { gravity: false, ..mover };
            prop_assert!(contact_allows_move(command, &floating));
        }
        for always in [Command::DEAD, Command::FALLING, Command::TURN_RIGHT, Command::TURN_LEFT] {
            prop_assert!(contact_allows_move(always, &mover));
        }
    }
}
