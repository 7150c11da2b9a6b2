//! Bounded reading and writing of the motion structures' wire forms: little endian, positions counted from the start of the message.

/// Why a motion structure could not be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// The message ends early.
    #[error("{wanted} bytes expected at offset {at}, {left} are left")]
    TooShort {
        /// Offset in the message, bytes.
        at: usize,
        /// Bytes wanted.
        wanted: usize,
        /// Bytes there are.
        left: usize,
    },
    /// A number that is no hold key.
    #[error("{value} at offset {at} is no hold key (0, 1 or 2)")]
    HoldKey {
        /// Offset in the message, bytes.
        at: usize,
        /// The number.
        value: u32,
    },
    /// A movement type that has no payload.
    #[error("{value} at offset {at} is no type of movement (0, 6, 7, 8 or 9)")]
    MovementType {
        /// Offset in the message, bytes.
        at: usize,
        /// The number.
        value: u8,
    },
}

/// Reads fields of a message from front to back.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    message: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// A reader at the start of `message`.
    pub const fn new(message: &'a [u8]) -> Self {
        Self { message, at: 0 }
    }

    /// A reader at an offset of `message`; alignment counts from the message's start.
    pub const fn at(message: &'a [u8], at: usize) -> Self {
        Self { message, at }
    }

    /// Offset of the next byte.
    pub const fn offset(&self) -> usize {
        self.at
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], WireError> {
        let rest = self.message.get(self.at..).unwrap_or_default();
        let bytes = rest.first_chunk::<N>().ok_or(WireError::TooShort {
            at: self.at,
            wanted: N,
            left: rest.len(),
        })?;
        self.at += N;
        Ok(*bytes)
    }

    /// One byte.
    pub fn u8(&mut self) -> Result<u8, WireError> {
        self.take().map(u8::from_le_bytes)
    }

    /// Two bytes.
    pub fn u16(&mut self) -> Result<u16, WireError> {
        self.take().map(u16::from_le_bytes)
    }

    /// Four bytes.
    pub fn u32(&mut self) -> Result<u32, WireError> {
        self.take().map(u32::from_le_bytes)
    }

    /// A float; every bit pattern is one.
    pub fn f32(&mut self) -> Result<f32, WireError> {
        self.take().map(f32::from_le_bytes)
    }

    /// Skips to the next multiple of 4. Padding that is missing at the end of the message is no error: nothing follows it.
    pub fn align(&mut self) {
        self.at = self
            .at
            .next_multiple_of(4)
            .min(self.message.len().max(self.at));
    }
}

/// Appends zero bytes up to the next multiple of 4.
pub fn pad(message: &mut Vec<u8>) {
    message.resize(message.len().next_multiple_of(4), 0);
}

pub(super) fn put_u16(message: &mut Vec<u8>, value: u16) {
    message.extend_from_slice(&value.to_le_bytes());
}

pub(super) fn put_u32(message: &mut Vec<u8>, value: u32) {
    message.extend_from_slice(&value.to_le_bytes());
}

pub(super) fn put_f32(message: &mut Vec<u8>, value: f32) {
    message.extend_from_slice(&value.to_le_bytes());
}
