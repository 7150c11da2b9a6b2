//! Bounded reading and writing of message fields: little endian, offsets counted from the opcode (`spec/10-messages.md`, 0 and 14).

use crate::motion::wire::WireError;

/// Why a field could not be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// The message ends early.
    #[error("{wanted} bytes wanted, {left} are left")]
    TooShort {
        /// Bytes wanted.
        wanted: usize,
        /// Bytes there are.
        left: usize,
    },
    /// A count that cannot be true.
    #[error(
        "{count} entries of at least {entry} bytes do not fit in the {left} bytes that are left"
    )]
    Count {
        /// Entries announced.
        count: usize,
        /// Least size of one, bytes.
        entry: usize,
        /// Bytes there are.
        left: usize,
    },
    /// A text with the escape length 0xFFFF, which nothing sends.
    #[error("a text with the length 0xFFFF")]
    TextLength,
    /// A marker has another value than its only one.
    #[error("{found:#x} where only {expected:#x} can be")]
    Marker {
        /// The only valid value.
        expected: u32,
        /// What is there.
        found: u32,
    },
    /// Presence bits without a layout: what follows cannot be found.
    #[error("unknown presence bits {0:#x}: what follows cannot be located")]
    UnknownFlags(u32),
    /// A motion structure.
    #[error("{0}")]
    Motion(WireError),
    /// Structures inside each other beyond the limit.
    #[error("structures are nested too deeply")]
    Depth,
}

/// A [`Problem`] and where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("at offset {offset}: {problem}")]
pub struct ReadError {
    /// Offset from the start of the message, bytes.
    pub offset: usize,
    /// What is wrong.
    pub problem: Problem,
}

/// Reads fields of a message from front to back. Every read is bounded by the message.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    message: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// A reader at the start of a message.
    pub const fn new(message: &'a [u8]) -> Self {
        Self { message, at: 0 }
    }

    /// Offset of the next byte from the start of the message.
    pub const fn offset(&self) -> usize {
        self.at
    }

    /// Bytes that are left.
    pub const fn left(&self) -> usize {
        self.message.len() - self.at
    }

    /// An error at the next byte.
    pub const fn error(&self, problem: Problem) -> ReadError {
        ReadError {
            offset: self.at,
            problem,
        }
    }

    /// The next `n` bytes.
    ///
    /// # Errors
    /// The message ends early.
    pub fn bytes(&mut self, n: usize) -> Result<&'a [u8], ReadError> {
        let rest = &self.message[self.at..];
        let bytes = rest.get(..n).ok_or(self.error(Problem::TooShort {
            wanted: n,
            left: rest.len(),
        }))?;
        self.at += n;
        Ok(bytes)
    }

    /// The next `N` bytes.
    ///
    /// # Errors
    /// The message ends early.
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], ReadError> {
        let mut out = [0; N];
        out.copy_from_slice(self.bytes(N)?);
        Ok(out)
    }

    /// Everything that is left.
    pub fn rest(&mut self) -> &'a [u8] {
        let rest = &self.message[self.at..];
        self.at = self.message.len();
        rest
    }

    /// Skips to the next multiple of 4 without looking; padding that is missing at the very end is no error.
    pub fn align(&mut self) {
        self.at = self.at.next_multiple_of(4).min(self.message.len());
    }

    /// Any value.
    ///
    /// # Errors
    /// The value's own.
    pub fn get<T: Wire>(&mut self) -> Result<T, ReadError> {
        T::read(self)
    }

    /// Checks an announced count against what is left, before anything is allocated.
    ///
    /// # Errors
    /// The entries cannot be there.
    pub fn count(&self, count: usize, entry: usize) -> Result<usize, ReadError> {
        let left = self.left();
        if count.checked_mul(entry.max(1)).is_none_or(|n| n > left) {
            return Err(self.error(Problem::Count { count, entry, left }));
        }
        Ok(count)
    }

    /// Runs a reader of the motion layer on this message, from here.
    ///
    /// # Errors
    /// The motion layer's, with its offset.
    pub fn motion<T>(
        &mut self,
        read: impl FnOnce(&mut crate::motion::wire::Reader<'a>) -> Result<T, WireError>,
    ) -> Result<T, ReadError> {
        let mut reader = crate::motion::wire::Reader::at(self.message, self.at);
        let value = read(&mut reader).map_err(|e| self.error(Problem::Motion(e)))?;
        self.at = reader.offset().min(self.message.len());
        Ok(value)
    }

    /// The bytes from an earlier offset up to here.
    pub fn since(&self, start: usize) -> &'a [u8] {
        self.message.get(start..self.at).unwrap_or_default()
    }
}

/// Collects the bytes of a message.
#[derive(Debug, Default)]
pub struct Writer {
    /// The bytes so far, from the opcode on.
    pub bytes: Vec<u8>,
}

impl Writer {
    /// Appends zero bytes up to the next multiple of 4.
    pub fn align(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    /// Appends bytes.
    pub fn put(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }
}

/// A value with one layout.
pub trait Wire: Sized {
    /// Least number of bytes that a value takes: bounds what a count may announce.
    const MIN: usize;

    /// Reads a value.
    ///
    /// # Errors
    /// Why the bytes are none.
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError>;

    /// Appends a value.
    fn write(&self, w: &mut Writer);
}

macro_rules! numbers {
    ($($t:ty),*) => {$(
        impl Wire for $t {
            const MIN: usize = size_of::<$t>();
            fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
                r.array().map(Self::from_le_bytes)
            }
            fn write(&self, w: &mut Writer) {
                w.put(&self.to_le_bytes());
            }
        }
    )*};
}

numbers!(u8, u16, u32, u64, i32, i64, f32, f64);

impl Wire for () {
    const MIN: usize = 0;
    fn read(_: &mut Reader<'_>) -> Result<Self, ReadError> {
        Ok(())
    }
    fn write(&self, _: &mut Writer) {}
}

impl<T: Wire + Copy + Default, const N: usize> Wire for [T; N] {
    const MIN: usize = T::MIN * N;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let mut out = [T::default(); N];
        for value in &mut out {
            *value = r.get()?;
        }
        Ok(out)
    }
    fn write(&self, w: &mut Writer) {
        self.iter().for_each(|value| value.write(w));
    }
}

impl<A: Wire, B: Wire> Wire for (A, B) {
    const MIN: usize = A::MIN + B::MIN;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        Ok((r.get()?, r.get()?))
    }
    fn write(&self, w: &mut Writer) {
        self.0.write(w);
        self.1.write(w);
    }
}

impl<T: Wire> Wire for Box<T> {
    const MIN: usize = T::MIN;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        T::read(r).map(Self::new)
    }
    fn write(&self, w: &mut Writer) {
        T::write(self, w);
    }
}

/// A structure whose fields follow each other; `=> align` after a field pads to the next multiple of 4.
macro_rules! wire_struct {
    ($($(#[$m:meta])* pub struct $name:ident {
        $( $(#[$fm:meta])* $f:ident : $t:ty $(=> $after:ident)? ),* $(,)?
    })*) => {$(
        $(#[$m])*
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct $name { $( $(#[$fm])* pub $f: $t, )* }

        impl $crate::net::messages::wire::Wire for $name {
            const MIN: usize = 0 $( + <$t as $crate::net::messages::wire::Wire>::MIN )*;
            fn read(
                r: &mut $crate::net::messages::wire::Reader<'_>,
            ) -> Result<Self, $crate::net::messages::wire::ReadError> {
                $( let $f = r.get::<$t>()?; $( r.$after(); )? )*
                Ok(Self { $($f),* })
            }
            fn write(&self, w: &mut $crate::net::messages::wire::Writer) {
                $( self.$f.write(w); $( w.$after(); )? )*
            }
        }
    )*};
}

/// Fields that are there if a bit of a word before them is set, in the order of the layout: `field: Type = word index, bit;`.
macro_rules! optional_fields {
    ($(#[$m:meta])* pub struct $name:ident {
        $( $(#[$fm:meta])* $f:ident : $t:ty = $word:literal, $bit:literal; )*
    }) => {
        $(#[$m])*
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct $name { $( $(#[$fm])* pub $f: Option<$t>, )* }

        impl $name {
            /// All bits that announce a field, by word.
            pub const KNOWN: [u32; 2] = {
                let mut known = [0u32; 2];
                $( known[$word] |= $bit; )*
                known
            };

            /// The bits of the fields that are there, by word.
            pub fn flags(&self) -> [u32; 2] {
                let mut flags = [0u32; 2];
                $( if self.$f.is_some() { flags[$word] |= $bit; } )*
                flags
            }

            /// Reads the fields that `flags` announces.
            ///
            /// # Errors
            /// Why a field could not be read.
            pub fn read_fields(
                flags: [u32; 2],
                r: &mut $crate::net::messages::wire::Reader<'_>,
            ) -> Result<Self, $crate::net::messages::wire::ReadError> {
                Ok(Self {
                    $( $f: if flags[$word] & $bit == 0 { None } else { Some(r.get::<$t>()?) }, )*
                })
            }

            /// Appends the fields that are there.
            pub fn write_fields(&self, w: &mut $crate::net::messages::wire::Writer) {
                $( if let Some(value) = &self.$f { value.write(w); } )*
            }
        }
    };
}

pub(super) use {optional_fields, wire_struct};
