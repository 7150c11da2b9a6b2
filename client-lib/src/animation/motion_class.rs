//! Class bits of a motion command; the low 24 bits are an index (`spec/07-animation.md`, 1.3). Several classes can be set.

/// A stance.
pub const STYLE: u32 = 0x8000_0000;
/// A continuous motion.
pub const SUBSTATE: u32 = 0x4000_0000;
/// A movement on top of a substate.
pub const MODIFIER: u32 = 0x2000_0000;
/// A one-shot motion.
pub const ACTION: u32 = 0x1000_0000;
/// Part that is no class.
pub const INDEX: u32 = 0x00FF_FFFF;

/// The command Ready: reported for every stop.
pub const READY: u32 = 0x4100_0003;

/// Whether a command has a class.
pub const fn has(motion: u32, class: u32) -> bool {
    motion & class != 0
}
