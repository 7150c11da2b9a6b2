//! Wave: a sound, 0x0A...... Source: `spec/11-dat-files.md, 9.10`.

use serde::Serialize;

use super::error::Problem;
use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// A sound.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wave {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// A WAVEFORMATEX, without RIFF.
    pub header: Vec<u8>,
    /// Samples.
    pub samples: Vec<u8>,
}

impl Record for Wave {
    const KIND: RecordKind = RecordKind::Wave;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let (h, d) = (r.i32()?, r.i32()?);
        let size = |r: &Reader<'_>, what, n: i32| match u64::try_from(n) {
            Ok(n) => r.fits(what, n, 1),
            Err(_) => Err(r.error(Problem::NegativeCount { what, count: n })),
        };
        let h = size(r, "bytes of the wave header", h)?;
        let header = r.bytes(h)?.to_vec();
        let d = size(r, "bytes of samples", d)?;
        Ok(Self {
            id,
            header,
            samples: r.bytes(d)?.to_vec(),
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.count_i32("bytes of the wave header", self.header.len());
        w.count_i32("bytes of samples", self.samples.len());
        w.bytes(&self.header);
        w.bytes(&self.samples);
    }

    fn id(&self) -> u32 {
        self.id
    }
}
