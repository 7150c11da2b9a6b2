//! Types that many messages share (`spec/10-messages.md`, 2).

use encoding_rs::WINDOWS_1252;

use super::wire::{Problem, ReadError, Reader, Wire, Writer, wire_struct};
use crate::math::{CellId, Position, Quat, Vec3};

/// A text as sent: code page 1252, at most 65534 bytes.
#[derive(Clone, PartialEq, Eq, Default)]
pub struct Text(pub Vec<u8>);

impl Text {
    /// A text of code page 1252; other characters become numeric references.
    pub fn new(text: &str) -> Self {
        let mut bytes = WINDOWS_1252.encode(text).0.into_owned();
        bytes.truncate(0xFFFE);
        Self(bytes)
    }

    /// The characters. Every byte string is a text.
    pub fn to_str(&self) -> std::borrow::Cow<'_, str> {
        WINDOWS_1252.decode_without_bom_handling(&self.0).0
    }
}

impl core::fmt::Debug for Text {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        core::fmt::Debug::fmt(&self.to_str(), f)
    }
}

impl Wire for Text {
    const MIN: usize = 2;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let start = r.offset();
        let n = usize::from(r.get::<u16>()?);
        if n == 0xFFFF {
            return Err(ReadError {
                offset: start,
                problem: Problem::TextLength,
            });
        }
        let text = r.bytes(n)?.to_vec();
        let padding = (2 + n).next_multiple_of(4) - (2 + n);
        r.bytes(padding.min(r.left()))?;
        Ok(Self(text))
    }

    fn write(&self, w: &mut Writer) {
        let n = self.0.len().min(0xFFFE);
        (n as u16).write(w);
        w.put(&self.0[..n]);
        let padding = (2 + n).next_multiple_of(4) - (2 + n);
        w.put(&[0; 3][..padding]);
    }
}

/// A text of UTF-16 code units, unpadded.
#[derive(Clone, PartialEq, Eq, Default)]
pub struct WideText(pub Vec<u16>);

impl WideText {
    /// A text.
    pub fn new(text: &str) -> Self {
        Self(text.encode_utf16().collect())
    }
}

impl core::fmt::Debug for WideText {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        core::fmt::Debug::fmt(&String::from_utf16_lossy(&self.0), f)
    }
}

impl Wire for WideText {
    const MIN: usize = 1;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let first = u32::from(r.get::<u8>()?);
        let n = if first < 0x80 {
            first
        } else {
            let second = u32::from(r.get::<u8>()?);
            if first & 0x40 == 0 {
                (first & 0x7F) << 8 | second
            } else {
                ((first & 0x3F) << 8 | second) << 16 | u32::from(r.get::<u16>()?)
            }
        };
        let n = r.count(n as usize, 2)?;
        let bytes = r.bytes(2 * n)?;
        Ok(Self(
            bytes
                .chunks_exact(2)
                .map(|c| u16::from_le_bytes([c[0], c[1]]))
                .collect(),
        ))
    }

    fn write(&self, w: &mut Writer) {
        let n = self.0.len().min(0x3FFF_FFFF);
        if n < 0x80 {
            w.put(&[n as u8]);
        } else if n < 0x4000 {
            w.put(&[0x80 | (n >> 8) as u8, n as u8]);
        } else {
            w.put(&[0xC0 | (n >> 24) as u8, (n >> 16) as u8]);
            (n as u16).write(w);
        }
        self.0[..n].iter().for_each(|c| c.write(w));
    }
}

fn read_packed(r: &mut Reader<'_>, mask: u32) -> Result<u32, ReadError> {
    let first = u32::from(r.get::<u16>()?);
    if first & 0x8000 == 0 {
        return Ok(first);
    }
    Ok((first & mask) << 16 | u32::from(r.get::<u16>()?))
}

fn write_packed(value: u32, w: &mut Writer) {
    if value > 0x7FFF {
        ((value >> 16) as u16 | 0x8000).write(w);
    }
    (value as u16).write(w);
}

/// A number of 31 bits in two or four bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PackedU32(pub u32);

impl Wire for PackedU32 {
    const MIN: usize = 2;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        read_packed(r, 0x7FFF).map(Self)
    }
    fn write(&self, w: &mut Writer) {
        write_packed(self.0, w);
    }
}

/// A data id of the type `T` (0x04000000 a palette, ...) in two or four bytes; 0 for none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PackedDid<const T: u32>(pub u32);

impl<const T: u32> PackedDid<T> {
    /// The data id, if there is one.
    pub const fn get(self) -> Option<u32> {
        if self.0 == 0 { None } else { Some(self.0) }
    }
}

impl<const T: u32> Wire for PackedDid<T> {
    const MIN: usize = 2;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let value = read_packed(r, 0x3FFF)?;
        Ok(Self(if value == 0 { 0 } else { value.wrapping_add(T) }))
    }
    fn write(&self, w: &mut Writer) {
        let value = if self.0 == 0 {
            0
        } else {
            self.0.wrapping_sub(T)
        };
        write_packed(value, w);
    }
}

/// Data id of a shape.
pub type PartDid = PackedDid<0x0100_0000>;
/// Data id of a palette.
pub type PaletteDid = PackedDid<0x0400_0000>;
/// Data id of a texture.
pub type TextureDid = PackedDid<0x0500_0000>;
/// Data id of an icon.
pub type IconDid = PackedDid<0x0600_0000>;

wire_struct! {
    /// A place with a rotation, as sent: origin in m, landblock coordinates; rotation w, x, y, z as received.
    #[derive(Copy)]
    pub struct WirePosition {
        /// Cell id.
        cell: u32,
        /// x, y, z, m.
        origin: [f32; 3],
        /// w, x, y, z.
        rotation: [f32; 4],
    }

    /// A place without rotation: landblock coordinates, m.
    #[derive(Copy)]
    pub struct Origin {
        /// Cell id.
        cell: u32,
        /// x, y, z, m.
        origin: [f32; 3],
    }
}

impl WirePosition {
    /// The place; the rotation is not normalised.
    pub fn to_position(self) -> Position {
        let [w, x, y, z] = self.rotation;
        Position::new(
            CellId(self.cell),
            Vec3::from_array(self.origin),
            Quat::new(w, x, y, z),
        )
    }

    /// As sent.
    pub fn of(position: &Position) -> Self {
        let q = position.frame.rotation();
        Self {
            cell: position.cell.0,
            origin: position.frame.origin.to_array(),
            rotation: [q.w, q.x, q.y, q.z],
        }
    }
}

/// A hash table: entries in the order of the message. The number of buckets is kept, and means nothing to a reader.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table<K, V> {
    /// Buckets of the sender.
    pub buckets: u16,
    /// Keys and values.
    pub entries: Vec<(K, V)>,
}

impl<K: Wire, V: Wire> Wire for Table<K, V> {
    const MIN: usize = 4;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let (count, buckets) = r.get::<(u16, u16)>()?;
        let n = r.count(count.into(), K::MIN + V::MIN)?;
        let mut entries = Vec::with_capacity(n);
        for _ in 0..n {
            entries.push(r.get()?);
        }
        Ok(Self { buckets, entries })
    }
    fn write(&self, w: &mut Writer) {
        let n = self.entries.len().min(0xFFFF);
        (n as u16).write(w);
        self.buckets.write(w);
        self.entries[..n].iter().for_each(|e| e.write(w));
    }
}

/// A list behind a 32-bit count.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct List<T>(pub Vec<T>);

impl<T: Wire> Wire for List<T> {
    const MIN: usize = 4;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let count = r.get::<u32>()? as usize;
        let n = r.count(count, T::MIN)?;
        let mut list = Vec::with_capacity(n);
        for _ in 0..n {
            list.push(r.get()?);
        }
        Ok(Self(list))
    }
    fn write(&self, w: &mut Writer) {
        (self.0.len() as u32).write(w);
        self.0.iter().for_each(|e| e.write(w));
    }
}

/// Everything up to the end of the message.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Rest(pub Vec<u8>);

impl Wire for Rest {
    const MIN: usize = 0;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        Ok(Self(r.rest().to_vec()))
    }
    fn write(&self, w: &mut Writer) {
        w.put(&self.0);
    }
}

/// A last field that some senders leave out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct IfLeft<T>(pub Option<T>);

impl<T: Wire> Wire for IfLeft<T> {
    const MIN: usize = 0;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        if r.left() < T::MIN {
            return Ok(Self(None));
        }
        r.get().map(Some).map(Self)
    }
    fn write(&self, w: &mut Writer) {
        if let Some(value) = &self.0 {
            value.write(w);
        }
    }
}
