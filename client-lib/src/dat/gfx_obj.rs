//! Shape: polygons for collision and drawing, 0x01...... Source: `spec/11-dat-files.md, 9.1`.

use bitflags::bitflags;
use serde::Serialize;

use super::bsp::{DrawingBsp, DrawingNode, PhysicsBsp, TreeLimits};

use super::kind::RecordKind;
use super::polygon::{PolygonLimits, PolygonSet};
use super::reader::{Read, Reader};
use super::record::Record;
use super::vertex::VertexArray;
use super::writer::Writer;
use crate::math::{Sphere, Vec3};

bitflags! {
    /// Which parts a shape has.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct GfxObjFlags: u32 {
        /// Physics polygons and tree.
        const PHYSICS = 1;
        /// Drawing polygons and tree.
        const DRAWING = 2;
        /// Unknown; ignored.
        const UNKNOWN = 4;
        /// Degrade info.
        const DEGRADE = 8;
    }
}

/// A shape, in its own space.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GfxObj {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Which parts are stored.
    pub flags: GfxObjFlags,
    /// Surfaces, 0x08......
    #[serde(serialize_with = "super::json::hex_list")]
    pub surfaces: Vec<u32>,
    /// Vertices of both polygon lists.
    pub vertices: VertexArray,
    /// Collision; stored iff [`GfxObjFlags::PHYSICS`].
    pub physics: Option<PhysicsShape>,
    /// Point by which transparent parts are sorted.
    pub sort_center: Vec3,
    /// Drawing; stored iff [`GfxObjFlags::DRAWING`].
    pub drawing: Option<DrawingShape>,
    /// Degrade info, 0x11......, 0 if not stored.
    #[serde(serialize_with = "super::json::hex")]
    pub degrade: u32,
}

/// Collision polygons and their tree.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PhysicsShape {
    /// Polygons; matter is behind them.
    pub polygons: PolygonSet,
    /// Solid-leaf tree over them.
    pub bsp: PhysicsBsp,
}

/// Drawing polygons and their tree.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct DrawingShape {
    /// Polygons.
    pub polygons: PolygonSet,
    /// Tree over them.
    pub bsp: DrawingBsp,
}

impl GfxObj {
    /// Physics sphere: that of the physics tree's root.
    #[must_use]
    pub fn physics_sphere(&self) -> Option<Sphere> {
        Some(self.physics.as_ref()?.bsp.root()?.sphere())
    }

    /// Drawing sphere: that of the drawing tree's root; none if that is a leaf.
    #[must_use]
    pub fn drawing_sphere(&self) -> Option<Sphere> {
        match self.drawing.as_ref()?.bsp.root()? {
            DrawingNode::Inner(n) => Some(n.sphere),
            DrawingNode::Leaf(_) => None,
        }
    }
}

impl Record for GfxObj {
    const KIND: RecordKind = RecordKind::GfxObj;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let flags = GfxObjFlags::from_bits_retain(r.u32()?);
        let n = r.count_compressed("surfaces", 4)?;
        let surfaces = r.many(n, Reader::u32)?;
        let vertices = VertexArray::parse(r)?;
        let mut physics = None;
        if flags.contains(GfxObjFlags::PHYSICS) {
            let n = r.count_compressed("physics polygons", PolygonSet::LEAST)?;
            let polygons = PolygonSet::parse(
                r,
                n,
                PolygonLimits {
                    vertices: &vertices,
                    surfaces: None,
                },
            )?;
            let bsp = PhysicsBsp::parse(
                r,
                TreeLimits {
                    polygons: polygons.len(),
                },
            )?;
            physics = Some(PhysicsShape { polygons, bsp });
        }
        let sort_center = r.vec3("sort centre")?;
        let mut drawing = None;
        if flags.contains(GfxObjFlags::DRAWING) {
            let n = r.count_compressed("drawing polygons", PolygonSet::LEAST)?;
            let polygons = PolygonSet::parse(
                r,
                n,
                PolygonLimits {
                    vertices: &vertices,
                    surfaces: Some(surfaces.len()),
                },
            )?;
            let bsp = DrawingBsp::parse(
                r,
                TreeLimits {
                    polygons: polygons.len(),
                },
            )?;
            drawing = Some(DrawingShape { polygons, bsp });
        }
        let degrade = if flags.contains(GfxObjFlags::DEGRADE) {
            r.u32()?
        } else {
            0
        };
        Ok(Self {
            id,
            flags,
            surfaces,
            vertices,
            physics,
            sort_center,
            drawing,
            degrade,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.same_len(
            "physics part without its flag",
            usize::from(self.flags.contains(GfxObjFlags::PHYSICS)),
            usize::from(self.physics.is_some()),
        );
        w.same_len(
            "drawing part without its flag",
            usize::from(self.flags.contains(GfxObjFlags::DRAWING)),
            usize::from(self.drawing.is_some()),
        );
        w.u32(self.id);
        w.u32(self.flags.bits());
        w.count_compressed("surfaces", self.surfaces.len());
        for &s in &self.surfaces {
            w.u32(s);
        }
        self.vertices.write(w);
        if let Some(p) = &self.physics {
            w.count_compressed("physics polygons", p.polygons.len());
            p.polygons.write(w);
            p.bsp.write(w);
        }
        w.vec3(self.sort_center);
        if let Some(d) = &self.drawing {
            w.count_compressed("drawing polygons", d.polygons.len());
            d.polygons.write(w);
            d.bsp.write(w);
        }
        if self.flags.contains(GfxObjFlags::DEGRADE) {
            w.u32(self.degrade);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}
