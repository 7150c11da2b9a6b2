//! Sound table: which waves stand for which sound slot, 0x20...... Source: `spec/11-dat-files.md, 9.10`.

use serde::Serialize;

use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// Sounds of a kind of object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SoundTable {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Hash key; without meaning.
    pub hash_key: u32,
    /// Default entries: a number and three floats.
    pub defaults: Vec<SoundChoice>,
    /// Bucket count of the list below; without meaning, kept for writing.
    pub buckets: u16,
    /// Sound slots.
    pub slots: Vec<SoundSlot>,
}

/// A wave and when it is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SoundChoice {
    /// Wave, 0x0A......
    #[serde(serialize_with = "super::json::hex")]
    pub wave: u32,
    /// Priority.
    pub priority: f32,
    /// Probability.
    pub probability: f32,
    /// Volume.
    pub volume: f32,
}

/// Waves of one sound slot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SoundSlot {
    /// Slot number.
    pub slot: u32,
    /// Waves.
    pub choices: Vec<SoundChoice>,
    /// Not known.
    pub unknown: u32,
}

impl Record for SoundTable {
    const KIND: RecordKind = RecordKind::SoundTable;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let (id, hash_key) = (r.own_id()?, r.u32()?);
        let n = r.count_u32("default sounds", 16)?;
        let defaults = r.many(n, choice)?;
        let m = r.u16()?;
        let buckets = r.u16()?;
        let m = r.fits("sound slots", u64::from(m), 12)?;
        let slots = r.many(m, |r| {
            let slot = r.u32()?;
            let k = r.count_u32("sounds", 16)?;
            Ok(SoundSlot {
                slot,
                choices: r.many(k, choice)?,
                unknown: r.u32()?,
            })
        })?;
        Ok(Self {
            id,
            hash_key,
            defaults,
            buckets,
            slots,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.hash_key);
        w.count_u32("default sounds", self.defaults.len());
        for c in &self.defaults {
            write_choice(w, c);
        }
        w.count_u16("sound slots", self.slots.len());
        w.u16(self.buckets);
        for s in &self.slots {
            w.u32(s.slot);
            w.count_u32("sounds", s.choices.len());
            for c in &s.choices {
                write_choice(w, c);
            }
            w.u32(s.unknown);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}

fn choice(r: &mut Reader<'_>) -> Read<SoundChoice> {
    Ok(SoundChoice {
        wave: r.u32()?,
        priority: r.f32()?,
        probability: r.f32()?,
        volume: r.f32()?,
    })
}

fn write_choice(w: &mut Writer, c: &SoundChoice) {
    w.u32(c.wave);
    for v in [c.priority, c.probability, c.volume] {
        w.f32(v);
    }
}
