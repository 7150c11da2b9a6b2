//! Binary space partitioning trees: the volume of a room (cell), collision (physics), and drawing.
//!
//! Three kinds share one encoding with different fields. A tree is kept as a flat list of nodes in file order (a parent before its
//! children, the root first), so that dropping it does not recurse and walking it stays in one piece of memory. Depth is at most
//! [`MAX_DEPTH`], so walks may recurse. Source: `spec/11-dat-files.md, 6`; meaning: `spec/04-collision-primitives.md, 10`.

use std::num::NonZeroU32;

use serde::Serialize;

use super::error::Problem;

use super::reader::{Read, Reader};
use super::writer::Writer;
use crate::math::{Plane, Sphere};

/// Most levels of a tree that is read.
pub const MAX_DEPTH: usize = 512;

/// Kind of a node: the four letters of its tag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[allow(missing_docs, reason = "the names are the stored letters")]
pub enum BspTag {
    Leaf,
    Port,
    BPnn,
    BPIn,
    BpIN,
    BpnN,
    BPIN,
    BPnN,
    BPOL,
    BPFL,
    BpIn,
    Bpnn,
}

impl BspTag {
    /// All tags that occur.
    pub const ALL: [Self; 12] = [
        Self::Leaf,
        Self::Port,
        Self::BPnn,
        Self::BPIn,
        Self::BpIN,
        Self::BpnN,
        Self::BPIN,
        Self::BPnN,
        Self::BPOL,
        Self::BPFL,
        Self::BpIn,
        Self::Bpnn,
    ];

    /// The stored number.
    #[must_use]
    pub fn value(self) -> u32 {
        u32::from_be_bytes(*match self {
            Self::Leaf => b"LEAF",
            Self::Port => b"PORT",
            Self::BPnn => b"BPnn",
            Self::BPIn => b"BPIn",
            Self::BpIN => b"BpIN",
            Self::BpnN => b"BpnN",
            Self::BPIN => b"BPIN",
            Self::BPnN => b"BPnN",
            Self::BPOL => b"BPOL",
            Self::BPFL => b"BPFL",
            Self::BpIn => b"BpIn",
            Self::Bpnn => b"Bpnn",
        })
    }

    /// The tag of a stored number.
    #[must_use]
    pub fn from_value(value: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.value() == value)
    }

    /// A positive child follows.
    #[must_use]
    pub fn has_positive(self) -> bool {
        matches!(
            self,
            Self::BPnn | Self::BPIn | Self::BPIN | Self::BPnN | Self::Port
        )
    }

    /// A negative child follows (after the positive one).
    #[must_use]
    pub fn has_negative(self) -> bool {
        matches!(
            self,
            Self::BpIN | Self::BpnN | Self::BPIN | Self::BPnN | Self::Port
        )
    }
}

/// Number of a node in its tree. Never the root, which is nobody's child.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct NodeId(NonZeroU32);

impl NodeId {
    /// A node number; `None` for 0, the root.
    #[must_use]
    pub fn new(index: usize) -> Option<Self> {
        u32::try_from(index)
            .ok()
            .and_then(NonZeroU32::new)
            .map(Self)
    }

    /// Position in [`BspTree::nodes`].
    #[must_use]
    pub fn index(self) -> usize {
        self.0.get() as usize
    }
}

/// A run of elements in one of the tree's pools.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct PoolRange {
    /// First element.
    pub first: u32,
    /// Number of elements.
    pub count: u32,
}

impl PoolRange {
    fn of<T>(self, pool: &[T]) -> &[T] {
        pool.get(self.first as usize..)
            .and_then(|p| p.get(..self.count as usize))
            .unwrap_or(&[])
    }
}

/// An opening of a building, listed in a drawing tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct BspPortal {
    /// Key of the drawing polygon.
    pub polygon: u16,
    /// Number of the building's portal.
    pub portal: u16,
}

/// A tree: nodes in file order and the pools they refer to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BspTree<N> {
    /// Nodes; the root is the first, every parent precedes its children. Never empty in a tree that was read.
    pub nodes: Vec<N>,
    /// Polygon keys of all nodes.
    pub polygon_keys: Vec<u16>,
    /// Portals of all nodes (drawing trees).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub portals: Vec<BspPortal>,
}

impl<N> Default for BspTree<N> {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            polygon_keys: Vec::new(),
            portals: Vec::new(),
        }
    }
}

/// Collision tree of a shape or room.
pub type PhysicsBsp = BspTree<PhysicsNode>;
/// Volume of a room.
pub type CellBsp = BspTree<CellNode>;
/// Drawing tree of a shape or room.
pub type DrawingBsp = BspTree<DrawingNode>;

impl<N> BspTree<N> {
    /// The root.
    #[must_use]
    pub fn root(&self) -> Option<&N> {
        self.nodes.first()
    }

    /// A node by number.
    #[must_use]
    pub fn node(&self, id: NodeId) -> Option<&N> {
        self.nodes.get(id.index())
    }

    /// Polygon keys of a node, in file order.
    #[must_use]
    pub fn polygons(&self, range: PoolRange) -> &[u16] {
        range.of(&self.polygon_keys)
    }

    /// Portals of a node, in file order.
    #[must_use]
    pub fn portals(&self, range: PoolRange) -> &[BspPortal] {
        range.of(&self.portals)
    }

    /// Adds polygon keys to the pool.
    pub fn add_polygons(&mut self, keys: &[u16]) -> PoolRange {
        let range = PoolRange {
            first: self.polygon_keys.len() as u32,
            count: keys.len() as u32,
        };
        self.polygon_keys.extend_from_slice(keys);
        range
    }

    /// Adds portals to the pool.
    pub fn add_portals(&mut self, portals: &[BspPortal]) -> PoolRange {
        let range = PoolRange {
            first: self.portals.len() as u32,
            count: portals.len() as u32,
        };
        self.portals.extend_from_slice(portals);
        range
    }
}

/// Node of a collision tree.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum PhysicsNode {
    /// A splitting plane.
    Inner(PhysicsInner),
    /// Solid matter or free space.
    Leaf(PhysicsLeaf),
}

impl PhysicsNode {
    /// Bounding sphere of the node.
    #[must_use]
    pub fn sphere(&self) -> Sphere {
        match self {
            Self::Inner(n) => n.sphere,
            Self::Leaf(n) => n.sphere,
        }
    }
}

/// Inner node of a collision tree.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhysicsInner {
    /// Tag, as stored.
    pub tag: BspTag,
    /// Splitting plane.
    pub plane: Plane,
    /// Child in front.
    pub positive: Option<NodeId>,
    /// Child behind.
    pub negative: Option<NodeId>,
    /// Holds every polygon below.
    pub sphere: Sphere,
}

/// Leaf of a collision tree.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhysicsLeaf {
    /// Number of the leaf; not used by physics.
    pub index: i32,
    /// Solid mark as stored: 1 solid, 0 free; only these occur (D-20).
    pub solid: i32,
    /// Bounding sphere; without meaning in a free leaf.
    pub sphere: Sphere,
    /// Keys of the physics polygons, in [`BspTree::polygons`].
    pub polygons: PoolRange,
}

/// Node of a room's volume.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum CellNode {
    /// A plane facing inwards.
    Inner(CellInner),
    /// End of the chain.
    Leaf(CellLeaf),
}

/// Inner node of a room's volume; only the positive chain is ever walked.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CellInner {
    /// Tag, as stored.
    pub tag: BspTag,
    /// Plane; inside is where it is not negative.
    pub plane: Plane,
    /// Rest of the chain.
    pub positive: Option<NodeId>,
    /// Never walked.
    pub negative: Option<NodeId>,
}

/// Leaf of a room's volume. Its plane counts as zero.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CellLeaf {
    /// Number of the leaf.
    pub index: i32,
}

/// Node of a drawing tree.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum DrawingNode {
    /// A splitting plane with the polygons on it; with openings if the tag is [`BspTag::Port`].
    Inner(DrawingInner),
    /// An empty side.
    Leaf(CellLeaf),
}

/// Inner node of a drawing tree.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DrawingInner {
    /// Tag, as stored.
    pub tag: BspTag,
    /// Splitting plane.
    pub plane: Plane,
    /// Child in front.
    pub positive: Option<NodeId>,
    /// Child behind.
    pub negative: Option<NodeId>,
    /// Holds every polygon below.
    pub sphere: Sphere,
    /// Keys of the drawing polygons on the plane.
    pub polygons: PoolRange,
    /// Openings on the plane (`PORT` nodes).
    pub portals: PoolRange,
}

/// What the polygon keys and portals of a tree may refer to.
#[derive(Debug, Clone, Copy)]
pub struct TreeLimits {
    /// Number of polygons of the owner.
    pub polygons: usize,
}

/// How the nodes of one kind of tree are stored.
pub trait NodeCodec: Sized {
    /// Fields of a leaf after its tag.
    fn read_leaf(tree: &mut BspTree<Self>, r: &mut Reader<'_>, limits: TreeLimits) -> Read<Self>;
    /// An inner node before its children; `None` if this kind of tree has no such tag.
    fn inner(tag: BspTag, plane: Plane) -> Option<Self>;
    /// Positive and negative child of an inner node.
    fn children_mut(&mut self) -> Option<[&mut Option<NodeId>; 2]>;
    /// Fields of an inner node after its children.
    fn read_tail(
        tree: &mut BspTree<Self>,
        at: usize,
        r: &mut Reader<'_>,
        limits: TreeLimits,
    ) -> Read<()>;
    /// Tag and, for inner nodes, plane and children.
    fn head(&self) -> (BspTag, Option<&Plane>, [Option<NodeId>; 2]);
    /// Fields of a leaf after its tag.
    fn write_leaf(&self, tree: &BspTree<Self>, w: &mut Writer);
    /// Fields of an inner node after its children.
    fn write_tail(&self, tree: &BspTree<Self>, w: &mut Writer);
}

/// A node whose children are being read or written, and how many of the two are done.
struct Open {
    node: usize,
    tag: BspTag,
    children_done: u8,
}

impl<N: NodeCodec> BspTree<N> {
    /// Reads a tree depth first, with an explicit stack.
    pub(super) fn parse(r: &mut Reader<'_>, limits: TreeLimits) -> Read<Self> {
        let mut tree = Self::default();
        let mut open: Vec<Open> = Vec::new();
        tree.read_head(r, limits, &mut open)?;
        while let Some(top) = open.last_mut() {
            let positive = top.children_done == 0;
            let (node, tag) = (top.node, top.tag);
            if top.children_done < 2 {
                top.children_done += 1;
                if if positive {
                    tag.has_positive()
                } else {
                    tag.has_negative()
                } {
                    let child = NodeId::new(tree.nodes.len());
                    if let Some([p, n]) = tree.nodes[node].children_mut() {
                        *(if positive { p } else { n }) = child;
                    }
                    tree.read_head(r, limits, &mut open)?;
                }
            } else {
                open.pop();
                N::read_tail(&mut tree, node, r, limits)?;
            }
        }
        Ok(tree)
    }

    fn read_head(
        &mut self,
        r: &mut Reader<'_>,
        limits: TreeLimits,
        open: &mut Vec<Open>,
    ) -> Read<()> {
        let at = r.offset();
        let value = r.u32()?;
        let unknown = || Problem::Unknown {
            what: "tree node tag",
            found: value,
        };
        let tag = BspTag::from_value(value).ok_or_else(|| r.error_at(at, unknown()))?;
        if tag == BspTag::Leaf {
            let leaf = N::read_leaf(self, r, limits)?;
            self.nodes.push(leaf);
            return Ok(());
        }
        if open.len() >= MAX_DEPTH {
            return Err(r.error_at(at, Problem::TreeDepth { limit: MAX_DEPTH }));
        }
        let plane = r.plane()?;
        let node = N::inner(tag, plane).ok_or_else(|| r.error_at(at, unknown()))?;
        open.push(Open {
            node: self.nodes.len(),
            tag,
            children_done: 0,
        });
        self.nodes.push(node);
        Ok(())
    }

    /// Writes the tree depth first. A link that does not fit its node's tag, a shared node and a cycle are refused.
    pub(super) fn write(&self, w: &mut Writer) {
        let mut open: Vec<Open> = Vec::new();
        let mut written = 0;
        self.write_head(0, w, &mut open, &mut written);
        while let Some(top) = open.last_mut() {
            let done = usize::from(top.children_done);
            let (node, tag) = (top.node, top.tag);
            let Some(n) = self.nodes.get(node) else {
                return;
            };
            if done < 2 {
                top.children_done += 1;
                let child = n.head().2[done];
                if child.is_some()
                    != if done == 0 {
                        tag.has_positive()
                    } else {
                        tag.has_negative()
                    }
                {
                    w.fail(
                        "tree node whose children do not fit its tag",
                        node as u64,
                        0,
                    );
                    return;
                }
                if let Some(child) = child {
                    self.write_head(child.index(), w, &mut open, &mut written);
                }
            } else {
                open.pop();
                n.write_tail(self, w);
            }
            if written > self.nodes.len() || open.len() > MAX_DEPTH {
                w.fail("tree levels", open.len() as u64, MAX_DEPTH as u64);
                return;
            }
        }
    }

    fn write_head(&self, at: usize, w: &mut Writer, open: &mut Vec<Open>, written: &mut usize) {
        *written += 1;
        let Some(node) = self.nodes.get(at) else {
            w.fail("missing tree node", at as u64, self.nodes.len() as u64);
            return;
        };
        let (tag, plane, _) = node.head();
        w.u32(tag.value());
        match plane {
            None => node.write_leaf(self, w),
            Some(plane) => {
                w.plane(plane);
                open.push(Open {
                    node: at,
                    tag,
                    children_done: 0,
                });
            }
        }
    }

    fn read_polygons(
        &mut self,
        r: &mut Reader<'_>,
        n: usize,
        limits: TreeLimits,
    ) -> Read<PoolRange> {
        let first = self.polygon_keys.len() as u32;
        for _ in 0..n {
            let key = read_polygon_key(r, limits)?;
            self.polygon_keys.push(key);
        }
        Ok(PoolRange {
            first,
            count: n as u32,
        })
    }

    fn write_polygons(&self, w: &mut Writer, range: PoolRange) {
        for &key in self.polygons(range) {
            w.u16(key);
        }
    }
}

fn read_polygon_key(r: &mut Reader<'_>, limits: TreeLimits) -> Read<u16> {
    let key = r.u16()?;
    if usize::from(key) >= limits.polygons {
        return Err(r.error_at(
            r.offset() - 2,
            Problem::Index {
                what: "polygon of a tree node",
                found: i64::from(key),
                limit: limits.polygons,
            },
        ));
    }
    Ok(key)
}

impl NodeCodec for PhysicsNode {
    fn read_leaf(tree: &mut BspTree<Self>, r: &mut Reader<'_>, limits: TreeLimits) -> Read<Self> {
        let (index, solid, sphere) = (r.i32()?, r.i32()?, r.sphere()?);
        let n = r.count_u32("polygons of a leaf", 2)?;
        Ok(Self::Leaf(PhysicsLeaf {
            index,
            solid,
            sphere,
            polygons: tree.read_polygons(r, n, limits)?,
        }))
    }

    fn inner(tag: BspTag, plane: Plane) -> Option<Self> {
        // D-10: a portal node does not occur in a physics tree and its layout there is disputed.
        (tag != BspTag::Port).then(|| {
            Self::Inner(PhysicsInner {
                tag,
                plane,
                positive: None,
                negative: None,
                sphere: Sphere::default(),
            })
        })
    }

    fn children_mut(&mut self) -> Option<[&mut Option<NodeId>; 2]> {
        match self {
            Self::Inner(n) => Some([&mut n.positive, &mut n.negative]),
            Self::Leaf(_) => None,
        }
    }

    fn read_tail(
        tree: &mut BspTree<Self>,
        at: usize,
        r: &mut Reader<'_>,
        _: TreeLimits,
    ) -> Read<()> {
        let sphere = r.sphere()?;
        if let Self::Inner(n) = &mut tree.nodes[at] {
            n.sphere = sphere;
        }
        Ok(())
    }

    fn head(&self) -> (BspTag, Option<&Plane>, [Option<NodeId>; 2]) {
        match self {
            Self::Inner(n) => (n.tag, Some(&n.plane), [n.positive, n.negative]),
            Self::Leaf(_) => (BspTag::Leaf, None, [None; 2]),
        }
    }

    fn write_leaf(&self, tree: &BspTree<Self>, w: &mut Writer) {
        if let Self::Leaf(n) = self {
            w.i32(n.index);
            w.i32(n.solid);
            w.sphere(&n.sphere);
            w.count_u32("polygons of a leaf", tree.polygons(n.polygons).len());
            tree.write_polygons(w, n.polygons);
        }
    }

    fn write_tail(&self, _: &BspTree<Self>, w: &mut Writer) {
        w.sphere(&self.sphere());
    }
}

impl NodeCodec for CellNode {
    fn read_leaf(_: &mut BspTree<Self>, r: &mut Reader<'_>, _: TreeLimits) -> Read<Self> {
        Ok(Self::Leaf(CellLeaf { index: r.i32()? }))
    }

    fn inner(tag: BspTag, plane: Plane) -> Option<Self> {
        (tag != BspTag::Port).then_some(Self::Inner(CellInner {
            tag,
            plane,
            positive: None,
            negative: None,
        }))
    }

    fn children_mut(&mut self) -> Option<[&mut Option<NodeId>; 2]> {
        match self {
            Self::Inner(n) => Some([&mut n.positive, &mut n.negative]),
            Self::Leaf(_) => None,
        }
    }

    fn read_tail(_: &mut BspTree<Self>, _: usize, _: &mut Reader<'_>, _: TreeLimits) -> Read<()> {
        Ok(())
    }

    fn head(&self) -> (BspTag, Option<&Plane>, [Option<NodeId>; 2]) {
        match self {
            Self::Inner(n) => (n.tag, Some(&n.plane), [n.positive, n.negative]),
            Self::Leaf(_) => (BspTag::Leaf, None, [None; 2]),
        }
    }

    fn write_leaf(&self, _: &BspTree<Self>, w: &mut Writer) {
        if let Self::Leaf(n) = self {
            w.i32(n.index);
        }
    }

    fn write_tail(&self, _: &BspTree<Self>, _: &mut Writer) {}
}

impl NodeCodec for DrawingNode {
    fn read_leaf(_: &mut BspTree<Self>, r: &mut Reader<'_>, _: TreeLimits) -> Read<Self> {
        Ok(Self::Leaf(CellLeaf { index: r.i32()? }))
    }

    fn inner(tag: BspTag, plane: Plane) -> Option<Self> {
        Some(Self::Inner(DrawingInner {
            tag,
            plane,
            positive: None,
            negative: None,
            sphere: Sphere::default(),
            polygons: PoolRange::default(),
            portals: PoolRange::default(),
        }))
    }

    fn children_mut(&mut self) -> Option<[&mut Option<NodeId>; 2]> {
        match self {
            Self::Inner(n) => Some([&mut n.positive, &mut n.negative]),
            Self::Leaf(_) => None,
        }
    }

    fn read_tail(
        tree: &mut BspTree<Self>,
        at: usize,
        r: &mut Reader<'_>,
        limits: TreeLimits,
    ) -> Read<()> {
        let port = tree.nodes[at].head().0 == BspTag::Port;
        let sphere = r.sphere()?;
        let n = r.count_u32("polygons of a node", 2)?;
        let m = if port {
            r.count_u32("portals of a node", 4)?
        } else {
            0
        };
        let polygons = tree.read_polygons(r, n, limits)?;
        let portals = PoolRange {
            first: tree.portals.len() as u32,
            count: m as u32,
        };
        for _ in 0..m {
            // D-09: polygon first, then the number of the portal.
            let portal = BspPortal {
                polygon: read_polygon_key(r, limits)?,
                portal: r.u16()?,
            };
            tree.portals.push(portal);
        }
        if let Self::Inner(node) = &mut tree.nodes[at] {
            (node.sphere, node.polygons, node.portals) = (sphere, polygons, portals);
        }
        Ok(())
    }

    fn head(&self) -> (BspTag, Option<&Plane>, [Option<NodeId>; 2]) {
        match self {
            Self::Inner(n) => (n.tag, Some(&n.plane), [n.positive, n.negative]),
            Self::Leaf(_) => (BspTag::Leaf, None, [None; 2]),
        }
    }

    fn write_leaf(&self, _: &BspTree<Self>, w: &mut Writer) {
        if let Self::Leaf(n) = self {
            w.i32(n.index);
        }
    }

    fn write_tail(&self, tree: &BspTree<Self>, w: &mut Writer) {
        let Self::Inner(n) = self else { return };
        w.sphere(&n.sphere);
        let portals = tree.portals(n.portals);
        w.count_u32("polygons of a node", tree.polygons(n.polygons).len());
        if n.tag == BspTag::Port {
            w.count_u32("portals of a node", portals.len());
        }
        tree.write_polygons(w, n.polygons);
        for p in portals {
            w.u16(p.polygon);
            w.u16(p.portal);
        }
    }
}
