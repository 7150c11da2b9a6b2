//! Palette, 0x04......, and palette set, 0x0F...... Source: `spec/11-dat-files.md, 9.6, 9.10`.

use serde::Serialize;

use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// Colours of an indexed texture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Palette {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Colours 0xAARRGGBB; usually 2048 or 256.
    pub colors: Vec<u32>,
}

impl Record for Palette {
    const KIND: RecordKind = RecordKind::Palette;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let n = r.count_i32("colours", 4)?;
        Ok(Self {
            id,
            colors: r.many(n, Reader::u32)?,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.count_i32("colours", self.colors.len());
        for &c in &self.colors {
            w.u32(c);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}

/// Palettes from which a shade is chosen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaletteSet {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Palettes, 0x04......
    #[serde(serialize_with = "super::json::hex_list")]
    pub palettes: Vec<u32>,
}

impl Record for PaletteSet {
    const KIND: RecordKind = RecordKind::PaletteSet;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let n = r.count_i32("palettes", 4)?;
        Ok(Self {
            id,
            palettes: r.many(n, Reader::u32)?,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.count_i32("palettes", self.palettes.len());
        for &p in &self.palettes {
            w.u32(p);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}
