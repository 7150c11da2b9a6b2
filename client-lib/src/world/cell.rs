//! Cells: outdoor squares of 24 m and indoor rooms (`spec/03-cells.md`, section 6).
//!
//! Everything is in metres; positions and frames are in the coordinates of the cell's landblock, polygons of a room in the room's own space.

use std::sync::Arc;

use super::room_volume::RoomVolume;
use super::terrain::WaterType;
use super::{CellHandle, World};
use crate::dat;
use crate::math::{CellId, Plane, Position, Vec3};
use crate::physics::body::{EntityId, ObjectRef, StaticId};
use crate::physics::collision::CellShape;

/// What all cells have: identity, and who is in or near them.
#[derive(Debug, Clone, Default)]
pub struct CellBase {
    /// Full id.
    pub id: CellId,
    /// Objects at home here.
    pub objects: Vec<ObjectRef>,
    /// Objects that must be tested here, in test order.
    pub shadows: Vec<ObjectRef>,
    /// GUID of the house barrier; 0 for none.
    pub restriction: u32,
}

/// An outdoor cell. Its two triangles are in the terrain of its block.
#[derive(Debug, Clone, Default)]
pub struct LandCell {
    /// Identity and contents.
    pub base: CellBase,
    /// The building that stands here.
    pub building: Option<StaticId>,
}

/// An indoor cell.
#[derive(Debug, Clone)]
pub struct EnvCell {
    /// Identity and contents.
    pub base: CellBase,
    /// Own id and frame.
    pub position: Position,
    /// Geometry, shared with all cells of the same kind. Empty if its record is missing: such a cell contains everything and stops nothing.
    pub shape: Arc<CellShape>,
    /// The volume of `shape` where the cell is.
    pub volume: RoomVolume,
    /// Openings in order.
    pub portals: Vec<CellPortal>,
    /// Indoor cells visible from here.
    pub stab_list: Vec<CellId>,
    /// The outdoors can be seen from here.
    pub seen_outside: bool,
    /// The static objects have been made (or are being made).
    pub statics_made: bool,
    /// Static objects of the record.
    pub statics: Vec<StaticId>,
    /// What the cell was made of.
    pub record: Arc<dat::EnvCell>,
}

/// Where a portal leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PortalTarget {
    /// Out into the open.
    Outside,
    /// Into an indoor cell of the same block, by full id.
    Cell(CellId),
}

/// An opening of an indoor cell.
#[derive(Debug, Clone, Copy)]
pub struct CellPortal {
    /// Polygons of both sides cover each other; not used by physics.
    pub exact_match: bool,
    /// Whether the neighbour lies on the positive side of the portal polygon's plane.
    pub portal_side: bool,
    /// Plane of the portal polygon, cell space.
    pub plane: Plane,
    /// Where it leads.
    pub target: PortalTarget,
    /// Index of the matching portal in the neighbour.
    pub other_portal: u16,
}

/// An opening of a building shell into an indoor cell.
#[derive(Debug, Clone)]
pub struct BuildingPortal {
    /// Polygons of both sides cover each other; not used by physics.
    pub exact_match: bool,
    /// As of a cell portal.
    pub portal_side: bool,
    /// The indoor cell behind it.
    pub other_cell: CellId,
    /// Index of the portal of that cell which leads outside; 0xFFFF for none.
    pub other_portal: u16,
    /// Cells visible through it.
    pub stab_list: Vec<CellId>,
}

/// A loaded cell of either kind.
#[derive(Debug, Clone, Copy)]
pub enum CellRef<'a> {
    /// Outdoors.
    Land(LandCellRef<'a>),
    /// Indoors.
    Env(&'a EnvCell),
}

/// An outdoor cell with the block that holds its terrain.
#[derive(Debug, Clone, Copy)]
pub struct LandCellRef<'a> {
    /// The block.
    pub block: &'a super::LandBlock,
    /// Index of the cell in the block, 0..64.
    pub index: usize,
    /// The cell.
    pub cell: &'a LandCell,
}

impl<'a> CellRef<'a> {
    /// Identity and contents.
    pub fn base(self) -> &'a CellBase {
        match self {
            Self::Land(land) => &land.cell.base,
            Self::Env(env) => &env.base,
        }
    }

    /// Full id.
    pub fn id(self) -> CellId {
        self.base().id
    }

    /// Whether this is an indoor cell.
    pub fn is_indoor(self) -> bool {
        matches!(self, Self::Env(_))
    }
}

impl World {
    /// The object of a GUID in a loaded cell, or, outdoors, in the rooms behind the portals of the cell's building (`get_object`, 8.3): the first
    /// in list order. Objects of the dat files have no GUID. Rooms that are not loaded hold nobody.
    pub fn object_in_cell(&self, cell: CellHandle, guid: u32) -> Option<EntityId> {
        if let Some(found) = self.at_home(cell, guid) {
            return Some(found);
        }
        let building = self.land.land_cell(cell)?.cell.building?;
        let portals = &self.land.static_object(building)?.portals;
        let mut visited = Vec::new();
        portals
            .iter()
            .find_map(|portal| self.object_behind(portal.other_cell, guid, &mut visited))
    }

    fn at_home(&self, cell: CellHandle, guid: u32) -> Option<EntityId> {
        let objects = &self.land.cell(cell)?.base().objects;
        objects.iter().find_map(|&object| match object {
            ObjectRef::Entity(id) => self.entity(id).filter(|e| e.guid() == guid).map(|e| e.id),
            ObjectRef::Static(_) => None,
        })
    }

    /// Depth first through the portals, each room once.
    fn object_behind(
        &self,
        room: CellId,
        guid: u32,
        visited: &mut Vec<CellId>,
    ) -> Option<EntityId> {
        let mut open = vec![room];
        while let Some(id) = open.pop() {
            if visited.contains(&id) {
                continue;
            }
            visited.push(id);
            let Some(cell) = self.land.loaded(id) else {
                continue;
            };
            if let Some(found) = self.at_home(cell, guid) {
                return Some(found);
            }
            let env = self.land.env_cell(cell);
            let next = env.into_iter().flat_map(|env| env.portals.iter().rev());
            open.extend(next.filter_map(|portal| match portal.target {
                PortalTarget::Cell(next) => Some(next),
                PortalTarget::Outside => None,
            }));
        }
        None
    }
}

impl LandCellRef<'_> {
    /// How much of the cell is water.
    pub fn water(&self) -> WaterType {
        self.block.terrain.cell_water(self.index)
    }

    /// Middle of the cell, block coordinates; z is 0.
    pub fn center(&self) -> Vec3 {
        let at = |i: usize| (2 * i + 1) as f32 * (crate::math::CELL_LENGTH / 2.0);
        Vec3::new(at(self.index / 8), at(self.index % 8), 0.0)
    }

    /// Own id, with the middle as origin.
    pub fn position(&self) -> Position {
        Position {
            cell: self.cell.base.id,
            frame: crate::math::Frame::new(self.center(), crate::math::Quat::IDENTITY),
        }
    }
}
