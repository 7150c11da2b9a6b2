//! Surface texture, 0x05......, and render surface, 0x06...... Source: `spec/11-dat-files.md, 9.7, 9.8`.

use serde::Serialize;

use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// A texture: render surfaces of falling quality. Render textures (0x15......) are laid out the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceTexture {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Data category.
    pub category: u32,
    /// 2: two-dimensional.
    pub kind: u8,
    /// Render surfaces, 0x06......, best first.
    #[serde(serialize_with = "super::json::hex_list")]
    pub surfaces: Vec<u32>,
}

impl Record for SurfaceTexture {
    const KIND: RecordKind = RecordKind::SurfaceTexture;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let (id, category, kind) = (r.own_id()?, r.u32()?, r.u8()?);
        let n = r.count_u32("render surfaces", 4)?;
        Ok(Self {
            id,
            category,
            kind,
            surfaces: r.many(n, Reader::u32)?,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.category);
        w.u8(self.kind);
        w.count_u32("render surfaces", self.surfaces.len());
        for &s in &self.surfaces {
            w.u32(s);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}

/// Pixel format of a render surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct PixelFormat(pub u32);

#[allow(missing_docs, reason = "named after the fields of the record")]
impl PixelFormat {
    pub const R8G8B8: Self = Self(0x14);
    pub const A8R8G8B8: Self = Self(0x15);
    pub const R5G6B5: Self = Self(0x17);
    pub const A4R4G4B4: Self = Self(0x1A);
    pub const A8: Self = Self(0x1C);
    pub const P8: Self = Self(0x29);
    pub const INDEX16: Self = Self(0x65);
    pub const LANDSCAPE_R8G8B8: Self = Self(0xF3);
    pub const LANDSCAPE_ALPHA: Self = Self(0xF4);
    pub const JPEG: Self = Self(0x1F4);
    pub const DXT1: Self = Self(0x3154_5844);
    pub const DXT3: Self = Self(0x3354_5844);
    pub const DXT5: Self = Self(0x3554_5844);
}

impl PixelFormat {
    /// Pixels are indices into a palette, whose id follows them.
    #[must_use]
    pub fn is_indexed(self) -> bool {
        self == Self::INDEX16 || self == Self::P8
    }
}

/// Pixels. Nobody checks their number against width and height: index with care.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RenderSurface {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Data category.
    pub category: u32,
    /// Width in pixels.
    pub width: i32,
    /// Height in pixels.
    pub height: i32,
    /// Format.
    pub format: PixelFormat,
    /// Pixels, in the format.
    pub pixels: Vec<u8>,
    /// Palette of an indexed format, 0x04......; 0 if not stored.
    #[serde(serialize_with = "super::json::hex")]
    pub palette: u32,
}

impl Record for RenderSurface {
    const KIND: RecordKind = RecordKind::RenderSurface;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let (id, category, width, height) = (r.own_id()?, r.u32()?, r.i32()?, r.i32()?);
        let format = PixelFormat(r.u32()?);
        let n = r.count_i32("bytes of pixels", 1)?;
        let pixels = r.bytes(n)?.to_vec();
        let palette = if format.is_indexed() { r.u32()? } else { 0 };
        Ok(Self {
            id,
            category,
            width,
            height,
            format,
            pixels,
            palette,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.category);
        w.i32(self.width);
        w.i32(self.height);
        w.u32(self.format.0);
        w.count_i32("bytes of pixels", self.pixels.len());
        w.bytes(&self.pixels);
        if self.format.is_indexed() {
            w.u32(self.palette);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}
