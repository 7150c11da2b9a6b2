//! Surface: how a polygon is drawn, 0x08......; the one record without an id of its own. Source: `spec/11-dat-files.md, 9.9`.

use bitflags::bitflags;
use serde::Serialize;

use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

bitflags! {
    /// Kind of a surface.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct SurfaceFlags: u32 {
        /// One colour.
        const SOLID = 0x1;
        /// A texture.
        const IMAGE = 0x2;
        /// A texture with holes.
        const CLIP_MAP = 0x4;
        /// Translucent.
        const TRANSLUCENT = 0x10;
        /// Diffuse factor is used.
        const DIFFUSE = 0x20;
        /// Shines by itself.
        const LUMINOUS = 0x40;
        /// Blended by alpha.
        const ALPHA = 0x100;
        /// Blended by inverse alpha.
        const INVERSE_ALPHA = 0x200;
        /// Added to what is behind.
        const ADDITIVE = 0x1_0000;
        /// Detail texture.
        const DETAIL = 0x2_0000;
        /// Shaded by vertex.
        const GOURAUD = 0x1000_0000;
        /// Stippled.
        const STIPPLED = 0x4000_0000;
        /// Perspective correction.
        const PERSPECTIVE = 0x8000_0000;
    }
}

/// What a surface shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum SurfaceFill {
    /// A texture, and the palette of an indexed one (0 none).
    Texture {
        /// Surface texture, 0x05......
        texture: u32,
        /// Palette, 0x04......
        palette: u32,
    },
    /// A colour 0xAARRGGBB.
    Color(u32),
}

/// A surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Surface {
    /// Id under which it is stored.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Kind; image or clip map go with a texture, all others with a colour.
    pub flags: SurfaceFlags,
    /// Texture or colour.
    pub fill: SurfaceFill,
    /// 0 opaque to 1.
    pub translucency: f32,
    /// Own light.
    pub luminosity: f32,
    /// Diffuse factor.
    pub diffuse: f32,
}

impl Record for Surface {
    const KIND: RecordKind = RecordKind::Surface;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let flags = SurfaceFlags::from_bits_retain(r.u32()?);
        let fill = if flags.intersects(SurfaceFlags::IMAGE | SurfaceFlags::CLIP_MAP) {
            SurfaceFill::Texture {
                texture: r.u32()?,
                palette: r.u32()?,
            }
        } else {
            SurfaceFill::Color(r.u32()?)
        };
        Ok(Self {
            id: r.id(),
            flags,
            fill,
            translucency: r.f32()?,
            luminosity: r.f32()?,
            diffuse: r.f32()?,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.flags.bits());
        let textured = self
            .flags
            .intersects(SurfaceFlags::IMAGE | SurfaceFlags::CLIP_MAP);
        w.same_len(
            "texture without its flag",
            usize::from(textured),
            usize::from(matches!(self.fill, SurfaceFill::Texture { .. })),
        );
        match self.fill {
            SurfaceFill::Texture { texture, palette } => {
                w.u32(texture);
                w.u32(palette);
            }
            SurfaceFill::Color(c) => w.u32(c),
        }
        w.f32(self.translucency);
        w.f32(self.luminosity);
        w.f32(self.diffuse);
    }

    fn id(&self) -> u32 {
        self.id
    }
}
