//! The motion layer on an object: invariants of `spec/08-motion.md`, section 17, and hard cases of section 18.

use proptest::prelude::*;

use super::fixtures::{GROUND, HOP, Rig, SWORD, WAVE, with_key};
use super::*;
use crate::math::Vec3;
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::{DefaultState, JumpPosture, NoWeenie, PendingJumpError, Profile};

use Command as C;
use HoldKey as K;

#[test]
fn a_creature_starts_falling_unless_it_stands() {
    let profile = Profile::retail();
    assert_eq!(Rig::new(profile.clone()).substate(), C::READY);
    let air = Rig::with_transient(profile.clone(), TransientState::empty());
    assert_eq!(air.substate(), C::FALLING);
    assert_eq!(air.interp().interpreted.forward_command, C::READY);
    let mut object = Rig::without_table(profile, TransientState::empty());
    object.entity.body.state.remove(PhysicsState::GRAVITY);
    object
        .entity
        .set_motion_table(crate::animation::fixtures::TABLE, &mut object.world);
    assert_eq!(object.substate(), C::READY);
}

#[test]
fn entering_twice_reports_one_motion_more() {
    let mut twice = Profile::retail();
    twice.default_state = DefaultState::Twice;
    let count = |profile| Rig::new(profile).entity.events.len();
    assert!(count(twice) > count(Profile::retail()));
}

#[test]
fn the_hold_key_decides_which_motion_is_stopped() {
    let mut rig = Rig::new(Profile::retail());
    assert_eq!(rig.press(C::WALK_FORWARD, K::Run), Ok(()));
    assert_eq!(rig.interp().interpreted.forward_command, C::RUN_FORWARD);
    assert_eq!(rig.interp().interpreted.forward_speed, 2.0);
    assert_eq!(rig.interp().raw.forward.command, C::WALK_FORWARD);
    assert_eq!(
        rig.release(C::WALK_FORWARD, K::None),
        Err(MotionError::NoMtableData)
    );
    assert_eq!(rig.substate(), C::RUN_FORWARD);
    assert_eq!(rig.interp().raw.forward.command, C::WALK_FORWARD);
    assert_eq!(rig.release(C::WALK_FORWARD, K::Run), Ok(()));
    assert_eq!(rig.substate(), C::READY);
    assert_eq!(rig.interp().raw.forward.command, C::READY);
}

#[test]
fn a_run_given_with_the_motion_becomes_a_walk_on_landing() {
    let mut rig = Rig::new(Profile::retail());
    rig.press(C::WALK_FORWARD, K::Run).unwrap();
    assert_eq!(rig.interp().raw.current_hold_key, K::None);
    rig.lift();
    rig.land();
    assert_eq!(rig.substate(), C::WALK_FORWARD);

    let mut rig = Rig::new(Profile::retail());
    rig.entity.set_hold_run(true, &mut rig.world);
    rig.press(C::WALK_FORWARD, K::Invalid).unwrap();
    rig.lift();
    rig.land();
    assert_eq!(rig.substate(), C::RUN_FORWARD);
    let before = rig.interp().pending.len();
    rig.entity.set_hold_run(true, &mut rig.world);
    assert_eq!(rig.interp().pending.len(), before);
    rig.entity.set_hold_run(false, &mut rig.world);
    assert_eq!(rig.substate(), C::WALK_FORWARD);
}

#[test]
fn combat_forbids_postures_and_emotes() {
    let mut rig = Rig::new(Profile::retail());
    rig.press(SWORD, K::None).unwrap();
    for (command, error) in [
        (C::CROUCH, MotionError::CantCrouchInCombat),
        (C::SITTING, MotionError::CantSitInCombat),
        (C::SLEEPING, MotionError::CantLieDownInCombat),
        (WAVE, MotionError::CantChatEmoteInCombat),
    ] {
        assert_eq!(rig.press(command, K::None), Err(error));
    }
    assert_eq!(rig.press(HOP, K::None), Ok(()));
}

#[test]
fn six_actions_wait_at_most() {
    let mut rig = Rig::new(Profile::retail());
    for _ in 0..6 {
        assert_eq!(rig.press(HOP, K::None), Ok(()));
    }
    assert_eq!(rig.press(HOP, K::None), Err(MotionError::TooManyActions));
    assert_eq!(rig.interp().interpreted.actions.len(), 6);
    rig.settle();
    assert!(rig.interp().interpreted.actions.is_empty() && rig.interp().raw.actions.is_empty());
    assert!(!rig.entity.motions_pending());
}

#[test]
fn in_the_air_states_follow_and_actions_are_refused() {
    let mut rig = Rig::new(Profile::retail());
    rig.lift();
    assert_eq!(rig.substate(), C::FALLING);
    assert_eq!(rig.press(HOP, K::None), Err(MotionError::NoContact));
    let waiting = rig.interp().pending.len();
    assert_eq!(rig.press(C::WALK_FORWARD, K::None), Ok(()));
    assert_eq!(rig.press(SWORD, K::None), Ok(()));
    assert_eq!(rig.interp().interpreted.style, SWORD);
    assert_eq!(rig.press(C::TURN_LEFT, K::None), Ok(()));
    assert_eq!(rig.interp().interpreted.turn_speed, -1.0);
    assert!(rig.interp().pending.len() <= waiting + 1);
    rig.land();
    assert_eq!(rig.interp().interpreted.style, SWORD);
}

#[test]
fn without_a_table_nothing_is_animated_and_the_queue_stays() {
    let mut rig = Rig::without_table(Profile::retail(), GROUND);
    let params = MovementParameters::default();
    let Rig { world, entity } = &mut rig;
    let refused = entity.do_motion(C::WALK_FORWARD, &params, world);
    assert_eq!(refused, Err(MotionError::NoAnimationTable));
    assert!(entity.movement.is_none());
    assert_eq!(
        rig.press(C::WALK_FORWARD, K::None),
        Err(MotionError::NoAnimationTable)
    );
    assert_eq!(rig.interp().interpreted.forward_command, C::READY);
    assert!(rig.entity.motions_pending());
    rig.entity.body.part_array = None;
    assert_eq!(
        rig.press(C::WALK_FORWARD, K::None),
        Err(MotionError::GeneralMovementFailure)
    );
}

#[test]
fn outside_all_cells_nothing_stays_pending() {
    let mut rig = Rig::new(Profile::retail());
    rig.entity.body.cell = None;
    assert_eq!(rig.press(HOP, K::None), Ok(()));
    assert!(!rig.entity.motions_pending());
    assert!(rig.interp().interpreted.actions.len() <= 1);
}

#[test]
fn leaving_the_world_ends_actions() {
    let mut rig = Rig::new(Profile::retail());
    rig.press(HOP, K::None).unwrap();
    rig.entity.movement_exit_world(&mut rig.world);
    assert!(!rig.entity.motions_pending() && rig.interp().interpreted.actions.is_empty());
}

#[test]
fn a_charged_jump_launches_with_what_it_recorded() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    rig.entity.charge_jump(&rig.world).unwrap();
    assert!(rig.interp().standing_longjump);
    rig.press(C::WALK_FORWARD, K::Run).unwrap();
    rig.press(C::SIDE_STEP_LEFT, K::None).unwrap();
    assert!(rig.interp().pending.is_empty());
    assert_eq!(rig.substate(), C::READY);
    let Rig { world, entity } = &mut rig;
    assert_eq!(entity.jump(0.5, world), Ok(3));
    assert!(entity.kin.velocity.y > 7.0 && entity.kin.velocity.x < 0.0);
    assert_eq!(entity.kin.velocity.z, 4.0);
    assert_eq!(rig.interp().jump_extent, 0.0);
    assert!(!rig.interp().standing_longjump);
    assert_eq!(rig.substate(), C::FALLING);
    let Rig { world, entity } = &mut rig;
    assert_eq!(entity.jump(0.5, world), Err(MotionError::NoContact));
}

#[test]
fn charging_while_moving_is_no_long_jump() {
    let mut rig = Rig::new(Profile::retail());
    rig.press(C::WALK_FORWARD, K::None).unwrap();
    rig.entity.charge_jump(&rig.world).unwrap();
    assert!(!rig.interp().standing_longjump);
    rig.press(C::CROUCH, K::None).unwrap();
    assert_eq!(
        rig.entity.charge_jump(&rig.world),
        Err(MotionError::CantJumpPosition)
    );
    if let Some(weenie) = &mut rig.entity.weenie {
        weenie.can_jump = false;
    }
    assert_eq!(
        rig.entity.charge_jump(&rig.world),
        Err(MotionError::CantJumpLoad)
    );
}

#[test]
fn tiny_jumps_are_accepted_and_lift_nothing() {
    let mut rig = Rig::new(Profile::retail());
    let Rig { world, entity } = &mut rig;
    assert!(entity.jump(0.0001, world).is_ok());
    assert_eq!(entity.kin.velocity, Vec3::ZERO);
    assert!(!entity.kin.transient.contains(TransientState::ON_WALKABLE));
}

#[test]
fn who_may_jump_in_the_air() {
    let mut profile = Profile::retail();
    let mut rig = Rig::with_transient(profile.clone(), TransientState::empty());
    rig.settle();
    let allowed = |rig: &Rig| rig.entity.jump_is_allowed(1.0, &rig.world);
    assert_eq!(allowed(&rig), Err(MotionError::NoContact));
    rig.entity.body.weenie.creature = false;
    assert_eq!(allowed(&rig), Ok(3));
    rig.entity.weenie = None;
    assert_eq!(allowed(&rig), Err(MotionError::NoContact));
    profile.no_weenie = NoWeenie::Always;
    rig.world.profile = profile;
    assert_eq!(allowed(&rig), Ok(0));
}

#[test]
fn the_oldest_pending_motion_may_forbid_a_jump() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    rig.press(C::CROUCH, K::None).unwrap();
    rig.press(C::WALK_FORWARD, K::None).unwrap();
    let allowed = |rig: &Rig| rig.entity.jump_is_allowed(1.0, &rig.world).map(|_| ());
    assert_eq!(
        rig.interp().pending.front().map(|p| p.forbids_jump),
        Some(true)
    );
    assert_eq!(allowed(&rig), Err(MotionError::CantJumpPosition));
    if let Some(interp) = rig.entity.interp_mut() {
        interp.pending.truncate(1);
    }
    assert_eq!(allowed(&rig), Err(MotionError::CantJumpPosition));
    rig.world.profile.pending_jump_error = PendingJumpError::MoreThanOne;
    assert_eq!(allowed(&rig), Ok(()));
    if let Some(interp) = rig.entity.interp_mut() {
        interp.interpreted.forward_command = C::FALLING;
    }
    rig.world.profile.jump_posture = JumpPosture::Falling;
    assert_eq!(allowed(&rig), Err(MotionError::CantJumpPosition));
}

#[test]
fn exhaustion_computes_the_speeds_again() {
    let mut rig = Rig::new(Profile::retail());
    rig.entity.set_hold_run(true, &mut rig.world);
    rig.press(C::WALK_FORWARD, K::Invalid).unwrap();
    if let Some(weenie) = &mut rig.entity.weenie {
        weenie.run_rate = Some(1.25);
    }
    rig.entity.report_exhaustion(&mut rig.world);
    assert_eq!(rig.interp().interpreted.forward_speed, 1.25);
    assert!(rig.interp().pending.iter().any(|p| p.forbids_jump));
}

#[test]
fn states_of_the_server_run_each_action_once() {
    let mut rig = Rig::new(Profile::retail());
    rig.entity.kin.last_move_was_autonomous = false;
    let mut state = InterpretedMotionState {
        forward_command: C::RUN_FORWARD,
        forward_speed: 1.5,
        ..InterpretedMotionState::default()
    };
    state.actions.add(Action {
        command: HOP,
        speed: 1.0,
        stamp: 5,
        autonomous: false,
    });
    rig.entity.move_to_interpreted_state(&state, &mut rig.world);
    assert_eq!(rig.substate(), C::RUN_FORWARD);
    assert_eq!(rig.interp().my_run_rate, 1.5);
    let waiting = rig.interp().interpreted.actions.len();
    rig.entity.move_to_interpreted_state(&state, &mut rig.world);
    assert_eq!(rig.interp().interpreted.actions.len(), waiting);
    assert_eq!(rig.interp().server_action_stamp, 5);
}

#[test]
fn stamps_half_a_circle_apart() {
    for (stamp, than, newer) in [
        (1, 0, true),
        (0, 0, false),
        (0x3FFF, 0, true),
        (0x4000, 0, false),
        (0, 0x7FFF, true),
        (0x8001, 0, true),
    ] {
        assert_eq!(
            ground::stamp_is_newer(stamp, than),
            newer,
            "{stamp:#x} {than:#x}"
        );
    }
}

#[test]
fn a_movement_event_sets_the_long_jump_flag_and_the_stance() {
    let mut rig = Rig::new(Profile::retail());
    let update = MovementUpdate {
        style: SWORD,
        standing_longjump: true,
        kind: UpdateKind::State(
            InterpretedMotionState {
                style: SWORD,
                ..InterpretedMotionState::default()
            },
            None,
        ),
    };
    rig.entity.kin.last_move_was_autonomous = false;
    rig.entity.apply_movement_update(&update, &mut rig.world);
    assert!(rig.interp().standing_longjump);
    assert_eq!(rig.interp().raw.style, SWORD);
    assert_eq!(rig.interp().interpreted.style, SWORD);
}

/// One call of the public interface.
#[derive(Debug, Clone)]
enum Op {
    Press(Command, HoldKey, f32),
    Release(Command, HoldKey),
    Interpreted(Command),
    StopCompletely,
    HoldRun(bool),
    Lift,
    Land,
    Settle,
    Jump(f32),
    Charge,
    TurnTo(f32),
    WalkTo(f32),
    Tick(f64),
}

fn motions() -> impl Strategy<Value = Command> {
    prop::sample::select(vec![
        C::READY,
        C::WALK_FORWARD,
        C::WALK_BACKWARDS,
        C::TURN_LEFT,
        C::TURN_RIGHT,
        C::SIDE_STEP_LEFT,
        C::SIDE_STEP_RIGHT,
        C::CROUCH,
        C::NON_COMBAT,
        SWORD,
        WAVE,
        HOP,
        C::SITTING,
    ])
}

fn keys() -> impl Strategy<Value = HoldKey> {
    prop::sample::select(vec![K::Invalid, K::None, K::Run])
}

fn op() -> impl Strategy<Value = Op> {
    prop_oneof![
        4 => (motions(), keys(), -2.0f32..2.0).prop_map(|(c, k, s)| Op::Press(c, k, s)),
        3 => (motions(), keys()).prop_map(|(c, k)| Op::Release(c, k)),
        1 => prop::sample::select(vec![C::READY, C::RUN_FORWARD, C::TURN_RIGHT, C::FALLING, C::DEAD]).prop_map(Op::Interpreted),
        1 => Just(Op::StopCompletely),
        1 => any::<bool>().prop_map(Op::HoldRun),
        1 => Just(Op::Lift),
        1 => Just(Op::Land),
        1 => Just(Op::Settle),
        1 => (0.0f32..1.2).prop_map(Op::Jump),
        1 => Just(Op::Charge),
        1 => (0.0f32..360.0).prop_map(Op::TurnTo),
        1 => (-40.0f32..40.0).prop_map(Op::WalkTo),
        2 => (0.01f64..2.0).prop_map(Op::Tick),
    ]
}

fn carry_out(rig: &mut Rig, op: &Op) {
    match *op {
        Op::Press(command, key, speed) => {
            let params = MovementParameters {
                speed,
                ..with_key(key)
            };
            let before = (rig.interp().raw.clone(), rig.interp().interpreted.clone());
            let had = (rig.entity.is_moving_to(), rig.interp().raw.current_hold_key);
            let result = rig.perform(Movement::Raw(command, params));
            let untouched =
                !had.0 && had.1 == rig.interp().raw.current_hold_key && !command.is_action();
            if result.is_err() && untouched && rig.interp().interpreted.actions == before.1.actions
            {
                assert_eq!(
                    rig.interp().interpreted,
                    before.1,
                    "a refused motion changed the state"
                );
                assert_eq!(rig.interp().raw.forward, before.0.forward);
            }
        }
        Op::Release(command, key) => {
            let _ = rig.release(command, key);
        }
        Op::Interpreted(command) => {
            let _ = rig.perform(Movement::Interpreted(command, with_key(K::None)));
        }
        Op::StopCompletely => {
            rig.perform(Movement::StopCompletely).unwrap();
            let interp = rig.interp();
            assert!(interp.interpreted.is_at_rest() && interp.interpreted.forward_speed == 1.0);
            assert_eq!(interp.raw.forward.command, C::READY);
            assert!(!rig.entity.is_moving_to());
        }
        Op::HoldRun(run) => rig.entity.set_hold_run(run, &mut rig.world),
        Op::Lift => rig.lift(),
        Op::Land => rig.land(),
        Op::Settle => {
            rig.settle();
            assert!(!rig.entity.motions_pending());
        }
        Op::Jump(extent) => {
            let _ = rig.entity.jump(extent, &mut rig.world);
        }
        Op::Charge => {
            let _ = rig.entity.charge_jump(&rig.world);
        }
        Op::TurnTo(heading) => {
            let params = MovementParameters {
                desired_heading: heading,
                ..MovementParameters::default()
            };
            rig.entity.turn_to_heading(&params, &mut rig.world);
        }
        Op::WalkTo(y) => rig.entity.move_to_position(
            &fixtures::place(1.0, y),
            &MovementParameters::default(),
            &mut rig.world,
        ),
        Op::Tick(dt) => rig.tick(rig.world.clock.now + dt),
    }
}

fn check_invariants(rig: &Rig) {
    let interp = rig.interp();
    let state = &interp.interpreted;
    assert!(matches!(
        state.sidestep_command,
        C::NONE | C::SIDE_STEP_RIGHT
    ));
    assert!(matches!(state.turn_command, C::NONE | C::TURN_RIGHT));
    assert_ne!(interp.raw.forward.command, C::RUN_FORWARD);
    assert_eq!(interp.pending.len(), rig.animating());
    assert!(state.actions.len() <= 6);
    let on_ground = rig.entity.kin.on_ground();
    assert!(on_ground || !interp.standing_longjump);
    if let Some(m) = rig.entity.move_to()
        && !m.is_active()
    {
        assert_eq!((m.current_command, m.aux_command), (C::NONE, C::NONE));
        assert!(!m.initialized && m.top_level_object_id == 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn invariants_hold_after_every_call(ops in prop::collection::vec(op(), 1..40)) {
        for profile in [Profile::retail(), Profile::gdle(), Profile::ace()] {
            let mut rig = Rig::new(profile);
            for op in &ops {
                carry_out(&mut rig, op);
                check_invariants(&rig);
            }
        }
    }
}

#[test]
fn the_steepest_ground_that_lets_an_object_move() {
    use crate::physics::transition::is_valid_walkable;
    let limit = f32::from_bits(0x3F2A_0751);
    let walkable = |z: f32, profile| is_valid_walkable(Vec3::new(0.0, 0.0, z), profile);
    let (retail, gdle) = (Profile::retail(), Profile::gdle());
    assert_eq!(libm::cos(3_437.746_770_784_939) as f32, limit);
    assert!(walkable(limit, &retail) && !walkable(limit, &gdle));
    for (z, expected) in [
        (limit.next_up(), true),
        (limit.next_down(), false),
        (1.0, true),
        (-1.0, false),
        (f32::NAN, false),
    ] {
        assert_eq!(walkable(z, &retail), expected);
        assert_eq!(walkable(z, &gdle), expected);
    }
}
