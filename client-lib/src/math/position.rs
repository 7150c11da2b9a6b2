//! Positions: a cell id and a frame local to that cell's landblock (`spec/01`, section 11).

use super::cell_id::{CellId, block_offset};
use super::frame::Frame;
use super::heading::heading_of_position_offset;
use super::{Quat, Vec3};
use crate::profile::{CylinderDistance, Profile, Width};

/// A place in the world. The frame's origin (m) is local to the landblock of `cell`, indoors as well as outdoors; z is absolute.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Position {
    /// Cell, or [`CellId::NONE`].
    pub cell: CellId,
    /// Origin and rotation in landblock coordinates.
    pub frame: Frame,
}

/// One of two upright cylinders whose distance is asked for.
#[derive(Debug, Clone, Copy)]
pub struct UprightCylinder<'a> {
    /// Radius, m.
    pub radius: f32,
    /// Height, m.
    pub height: f32,
    /// Middle of its bottom.
    pub position: &'a Position,
}

impl Position {
    /// A position from its parts; the rotation is taken as it is.
    pub fn new(cell: CellId, origin: Vec3, rotation: Quat) -> Self {
        Self {
            cell,
            frame: Frame::new(origin, rotation),
        }
    }

    /// Vector (m, global axes) from this position to `p`, across landblocks.
    #[inline]
    pub fn offset_to(&self, p: &Self) -> Vec3 {
        block_offset(self.cell, p.cell) + p.frame.origin - self.frame.origin
    }

    /// Vector (m, global axes) from this position to the point `local` of `p`'s own space.
    pub fn offset_to_point(&self, p: &Self, local: Vec3, profile: &Profile) -> Vec3 {
        block_offset(self.cell, p.cell) + p.frame.local_to_global(local, profile)
            - self.frame.origin
    }

    /// Distance to `p`, m.
    pub fn distance(&self, p: &Self) -> f32 {
        self.offset_to(p).length()
    }

    /// Squared distance to `p`, m².
    pub fn distance_squared(&self, p: &Self) -> f32 {
        self.offset_to(p).length_squared()
    }

    /// Compass heading from here to `p`, degrees; 0 when `p` is straight above or below.
    pub fn heading_to(&self, p: &Self, profile: &Profile) -> f32 {
        heading_of_position_offset(self.offset_to(p), profile)
    }

    /// Heading to `p` minus the own heading: degrees in (−360, 360), not wrapped.
    pub fn heading_diff(&self, p: &Self, profile: &Profile) -> f32 {
        self.heading_to(p, profile) - self.frame.heading(profile)
    }

    /// Puts a point that may have left its block into the right outdoor cell; `false` (and no cell) off the map.
    pub fn adjust_to_outside(&mut self, profile: &Profile) -> bool {
        let (cell, origin) = self.cell.adjust_to_outside(self.frame.origin, profile);
        self.cell = cell;
        self.frame.origin = origin;
        !cell.is_none()
    }

    /// Id of the outdoor cell at this place; [`CellId::NONE`] off the map.
    pub fn outside_cell(&self, profile: &Profile) -> CellId {
        self.cell.adjust_to_outside(self.frame.origin, profile).0
    }

    /// The point `p` of `from`'s own space in the coordinates of **this position's landblock** (this frame does not matter).
    #[inline]
    pub fn landblock_point_of(&self, from: &Self, p: Vec3, profile: &Profile) -> Vec3 {
        block_offset(self.cell, from.cell) + from.frame.local_to_global(p, profile)
    }

    /// The point `p` of `from`'s own space in this position's own space.
    #[inline]
    pub fn local_to_local(&self, from: &Self, p: Vec3, profile: &Profile) -> Vec3 {
        self.frame
            .global_to_local(self.landblock_point_of(from, p, profile), profile)
    }

    /// This position as seen from `base`, across landblocks (`subtract2`).
    pub fn relative_to(&self, base: &Self, profile: &Profile) -> Frame {
        let mut frame = self.frame.relative_to(&base.frame, profile);
        frame.origin = base.local_to_local(self, Vec3::ZERO, profile);
        frame
    }

    /// Whether cells are the same and frames equal within ε. The same place written in two blocks is not equal.
    pub fn is_equal(&self, p: &Self, profile: &Profile) -> bool {
        self.cell == p.cell && self.frame.is_equal(&p.frame, profile)
    }

    /// Where `p` lies as seen from here: High 1, Medium 2, Low 4, Left 8, Right 16, Front 32, Back 64, for an own height in m.
    pub fn quadrant_of(&self, height: f32, p: &Self, profile: &Profile) -> u32 {
        let hit = self.local_to_local(p, Vec3::ZERO, profile);
        let side = if hit.x < 0.0 { 0x08 } else { 0x10 };
        let front = if hit.y >= 0.0 { 0x20 } else { 0x40 };
        let (low, medium) = match profile.quadrant_thirds {
            Width::F32 => (hit.z < height * 1.0 / 3.0, hit.z < height * 2.0 / 3.0),
            Width::F64 => {
                let (z, h) = (f64::from(hit.z), f64::from(height));
                (z < h * 0.333333333, z < h * 0.66666667)
            }
        };
        let third = if low {
            0x04
        } else if medium {
            0x02
        } else {
            0x01
        };
        side | front | third
    }
}

impl UprightCylinder<'_> {
    /// Distance between two upright cylinders without regard to height, m; negative when they overlap.
    pub fn distance_no_z(&self, other: &Self) -> f32 {
        self.position.distance(other.position) - (self.radius + other.radius)
    }

    /// Distance between two upright cylinders, m (11.4; `01:P2`). The root is f64; callers that keep f32 narrow the result.
    pub fn distance(&self, other: &Self, profile: &Profile) -> f64 {
        let reach = self.distance_no_z(other);
        let (z1, z2) = (self.position.frame.origin.z, other.position.frame.origin.z);
        let gap = if z1 <= z2 {
            z2 - (z1 + self.height)
        } else {
            z1 - (z2 + other.height)
        };
        let root = f64::from(gap * gap + reach * reach).sqrt();
        match profile.cylinder_distance {
            _ if gap > 0.0 && reach > 0.0 => root,
            CylinderDistance::Reach if gap < 0.0 && reach < 0.0 => -root,
            CylinderDistance::Gap if gap > 0.0 => gap.into(),
            CylinderDistance::Gap if reach <= 0.0 => -root,
            _ => reach.into(),
        }
    }
}
