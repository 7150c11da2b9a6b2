//! Motion commands: 32-bit numbers whose top byte is a set of classes and whose low word is the index used on the wire.
//!
//! Source: `spec/08-motion.md`, section 4 and Appendix A.

use core::fmt;

use super::command_table::COMMANDS;

/// A motion command. Any number is a command; those of Appendix A have a [name](Self::name).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Command(pub u32);

macro_rules! commands {
    ($($(#[$doc:meta])* $name:ident = $value:literal;)*) => {
        impl Command { $($(#[$doc])* pub const $name: Self = Self($value);)* }
    };
}

commands! {
    /// No command: an axis that does nothing. Not the same as [`INVALID`](Self::INVALID).
    NONE = 0;
    /// What an unknown wire index means; a style.
    INVALID = 0x8000_0000;
    /// The run key.
    HOLD_RUN = 0x8500_0001;
    /// The "turns sidestep" key.
    HOLD_SIDESTEP = 0x8500_0002;
    /// Standing.
    READY = 0x4100_0003;
    /// Walking forward.
    WALK_FORWARD = 0x4500_0005;
    /// Walking backwards; only in the raw state.
    WALK_BACKWARDS = 0x4500_0006;
    /// Running; only in the interpreted state.
    RUN_FORWARD = 0x4400_0007;
    /// Lying after a fall.
    FALLEN = 0x4000_0008;
    /// Turning clockwise.
    TURN_RIGHT = 0x6500_000D;
    /// Turning counterclockwise; only in the raw state.
    TURN_LEFT = 0x6500_000E;
    /// Sidestepping to the right.
    SIDE_STEP_RIGHT = 0x6500_000F;
    /// Sidestepping to the left; only in the raw state.
    SIDE_STEP_LEFT = 0x6500_0010;
    /// Dead.
    DEAD = 0x4000_0011;
    /// Crouching.
    CROUCH = 0x4100_0012;
    /// Sitting.
    SITTING = 0x4100_0013;
    /// Sleeping.
    SLEEPING = 0x4100_0014;
    /// In the air.
    FALLING = 0x4000_0015;
    /// The jump key.
    JUMP = 0x2500_003B;
    /// Peace stance.
    NON_COMBAT = 0x8000_003D;
    /// Stance with a weapon in each hand.
    DUAL_WIELD_COMBAT = 0x8000_0046;
    /// The mouse turns the player.
    MOUSE_LOOK = 0x0C00_00C1;
    /// Running without a key.
    AUTO_RUN = 0x0900_00C7;
}

/// A stance.
pub const STYLE: u32 = 0x8000_0000;
/// A state that lasts.
pub const SUB_STATE: u32 = 0x4000_0000;
/// Overlays a substate.
pub const MODIFIER: u32 = 0x2000_0000;
/// Happens once, in the order of requests.
pub const ACTION: u32 = 0x1000_0000;
/// Never reaches the motion layer.
pub const UI: u32 = 0x0800_0000;
/// Lasts while its key is held.
pub const TOGGLE: u32 = 0x0400_0000;
/// An emote; refused in combat stances.
pub const CHAT_EMOTE: u32 = 0x0200_0000;
/// Can be bound to a key.
pub const MAPPABLE: u32 = 0x0100_0000;

impl Command {
    /// Whether any bit of `class` is set.
    pub const fn has(self, class: u32) -> bool {
        self.0 & class != 0
    }

    /// Whether this is a stance.
    pub const fn is_style(self) -> bool {
        self.has(STYLE)
    }

    /// Whether this is a state that lasts.
    pub const fn is_sub_state(self) -> bool {
        self.has(SUB_STATE)
    }

    /// Whether this happens once and is queued.
    pub const fn is_action(self) -> bool {
        self.has(ACTION)
    }

    /// Whether this is a turn, either way.
    pub const fn is_turn(self) -> bool {
        matches!(self, Self::TURN_RIGHT | Self::TURN_LEFT)
    }

    /// Whether this is a sidestep, either way.
    pub const fn is_sidestep(self) -> bool {
        matches!(self, Self::SIDE_STEP_RIGHT | Self::SIDE_STEP_LEFT)
    }

    /// Whether the number lies in a range, inclusive.
    pub const fn within(self, first: u32, last: u32) -> bool {
        self.0 >= first && self.0 <= last
    }

    /// The 16-bit form on the wire.
    pub const fn index(self) -> u16 {
        (self.0 & 0xFFFF) as u16
    }

    /// What a wire index means; [`INVALID`](Self::INVALID) for an unknown one.
    pub fn from_index(index: u16) -> Self {
        Self(COMMANDS.get(usize::from(index)).unwrap_or(&COMMANDS[0]).0)
    }

    /// What an index of the older numbering means: indices from 0x115 on were moved up by 3.
    pub fn from_old_index(index: u16) -> Self {
        Self::from_index(if index < 0x115 {
            index
        } else {
            index.saturating_add(3)
        })
    }

    /// The name in Appendix A; `None` for a number that is not in it.
    pub fn name(self) -> Option<&'static str> {
        COMMANDS
            .get(usize::from(self.index()))
            .filter(|(value, _)| *value == self.0)
            .map(|(_, name)| *name)
    }

    /// The command of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        COMMANDS
            .iter()
            .find(|(_, known)| *known == name)
            .map(|(value, _)| Self(*value))
    }

    /// Every command of Appendix A, in wire order.
    pub fn all() -> impl Iterator<Item = Self> {
        COMMANDS.iter().map(|(value, _)| Self(*value))
    }
}

impl fmt::Debug for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => write!(f, "{name}({:#010X})", self.0),
            None => write!(f, "{:#010X}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_low_word_is_the_index() {
        for (index, command) in Command::all().enumerate() {
            assert_eq!(usize::from(command.index()), index);
            assert_eq!(Command::from_index(command.index()), command);
            assert!(command.0 & 0x00FF_FFFF <= 0x19B);
        }
    }

    #[test]
    fn unknown_indices_are_the_invalid_style() {
        for index in [0, 412, 0xFFFF] {
            assert_eq!(Command::from_index(index), Command::INVALID);
        }
        assert!(Command::INVALID.is_style());
        assert_ne!(Command::INVALID, Command::NONE);
    }

    #[test]
    fn named_constants_are_in_the_table() {
        for (command, name) in [
            (Command::HOLD_RUN, "HoldRun"),
            (Command::READY, "Ready"),
            (Command::RUN_FORWARD, "RunForward"),
            (Command::FALLEN, "Fallen"),
            (Command::FALLING, "Falling"),
            (Command::JUMP, "Jump"),
            (Command::NON_COMBAT, "NonCombat"),
            (Command::DUAL_WIELD_COMBAT, "DualWieldCombat"),
            (Command::MOUSE_LOOK, "MouseLook"),
            (Command::AUTO_RUN, "AutoRun"),
        ] {
            assert_eq!(command.name(), Some(name));
            assert_eq!(Command::from_name(name), Some(command));
        }
        assert_eq!(Command(0x4100_0004).name(), None);
    }

    #[test]
    fn old_indices_move_up_by_three() {
        assert_eq!(Command::from_old_index(0x114), Command(0x0900_0114));
        assert_eq!(Command::from_old_index(0x115), Command(0x4300_0118));
        assert_eq!(Command::from_old_index(0xFFFF), Command::INVALID);
    }
}
