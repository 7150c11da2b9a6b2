//! What the client sends: game actions with their numbers, and movement reports only when something has changed
//! (`spec/10-messages.md`, 1 and 6; `spec/08-motion.md`, 14).

use super::messages::{ClientMessage, GAME_ACTION, GameAction};
use crate::motion::{Outgoing, RawMotionState};

/// When a movement is reported again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Repeats {
    /// At every key, as the retail client does, also when the motion stays the same (14.1).
    #[default]
    Sent,
    /// Only when it differs from the last one.
    LeftOut,
}

/// What a movement report says beside where the player is.
#[derive(Debug, Clone, PartialEq)]
struct Reported {
    state: RawMotionState,
    contact: bool,
    standing_longjump: bool,
}

/// Numbers the actions of a session and turns them into messages.
#[derive(Debug, Clone, Default)]
pub struct ActionWriter {
    /// Whether repeated movements are sent.
    pub repeats: Repeats,
    sent: u32,
    last: Option<Reported>,
}

impl ActionWriter {
    /// Actions so far: the number of the last one, from 1.
    pub const fn sent(&self) -> u32 {
        self.sent
    }

    fn next(&mut self) -> u32 {
        self.sent = self.sent.wrapping_add(1);
        self.sent
    }

    /// The message of an action.
    pub fn action(&mut self, action: GameAction) -> Vec<u8> {
        let sequence = self.next();
        ClientMessage::Action { sequence, action }.to_bytes()
    }

    /// The message of something that the command interpreter wants to be sent; `None` if it is left out as a repeat.
    pub fn report(&mut self, report: &Outgoing) -> Option<Vec<u8>> {
        if let Outgoing::MoveToState {
            state,
            contact,
            standing_longjump,
            ..
        } = report
        {
            let now = Reported {
                state: state.clone(),
                contact: *contact,
                standing_longjump: *standing_longjump,
            };
            let repeated = self.last.as_ref() == Some(&now);
            self.last = Some(now);
            if repeated && self.repeats == Repeats::LeftOut {
                return None;
            }
        }
        let mut message = Vec::new();
        for word in [GAME_ACTION, self.next(), report.opcode()] {
            message.extend(word.to_le_bytes());
        }
        report.pack(&mut message);
        Some(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{CellId, Position, Quat, Vec3};
    use crate::motion::{
        AutonomyLevel, Command, HoldKey, MovementParameters, RawMotionState, SequenceStamps,
    };
    use crate::net::messages::action;
    use crate::profile::Profile;

    fn movement(command: Command) -> Outgoing {
        let mut state = RawMotionState::default();
        state.forward.command = command;
        Outgoing::MoveToState {
            state,
            position: Position::new(
                CellId(0xA9B4_0019),
                Vec3::new(84.0, 7.25, 94.0),
                Quat::IDENTITY,
            ),
            stamps: SequenceStamps {
                instance: 5,
                server_control: 3,
                teleport: 1,
                force_position: 0,
            },
            contact: true,
            standing_longjump: false,
        }
    }

    fn read(bytes: &[u8]) -> (u32, GameAction) {
        let parsed = ClientMessage::parse(bytes).expect("a valid message");
        assert!(parsed.extra.is_empty(), "{parsed:?}");
        assert_eq!(bytes.len() % 4, 0);
        match parsed.message {
            ClientMessage::Action { sequence, action } => (sequence, action),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn actions_are_numbered_from_one() {
        let mut writer = ActionWriter::default();
        let login = writer.action(GameAction::LoginComplete(()));
        assert_eq!(read(&login), (1, GameAction::LoginComplete(())));
        let bytes = writer
            .report(&movement(Command::WALK_FORWARD))
            .expect("sent");
        let (sequence, GameAction::MoveToState(sent)) = read(&bytes) else {
            panic!("a movement");
        };
        assert_eq!(sequence, 2);
        assert_eq!(sent.state.state().forward.command, Command::WALK_FORWARD);
        let stamps = action::ReportStamps {
            instance: 5,
            server_control: 3,
            teleport: 1,
            force: 0,
        };
        assert_eq!((sent.stamps, sent.bits), (stamps, 1));
    }

    #[test]
    fn repeats_are_left_out_on_demand() {
        let mut writer = ActionWriter::default();
        for repeats in [Repeats::Sent, Repeats::LeftOut] {
            writer.repeats = repeats;
            writer.last = None;
            assert!(writer.report(&movement(Command::WALK_FORWARD)).is_some());
            let again = writer.report(&movement(Command::WALK_FORWARD));
            assert_eq!(again.is_some(), repeats == Repeats::Sent);
            assert!(writer.report(&movement(Command::READY)).is_some());
        }
    }

    #[test]
    fn every_report_has_the_layout_that_servers_read() {
        let mut writer = ActionWriter::default();
        let level = writer
            .report(&Outgoing::AutonomyLevel(AutonomyLevel::Follows))
            .expect("sent");
        assert_eq!(read(&level).1, GameAction::AutonomyLevel(1));
        let stop = Outgoing::StopMovementCommand {
            command: Command::WALK_FORWARD,
            hold_key: HoldKey::Run,
        };
        let GameAction::StopMovementCommand(stop) = read(&writer.report(&stop).expect("sent")).1
        else {
            panic!("a stop");
        };
        assert_eq!(stop.command, Command::WALK_FORWARD.0);
        let turn = Outgoing::TurnTo(MovementParameters::new(&Profile::retail()));
        let GameAction::Unread(0xF649, rest) = read(&writer.report(&turn).expect("sent")).1 else {
            panic!("a turn");
        };
        assert_eq!(rest.0.len(), 12);
    }
}
