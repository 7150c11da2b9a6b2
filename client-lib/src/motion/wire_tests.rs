//! Invariant 24 of `spec/08-motion.md`, section 17: wire forms survive a round trip, and no bytes make a reader misbehave.

use proptest::prelude::*;

use super::*;

fn command() -> impl Strategy<Value = Command> {
    (0u16..412).prop_map(Command::from_index)
}

fn speed() -> impl Strategy<Value = f32> {
    prop_oneof![Just(1.0), Just(-0.0), -10.0f32..10.0, Just(f32::INFINITY)]
}

fn hold_key() -> impl Strategy<Value = HoldKey> {
    prop_oneof![
        Just(HoldKey::Invalid),
        Just(HoldKey::None),
        Just(HoldKey::Run)
    ]
}

fn axis_command() -> impl Strategy<Value = Command> {
    prop_oneof![Just(Command::NONE), command()]
}

prop_compose! {
    fn action()(command in command(), speed in speed(), stamp in 0u32..0x8000, autonomous: bool) -> Action {
        Action { command, speed, stamp, autonomous }
    }
}

fn actions() -> impl Strategy<Value = Actions> {
    prop::collection::vec(action(), 0..32).prop_map(|list| {
        let mut actions = Actions::default();
        list.into_iter().for_each(|action| actions.add(action));
        actions
    })
}

prop_compose! {
    fn axis()(command in axis_command(), hold_key in hold_key(), speed in speed()) -> RawAxis {
        RawAxis { command, hold_key, speed }
    }
}

prop_compose! {
    fn raw()(run: bool, style in command(), forward in axis(), sidestep in axis(), turn in axis(), actions in actions())
        -> RawMotionState
    {
        RawMotionState { current_hold_key: HoldKey::running(run), style, forward, sidestep, turn, actions }
    }
}

prop_compose! {
    fn interpreted()(style in command(), forward_command in command(), sidestep_command in axis_command(),
        turn_command in axis_command(), speeds in [speed(), speed(), speed()], actions in actions())
        -> InterpretedMotionState
    {
        let [forward_speed, sidestep_speed, turn_speed] = speeds;
        InterpretedMotionState {
            style, forward_command, forward_speed, sidestep_command, sidestep_speed, turn_command, turn_speed, actions,
        }
    }
}

proptest! {
    #[test]
    fn raw_states_survive(state in raw()) {
        let mut message = Vec::new();
        state.pack(&mut message);
        let mut reader = wire::Reader::new(&message);
        prop_assert_eq!(RawMotionState::unpack(&mut reader), Ok(state));
        prop_assert_eq!(reader.offset(), message.len());
    }

    #[test]
    fn interpreted_states_survive(state in interpreted(), before in 0usize..4) {
        let mut message = vec![0; before];
        state.pack(&mut message);
        let mut reader = wire::Reader::at(&message, before);
        prop_assert_eq!(InterpretedMotionState::unpack(&mut reader), Ok(state));
        prop_assert_eq!(reader.offset(), message.len());
        prop_assert_eq!(message.len() % 4, 0);
    }

    #[test]
    fn any_bytes_are_read_or_refused(message: Vec<u8>) {
        for at in 0..message.len().min(4) {
            let _ = RawMotionState::unpack(&mut wire::Reader::at(&message, at));
            let _ = InterpretedMotionState::unpack(&mut wire::Reader::at(&message, at));
        }
    }
}

#[test]
fn more_than_31_actions_lose_their_count() {
    let mut state = RawMotionState::default();
    for stamp in 0..34 {
        state.actions.add(Action {
            command: Command(0x1000_0050),
            speed: 1.0,
            stamp,
            autonomous: false,
        });
    }
    let mut message = Vec::new();
    state.pack(&mut message);
    let back = RawMotionState::unpack(&mut wire::Reader::new(&message)).unwrap();
    let stamps: Vec<u32> = back.actions.iter().map(|action| action.stamp).collect();
    assert_eq!(stamps, [0, 1]);
}
