//! Landblock info: static objects, buildings and the number of rooms, id 0xXXYYFFFE of the cell file.
//! Source: `spec/11-dat-files.md, 8.2`.

use bitflags::bitflags;
use serde::Serialize;

use super::env_cell::PortalFlags;
use super::error::Problem;
use super::frame::StoredFrame;
use super::keyed::{KeyedList, keyed};
use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::stab::Stab;
use super::writer::Writer;

/// Most rooms a landblock can have: ids 0x0100..=0xFFFD.
pub const MAX_ROOMS: u32 = 0xFEFE;

bitflags! {
    /// Which tables follow the buildings.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct LandblockInfoMask: u16 {
        /// A restriction table follows.
        const RESTRICTIONS = 1;
        /// A table of room ids; never seen, not read by anyone.
        const ROOM_IDS = 2;
    }
}

/// Contents of a landblock.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LandblockInfo {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Number of rooms; their ids are 0x0100, 0x0101, ... without gaps.
    pub room_count: u32,
    /// Static objects outdoors.
    pub statics: Vec<Stab>,
    /// Buildings.
    pub buildings: Vec<Building>,
    /// Which tables are stored.
    pub mask: LandblockInfoMask,
    /// Houses: cell id to the object that restricts access.
    pub restrictions: KeyedList<u32, u32>,
    /// Bucket count of the restriction table; without meaning, kept for writing.
    pub restriction_buckets: u16,
}

/// A building: a shell outdoors and the openings to its rooms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Building {
    /// Shape or setup of the shell.
    #[serde(serialize_with = "super::json::hex")]
    pub model: u32,
    /// Place in landblock coordinates.
    pub frame: StoredFrame,
    /// Leaves of the shell's drawing tree.
    pub leaf_count: u32,
    /// Openings.
    pub portals: Vec<BuildingPortal>,
}

/// An opening of a building.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BuildingPortal {
    /// As of a room's portal.
    pub flags: PortalFlags,
    /// Room behind it, low 16 bits.
    pub room: u16,
    /// Number of that room's portal which leads outside, 0xFFFF none.
    pub room_portal: u16,
    /// Rooms visible through it, low 16 bits.
    pub visible_rooms: Vec<u16>,
}

impl Record for LandblockInfo {
    const KIND: RecordKind = RecordKind::LandblockInfo;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let room_count = r.u32()?;
        if room_count > MAX_ROOMS {
            return Err(r.error_at(
                r.offset() - 4,
                Problem::Value {
                    what: "number of rooms",
                    found: i64::from(room_count),
                    expected: "at most 65278",
                },
            ));
        }
        let n = r.count_u32("static objects", Stab::LEAST)?;
        let statics = r.many(n, Stab::parse)?;
        let n = r.u16()?;
        let mask = LandblockInfoMask::from_bits_retain(r.u16()?);
        let n = r.fits("buildings", u64::from(n), 40)?;
        let buildings = r.many(n, parse_building)?;
        let (mut restrictions, mut restriction_buckets) = (Vec::new(), 0);
        if mask.contains(LandblockInfoMask::RESTRICTIONS) {
            let n = r.u16()?;
            restriction_buckets = r.u16()?;
            let n = r.fits("restrictions", u64::from(n), 8)?;
            restrictions = r.many(n, |r| Ok((r.u32()?, r.u32()?)))?;
        }
        r.align4()?;
        let restrictions = keyed(r, "restriction", restrictions)?;
        Ok(Self {
            id,
            room_count,
            statics,
            buildings,
            mask,
            restrictions,
            restriction_buckets,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.room_count);
        w.count_u32("static objects", self.statics.len());
        for s in &self.statics {
            s.write(w);
        }
        w.count_u16("buildings", self.buildings.len());
        w.u16(self.mask.bits());
        for b in &self.buildings {
            write_building(w, b);
        }
        if self.mask.contains(LandblockInfoMask::RESTRICTIONS) {
            w.count_u16("restrictions", self.restrictions.len());
            w.u16(self.restriction_buckets);
            for (cell, object) in &self.restrictions {
                w.u32(*cell);
                w.u32(*object);
            }
        }
        w.align4();
    }

    fn id(&self) -> u32 {
        self.id
    }
}

fn parse_building(r: &mut Reader<'_>) -> Read<Building> {
    let (model, frame, leaf_count) = (r.u32()?, r.frame()?, r.u32()?);
    let n = r.count_u32("building portals", 8)?;
    Ok(Building {
        model,
        frame,
        leaf_count,
        portals: r.many(n, parse_portal)?,
    })
}

fn parse_portal(r: &mut Reader<'_>) -> Read<BuildingPortal> {
    let flags = PortalFlags::from_bits_retain(r.u16()?);
    let (room, room_portal) = (r.u16()?, r.u16()?);
    let n = r.count_u16("visible rooms", 2)?;
    let visible_rooms = r.many(n, Reader::u16)?;
    r.align4()?;
    Ok(BuildingPortal {
        flags,
        room,
        room_portal,
        visible_rooms,
    })
}

fn write_building(w: &mut Writer, b: &Building) {
    w.u32(b.model);
    w.frame(&b.frame);
    w.u32(b.leaf_count);
    w.count_u32("building portals", b.portals.len());
    for p in &b.portals {
        w.u16(p.flags.bits());
        w.u16(p.room);
        w.u16(p.room_portal);
        w.count_u16("visible rooms", p.visible_rooms.len());
        for &room in &p.visible_rooms {
            w.u16(room);
        }
        w.align4();
    }
}
