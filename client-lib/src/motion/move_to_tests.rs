//! Move-to on an object whose place the test moves: states of `spec/08-motion.md`, 11.17, and hard cases of section 18.

use super::fixtures::{HOP, Rig, place, with_key};
use super::*;
use crate::math::Position;
use crate::physics::managers::{TargetInfo, TargetStatus};
use crate::profile::{MoveToArrival, MoveToHeading, Profile};

use Command as C;

const TARGET: u32 = 0x5000_0002;

impl Rig {
    fn walk_to(&mut self, position: &Position, params: &MovementParameters) {
        let Rig { world, entity } = self;
        entity.move_to_position(position, params, world);
    }

    fn move_to(&self) -> &MoveToManager {
        self.entity.move_to().expect("there is a move-to manager")
    }

    /// The object is somewhere else, with the same heading.
    fn put(&mut self, x: f32, y: f32) {
        self.entity.body.position.frame.origin = place(x, y).frame.origin;
    }

    fn turn(&mut self, heading: f32) {
        self.entity.set_heading(heading, &mut self.world);
    }

    fn report(&mut self, status: TargetStatus, at: &Position) {
        let info = TargetInfo {
            object_id: TARGET,
            status,
            target_position: *at,
            interpolated_position: *at,
            ..TargetInfo::default()
        };
        self.entity
            .movement_handle_update_target(&info, &mut self.world);
    }
}

#[test]
fn near_enough_is_done_at_once() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    rig.walk_to(&place(0.0, 0.5), &MovementParameters::default());
    assert!(!rig.entity.is_moving_to());
    rig.settle();
    rig.walk_to(&place(0.0, 5.0), &MovementParameters::default());
    assert!(rig.entity.is_moving_to());
}

#[test]
fn turns_walks_and_arrives() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    rig.press(HOP, HoldKey::None).unwrap();
    rig.walk_to(&place(5.0, 0.0), &MovementParameters::default());
    rig.tick(100.05);
    // The turn waits for the action.
    assert!(rig.entity.motions_pending());
    assert_eq!(rig.move_to().current_command, C::NONE);
    rig.settle();
    rig.tick(100.1);
    assert_eq!(rig.move_to().current_command, C::TURN_RIGHT);
    assert_eq!(rig.substate(), C::TURN_RIGHT);
    rig.turn(90.5);
    rig.settle();
    rig.tick(100.2);
    assert_eq!(rig.entity.heading(&rig.world).round(), 90.0);
    assert_eq!(rig.move_to().current_command, C::WALK_FORWARD);
    assert_eq!(rig.interp().interpreted.forward_command, C::WALK_FORWARD);
    assert_eq!(rig.interp().raw.forward.command, C::READY);
    rig.put(4.5, 0.0);
    rig.settle();
    rig.tick(101.0);
    assert!(!rig.entity.is_moving_to());
    assert!(rig.interp().interpreted.is_at_rest());
}

#[test]
fn far_goals_are_run_to_and_the_limit_fails() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    let params = MovementParameters {
        fail_distance: 3.0,
        ..MovementParameters::default()
    };
    rig.walk_to(&place(0.0, 40.0), &params);
    rig.settle();
    rig.tick(100.1);
    assert_eq!(rig.interp().interpreted.forward_command, C::RUN_FORWARD);
    assert_eq!(rig.move_to().params.hold_key, HoldKey::Run);
    rig.put(0.0, 3.0);
    rig.settle();
    rig.tick(100.5);
    assert!(rig.entity.is_moving_to());
    rig.put(0.0, 3.1);
    rig.tick(100.6);
    assert!(!rig.entity.is_moving_to());
}

#[test]
fn a_blocked_walk_neither_arrives_nor_fails() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    let params = MovementParameters {
        fail_distance: 0.0,
        ..MovementParameters::default()
    };
    rig.walk_to(&place(0.0, 10.0), &params);
    rig.settle();
    rig.tick(100.1);
    rig.settle();
    rig.put(0.0, 0.1);
    rig.tick(101.2);
    assert!(rig.entity.is_moving_to());
    assert_eq!(rig.move_to().fail_progress_count, 1);
    rig.put(0.0, 1.0);
    rig.tick(101.3);
    assert!(!rig.entity.is_moving_to());
}

#[test]
fn steering_turns_beyond_twenty_degrees() {
    for arrival in [MoveToArrival::Stops, MoveToArrival::Snaps] {
        let mut profile = Profile::retail();
        profile.move_to_arrival = arrival;
        let mut rig = Rig::new(profile);
        rig.settle();
        rig.walk_to(&place(0.0, 40.0), &MovementParameters::default());
        rig.settle();
        rig.tick(100.1);
        rig.settle();
        rig.turn(30.0);
        rig.tick(100.2);
        assert_eq!(rig.move_to().aux_command, C::TURN_LEFT);
        assert_eq!(rig.interp().interpreted.turn_command, C::TURN_RIGHT);
        assert!(rig.interp().interpreted.turn_speed < 0.0);
        rig.settle();
        rig.turn(10.0);
        rig.tick(100.3);
        assert_eq!(rig.move_to().aux_command, C::NONE);
        assert_eq!(rig.interp().interpreted.turn_command, C::NONE);
        let heading = rig.entity.heading(&rig.world).round();
        let expected = if arrival == MoveToArrival::Snaps {
            0.0
        } else {
            10.0
        };
        assert_eq!(heading, expected);
    }
}

#[test]
fn the_final_heading_is_of_the_new_parameters() {
    for (source, nodes) in [
        (MoveToHeading::NewParameters, 3),
        (MoveToHeading::OldParameters, 2),
    ] {
        let mut profile = Profile::retail();
        profile.move_to_heading = source;
        let mut rig = Rig::new(profile);
        let params = MovementParameters::default().with(MovementFlags::USE_FINAL_HEADING, true);
        rig.walk_to(&place(5.0, 0.0), &params);
        assert_eq!(rig.move_to().nodes.len(), nodes);
    }
}

#[test]
fn a_turn_to_a_heading_begins_with_the_next_quantum() {
    let mut rig = Rig::new(Profile::retail());
    let params = MovementParameters {
        desired_heading: 270.0,
        ..MovementParameters::default()
    };
    rig.entity.turn_to_heading(&params, &mut rig.world);
    rig.settle();
    assert_eq!(rig.move_to().current_command, C::NONE);
    rig.tick(100.1);
    assert_eq!(rig.move_to().current_command, C::TURN_LEFT);
    rig.turn(280.0);
    rig.tick(100.2);
    assert_eq!(rig.move_to().current_command, C::TURN_LEFT);
    rig.turn(269.0);
    rig.tick(100.3);
    assert!(!rig.entity.is_moving_to());
    assert_eq!(rig.entity.heading(&rig.world), 270.0);
}

#[test]
fn an_unknown_target_is_waited_for() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    let target = MoveTarget {
        object_id: TARGET,
        top_level_id: TARGET,
        radius: 0.5,
        height: 1.0,
    };
    rig.perform(Movement::MoveToObject(
        target,
        MovementParameters::default(),
    ))
    .unwrap();
    rig.tick(100.1);
    assert!(rig.entity.is_moving_to() && rig.move_to().nodes.is_empty());
    rig.settle();
    rig.report(TargetStatus::Ok, &place(0.0, 9.0));
    assert!(rig.move_to().initialized);
    assert_eq!(rig.move_to().current_command, C::WALK_FORWARD);
    rig.report(TargetStatus::Ok, &place(0.0, 12.0));
    assert_eq!(rig.move_to().current_target_position, place(0.0, 12.0));
    assert_eq!(rig.move_to().previous.distance, f32::MAX);
    rig.report(TargetStatus::ExitWorld, &place(0.0, 12.0));
    assert!(!rig.entity.is_moving_to());
    rig.perform(Movement::MoveToObject(
        target,
        MovementParameters::default(),
    ))
    .unwrap();
    rig.report(TargetStatus::TimedOut, &place(0.0, 12.0));
    assert!(!rig.entity.is_moving_to());
}

#[test]
fn landing_while_waiting_ends_the_activity() {
    let mut rig = Rig::new(Profile::retail());
    let target = MoveTarget {
        object_id: TARGET,
        top_level_id: TARGET,
        ..MoveTarget::default()
    };
    rig.perform(Movement::MoveToObject(
        target,
        MovementParameters::default(),
    ))
    .unwrap();
    rig.lift();
    rig.land();
    assert!(!rig.entity.is_moving_to());
}

#[test]
fn a_turn_to_an_object_loses_its_desired_heading() {
    let mut rig = Rig::new(Profile::retail());
    let target = MoveTarget {
        object_id: TARGET,
        top_level_id: TARGET,
        ..MoveTarget::default()
    };
    let params = MovementParameters {
        desired_heading: 90.0,
        ..MovementParameters::default()
    };
    rig.perform(Movement::TurnToObject(target, params)).unwrap();
    rig.report(TargetStatus::Ok, &place(0.0, -3.0));
    assert_eq!(rig.move_to().nodes.front(), Some(&MoveToNode::Turn(180.0)));
}

#[test]
fn moving_to_oneself_ends_silently() {
    let mut rig = Rig::new(Profile::retail());
    let own = MoveTarget {
        object_id: 0x5000_0001,
        top_level_id: 0x5000_0001,
        ..MoveTarget::default()
    };
    rig.perform(Movement::MoveToObject(own, MovementParameters::default()))
        .unwrap();
    assert!(!rig.entity.is_moving_to());
    let Rig { world, entity } = &mut rig;
    assert!(!entity.move_to_object(TARGET, &MovementParameters::default(), world));
}

#[test]
fn keys_cancel_and_cancelling_twice_is_nothing() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    rig.walk_to(&place(0.0, 40.0), &MovementParameters::default());
    rig.settle();
    rig.tick(100.1);
    let params = with_key(HoldKey::None).with(MovementFlags::CANCEL_MOVETO, false);
    rig.perform(Movement::Raw(C::TURN_RIGHT, params)).unwrap();
    assert!(rig.entity.is_moving_to());
    rig.press(C::TURN_LEFT, HoldKey::None).unwrap();
    assert!(!rig.entity.is_moving_to());
    assert!(rig.move_to().nodes.is_empty());
    let waiting = rig.interp().pending.len();
    rig.entity.cancel_moveto(&mut rig.world);
    assert_eq!(rig.interp().pending.len(), waiting);
}

#[test]
fn in_the_air_nothing_is_served() {
    let mut rig = Rig::new(Profile::retail());
    rig.settle();
    rig.walk_to(&place(0.0, 40.0), &MovementParameters::default());
    rig.settle();
    rig.lift();
    rig.put(0.0, 39.9);
    rig.tick(100.1);
    assert!(rig.entity.is_moving_to());
    assert_eq!(rig.substate(), C::FALLING);
    rig.put(0.0, 5.0);
    rig.land();
    assert_eq!(rig.move_to().previous.distance, 35.0);
    assert_eq!(rig.substate(), C::RUN_FORWARD);
}
