//! Environment: a set of room structures, 0x0D...... Source: `spec/11-dat-files.md, 9.5`.

use serde::Serialize;

use super::bsp::{CellBsp, DrawingBsp, PhysicsBsp, TreeLimits};
use super::error::Problem;
use super::kind::RecordKind;
use super::polygon::{PolygonLimits, PolygonSet};
use super::reader::{Read, Reader};
use super::record::Record;
use super::vertex::VertexArray;
use super::writer::Writer;

/// Room structures by key; keys count up from 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Environment {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Structures; the key is the position.
    pub structures: Vec<CellStruct>,
}

/// The shape of a room, in its own space.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct CellStruct {
    /// Vertices of both polygon lists.
    pub vertices: VertexArray,
    /// Drawing polygons, portals among them.
    pub polygons: PolygonSet,
    /// Keys of the portal polygons.
    pub portals: Vec<u16>,
    /// Volume: the intersection of half-spaces along the positive chain.
    pub cell_bsp: CellBsp,
    /// Collision polygons; they face into the room.
    pub physics_polygons: PolygonSet,
    /// Tree over the collision polygons.
    pub physics_bsp: PhysicsBsp,
    /// Tree over the drawing polygons.
    pub drawing_bsp: Option<DrawingBsp>,
}

impl Environment {
    /// The structure with this key.
    #[must_use]
    pub fn structure(&self, key: u16) -> Option<&CellStruct> {
        self.structures.get(usize::from(key))
    }
}

impl Record for Environment {
    const KIND: RecordKind = RecordKind::Environment;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let n = r.count_u32("room structures", 24)?;
        let mut structures = Vec::with_capacity(n);
        for i in 0..n {
            let found = r.u32()?;
            if found != i as u32 {
                return Err(r.error_at(
                    r.offset() - 4,
                    Problem::KeyOrder {
                        what: "room structure",
                        expected: i as u32,
                        found,
                    },
                ));
            }
            structures.push(CellStruct::parse(r)?);
        }
        Ok(Self { id, structures })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.count_u32("room structures", self.structures.len());
        for (key, s) in self.structures.iter().enumerate() {
            w.u32(key as u32);
            s.write(w);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}

impl CellStruct {
    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let drawing = r.count_u32("drawing polygons", PolygonSet::LEAST)?;
        let physics = r.count_u32("physics polygons", PolygonSet::LEAST)?;
        let portals = r.count_u32("portals", 2)?;
        let vertices = VertexArray::parse(r)?;
        // The surfaces of a room are in the record of the placed room; here any index may stand.
        let limits = PolygonLimits {
            vertices: &vertices,
            surfaces: None,
        };
        let n = r.fits("drawing polygons", drawing as u64, PolygonSet::LEAST)?;
        let polygons = PolygonSet::parse(r, n, limits)?;
        let n = r.fits("portals", portals as u64, 2)?;
        let portals = r.many(n, |r| match r.u16()? {
            key if usize::from(key) < polygons.len() => Ok(key),
            key => Err(r.error_at(
                r.offset() - 2,
                Problem::Index {
                    what: "portal polygon",
                    found: i64::from(key),
                    limit: polygons.len(),
                },
            )),
        })?;
        r.align4()?;
        let cell_bsp = CellBsp::parse(r, TreeLimits { polygons: 0 })?;
        let n = r.fits("physics polygons", physics as u64, PolygonSet::LEAST)?;
        let physics_polygons = PolygonSet::parse(r, n, limits)?;
        let physics_bsp = PhysicsBsp::parse(
            r,
            TreeLimits {
                polygons: physics_polygons.len(),
            },
        )?;
        let drawing_bsp = match r.u32()? {
            0 => None,
            _ => Some(DrawingBsp::parse(
                r,
                TreeLimits {
                    polygons: polygons.len(),
                },
            )?),
        };
        r.align4()?;
        Ok(Self {
            vertices,
            polygons,
            portals,
            cell_bsp,
            physics_polygons,
            physics_bsp,
            drawing_bsp,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.count_u32("drawing polygons", self.polygons.len());
        w.count_u32("physics polygons", self.physics_polygons.len());
        w.count_u32("portals", self.portals.len());
        self.vertices.write(w);
        self.polygons.write(w);
        for &p in &self.portals {
            w.u16(p);
        }
        w.align4();
        self.cell_bsp.write(w);
        self.physics_polygons.write(w);
        self.physics_bsp.write(w);
        w.u32(u32::from(self.drawing_bsp.is_some()));
        if let Some(tree) = &self.drawing_bsp {
            tree.write(w);
        }
        w.align4();
    }
}
