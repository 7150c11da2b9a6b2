//! Shapes and room structures from polygon soups.

use std::collections::BTreeMap;

use glam::DVec3;

use super::mesh::{Axis, Face, Rect, rectangle, wall};
use super::tree::{DPlane, bounding_sphere, cell_tree, drawing_tree, physics_tree};
use crate::dat::{
    CellStruct, DrawingShape, GfxObj, GfxObjFlags, PhysicsShape, Polygon, PolygonSet, Sides,
    Stippling, VertexArray,
};
use crate::math::{Plane, Vec3};

/// Surface that all generated shapes use; the world builder writes it.
pub const SURFACE: u32 = 0x0800_0001;

/// One vertex per place, with the sum of the normals of the faces around it.
#[derive(Default)]
struct Vertices {
    keys: BTreeMap<[u32; 3], usize>,
    places: Vec<(Vec3, DVec3)>,
}

impl Vertices {
    fn key(&mut self, p: Vec3, normal: DVec3) -> u16 {
        let p = p + Vec3::ZERO;
        let next = self.places.len();
        let key = *self
            .keys
            .entry(p.to_array().map(f32::to_bits))
            .or_insert(next);
        if key == next {
            self.places.push((p, DVec3::ZERO));
        }
        self.places[key].1 += normal;
        key as u16
    }

    fn polygons(&mut self, faces: &[Face], uvs: bool) -> PolygonSet {
        let mut set = PolygonSet::default();
        for face in faces {
            let normal = DPlane::of(&face.corners()).stored().n.as_dvec3();
            let points: Vec<u16> = face.points.iter().map(|&p| self.key(p, normal)).collect();
            set.push(Polygon {
                key: 0,
                stippling: if uvs {
                    Stippling::empty()
                } else {
                    Stippling::NO_FRONT_UV
                },
                sides: Sides::FRONT,
                front_surface: face.surface,
                back_surface: -1,
                points: &points,
                front_uvs: &[],
                back_uvs: &[],
            });
        }
        set
    }

    fn array(&self) -> VertexArray {
        let mut array = VertexArray::default();
        for &(p, n) in &self.places {
            let normal = if n.length() > 1e-6 {
                n.normalize().as_vec3()
            } else {
                Vec3::Z
            };
            array.push(p, normal, &[[p.x / 4.0, p.y / 4.0]]);
        }
        array
    }
}

/// A shape: faces to collide with and faces to draw. `physics` faces look outwards, matter is behind them.
///
/// Without physics faces the shape has no physics tree, without drawing faces no drawing tree.
#[must_use]
pub fn shape(id: u32, physics: &[Face], drawing: &[Face]) -> GfxObj {
    let mut vertices = Vertices::default();
    let mut flags = GfxObjFlags::empty();
    let collision = (!physics.is_empty()).then(|| {
        flags |= GfxObjFlags::PHYSICS;
        PhysicsShape {
            polygons: vertices.polygons(physics, false),
            bsp: physics_tree(physics, &[]),
        }
    });
    let drawn = drawing_tree(drawing, 0).map(|(bsp, faces)| {
        flags |= GfxObjFlags::DRAWING;
        DrawingShape {
            polygons: vertices.polygons(&faces, true),
            bsp,
        }
    });
    let points = physics
        .iter()
        .chain(drawing)
        .flat_map(|f| f.points.iter().map(|p| p.as_dvec3()));
    let surfaces = physics
        .iter()
        .chain(drawing)
        .map(|f| f.surface.max(0) as usize + 1)
        .max()
        .unwrap_or(1);
    GfxObj {
        id,
        flags,
        surfaces: vec![SURFACE; surfaces],
        vertices: vertices.array(),
        physics: collision,
        sort_center: bounding_sphere(points).center,
        drawing: drawn,
        degrade: 0,
    }
}

/// A side of a box-shaped room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// -x.
    West,
    /// +x.
    East,
    /// -y.
    South,
    /// +y.
    North,
    /// -z.
    Floor,
    /// +z.
    Ceiling,
}

impl Side {
    /// All sides, in the order in which walls and planes are made.
    pub const ALL: [Self; 6] = [
        Self::West,
        Self::East,
        Self::South,
        Self::North,
        Self::Floor,
        Self::Ceiling,
    ];

    fn axis(self) -> Axis {
        match self {
            Self::West | Self::East => Axis::X,
            Self::South | Self::North => Axis::Y,
            Self::Floor | Self::Ceiling => Axis::Z,
        }
    }

    fn is_high(self) -> bool {
        matches!(self, Self::East | Self::North | Self::Ceiling)
    }
}

/// A box-shaped room: walls that face inwards, with rectangular doorways.
#[derive(Debug, Clone)]
pub struct Room {
    low: Vec3,
    high: Vec3,
    doors: Vec<(Side, Rect)>,
    leaf_end: bool,
}

impl Room {
    /// A closed room between two corners, in its own space.
    #[must_use]
    pub fn new(low: Vec3, high: Vec3) -> Self {
        Self {
            low,
            high,
            doors: Vec::new(),
            leaf_end: false,
        }
    }

    /// Adds a doorway. The rectangle is in the two axes other than the side's, in their order; portals are numbered as added.
    #[must_use]
    pub fn doorway(mut self, side: Side, rect: Rect) -> Self {
        self.doors.push((side, rect));
        self
    }

    /// Ends the cell tree with a LEAF: a sphere wholly inside is then reported as partially inside (`spec/11-dat-files.md, 6.3`).
    #[must_use]
    pub fn leaf_end(mut self) -> Self {
        self.leaf_end = true;
        self
    }

    /// Number of doorways.
    #[must_use]
    pub fn doorway_count(&self) -> usize {
        self.doors.len()
    }

    fn at(&self, side: Side) -> f32 {
        let corner = if side.is_high() { self.high } else { self.low };
        corner.to_array()[side.axis() as usize]
    }

    /// The room structure. Portal polygons come first among the drawing polygons, portal i is polygon i; they face out of the room.
    #[must_use]
    pub fn structure(&self) -> CellStruct {
        let (low, high) = (self.low.to_array(), self.high.to_array());
        let mut walls = Vec::new();
        for side in Side::ALL {
            let [i, j] = match side.axis() {
                Axis::X => [1, 2],
                Axis::Y => [0, 2],
                Axis::Z => [0, 1],
            };
            let rect = Rect {
                u: [low[i], high[i]],
                v: [low[j], high[j]],
            };
            let holes: Vec<Rect> = self
                .doors
                .iter()
                .filter(|d| d.0 == side)
                .map(|d| d.1)
                .collect();
            walls.extend(wall(
                side.axis(),
                self.at(side),
                rect,
                &holes,
                !side.is_high(),
            ));
        }
        let portals: Vec<Face> = self
            .doors
            .iter()
            .map(|&(s, rect)| rectangle(s.axis(), self.at(s), rect, s.is_high()))
            .collect();
        let openings: Vec<Face> = portals.iter().map(Face::flipped).collect();
        let planes: Vec<Plane> = Side::ALL.iter().map(|&s| self.inward_plane(s)).collect();
        structure(&walls, &portals, &openings, &planes, self.leaf_end)
    }

    fn inward_plane(&self, side: Side) -> Plane {
        let sign = if side.is_high() { -1.0 } else { 1.0 };
        let mut n = [0.0; 3];
        n[side.axis() as usize] = sign;
        Plane {
            n: n.into(),
            d: -sign * self.at(side) + 0.0,
        }
    }
}

/// A room structure of any convex room: walls that face inwards, portal polygons facing either way, the same portals facing inwards, and
/// the inward planes of the volume.
#[must_use]
pub fn structure(
    walls: &[Face],
    portals: &[Face],
    openings: &[Face],
    planes: &[Plane],
    leaf_end: bool,
) -> CellStruct {
    let mut vertices = Vertices::default();
    let (tree, drawn) = match drawing_tree(walls, portals.len() as u16) {
        Some((tree, faces)) => (Some(tree), faces),
        None => (None, Vec::new()),
    };
    let mut polygons = vertices.polygons(portals, false);
    for p in vertices.polygons(&drawn, true).iter() {
        polygons.push(p);
    }
    let physics_polygons = vertices.polygons(walls, false);
    CellStruct {
        vertices: vertices.array(),
        polygons,
        portals: (0..portals.len() as u16).collect(),
        cell_bsp: cell_tree(planes, leaf_end),
        physics_polygons,
        physics_bsp: physics_tree(walls, openings),
        drawing_bsp: tree,
    }
}
