//! Room: where a room structure stands and what its openings lead to, id 0xXXYY0100..=0xXXYYFFFD of the cell file.
//! Source: `spec/11-dat-files.md, 8.3`.

use bitflags::bitflags;
use serde::Serialize;

use super::error::Problem;
use super::frame::StoredFrame;
use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::stab::Stab;
use super::writer::Writer;

bitflags! {
    /// Flags of a room.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct EnvCellFlags: u32 {
        /// The outdoors can be seen from here.
        const SEEN_OUTSIDE = 1;
        /// Static objects follow.
        const STATICS = 2;
        /// A restriction object follows.
        const RESTRICTION = 8;
    }
}

bitflags! {
    /// Flags of an opening.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct PortalFlags: u16 {
        /// The two polygons cover each other.
        const EXACT_MATCH = 1;
        /// **Set**: the other side is behind the portal polygon (it faces into this room); clear: in front of it.
        const INVERTED_SIDE = 2;
        /// Leads outdoors.
        const OUTSIDE = 4;
    }
}

impl PortalFlags {
    /// Retail's "portal side": true if the other side of the opening is in front of the portal polygon. Stored inverted.
    #[must_use]
    pub fn portal_side(self) -> bool {
        !self.contains(Self::INVERTED_SIDE)
    }
}

/// An opening of a room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct CellPortal {
    /// Flags.
    pub flags: PortalFlags,
    /// Key among the structure's drawing polygons.
    pub polygon: u16,
    /// Low 16 bits of the room behind it, 0xFFFF the outdoors.
    pub other_room: u16,
    /// Number of the matching portal there, 0xFFFF if outdoors.
    pub other_portal: u16,
}

impl CellPortal {
    /// True if it leads outdoors: either mark counts (D-17).
    #[must_use]
    pub fn is_outside(&self) -> bool {
        self.other_room == 0xFFFF || self.flags.contains(PortalFlags::OUTSIDE)
    }
}

/// A room.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EnvCell {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Flags.
    pub flags: EnvCellFlags,
    /// Surfaces without the type's base; index = surface index of the structure's polygons. See [`EnvCell::surface_id`].
    pub surfaces: Vec<u16>,
    /// Environment without the type's base. See [`EnvCell::environment_id`].
    pub environment: u16,
    /// Key of the structure in that environment.
    pub structure: u16,
    /// Place in landblock coordinates.
    pub frame: StoredFrame,
    /// Openings, in the order of the structure's portal list.
    pub portals: Vec<CellPortal>,
    /// Visible rooms, low 16 bits.
    pub visible_rooms: Vec<u16>,
    /// Static objects, in landblock coordinates.
    pub statics: Vec<Stab>,
    /// Object that restricts access; 0 if not stored.
    pub restriction: u32,
}

impl EnvCell {
    /// Full id of the environment.
    #[must_use]
    pub fn environment_id(&self) -> u32 {
        0x0D00_0000 | u32::from(self.environment)
    }

    /// Full id of a surface.
    #[must_use]
    pub fn surface_id(&self, index: usize) -> Option<u32> {
        self.surfaces
            .get(index)
            .map(|&s| 0x0800_0000 | u32::from(s))
    }

    /// Full id of a room of the same landblock.
    #[must_use]
    pub fn room_id(&self, low: u16) -> u32 {
        self.id & 0xFFFF_0000 | u32::from(low)
    }

    /// The outdoors can be seen from here.
    #[must_use]
    pub fn seen_outside(&self) -> bool {
        self.flags.contains(EnvCellFlags::SEEN_OUTSIDE)
    }
}

impl Record for EnvCell {
    const KIND: RecordKind = RecordKind::EnvCell;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let flags = EnvCellFlags::from_bits_retain(r.u32()?);
        let again = r.u32()?;
        if again != id {
            r.deviation(4, Problem::OwnId { found: again })?;
        }
        let (ns, np, nv) = (r.u8()?, r.u8()?, r.u16()?);
        let n = r.fits("surfaces", u64::from(ns), 2)?;
        let surfaces = r.many(n, Reader::u16)?;
        let (environment, structure, frame) = (r.u16()?, r.u16()?, r.frame()?);
        let n = r.fits("portals", u64::from(np), 8)?;
        let portals = r.many(n, |r| {
            Ok(CellPortal {
                flags: PortalFlags::from_bits_retain(r.u16()?),
                polygon: r.u16()?,
                other_room: r.u16()?,
                other_portal: r.u16()?,
            })
        })?;
        let n = r.fits("visible rooms", u64::from(nv), 2)?;
        let visible_rooms = r.many(n, Reader::u16)?;
        let mut statics = Vec::new();
        if flags.contains(EnvCellFlags::STATICS) {
            let n = r.count_u32("static objects", Stab::LEAST)?;
            statics = r.many(n, Stab::parse)?;
        }
        let restriction = if flags.contains(EnvCellFlags::RESTRICTION) {
            r.u32()?
        } else {
            0
        };
        Ok(Self {
            id,
            flags,
            surfaces,
            environment,
            structure,
            frame,
            portals,
            visible_rooms,
            statics,
            restriction,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.flags.bits());
        w.u32(self.id);
        w.count_u8("surfaces", self.surfaces.len());
        w.count_u8("portals", self.portals.len());
        w.count_u16("visible rooms", self.visible_rooms.len());
        for &s in &self.surfaces {
            w.u16(s);
        }
        w.u16(self.environment);
        w.u16(self.structure);
        w.frame(&self.frame);
        for p in &self.portals {
            w.u16(p.flags.bits());
            w.u16(p.polygon);
            w.u16(p.other_room);
            w.u16(p.other_portal);
        }
        for &v in &self.visible_rooms {
            w.u16(v);
        }
        if self.flags.contains(EnvCellFlags::STATICS) {
            w.count_u32("static objects", self.statics.len());
            for s in &self.statics {
                s.write(w);
            }
        }
        if self.flags.contains(EnvCellFlags::RESTRICTION) {
            w.u32(self.restriction);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}
