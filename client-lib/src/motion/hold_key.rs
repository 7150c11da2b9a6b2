//! The walk/run modifier.

use super::wire::{Reader, WireError};

/// Whether the run key is held, as one axis of a motion sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u32)]
pub enum HoldKey {
    /// "Whatever holds at present."
    #[default]
    Invalid = 0,
    /// Walk.
    None = 1,
    /// Run.
    Run = 2,
}

impl HoldKey {
    /// The number on the wire.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// The hold key of a number; `None` for any but 0, 1, 2.
    pub const fn from_code(code: u32) -> Option<Self> {
        match code {
            0 => Some(Self::Invalid),
            1 => Some(Self::None),
            2 => Some(Self::Run),
            _ => None,
        }
    }

    /// [`Run`](Self::Run) or [`None`](Self::None).
    pub const fn running(run: bool) -> Self {
        if run { Self::Run } else { Self::None }
    }

    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, WireError> {
        let at = reader.offset();
        let value = reader.u32()?;
        Self::from_code(value).ok_or(WireError::HoldKey { at, value })
    }
}
