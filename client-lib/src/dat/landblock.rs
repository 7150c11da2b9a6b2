//! Landblock: terrain words and height indices of 9 x 9 vertices, id 0xXXYYFFFF of the cell file.
//! Source: `spec/11-dat-files.md, 8.1`; meaning: `spec/02-terrain.md, 3`.

use serde::{Serialize, Serializer};

use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// Vertices along a side of a landblock.
pub const VERTICES: usize = 9;

/// Road, terrain type and scenery of one vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(transparent)]
pub struct TerrainWord(pub u16);

impl TerrainWord {
    /// Packs the three parts; each is cut to its width.
    #[must_use]
    pub fn new(road: u8, terrain: u8, scenery: u8) -> Self {
        Self(
            u16::from(road) & 0x3
                | (u16::from(terrain) & 0x1F) << 2
                | (u16::from(scenery) & 0x1F) << 11,
        )
    }

    /// Road code 0..=3, 0 none.
    #[must_use]
    pub fn road(self) -> u8 {
        (self.0 & 0x3) as u8
    }

    /// Terrain type 0..=31.
    #[must_use]
    pub fn terrain(self) -> u8 {
        (self.0 >> 2 & 0x1F) as u8
    }

    /// Scene type index 0..=31 within the terrain type.
    #[must_use]
    pub fn scenery(self) -> u8 {
        (self.0 >> 11) as u8
    }
}

/// Terrain of one landblock. Lists are indexed `9 x + y`, x east, y north.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Landblock {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Not 0: a landblock info record exists. Only 0 and 1 occur (D-19).
    pub has_info: u32,
    /// Terrain words.
    #[serde(serialize_with = "slice")]
    pub terrain: [TerrainWord; VERTICES * VERTICES],
    /// Indices into the region's height table.
    #[serde(serialize_with = "slice")]
    pub heights: [u8; VERTICES * VERTICES],
}

fn slice<T: Serialize, S: Serializer>(
    v: &[T; VERTICES * VERTICES],
    s: S,
) -> Result<S::Ok, S::Error> {
    s.collect_seq(v)
}

impl Landblock {
    /// Bytes of the record.
    pub const SIZE: usize = 252;

    /// Terrain word of vertex (x, y), each 0..=8.
    #[must_use]
    pub fn terrain_at(&self, x: usize, y: usize) -> Option<TerrainWord> {
        (x < VERTICES && y < VERTICES).then(|| self.terrain[VERTICES * x + y])
    }

    /// Height index of vertex (x, y), each 0..=8.
    #[must_use]
    pub fn height_at(&self, x: usize, y: usize) -> Option<u8> {
        (x < VERTICES && y < VERTICES).then(|| self.heights[VERTICES * x + y])
    }
}

impl Record for Landblock {
    const KIND: RecordKind = RecordKind::Landblock;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let has_info = r.u32()?;
        let mut terrain = [TerrainWord(0); VERTICES * VERTICES];
        for t in &mut terrain {
            *t = TerrainWord(r.u16()?);
        }
        let mut heights = [0; VERTICES * VERTICES];
        heights.copy_from_slice(r.bytes(VERTICES * VERTICES)?);
        r.align4()?;
        Ok(Self {
            id,
            has_info,
            terrain,
            heights,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.has_info);
        for t in &self.terrain {
            w.u16(t.0);
        }
        w.bytes(&self.heights);
        w.align4();
    }

    fn id(&self) -> u32 {
        self.id
    }
}
