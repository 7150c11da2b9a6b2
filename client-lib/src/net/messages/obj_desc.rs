//! An object's appearance (`spec/10-messages.md`, 4.1).

use super::common::{PaletteDid, PartDid, TextureDid};
use super::wire::{Problem, ReadError, Reader, Wire, Writer, wire_struct};

wire_struct! {
    /// A range of a palette that another palette replaces; units of 8 colours, length 0 means 256 units.
    #[derive(Copy)]
    pub struct SubPalette {
        /// Palette.
        palette: PaletteDid,
        /// First unit.
        offset: u8,
        /// Units.
        length: u8,
    }

    /// A texture of a part that another texture replaces.
    #[derive(Copy)]
    pub struct TextureChange {
        /// Part index.
        part: u8,
        /// Texture that is replaced.
        old: TextureDid,
        /// Texture that replaces it.
        new: TextureDid,
    }

    /// A part that shows, and collides as, another shape.
    #[derive(Copy)]
    pub struct PartChange {
        /// Part index.
        part: u8,
        /// Shape.
        shape: PartDid,
    }
}

/// Palettes, textures and parts that differ from the setup's. At most 255 of each are sent.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObjDesc {
    /// Palette that the ranges are put into; present only with ranges.
    pub base_palette: PaletteDid,
    /// Ranges of palettes.
    pub palettes: Vec<SubPalette>,
    /// Textures.
    pub textures: Vec<TextureChange>,
    /// Shapes of parts.
    pub parts: Vec<PartChange>,
}

const MARKER: u8 = 0x11;

fn read_all<T: Wire>(n: u8, r: &mut Reader<'_>) -> Result<Vec<T>, ReadError> {
    let n = r.count(n.into(), T::MIN)?;
    (0..n).map(|_| r.get()).collect()
}

fn write_all<T: Wire>(list: &[T], w: &mut Writer) {
    list.iter().take(255).for_each(|e| e.write(w));
}

impl Wire for ObjDesc {
    const MIN: usize = 4;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let start = r.offset();
        let [marker, palettes, textures, parts] = r.get::<[u8; 4]>()?;
        if marker != MARKER {
            let problem = Problem::Marker {
                expected: MARKER.into(),
                found: marker.into(),
            };
            return Err(ReadError {
                offset: start,
                problem,
            });
        }
        let base_palette = if palettes > 0 {
            r.get()?
        } else {
            PaletteDid::default()
        };
        let desc = Self {
            base_palette,
            palettes: read_all(palettes, r)?,
            textures: read_all(textures, r)?,
            parts: read_all(parts, r)?,
        };
        r.align();
        Ok(desc)
    }

    fn write(&self, w: &mut Writer) {
        let count = |n: usize| n.min(255) as u8;
        w.put(&[
            MARKER,
            count(self.palettes.len()),
            count(self.textures.len()),
            count(self.parts.len()),
        ]);
        if !self.palettes.is_empty() {
            self.base_palette.write(w);
        }
        write_all(&self.palettes, w);
        write_all(&self.textures, w);
        write_all(&self.parts, w);
        w.align();
    }
}
