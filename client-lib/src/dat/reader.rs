//! A bounded cursor over the bytes of one record.
//!
//! It knows the file, the record's id and the offset, so that every error can name them. All numbers are little-endian.
//! Source: `spec/11-dat-files.md, 2`, `4` and `12.3`.

use encoding_rs::WINDOWS_1252;

use super::cyl_sphere::CylSphere;
use super::error::{DatError, Problem};
use super::frame::StoredFrame;
use crate::math::{Plane, Quat, Sphere, Vec3};

/// How much a reader tolerates.
///
/// Both refuse what cannot be read safely; strict reading also refuses what the format does not allow but a client would survive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Strictness {
    /// Deviations that do not hinder reading become notes.
    #[default]
    Lenient,
    /// Every deviation is an error.
    Strict,
}

/// A deviation that a lenient reader passed over.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// Byte offset in the record.
    pub offset: usize,
    /// What it was.
    pub problem: Problem,
}

/// A cursor over one record's bytes.
#[derive(Debug)]
pub struct Reader<'a> {
    file: &'a str,
    id: u32,
    data: &'a [u8],
    at: usize,
    strictness: Strictness,
    notes: Vec<Note>,
}

/// `Result` of reading a part of a record.
pub type Read<T> = Result<T, DatError>;

impl<'a> Reader<'a> {
    /// A cursor at the start of `data`, the bytes of record `id` of `file`.
    #[must_use]
    pub fn new(file: &'a str, id: u32, data: &'a [u8], strictness: Strictness) -> Self {
        Self {
            file,
            id,
            data,
            at: 0,
            strictness,
            notes: Vec::new(),
        }
    }

    /// Id under which the record is stored.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.id
    }

    /// Bytes read so far.
    #[must_use]
    pub fn offset(&self) -> usize {
        self.at
    }

    /// Bytes not read yet.
    #[must_use]
    pub fn left(&self) -> usize {
        self.data.len() - self.at
    }

    /// How much is tolerated.
    #[must_use]
    pub fn strictness(&self) -> Strictness {
        self.strictness
    }

    /// Deviations passed over so far.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// Ends the reading and hands out the notes.
    #[must_use]
    pub fn into_notes(self) -> Vec<Note> {
        self.notes
    }

    /// An error at the present offset.
    #[must_use]
    pub fn error(&self, problem: Problem) -> DatError {
        self.error_at(self.at, problem)
    }

    /// An error at a given offset.
    #[must_use]
    pub fn error_at(&self, offset: usize, problem: Problem) -> DatError {
        DatError::in_record(self.file, self.id, offset as u64, problem)
    }

    /// An error when strict, a note otherwise. The offset is the present one less `back`.
    ///
    /// # Errors
    /// The problem, when strict.
    pub fn deviation(&mut self, back: usize, problem: Problem) -> Read<()> {
        let offset = self.at.saturating_sub(back);
        match self.strictness {
            Strictness::Strict => Err(self.error_at(offset, problem)),
            Strictness::Lenient => {
                // One damaged list can deviate at every element; the first few say enough.
                if self.notes.len() < 64 {
                    self.notes.push(Note { offset, problem });
                }
                Ok(())
            }
        }
    }

    /// The next `n` bytes.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`] if fewer are left.
    pub fn bytes(&mut self, n: usize) -> Read<&'a [u8]> {
        match self.data[self.at..].get(..n) {
            Some(part) => {
                self.at += n;
                Ok(part)
            }
            None => Err(self.error(Problem::EndOfRecord {
                wanted: n,
                left: self.left(),
            })),
        }
    }

    #[inline]
    fn array<const N: usize>(&mut self) -> Read<[u8; N]> {
        match self.data[self.at..].first_chunk::<N>() {
            Some(part) => {
                self.at += N;
                Ok(*part)
            }
            None => Err(self.error(Problem::EndOfRecord {
                wanted: N,
                left: self.left(),
            })),
        }
    }

    /// An unsigned byte.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    #[inline]
    pub fn u8(&mut self) -> Read<u8> {
        Ok(self.array::<1>()?[0])
    }

    /// An unsigned 16-bit number.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    #[inline]
    pub fn u16(&mut self) -> Read<u16> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    /// A signed 16-bit number.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    #[inline]
    pub fn i16(&mut self) -> Read<i16> {
        Ok(i16::from_le_bytes(self.array()?))
    }

    /// An unsigned 32-bit number.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    #[inline]
    pub fn u32(&mut self) -> Read<u32> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    /// A signed 32-bit number.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    #[inline]
    pub fn i32(&mut self) -> Read<i32> {
        Ok(i32::from_le_bytes(self.array()?))
    }

    /// A 32-bit float, any bits.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    #[inline]
    pub fn f32(&mut self) -> Read<f32> {
        Ok(f32::from_le_bytes(self.array()?))
    }

    /// A 64-bit float, any bits.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    #[inline]
    pub fn f64(&mut self) -> Read<f64> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    /// A 32-bit float that must be finite when strict; `what` names it.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::NotFinite`].
    #[inline]
    pub fn finite(&mut self, what: &'static str) -> Read<f32> {
        let v = self.f32()?;
        if !v.is_finite() {
            self.deviation(4, Problem::NotFinite { what })?;
        }
        Ok(v)
    }

    /// Three floats x, y, z; finite when strict.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::NotFinite`].
    #[inline]
    pub fn vec3(&mut self, what: &'static str) -> Read<Vec3> {
        let b: [u8; 12] = self.array()?;
        let v = Vec3::new(le(&b, 0), le(&b, 4), le(&b, 8));
        if !v.is_finite() {
            self.deviation(12, Problem::NotFinite { what })?;
        }
        Ok(v)
    }

    /// Four floats w, x, y, z; a unit quaternion when strict.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::NotUnit`].
    #[inline]
    pub fn quat(&mut self) -> Read<Quat> {
        let b: [u8; 16] = self.array()?;
        let q = Quat {
            w: le(&b, 0),
            x: le(&b, 4),
            y: le(&b, 8),
            z: le(&b, 12),
        };
        let norm_squared = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
        // Written so that not-a-number deviates as well.
        let unit = (norm_squared - 1.0).abs() <= 0.001;
        if !unit {
            self.deviation(16, Problem::NotUnit { norm_squared })?;
        }
        Ok(q)
    }

    /// Origin and orientation, 28 bytes.
    ///
    /// # Errors
    /// As [`Reader::vec3`] and [`Reader::quat`].
    #[inline]
    pub fn frame(&mut self) -> Read<StoredFrame> {
        Ok(StoredFrame {
            origin: self.vec3("origin")?,
            rotation: self.quat()?,
        })
    }

    /// Normal and distance, 16 bytes.
    ///
    /// # Errors
    /// As [`Reader::vec3`].
    #[inline]
    pub fn plane(&mut self) -> Read<Plane> {
        Ok(Plane {
            n: self.vec3("plane normal")?,
            d: self.finite("plane distance")?,
        })
    }

    /// Centre and radius, 16 bytes.
    ///
    /// # Errors
    /// As [`Reader::vec3`].
    #[inline]
    pub fn sphere(&mut self) -> Read<Sphere> {
        Ok(Sphere {
            center: self.vec3("sphere centre")?,
            radius: self.finite("sphere radius")?,
        })
    }

    /// Low point, radius, height (in this order on disk), 20 bytes.
    ///
    /// # Errors
    /// As [`Reader::vec3`].
    #[inline]
    pub fn cyl_sphere(&mut self) -> Read<CylSphere> {
        Ok(CylSphere {
            low: self.vec3("cylinder low point")?,
            radius: self.finite("cylinder radius")?,
            height: self.finite("cylinder height")?,
        })
    }

    /// The number of 1, 2 or 4 bytes that counts most lists of the portal file; 0..=0x3FFFFFFF. Any form is accepted.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    pub fn compressed_u32(&mut self) -> Read<u32> {
        let b0 = u32::from(self.u8()?);
        if b0 & 0x80 == 0 {
            return Ok(b0);
        }
        let b1 = u32::from(self.u8()?);
        if b0 & 0x40 == 0 {
            return Ok((b0 & 0x7F) << 8 | b1);
        }
        let low = u32::from(self.u16()?);
        Ok(((b0 & 0x3F) << 8 | b1) << 16 | low)
    }

    /// A data id relative to the base of its type (`0x01000000`...), 2 or 4 bytes.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`].
    pub fn packed_did(&mut self, base: u32) -> Read<u32> {
        let v = u32::from(self.u16()?);
        if v & 0x8000 == 0 {
            return Ok(base.wrapping_add(v));
        }
        let low = u32::from(self.u16()?);
        Ok(base.wrapping_add((v & 0x3FFF) << 16 | low))
    }

    /// Legacy string: 16-bit length (0xFFFF: a 32-bit one follows), Windows-1252 bytes, alignment.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::Padding`].
    pub fn pstring(&mut self) -> Read<String> {
        let short = self.u16()?;
        let n = if short == 0xFFFF {
            self.u32()? as usize
        } else {
            usize::from(short)
        };
        let text = WINDOWS_1252
            .decode_without_bom_handling(self.bytes(n)?)
            .0
            .into_owned();
        self.align4()?;
        Ok(text)
    }

    /// String with the two halves of every byte swapped: 16-bit length, bytes, alignment. No long form.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::Padding`].
    pub fn obfuscated_string(&mut self) -> Read<String> {
        let n = usize::from(self.u16()?);
        let plain: Vec<u8> = self.bytes(n)?.iter().map(|b| b.rotate_left(4)).collect();
        self.align4()?;
        Ok(WINDOWS_1252
            .decode_without_bom_handling(&plain)
            .0
            .into_owned())
    }

    /// Skips to the next multiple of four, counted from the start of the record. The bytes must be zero when strict.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::Padding`].
    pub fn align4(&mut self) -> Read<()> {
        let n = self.at.wrapping_neg() & 3;
        if self.bytes(n)?.iter().any(|&b| b != 0) {
            self.deviation(n, Problem::Padding)?;
        }
        Ok(())
    }

    /// Checks a count against the bytes that are left and answers it as a length.
    ///
    /// # Errors
    /// [`Problem::Count`] if `count` elements of at least `least` bytes cannot follow.
    pub fn fits(&self, what: &'static str, count: u64, least: usize) -> Read<usize> {
        let left = self.left();
        if count > (left / least.max(1)) as u64 {
            return Err(self.error(Problem::Count {
                what,
                count,
                least,
                left,
            }));
        }
        Ok(count as usize)
    }

    /// A 32-bit unsigned count, checked.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::Count`].
    pub fn count_u32(&mut self, what: &'static str, least: usize) -> Read<usize> {
        let n = self.u32()?;
        self.fits(what, u64::from(n), least)
    }

    /// A 32-bit signed count, checked.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::NegativeCount`], [`Problem::Count`].
    pub fn count_i32(&mut self, what: &'static str, least: usize) -> Read<usize> {
        let count = self.i32()?;
        match u64::try_from(count) {
            Ok(n) => self.fits(what, n, least),
            Err(_) => Err(self.error_at(self.at - 4, Problem::NegativeCount { what, count })),
        }
    }

    /// A 16-bit count, checked.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::Count`].
    pub fn count_u16(&mut self, what: &'static str, least: usize) -> Read<usize> {
        let n = self.u16()?;
        self.fits(what, u64::from(n), least)
    }

    /// An 8-bit count, checked.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::Count`].
    pub fn count_u8(&mut self, what: &'static str, least: usize) -> Read<usize> {
        let n = self.u8()?;
        self.fits(what, u64::from(n), least)
    }

    /// A compressed count, checked.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::Count`].
    pub fn count_compressed(&mut self, what: &'static str, least: usize) -> Read<usize> {
        let n = self.compressed_u32()?;
        self.fits(what, u64::from(n), least)
    }

    /// Exactly `n` elements in a row. `n` must have been checked by one of the counts.
    ///
    /// # Errors
    /// Those of `element`.
    pub fn many<T>(
        &mut self,
        n: usize,
        mut element: impl FnMut(&mut Self) -> Read<T>,
    ) -> Read<Vec<T>> {
        let mut list = Vec::with_capacity(n);
        for _ in 0..n {
            list.push(element(self)?);
        }
        Ok(list)
    }

    /// The record's own id in front of most records; must be the id it is stored under when strict. Answers the stored one.
    ///
    /// # Errors
    /// [`Problem::EndOfRecord`], [`Problem::OwnId`].
    pub fn own_id(&mut self) -> Read<u32> {
        let found = self.u32()?;
        if found != self.id {
            self.deviation(4, Problem::OwnId { found })?;
        }
        Ok(found)
    }

    /// Reports bytes that are left over.
    ///
    /// # Errors
    /// [`Problem::LeftOver`] when strict.
    pub fn finish(&mut self) -> Read<()> {
        match self.left() {
            0 => Ok(()),
            bytes => self.deviation(0, Problem::LeftOver { bytes }),
        }
    }
}

#[inline]
fn le(b: &[u8], at: usize) -> f32 {
    f32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]])
}
