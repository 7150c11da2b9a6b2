//! A static object of a landblock or room. Source: `spec/11-dat-files.md, 5.3`.

use serde::Serialize;

use super::frame::StoredFrame;
use super::reader::{Read, Reader};
use super::writer::Writer;

/// A static object: what and where, in **landblock** coordinates, also inside rooms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stab {
    /// Shape (0x01......) or setup (0x02......).
    #[serde(serialize_with = "super::json::hex")]
    pub model: u32,
    /// Place in landblock coordinates, metres.
    pub frame: StoredFrame,
}

impl Stab {
    /// Bytes of a stab.
    pub const LEAST: usize = 32;

    pub(super) fn parse(r: &mut Reader<'_>) -> Read<Self> {
        Ok(Self {
            model: r.u32()?,
            frame: r.frame()?,
        })
    }

    pub(super) fn write(&self, w: &mut Writer) {
        w.u32(self.model);
        w.frame(&self.frame);
    }
}
