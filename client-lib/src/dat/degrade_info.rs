//! Degrade info: which shape stands for another at which distance, 0x11......; cosmetic. Source: `spec/11-dat-files.md, 9.10`.

use serde::Serialize;

use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// Levels of detail of a shape.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DegradeInfo {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Levels; level 0 is the one used for collision.
    pub levels: Vec<DegradeLevel>,
}

/// One level of detail.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DegradeLevel {
    /// Shape, 0x01......
    #[serde(serialize_with = "super::json::hex")]
    pub shape: u32,
    /// 1 none, 2 faces the viewer, 3 4 5 turns around the part's x y z axis towards the viewer.
    pub mode: u32,
    /// Metres.
    pub min_distance: f32,
    /// Metres.
    pub ideal_distance: f32,
    /// Metres.
    pub max_distance: f32,
}

impl Record for DegradeInfo {
    const KIND: RecordKind = RecordKind::DegradeInfo;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let n = r.count_u32("degrade levels", 20)?;
        let levels = r.many(n, |r| {
            Ok(DegradeLevel {
                shape: r.u32()?,
                mode: r.u32()?,
                min_distance: r.f32()?,
                ideal_distance: r.f32()?,
                max_distance: r.f32()?,
            })
        })?;
        Ok(Self { id, levels })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.count_u32("degrade levels", self.levels.len());
        for l in &self.levels {
            w.u32(l.shape);
            w.u32(l.mode);
            for v in [l.min_distance, l.ideal_distance, l.max_distance] {
                w.f32(v);
            }
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}
