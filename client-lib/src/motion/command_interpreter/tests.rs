//! Keys to motions and messages (`spec/08-motion.md`, sections 13 and 14).

use super::*;
use crate::math::Vec3;
use crate::motion::fixtures::{HOP, Rig, SWORD, WAVE, place};
use crate::motion::{HoldKey, RawMotionState};
use crate::profile::Profile;

use Command as C;

struct Seat {
    rig: Rig,
    keys: CommandInterpreter,
}

impl Seat {
    /// A player that stands; the first key takes control.
    fn new() -> Self {
        let mut rig = Rig::new(Profile::retail());
        rig.settle();
        Self {
            keys: CommandInterpreter::new(100.0),
            rig,
        }
    }

    fn with<R>(&mut self, f: impl FnOnce(&mut CommandInterpreter, &mut Scene<'_>) -> R) -> R {
        let Rig { world, entity } = &mut self.rig;
        let mut scene = Scene {
            player: Some(entity),
            world,
        };
        f(&mut self.keys, &mut scene)
    }

    fn key(&mut self, command: Command, down: bool) {
        self.with(|keys, scene| keys.handle_keyboard_command(command, down, 1.0, scene));
        self.rig.settle();
    }

    /// One frame at a time, s; what was sent by then.
    fn frame(&mut self, now: f64) -> Vec<u32> {
        self.rig.world.clock.now = now;
        self.with(|keys, scene| keys.use_time(scene));
        self.sent()
    }

    fn sent(&mut self) -> Vec<u32> {
        self.keys.outbox.drain(..).map(|m| m.opcode()).collect()
    }

    fn raw(&self) -> &RawMotionState {
        &self.rig.interp().raw
    }

    fn forward(&self) -> Command {
        self.rig.interp().interpreted.forward_command
    }
}

#[test]
fn a_key_walks_and_its_release_stops() {
    let mut seat = Seat::new();
    assert!(seat.keys.controlled_by_server);
    seat.key(C::WALK_FORWARD, true);
    assert!(!seat.keys.controlled_by_server);
    assert_eq!(seat.forward(), C::WALK_FORWARD);
    assert_eq!(seat.sent(), [0xF61C]);
    seat.key(C::HOLD_RUN, true);
    assert_eq!(seat.forward(), C::RUN_FORWARD);
    assert_eq!(seat.raw().current_hold_key, HoldKey::Run);
    seat.key(C::HOLD_RUN, false);
    assert_eq!(seat.sent(), [0xF61C, 0xF61C]);
    seat.key(C::WALK_FORWARD, false);
    assert_eq!(seat.forward(), C::READY);
    assert_eq!(seat.sent(), [0xF61C]);
    seat.key(C::HOLD_RUN, true);
    assert_eq!(seat.sent(), [0u32; 0]);
}

#[test]
fn the_older_key_takes_over() {
    let mut seat = Seat::new();
    seat.key(C::TURN_LEFT, true);
    seat.key(C::TURN_RIGHT, true);
    assert_eq!(seat.raw().turn.command, C::TURN_RIGHT);
    seat.key(C::TURN_RIGHT, false);
    assert_eq!(seat.raw().turn.command, C::TURN_LEFT);
    assert!(seat.rig.interp().interpreted.turn_speed < 0.0);
    seat.key(C::TURN_RIGHT, true);
    seat.key(C::TURN_LEFT, false);
    assert_eq!(seat.raw().turn.command, C::TURN_RIGHT);
    seat.key(C::TURN_RIGHT, false);
    assert_eq!(seat.raw().turn.command, C::NONE);
    assert_eq!(seat.sent().len(), 6);
}

#[test]
fn releases_under_server_control_only_forget() {
    let mut seat = Seat::new();
    seat.key(C::WALK_FORWARD, true);
    seat.with(|keys, scene| keys.lose_control_to_server(scene));
    seat.sent();
    seat.key(C::WALK_FORWARD, false);
    assert_eq!(seat.sent(), [0u32; 0]);
    assert!(seat.keys.substates.is_empty() && seat.keys.controlled_by_server);
    assert_eq!(seat.forward(), C::WALK_FORWARD);
}

#[test]
fn held_keys_take_control_when_the_server_is_done() {
    let mut seat = Seat::new();
    seat.key(C::WALK_FORWARD, true);
    seat.with(|keys, scene| keys.lose_control_to_server(scene));
    seat.frame(100.1);
    assert!(!seat.keys.controlled_by_server);
    assert_eq!(seat.forward(), C::WALK_FORWARD);
}

#[test]
fn turning_keys_sidestep_while_the_modifier_is_held() {
    let mut seat = Seat::new();
    seat.key(C::HOLD_SIDESTEP, true);
    seat.key(C::TURN_LEFT, true);
    assert_eq!(seat.raw().turn.command, C::NONE);
    assert_eq!(seat.raw().sidestep.command, C::SIDE_STEP_LEFT);
    seat.key(C::HOLD_SIDESTEP, false);
    assert_eq!(seat.raw().sidestep.command, C::NONE);
    assert_eq!(seat.raw().turn.command, C::TURN_LEFT);
    // The sidestep list is empty, so its stop takes the mapped turn along.
    seat.key(C::HOLD_SIDESTEP, true);
    assert_eq!(seat.raw().turn.command, C::NONE);
    assert_eq!(seat.raw().sidestep.command, C::NONE);
}

#[test]
fn autorun_ends_with_a_walking_key() {
    let mut seat = Seat::new();
    seat.key(C::AUTO_RUN, true);
    assert!(seat.keys.auto_run);
    assert_eq!(seat.forward(), C::RUN_FORWARD);
    assert_eq!(seat.raw().forward.hold_key, HoldKey::Run);
    assert_eq!(seat.sent(), [0xF61C]);
    seat.key(C::WALK_BACKWARDS, true);
    assert!(!seat.keys.auto_run);
    assert_eq!(seat.raw().forward.command, C::WALK_BACKWARDS);
    seat.key(C::AUTO_RUN, true);
    seat.key(C::AUTO_RUN, true);
    assert!(!seat.keys.auto_run);
    assert_eq!(seat.raw().forward.command, C::WALK_BACKWARDS);
}

#[test]
fn actions_stop_everything_and_send_two_events() {
    let mut seat = Seat::new();
    seat.key(C::WALK_FORWARD, true);
    seat.sent();
    seat.with(|keys, scene| keys.handle_keyboard_command(HOP, true, 1.0, scene));
    assert_eq!(seat.sent(), [0xF61C, 0xF61C]);
    assert_eq!(seat.keys.action_stamp, 2);
    let action = *seat.raw().actions.iter().next().unwrap();
    assert_eq!(
        (action.command, action.stamp, action.autonomous),
        (HOP, 1, true)
    );
    assert!(seat.keys.substates.is_empty());
}

#[test]
fn refusals_are_noted() {
    let mut seat = Seat::new();
    seat.key(SWORD, true);
    seat.key(WAVE, true);
    seat.key(C::CROUCH, true);
    assert_eq!(
        seat.keys.notices,
        [
            MotionError::CantChatEmoteInCombat,
            MotionError::CantCrouchInCombat
        ]
    );
}

#[test]
fn a_posture_is_not_replaced_by_ready() {
    let mut seat = Seat::new();
    seat.key(C::CROUCH, true);
    assert!(seat.keys.transient);
    seat.with(|keys, scene| keys.apply_current_movement(scene));
    assert_eq!(seat.forward(), C::CROUCH);
    seat.key(C::WALK_FORWARD, true);
    assert!(!seat.keys.transient);
}

#[test]
fn a_jump_is_charged_and_reported() {
    let mut seat = Seat::new();
    seat.key(C::WALK_FORWARD, true);
    seat.sent();
    seat.with(|keys, scene| assert!(keys.handle_action(0x31, true, scene)));
    seat.rig.world.clock.now += 0.25;
    seat.with(|keys, scene| keys.do_jump(scene));
    let Some(Outgoing::Jump {
        extent, velocity, ..
    }) = seat.keys.outbox.pop()
    else {
        panic!("no jump was sent");
    };
    assert_eq!(extent, 0.25);
    assert_eq!(velocity, Vec3::new(0.0, 3.12, 2.0));
    seat.with(|keys, scene| keys.do_jump(scene));
    seat.with(|keys, scene| keys.commence_jump(scene));
    seat.rig.world.clock.now += 9.0;
    seat.with(|keys, scene| keys.do_jump(scene));
    assert_eq!(seat.keys.notices, [MotionError::NoContact]);
    assert!(seat.sent().is_empty());
}

#[test]
fn at_level_0_single_commands_are_sent() {
    let mut seat = Seat::new();
    assert!(!seat.keys.set_autonomy_level(3) && seat.keys.set_autonomy_level(0));
    seat.keys.controlled_by_server = false;
    seat.key(C::TURN_LEFT, true);
    seat.key(C::TURN_LEFT, false);
    assert_eq!(seat.sent(), [0xF61E, 0xF661]);
    assert_eq!(seat.raw().turn.command, C::NONE);
}

#[test]
fn turning_keys_sidestep_while_the_mouse_turns() {
    let mut seat = Seat::new();
    seat.keys.options.mouse_turning = true;
    seat.key(C::TURN_LEFT, true);
    seat.keys.mouse_look = true;
    seat.with(|keys, scene| {
        keys.handle_mouse_movement_command(C::MOUSE_LOOK, true, 1.0, false, scene);
    });
    assert_eq!(seat.raw().turn.command, C::NONE);
    assert_eq!(seat.raw().sidestep.command, C::SIDE_STEP_LEFT);
    seat.with(|keys, scene| keys.handle_select_left(true, scene));
    assert_eq!(seat.forward(), C::RUN_FORWARD);
    assert_eq!(seat.raw().forward.hold_key, HoldKey::Run);
}

#[test]
fn death_takes_the_keyboard() {
    let mut seat = Seat::new();
    seat.key(C::WALK_FORWARD, true);
    if let Some(interp) = seat.rig.entity.interp_mut() {
        interp.interpreted.forward_command = C::DEAD;
    }
    seat.key(C::TURN_LEFT, true);
    assert!(seat.keys.substates.is_empty() && seat.keys.turns.is_empty());
    assert_eq!(seat.raw().turn.command, C::NONE);
}

#[test]
fn losing_the_focus_and_logging_off_end_what_is_held() {
    let mut seat = Seat::new();
    seat.key(C::WALK_FORWARD, true);
    seat.with(|keys, scene| keys.lose_keyboard_focus(scene));
    assert_eq!(seat.forward(), C::READY);
    seat.rig.settle();
    seat.key(C::WALK_FORWARD, true);
    seat.with(|keys, scene| keys.disable(scene));
    assert_eq!(seat.forward(), C::READY);
    seat.sent();
    seat.key(C::WALK_FORWARD, true);
    assert!(seat.sent().is_empty() && !seat.keys.enabled);
}

#[test]
fn a_resting_player_reports_once() {
    let mut seat = Seat::new();
    assert_eq!(seat.frame(100.01), [0xF753]);
    for n in 0..50 {
        assert!(seat.frame(100.1 + f64::from(n)).is_empty());
    }
}

#[test]
fn a_moving_player_reports_every_second() {
    let mut seat = Seat::new();
    seat.frame(100.0);
    let mut times = Vec::new();
    for n in 1..=300 {
        let now = 100.0 + f64::from(n) / 100.0;
        seat.rig.entity.body.position = place(n as f32 * 0.01, 0.0);
        if !seat.frame(now).is_empty() {
            times.push(n);
        }
    }
    assert_eq!(times, [101, 202]);
    seat.key(C::TURN_LEFT, true);
    assert_eq!(seat.sent(), [0xF61C]);
    assert!(seat.frame(103.5).is_empty());
}

#[test]
fn planes_cells_and_the_air() {
    let mut seat = Seat::new();
    seat.frame(100.0);
    seat.rig.entity.kin.contact_plane.d = 1.0;
    assert_eq!(seat.frame(100.1), [0xF753]);
    seat.rig.entity.body.position.cell.0 += 1;
    seat.rig.lift();
    assert!(seat.frame(100.2).is_empty());
    seat.rig.land();
    assert_eq!(seat.frame(100.3), [0xF753]);
    seat.keys.set_autonomy_level(1);
    seat.rig.entity.body.position.cell.0 += 1;
    assert!(seat.frame(102.0).is_empty());
}

#[test]
fn bodies_of_messages() {
    let mut seat = Seat::new();
    seat.rig.entity.timestamps.0 = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    seat.frame(100.0);
    seat.with(|keys, scene| {
        scene.player.as_mut().unwrap().timestamps.0 = [1, 2, 3, 4, 5, 6, 7, 8, 9];
        keys.last_sent_position = Position::default();
        keys.use_time(scene);
        keys.handle_keyboard_command(Command::TURN_RIGHT, true, 1.0, scene);
    });
    let bodies: Vec<Vec<u8>> = seat
        .keys
        .outbox
        .drain(..)
        .map(|m| {
            let mut body = Vec::new();
            m.pack(&mut body);
            body
        })
        .collect();
    let [report, state] = bodies.try_into().unwrap();
    assert_eq!(report.len(), 32 + 8 + 4);
    assert_eq!(report[..4], [0x25, 0, 0xB4, 0xA9]);
    assert_eq!(report[32..], [9, 0, 6, 0, 5, 0, 7, 0, 1, 0, 0, 0]);
    assert_eq!(state[..12], [1, 1, 0, 0, 1, 0, 0, 0, 0x0D, 0, 0, 0x65]);
    assert_eq!(state[44..], [9, 0, 6, 0, 5, 0, 7, 0, 1, 0, 0, 0]);
    let jump = Outgoing::Jump {
        extent: 1.0,
        velocity: Vec3::ZERO,
        position: Position::default(),
        stamps: SequenceStamps::default(),
    };
    let mut body = Vec::new();
    jump.pack(&mut body);
    assert_eq!((jump.opcode(), body.len()), (0xF61B, 56));
}
