//! Builds trees over polygon soups. Source: `spec/11-dat-files.md, 6, 11`.

use glam::DVec3;

use super::mesh::Face;
use crate::dat::{
    BspTag, CellBsp, CellInner, CellLeaf, CellNode, DrawingBsp, DrawingInner, DrawingNode, NodeId,
    PhysicsBsp, PhysicsInner, PhysicsLeaf, PhysicsNode, PoolRange,
};
use crate::math::{Plane, Sphere};

/// A point this close to a plane lies on it, metres.
const ON: f64 = 1e-4;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DPlane {
    n: DVec3,
    d: f64,
}

impl DPlane {
    pub(super) fn of(points: &[DVec3]) -> Self {
        let mut n = DVec3::ZERO;
        for w in points.windows(2).skip(1) {
            n += (w[0] - points[0]).cross(w[1] - points[0]);
        }
        let n = n.normalize_or_zero();
        let sum: f64 = points.iter().map(|p| n.dot(*p)).sum();
        Self {
            n,
            d: -sum / points.len().max(1) as f64,
        }
    }

    pub(super) fn distance(self, p: DVec3) -> f64 {
        self.n.dot(p) + self.d
    }

    pub(super) fn stored(self) -> Plane {
        // Adding 0 turns -0 into 0, so that mirrored soups give the same bytes.
        Plane {
            n: (self.n + DVec3::ZERO).as_vec3(),
            d: (self.d + 0.0) as f32,
        }
    }
}

/// The part of a polygon that lies in the region of a node. `face` is `None` for a doorway.
#[derive(Debug, Clone)]
struct Piece {
    face: Option<usize>,
    points: Vec<DVec3>,
    plane: DPlane,
    /// Its plane has been used as a splitter above.
    done: bool,
}

impl Piece {
    fn whole(face: Option<usize>, points: Vec<DVec3>) -> Self {
        let plane = DPlane::of(&points);
        Self {
            face,
            points,
            plane,
            done: false,
        }
    }

    fn part(&self, points: Vec<DVec3>) -> Self {
        Self {
            face: self.face,
            points,
            plane: self.plane,
            done: self.done,
        }
    }
}

/// Parts in front of and behind a plane; both empty if all points lie on it.
fn split(points: &[DVec3], plane: DPlane) -> (Vec<DVec3>, Vec<DVec3>) {
    let dist: Vec<f64> = points.iter().map(|p| plane.distance(*p)).collect();
    let (low, high) = dist
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), d| (l.min(*d), h.max(*d)));
    if low >= -ON && high <= ON {
        return (Vec::new(), Vec::new());
    }
    if low >= -ON {
        return (points.to_vec(), Vec::new());
    }
    if high <= ON {
        return (Vec::new(), points.to_vec());
    }
    let (mut front, mut back) = (Vec::new(), Vec::new());
    for (i, &p) in points.iter().enumerate() {
        let j = (i + 1) % points.len();
        let (q, dp, dq) = (points[j], dist[i], dist[j]);
        if dp >= -ON {
            front.push(p);
        }
        if dp <= ON {
            back.push(p);
        }
        if (dp > ON && dq < -ON) || (dp < -ON && dq > ON) {
            let cut = p + (q - p) * (dp / (dp - dq));
            front.push(cut);
            back.push(cut);
        }
    }
    (front, back)
}

/// Of the planes that were not used yet, the one that cuts the fewest pieces, then the best balanced one.
fn choose_splitter<'a>(pieces: impl Iterator<Item = &'a Piece> + Clone) -> Option<DPlane> {
    let mut best: Option<((usize, usize), DPlane)> = None;
    for candidate in pieces.clone().filter(|p| !p.done) {
        let (mut front, mut back, mut cut) = (0usize, 0usize, 0usize);
        for p in pieces.clone() {
            let (f, b) = split(&p.points, candidate.plane);
            match (f.is_empty(), b.is_empty()) {
                (false, false) => cut += 1,
                (false, true) => front += 1,
                (true, false) => back += 1,
                (true, true) => {}
            }
        }
        let cost = (8 * cut + front.abs_diff(back), back);
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, candidate.plane));
        }
    }
    best.map(|(_, plane)| plane)
}

#[derive(Default)]
struct Parts {
    front: Vec<Piece>,
    back: Vec<Piece>,
    /// On the plane, facing as it does, or against it.
    same: Vec<Piece>,
    other: Vec<Piece>,
}

fn distribute(pieces: &[Piece], plane: DPlane) -> Parts {
    let mut parts = Parts::default();
    for p in pieces {
        let (f, b) = split(&p.points, plane);
        if f.is_empty() && b.is_empty() {
            let list = if p.plane.n.dot(plane.n) > 0.0 {
                &mut parts.same
            } else {
                &mut parts.other
            };
            list.push(p.clone());
            continue;
        }
        if f.len() >= 3 {
            parts.front.push(p.part(f));
        }
        if b.len() >= 3 {
            parts.back.push(p.part(b));
        }
    }
    parts
}

/// A plane along an edge of a doorway that parts the doorway from a wall around it.
fn doorway_edge(pieces: &[Piece]) -> Option<DPlane> {
    let mut best: Option<(usize, DPlane)> = None;
    for door in pieces.iter().filter(|p| p.face.is_none()) {
        for (i, &a) in door.points.iter().enumerate() {
            let b = door.points[(i + 1) % door.points.len()];
            let n = (b - a).cross(door.plane.n).normalize_or_zero();
            let plane = DPlane { n, d: -n.dot(a) };
            let parts = distribute(pieces, plane);
            let parted = parts.front.iter().any(|p| p.face.is_some())
                && parts.back.iter().any(|p| p.face.is_none());
            let cost = parts.front.len() + parts.back.len();
            if parted && best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, plane));
            }
        }
    }
    best.map(|(_, plane)| plane)
}

/// Middle of the bounding box and the farthest point, rounded outwards.
pub(super) fn bounding_sphere(points: impl Iterator<Item = DVec3> + Clone) -> Sphere {
    let (low, high) = points
        .clone()
        .fold((DVec3::MAX, DVec3::MIN), |(l, h), p| (l.min(p), h.max(p)));
    if low.x > high.x {
        return Sphere::default();
    }
    let center = ((low + high) / 2.0).as_vec3();
    let middle = center.as_dvec3();
    let radius = points.map(|p| p.distance(middle)).fold(0.0, f64::max);
    Sphere {
        center,
        radius: (radius + 1e-4) as f32,
    }
}

/// A solid-leaf tree over faces with matter behind them.
///
/// Every polygon is listed in the solid leaves right behind it; free leaves list nothing. What lies behind an opening (a doorway in the
/// walls of a room, facing inwards) is free: half of somebody who stands in it is there.
#[must_use]
pub fn physics_tree(faces: &[Face], openings: &[Face]) -> PhysicsBsp {
    let walls = faces
        .iter()
        .enumerate()
        .map(|(i, f)| Piece::whole(Some(i), f.corners()));
    let doors = openings.iter().map(|f| Piece::whole(None, f.corners()));
    let mut builder = PhysicsBuilder {
        faces,
        tree: PhysicsBsp::default(),
        leaves: 0,
    };
    builder.build(walls.chain(doors).collect());
    builder.tree
}

struct PhysicsBuilder<'a> {
    faces: &'a [Face],
    tree: PhysicsBsp,
    leaves: i32,
}

impl PhysicsBuilder<'_> {
    fn build(&mut self, pieces: Vec<Piece>) -> usize {
        let number = self.tree.nodes.len();
        let mut keys: Vec<u16> = pieces
            .iter()
            .filter_map(|p| p.face)
            .map(|f| f as u16)
            .collect();
        keys.sort_unstable();
        keys.dedup();
        let sphere = bounding_sphere(keys.iter().flat_map(|&k| {
            self.faces[usize::from(k)]
                .points
                .iter()
                .map(|p| p.as_dvec3())
        }));
        let walls = pieces.iter().filter(|p| p.face.is_some());
        let Some(plane) = choose_splitter(walls).or_else(|| doorway_edge(&pieces)) else {
            let polygons = self.tree.add_polygons(&keys);
            let leaf = PhysicsLeaf {
                index: self.leaves,
                solid: i32::from(!keys.is_empty()),
                sphere,
                polygons,
            };
            self.leaves += 1;
            self.tree.nodes.push(PhysicsNode::Leaf(leaf));
            return number;
        };
        let mut parts = distribute(&pieces, plane);
        let used = |mut p: Piece| {
            p.done = true;
            p
        };
        parts.back.extend(parts.same.into_iter().map(used));
        parts.front.extend(parts.other.into_iter().map(used));
        let inner = PhysicsInner {
            tag: BspTag::BPnN,
            plane: plane.stored(),
            positive: None,
            negative: None,
            sphere,
        };
        self.tree.nodes.push(PhysicsNode::Inner(inner));
        let positive = NodeId::new(self.build(parts.front));
        let negative = NodeId::new(self.build(parts.back));
        if let PhysicsNode::Inner(n) = &mut self.tree.nodes[number] {
            (n.positive, n.negative) = (positive, negative);
        }
        number
    }
}

/// A drawing tree, and the faces it lists: faces that a plane cuts are replaced by their parts. Keys in the tree are increased by
/// `first_key`. `None` without faces.
#[must_use]
pub fn drawing_tree(faces: &[Face], first_key: u16) -> Option<(DrawingBsp, Vec<Face>)> {
    let pieces: Vec<Piece> = faces
        .iter()
        .enumerate()
        .map(|(i, f)| Piece::whole(Some(i), f.corners()))
        .collect();
    let mut builder = DrawingBuilder {
        faces,
        first_key,
        tree: DrawingBsp::default(),
        out: Vec::new(),
    };
    builder.build(&pieces)?;
    Some((builder.tree, builder.out))
}

struct DrawingBuilder<'a> {
    faces: &'a [Face],
    first_key: u16,
    tree: DrawingBsp,
    out: Vec<Face>,
}

impl DrawingBuilder<'_> {
    fn build(&mut self, pieces: &[Piece]) -> Option<NodeIdOrRoot> {
        let plane = choose_splitter(pieces.iter())?;
        let number = self.tree.nodes.len();
        let parts = distribute(pieces, plane);
        let mut keys = Vec::new();
        for p in parts.same.iter().chain(&parts.other) {
            keys.push(self.first_key + self.out.len() as u16);
            let surface = p.face.map_or(0, |f| self.faces[f].surface);
            self.out.push(Face {
                points: p.points.iter().map(|p| p.as_vec3()).collect(),
                surface,
            });
        }
        let polygons = self.tree.add_polygons(&keys);
        let sphere = bounding_sphere(pieces.iter().flat_map(|p| p.points.iter().copied()));
        let node = DrawingInner {
            tag: BspTag::BpIn,
            plane: plane.stored(),
            positive: None,
            negative: None,
            sphere,
            polygons,
            portals: PoolRange::default(),
        };
        self.tree.nodes.push(DrawingNode::Inner(node));
        let positive = self.build(&parts.front);
        let negative = self.build(&parts.back);
        if let DrawingNode::Inner(n) = &mut self.tree.nodes[number] {
            n.tag = match (&positive, &negative) {
                (None, None) => BspTag::BpIn,
                (Some(_), None) => BspTag::BPIn,
                (None, Some(_)) => BspTag::BpIN,
                (Some(_), Some(_)) => BspTag::BPIN,
            };
            n.positive = positive.and_then(|p| NodeId::new(p.0));
            n.negative = negative.and_then(|p| NodeId::new(p.0));
        }
        Some(NodeIdOrRoot(number))
    }
}

struct NodeIdOrRoot(usize);

/// The volume of a convex room: a chain of planes that face inwards, ended by a LEAF if `leaf_end`.
#[must_use]
pub fn cell_tree(planes: &[Plane], leaf_end: bool) -> CellBsp {
    let mut tree = CellBsp::default();
    for (i, &plane) in planes.iter().enumerate() {
        let more = i + 1 < planes.len() || leaf_end;
        let tag = if more { BspTag::BPnn } else { BspTag::BpIn };
        let positive = if more { NodeId::new(i + 1) } else { None };
        tree.nodes.push(CellNode::Inner(CellInner {
            tag,
            plane,
            positive,
            negative: None,
        }));
    }
    if leaf_end || planes.is_empty() {
        tree.nodes.push(CellNode::Leaf(CellLeaf { index: 0 }));
    }
    tree
}
