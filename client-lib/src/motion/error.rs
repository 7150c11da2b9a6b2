//! Answers of the motion layer (`spec/08-motion.md`, 4.5). The numbers are those of the protocol's error messages.

/// Why a movement was refused or ended. `code` gives the protocol's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[repr(u32)]
pub enum MotionError {
    /// No movement manager, or no motion table.
    #[error("no motion table")]
    NoAnimationTable = 0x07,
    /// A back reference is missing.
    #[error("no physics object")]
    NoPhysicsObject = 0x08,
    /// A move-to without an interpreter.
    #[error("no motion interpreter")]
    NoMotionInterpreter = 0x0B,
    /// An action or a jump in the air.
    #[error("not on the ground")]
    NoContact = 0x24,
    /// A new movement replaced this one.
    #[error("interrupted")]
    ActionCancelled = 0x36,
    /// The target went away while it was followed.
    #[error("the target went away")]
    ObjectGone = 0x37,
    /// The target was never found.
    #[error("there is no target")]
    NoObject = 0x38,
    /// A teleport ended the movement.
    #[error("teleported")]
    Teleported = 0x3C,
    /// The fail distance was exceeded.
    #[error("charged too far")]
    TooFar = 0x3D,
    /// Not enough stamina; shown by the input layer.
    #[error("too tired")]
    StaminaTooLow = 0x3E,
    /// Crouching in a combat stance.
    #[error("can't crouch in combat")]
    CantCrouchInCombat = 0x3F,
    /// Sitting in a combat stance.
    #[error("can't sit in combat")]
    CantSitInCombat = 0x40,
    /// Lying down in a combat stance.
    #[error("can't lie down in combat")]
    CantLieDownInCombat = 0x41,
    /// An emote in a combat stance.
    #[error("can't emote in combat")]
    CantChatEmoteInCombat = 0x42,
    /// The motion table has no such motion.
    #[error("the motion table has no such motion")]
    NoMtableData = 0x43,
    /// An emote that needs standing; shown by the input layer.
    #[error("can't emote unless standing")]
    CantChatEmoteNotStanding = 0x44,
    /// Six actions wait already.
    #[error("too many actions")]
    TooManyActions = 0x45,
    /// Wrong type of movement, no parts, fully constrained, or no stamina.
    #[error("movement failed")]
    GeneralMovementFailure = 0x47,
    /// The posture forbids a jump.
    #[error("can't jump from this position")]
    CantJumpPosition = 0x48,
    /// Too much burden for a jump.
    #[error("too encumbered to jump")]
    CantJumpLoad = 0x49,
}

impl MotionError {
    /// The protocol's number, never 0.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The error of a protocol number; `None` for 0 and for numbers of other layers.
    pub const fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            0x07 => Self::NoAnimationTable,
            0x08 => Self::NoPhysicsObject,
            0x0B => Self::NoMotionInterpreter,
            0x24 => Self::NoContact,
            0x36 => Self::ActionCancelled,
            0x37 => Self::ObjectGone,
            0x38 => Self::NoObject,
            0x3C => Self::Teleported,
            0x3D => Self::TooFar,
            0x3E => Self::StaminaTooLow,
            0x3F => Self::CantCrouchInCombat,
            0x40 => Self::CantSitInCombat,
            0x41 => Self::CantLieDownInCombat,
            0x42 => Self::CantChatEmoteInCombat,
            0x43 => Self::NoMtableData,
            0x44 => Self::CantChatEmoteNotStanding,
            0x45 => Self::TooManyActions,
            0x47 => Self::GeneralMovementFailure,
            0x48 => Self::CantJumpPosition,
            0x49 => Self::CantJumpLoad,
            _ => return None,
        })
    }
}

/// Result of a request to the motion layer.
pub type MotionResult = Result<(), MotionError>;

/// The protocol's number of a result; 0 for success.
pub const fn code_of(result: MotionResult) -> u32 {
    match result {
        Ok(()) => 0,
        Err(error) => error.code(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_name_errors() {
        let named: Vec<u32> = (0..0x100)
            .filter(|&code| MotionError::from_code(code).is_some_and(|e| e.code() == code))
            .collect();
        assert_eq!(named.len(), 20);
        assert_eq!(MotionError::from_code(0), None);
        assert_eq!(code_of(Ok(())), 0);
        assert_eq!(code_of(Err(MotionError::NoMtableData)), 0x43);
    }
}
