//! The interpreted motion state: what the body does, in normalised commands (`spec/08-motion.md`, section 7).

use super::wire::{Reader, WireError, pad, put_f32, put_u16, put_u32};
use super::{Actions, Command, MovementParameters};

/// What the body does: no "left", no "backwards", but signed and scaled speeds. Retail: `InterpretedMotionState`.
#[derive(Debug, Clone, PartialEq)]
pub struct InterpretedMotionState {
    /// Stance.
    pub style: Command,
    /// Standing, walking, running, postures.
    pub forward_command: Command,
    /// Factor of the animation's rate, negative backwards.
    pub forward_speed: f32,
    /// [`Command::NONE`] or [`Command::SIDE_STEP_RIGHT`].
    pub sidestep_command: Command,
    /// Negative to the left.
    pub sidestep_speed: f32,
    /// [`Command::NONE`] or [`Command::TURN_RIGHT`].
    pub turn_command: Command,
    /// Negative to the left.
    pub turn_speed: f32,
    /// Waiting actions.
    pub actions: Actions,
}

impl Default for InterpretedMotionState {
    fn default() -> Self {
        Self {
            style: Command::NON_COMBAT,
            forward_command: Command::READY,
            forward_speed: 1.0,
            sidestep_command: Command::NONE,
            sidestep_speed: 1.0,
            turn_command: Command::NONE,
            turn_speed: 1.0,
            actions: Actions::default(),
        }
    }
}

impl InterpretedMotionState {
    /// Takes a motion into the state (7.2). A left turn or sidestep, which only a non-creature asks for, takes the forward axis.
    pub fn apply_motion(&mut self, command: Command, params: &MovementParameters) {
        if command == Command::TURN_RIGHT {
            self.turn_command = command;
            self.turn_speed = params.speed;
        } else if command == Command::SIDE_STEP_RIGHT {
            self.sidestep_command = command;
            self.sidestep_speed = params.speed;
        } else if command.is_sub_state() {
            self.forward_command = command;
            self.forward_speed = params.speed;
        } else if command.is_style() {
            self.forward_command = Command::READY;
            self.style = command;
        } else if command.is_action() {
            self.actions.add(params.action(command));
        }
    }

    /// Takes a motion out of the state (7.3).
    pub fn remove_motion(&mut self, command: Command) {
        if command == Command::TURN_RIGHT {
            self.turn_command = Command::NONE;
        } else if command == Command::SIDE_STEP_RIGHT {
            self.sidestep_command = Command::NONE;
        } else if command.is_sub_state() {
            if command == self.forward_command {
                self.forward_command = Command::READY;
                self.forward_speed = 1.0;
            }
        } else if command.is_style() && command == self.style {
            self.style = Command::NON_COMBAT;
        }
    }

    /// Copies everything but the actions (7.4).
    pub fn copy_movement_from(&mut self, other: &Self) {
        self.style = other.style;
        self.forward_command = other.forward_command;
        self.forward_speed = other.forward_speed;
        self.sidestep_command = other.sidestep_command;
        self.sidestep_speed = other.sidestep_speed;
        self.turn_command = other.turn_command;
        self.turn_speed = other.turn_speed;
    }

    /// Forward Ready at 1, no sidestep, no turn; everything else stays (8.13).
    pub(super) fn stop_completely(&mut self) {
        self.forward_command = Command::READY;
        self.forward_speed = 1.0;
        self.sidestep_command = Command::NONE;
        self.turn_command = Command::NONE;
    }

    /// Whether forward is Ready and there is neither sidestep nor turn.
    pub fn is_at_rest(&self) -> bool {
        self.forward_command == Command::READY
            && self.sidestep_command == Command::NONE
            && self.turn_command == Command::NONE
    }

    /// Appends the wire form (7.6), padded to a multiple of 4 bytes from the start of `message`.
    pub fn pack(&self, message: &mut Vec<u8>) {
        let commands = [
            (0x01, self.style, Command::NON_COMBAT),
            (0x02, self.forward_command, Command::READY),
            (0x08, self.sidestep_command, Command::NONE),
            (0x20, self.turn_command, Command::NONE),
        ];
        let speeds = [
            (0x04, self.forward_speed),
            (0x10, self.sidestep_speed),
            (0x40, self.turn_speed),
        ];
        let mut header = (self.actions.wire_len() as u32) << 7;
        for (bit, command, rest) in commands {
            header |= if command == rest { 0 } else { bit };
        }
        for (bit, speed) in speeds {
            header |= if speed == 1.0 { 0 } else { bit };
        }
        put_u32(message, header);
        for (bit, command, _) in commands {
            if header & bit != 0 {
                put_u16(message, command.index());
            }
        }
        for (bit, speed) in speeds {
            if header & bit != 0 {
                put_f32(message, speed);
            }
        }
        self.actions.pack(message);
        pad(message);
    }

    /// Reads the wire form (7.6); absent fields take their defaults.
    pub fn unpack(reader: &mut Reader<'_>) -> Result<Self, WireError> {
        let header = reader.u32()?;
        let mut state = Self::default();
        for (bit, command) in [
            (0x01, &mut state.style),
            (0x02, &mut state.forward_command),
            (0x08, &mut state.sidestep_command),
            (0x20, &mut state.turn_command),
        ] {
            if header & bit != 0 {
                *command = Command::from_index(reader.u16()?);
            }
        }
        for (bit, speed) in [
            (0x04, &mut state.forward_speed),
            (0x10, &mut state.sidestep_speed),
            (0x40, &mut state.turn_speed),
        ] {
            if header & bit != 0 {
                *speed = reader.f32()?;
            }
        }
        state.actions.unpack((header >> 7 & 31) as usize, reader)?;
        reader.align();
        Ok(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn apply_and_remove() {
        let mut state = InterpretedMotionState::default();
        let params = MovementParameters {
            speed: 2.0,
            ..MovementParameters::default()
        };
        state.apply_motion(Command::RUN_FORWARD, &params);
        state.apply_motion(Command::NON_COMBAT, &params);
        assert_eq!(state.forward_command, Command::READY);
        assert_eq!(state.forward_speed, 2.0);
        state.apply_motion(Command::TURN_LEFT, &params);
        assert_eq!(state.forward_command, Command::TURN_LEFT);
        state.remove_motion(Command::TURN_LEFT);
        assert_eq!(
            (state.forward_command, state.forward_speed),
            (Command::READY, 1.0)
        );
        assert!(state.is_at_rest());
    }

    #[test]
    fn commands_come_before_speeds() {
        let state = InterpretedMotionState {
            forward_command: Command::RUN_FORWARD,
            forward_speed: 1.5,
            turn_command: Command::TURN_RIGHT,
            ..InterpretedMotionState::default()
        };
        let mut message = vec![0xEE; 4];
        state.pack(&mut message);
        assert_eq!(
            message[4..],
            [0x26, 0, 0, 0, 7, 0, 0x0D, 0, 0, 0, 0xC0, 0x3F]
        );
        let mut reader = Reader::at(&message, 4);
        assert_eq!(InterpretedMotionState::unpack(&mut reader), Ok(state));
        assert_eq!(reader.offset(), message.len());
    }

    #[test]
    fn padding_counts_from_the_message() {
        let state = InterpretedMotionState {
            sidestep_command: Command::SIDE_STEP_RIGHT,
            ..InterpretedMotionState::default()
        };
        let mut message = Vec::new();
        state.pack(&mut message);
        assert_eq!(message, [8, 0, 0, 0, 0x0F, 0, 0, 0]);
    }

    #[test]
    fn explicit_defaults_and_index_zero_are_read() {
        let message = [0x0B, 0, 0, 0, 0x3D, 0, 3, 0, 0, 0, 0, 0];
        let state = InterpretedMotionState::unpack(&mut Reader::new(&message)).unwrap();
        assert_eq!(state.style, Command::NON_COMBAT);
        assert_eq!(state.forward_command, Command::READY);
        assert_eq!(state.sidestep_command, Command::INVALID);
    }
}
