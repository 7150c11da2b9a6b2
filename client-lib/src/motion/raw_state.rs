//! The raw motion state: what the input wants, in its own terms (`spec/08-motion.md`, section 6).

use super::wire::{Reader, WireError, put_u32};
use super::{Action, Actions, Command, HoldKey, MovementFlags, MovementParameters};

/// One axis of the raw state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawAxis {
    /// What is wanted; for the forward axis never [`Command::RUN_FORWARD`] unless it came over the wire.
    pub command: Command,
    /// Invalid: as [`RawMotionState::current_hold_key`] says.
    pub hold_key: HoldKey,
    /// Factor of the animation's rate; 1 from the keyboard.
    pub speed: f32,
}

impl RawAxis {
    const fn resting(command: Command) -> Self {
        Self {
            command,
            hold_key: HoldKey::Invalid,
            speed: 1.0,
        }
    }
}

/// What the input wants. Retail: `RawMotionState`.
#[derive(Debug, Clone, PartialEq)]
pub struct RawMotionState {
    /// The walk/run modifier that axes without their own follow.
    pub current_hold_key: HoldKey,
    /// Stance.
    pub style: Command,
    /// Standing, walking, postures.
    pub forward: RawAxis,
    /// [`Command::NONE`] or a sidestep, either way.
    pub sidestep: RawAxis,
    /// [`Command::NONE`] or a turn, either way.
    pub turn: RawAxis,
    /// Waiting actions.
    pub actions: Actions,
}

impl Default for RawMotionState {
    fn default() -> Self {
        Self {
            current_hold_key: HoldKey::None,
            style: Command::NON_COMBAT,
            forward: RawAxis::resting(Command::READY),
            sidestep: RawAxis::resting(Command::NONE),
            turn: RawAxis::resting(Command::NONE),
            actions: Actions::default(),
        }
    }
}

impl RawMotionState {
    /// Takes a motion into the state (6.2).
    pub fn apply_motion(&mut self, command: Command, params: &MovementParameters) {
        let axis = RawAxis {
            command,
            hold_key: if params.has(MovementFlags::SET_HOLD_KEY) {
                HoldKey::Invalid
            } else {
                params.hold_key
            },
            speed: params.speed,
        };
        if command.is_turn() {
            self.turn = axis;
        } else if command.is_sidestep() {
            self.sidestep = axis;
        } else if command.is_sub_state() {
            if command != Command::RUN_FORWARD {
                self.forward = axis;
            }
        } else if command.is_style() {
            if self.style != command {
                self.forward.command = Command::READY;
                self.style = command;
            }
        } else if command.is_action() {
            self.actions.add(params.action(command));
        }
    }

    /// Takes a motion out of the state; either turn clears the turn axis, either sidestep the sidestep axis (6.3).
    pub fn remove_motion(&mut self, command: Command) {
        if command.is_turn() {
            self.turn.command = Command::NONE;
        } else if command.is_sidestep() {
            self.sidestep.command = Command::NONE;
        } else if command.is_sub_state() {
            if command == self.forward.command {
                self.forward.command = Command::READY;
                self.forward.speed = 1.0;
            }
        } else if command.is_style() && command == self.style {
            self.style = Command::NON_COMBAT;
        }
    }

    /// Forward Ready at 1, no sidestep, no turn; everything else stays (8.13).
    pub(super) fn stop_completely(&mut self) {
        self.forward.command = Command::READY;
        self.forward.speed = 1.0;
        self.sidestep.command = Command::NONE;
        self.turn.command = Command::NONE;
    }

    /// Appends the wire form (6.5). A current hold key of Invalid is not written and reads back as None.
    pub fn pack(&self, message: &mut Vec<u8>) {
        let header_at = message.len();
        put_u32(message, 0);
        let mut header = (self.actions.wire_len() as u32) << 11;
        let mut field = |bit: u32, written: bool, value: u32| {
            if written {
                header |= bit;
                put_u32(message, value);
            }
        };
        let key = self.current_hold_key;
        field(0x001, key != HoldKey::Invalid, key.code());
        field(0x002, self.style != Command::NON_COMBAT, self.style.0);
        let axes = [
            (self.forward, Command::READY),
            (self.sidestep, Command::NONE),
            (self.turn, Command::NONE),
        ];
        for (i, (axis, rest)) in axes.into_iter().enumerate() {
            let bit = 0x004 << (3 * i);
            field(bit, axis.command != rest, axis.command.0);
            field(
                bit << 1,
                axis.hold_key != HoldKey::Invalid,
                axis.hold_key.code(),
            );
            field(bit << 2, axis.speed != 1.0, axis.speed.to_bits());
        }
        message[header_at..header_at + 4].copy_from_slice(&header.to_le_bytes());
        self.actions.pack(message);
    }

    /// Reads the wire form (6.5): exactly the fields whose bit is set; the others take their defaults.
    pub fn unpack(reader: &mut Reader<'_>) -> Result<Self, WireError> {
        let header = reader.u32()?;
        let mut state = Self::default();
        if header & 0x001 != 0 {
            state.current_hold_key = HoldKey::read(reader)?;
        }
        if header & 0x002 != 0 {
            state.style = Command(reader.u32()?);
        }
        let axes = [&mut state.forward, &mut state.sidestep, &mut state.turn];
        for (i, axis) in axes.into_iter().enumerate() {
            let bit = 0x004 << (3 * i);
            if header & bit != 0 {
                axis.command = Command(reader.u32()?);
            }
            if header & (bit << 1) != 0 {
                axis.hold_key = HoldKey::read(reader)?;
            }
            if header & (bit << 2) != 0 {
                axis.speed = reader.f32()?;
            }
        }
        state.actions.unpack((header >> 11 & 31) as usize, reader)?;
        Ok(state)
    }
}

impl MovementParameters {
    /// The node that an action of these parameters leaves in a motion state.
    pub(super) fn action(&self, command: Command) -> Action {
        Action {
            command,
            speed: self.speed,
            stamp: self.action_stamp,
            autonomous: self.has(MovementFlags::AUTONOMOUS),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn apply_and_remove() {
        let mut raw = RawMotionState::default();
        let mut params = MovementParameters {
            speed: 2.0,
            hold_key: HoldKey::Run,
            ..MovementParameters::default()
        };
        raw.apply_motion(Command::TURN_LEFT, &params);
        assert_eq!(raw.turn.command, Command::TURN_LEFT);
        assert_eq!(raw.turn.hold_key, HoldKey::Invalid);
        params.flags.remove(MovementFlags::SET_HOLD_KEY);
        raw.apply_motion(Command::WALK_FORWARD, &params);
        assert_eq!(raw.forward.hold_key, HoldKey::Run);
        raw.apply_motion(Command::RUN_FORWARD, &params);
        assert_eq!(raw.forward.command, Command::WALK_FORWARD);
        raw.remove_motion(Command::TURN_RIGHT);
        assert_eq!((raw.turn.command, raw.turn.speed), (Command::NONE, 2.0));
        raw.apply_motion(Command::NON_COMBAT, &params);
        assert_eq!(raw.forward.command, Command::WALK_FORWARD);
        raw.apply_motion(Command::DUAL_WIELD_COMBAT, &params);
        assert_eq!(
            (raw.forward.command, raw.forward.speed),
            (Command::READY, 2.0)
        );
        raw.remove_motion(Command::DUAL_WIELD_COMBAT);
        assert_eq!(raw.style, Command::NON_COMBAT);
    }

    #[test]
    fn a_plain_state_writes_its_hold_key() {
        let mut message = Vec::new();
        RawMotionState::default().pack(&mut message);
        assert_eq!(message, [1, 0, 0, 0, 1, 0, 0, 0]);
        let truncated = RawMotionState::unpack(&mut Reader::new(&message[..6]));
        assert_eq!(
            truncated,
            Err(WireError::TooShort {
                at: 4,
                wanted: 4,
                left: 2
            })
        );
        message[4] = 3;
        let unknown = RawMotionState::unpack(&mut Reader::new(&message));
        assert_eq!(unknown, Err(WireError::HoldKey { at: 4, value: 3 }));
    }

    #[test]
    fn running_key_and_turn_in_order() {
        let mut raw = RawMotionState {
            current_hold_key: HoldKey::Run,
            ..RawMotionState::default()
        };
        raw.forward.command = Command::WALK_FORWARD;
        raw.turn = RawAxis {
            command: Command::TURN_LEFT,
            hold_key: HoldKey::None,
            speed: 1.5,
        };
        let mut message = Vec::new();
        raw.pack(&mut message);
        let words: Vec<u32> = message
            .chunks(4)
            .map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]))
            .collect();
        let expected = [0x705, 2, 0x4500_0005, 0x6500_000E, 1, 1.5f32.to_bits()];
        assert_eq!(words, expected);
        assert_eq!(RawMotionState::unpack(&mut Reader::new(&message)), Ok(raw));
    }
}
