//! A growing little-endian buffer with the packed primitives of the records.
//!
//! Source: `spec/11-dat-files.md, 4`. Writing never panics: the first thing that does not fit is kept and answered by
//! [`Writer::finish`].

use encoding_rs::WINDOWS_1252;

use super::cyl_sphere::CylSphere;
use super::error::{DatError, Problem};
use super::frame::StoredFrame;
use crate::math::{Plane, Quat, Sphere, Vec3};

/// Collects the bytes of one record.
#[derive(Debug, Default)]
pub struct Writer {
    out: Vec<u8>,
    failed: Option<(usize, Problem)>,
}

impl Writer {
    /// An empty record.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Bytes written so far.
    #[must_use]
    pub fn len(&self) -> usize {
        self.out.len()
    }

    /// True if nothing has been written.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.out.is_empty()
    }

    /// The bytes of record `id`.
    ///
    /// # Errors
    /// The first [`Problem::CannotEncode`] met while writing.
    pub fn finish(self, id: u32) -> Result<Vec<u8>, DatError> {
        match self.failed {
            None => Ok(self.out),
            Some((offset, problem)) => Err(DatError::in_record(
                "(new record)",
                id,
                offset as u64,
                problem,
            )),
        }
    }

    /// Remembers that something cannot be written.
    pub fn fail(&mut self, what: &'static str, found: u64, limit: u64) {
        let at = self.out.len();
        self.failed
            .get_or_insert((at, Problem::CannotEncode { what, found, limit }));
    }

    /// Fails if two lengths that must agree do not.
    pub fn same_len(&mut self, what: &'static str, found: usize, wanted: usize) {
        if found != wanted {
            self.fail(what, found as u64, wanted as u64);
        }
    }

    /// Raw bytes.
    pub fn bytes(&mut self, b: &[u8]) {
        self.out.extend_from_slice(b);
    }

    /// An unsigned byte.
    pub fn u8(&mut self, v: u8) {
        self.out.push(v);
    }

    /// An unsigned 16-bit number.
    pub fn u16(&mut self, v: u16) {
        self.bytes(&v.to_le_bytes());
    }

    /// A signed 16-bit number.
    pub fn i16(&mut self, v: i16) {
        self.bytes(&v.to_le_bytes());
    }

    /// An unsigned 32-bit number.
    pub fn u32(&mut self, v: u32) {
        self.bytes(&v.to_le_bytes());
    }

    /// A signed 32-bit number.
    pub fn i32(&mut self, v: i32) {
        self.bytes(&v.to_le_bytes());
    }

    /// A 32-bit float.
    pub fn f32(&mut self, v: f32) {
        self.bytes(&v.to_le_bytes());
    }

    /// A 64-bit float.
    pub fn f64(&mut self, v: f64) {
        self.bytes(&v.to_le_bytes());
    }

    /// Three floats x, y, z.
    pub fn vec3(&mut self, v: Vec3) {
        self.f32(v.x);
        self.f32(v.y);
        self.f32(v.z);
    }

    /// Four floats w, x, y, z.
    pub fn quat(&mut self, q: Quat) {
        self.f32(q.w);
        self.f32(q.x);
        self.f32(q.y);
        self.f32(q.z);
    }

    /// Origin, then orientation.
    pub fn frame(&mut self, f: &StoredFrame) {
        self.vec3(f.origin);
        self.quat(f.rotation);
    }

    /// Normal, then distance.
    pub fn plane(&mut self, p: &Plane) {
        self.vec3(p.n);
        self.f32(p.d);
    }

    /// Centre, then radius.
    pub fn sphere(&mut self, s: &Sphere) {
        self.vec3(s.center);
        self.f32(s.radius);
    }

    /// Low point, radius, height.
    pub fn cyl_sphere(&mut self, c: &CylSphere) {
        self.vec3(c.low);
        self.f32(c.radius);
        self.f32(c.height);
    }

    /// The shortest form of a number in 0..=0x3FFFFFFF.
    pub fn compressed_u32(&mut self, v: u32) {
        if v < 0x80 {
            self.u8(v as u8);
        } else if v < 0x4000 {
            self.u8(0x80 | (v >> 8) as u8);
            self.u8(v as u8);
        } else {
            if v > 0x3FFF_FFFF {
                self.fail("compressed number", u64::from(v), 0x3FFF_FFFF);
            }
            self.u8(0xC0 | (v >> 24) as u8);
            self.u8((v >> 16) as u8);
            self.u16(v as u16);
        }
    }

    /// A data id relative to the base of its type, in the shortest form.
    pub fn packed_did(&mut self, did: u32, base: u32) {
        let v = did.wrapping_sub(base);
        if v < 0x8000 {
            self.u16(v as u16);
        } else {
            if v > 0x3FFF_FFFF {
                self.fail("data id", u64::from(did), u64::from(base) + 0x3FFF_FFFF);
            }
            self.u16(0x8000 | (v >> 16) as u16);
            self.u16(v as u16);
        }
    }

    /// Legacy string with its alignment; the long form from 0xFFFF bytes on.
    pub fn pstring(&mut self, text: &str) {
        let bytes = self.windows_1252(text);
        match u16::try_from(bytes.len()) {
            Ok(n) if n != 0xFFFF => self.u16(n),
            _ => {
                self.u16(0xFFFF);
                self.count_u32("string bytes", bytes.len());
            }
        }
        self.bytes(&bytes);
        self.align4();
    }

    /// String with the two halves of every byte swapped, with its alignment.
    pub fn obfuscated_string(&mut self, text: &str) {
        let bytes = self.windows_1252(text);
        self.count_u16("string bytes", bytes.len());
        self.out.extend(bytes.iter().map(|b| b.rotate_left(4)));
        self.align4();
    }

    fn windows_1252(&mut self, text: &str) -> Vec<u8> {
        let (bytes, _, unmappable) = WINDOWS_1252.encode(text);
        if unmappable {
            self.fail("characters outside Windows-1252", text.len() as u64, 0);
        }
        bytes.into_owned()
    }

    /// Zero bytes up to the next multiple of four.
    pub fn align4(&mut self) {
        while self.out.len() & 3 != 0 {
            self.out.push(0);
        }
    }

    /// A length as a 32-bit count.
    pub fn count_u32(&mut self, what: &'static str, n: usize) {
        if n > u32::MAX as usize {
            self.fail(what, n as u64, u64::from(u32::MAX));
        }
        self.u32(n as u32);
    }

    /// A length as a signed 32-bit count.
    pub fn count_i32(&mut self, what: &'static str, n: usize) {
        if n > i32::MAX as usize {
            self.fail(what, n as u64, i32::MAX as u64);
        }
        self.i32(n as i32);
    }

    /// A length as a 16-bit count.
    pub fn count_u16(&mut self, what: &'static str, n: usize) {
        if n > usize::from(u16::MAX) {
            self.fail(what, n as u64, u64::from(u16::MAX));
        }
        self.u16(n as u16);
    }

    /// A length as an 8-bit count.
    pub fn count_u8(&mut self, what: &'static str, n: usize) {
        if n > usize::from(u8::MAX) {
            self.fail(what, n as u64, u64::from(u8::MAX));
        }
        self.u8(n as u8);
    }

    /// A length as a compressed count.
    pub fn count_compressed(&mut self, what: &'static str, n: usize) {
        if n > 0x3FFF_FFFF {
            self.fail(what, n as u64, 0x3FFF_FFFF);
        }
        self.compressed_u32((n & 0x3FFF_FFFF) as u32);
    }
}
