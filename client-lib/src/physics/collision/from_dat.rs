//! Shapes from dat records: polygons get their planes, trees are laid out for traversal (`spec/11-dat-files.md`, 6, 9.1 and 9.5).

use super::cell_tree::CellTree;
use super::physics_tree::{PhysicsTree, SourceNode, TreeError};
use super::polygon_list::PolygonList;
use super::shape::{CellShape, GfxShape};
use crate::dat::{
    CellBsp, CellNode, CellStruct, GfxObj, NodeId, PhysicsBsp, PhysicsNode, PolygonSet, Sides,
    VertexArray,
};
use crate::math::Vec3;
use crate::profile::Profile;

impl PolygonList {
    /// The polygons of a record, with their planes. A corner that the vertices lack is left out.
    pub fn from_records(set: &PolygonSet, vertices: &VertexArray, profile: &Profile) -> Self {
        let mut list = Self::default();
        for polygon in set.iter() {
            let corners = polygon
                .points
                .iter()
                .filter_map(|&key| vertices.get(key).map(|v| v.position));
            list.push(polygon.key, corners, polygon.sides == Sides(0), profile);
        }
        list
    }
}

impl PhysicsTree {
    /// The tree of a record over `polygons`, which are in order of key.
    ///
    /// # Errors
    /// As [`PhysicsTree::new`]; a tree that was read from a dat file has none of them.
    pub fn from_record(bsp: &PhysicsBsp, polygons: &PolygonList) -> Result<Self, TreeError> {
        let child = |id: Option<NodeId>| id.map(NodeId::index);
        let source: Vec<SourceNode<'_>> = bsp
            .nodes
            .iter()
            .map(|node| match node {
                PhysicsNode::Inner(n) => SourceNode::Inner {
                    plane: n.plane,
                    sphere: n.sphere,
                    positive: child(n.positive),
                    negative: child(n.negative),
                },
                PhysicsNode::Leaf(n) => SourceNode::Leaf {
                    solid: n.solid,
                    sphere: n.sphere,
                    polygons: bsp.polygons(n.polygons),
                },
            })
            .collect();
        Self::new(&source, polygons)
    }
}

impl CellTree {
    /// The volume of a record: the chain of positive children.
    pub fn from_record(bsp: &CellBsp) -> Self {
        let mut planes = Vec::new();
        let mut ends_in_leaf = false;
        let mut next = bsp.root();
        // Children follow their parents in the list, so the chain is not longer than it.
        for _ in 0..bsp.nodes.len() {
            match next {
                Some(CellNode::Inner(n)) => {
                    planes.push(n.plane);
                    next = n.positive.and_then(|id| bsp.node(id));
                }
                Some(CellNode::Leaf(_)) => {
                    ends_in_leaf = true;
                    break;
                }
                None => break,
            }
        }
        Self::new(planes, ends_in_leaf)
    }
}

fn positions(vertices: &VertexArray) -> impl Iterator<Item = Vec3> {
    vertices.vertices().iter().map(|v| v.position)
}

impl GfxShape {
    /// The shape of a graphics object. Without physics polygons it collides with nothing.
    ///
    /// # Errors
    /// As [`PhysicsTree::new`]; a record that was read from a dat file has none of them.
    pub fn from_record(record: &GfxObj, profile: &Profile) -> Result<Self, TreeError> {
        let physics = match &record.physics {
            Some(physics) if !physics.polygons.is_empty() => {
                let list = PolygonList::from_records(&physics.polygons, &record.vertices, profile);
                Some(PhysicsTree::from_record(&physics.bsp, &list)?)
            }
            _ => None,
        };
        Ok(Self {
            id: record.id,
            ..Self::new(
                physics,
                record.drawing_sphere(),
                positions(&record.vertices),
            )
        })
    }
}

impl CellShape {
    /// The shape of an indoor cell.
    ///
    /// # Errors
    /// As [`PhysicsTree::new`]; a record that was read from a dat file has none of them.
    pub fn from_record(record: &CellStruct, profile: &Profile) -> Result<Self, TreeError> {
        let list = PolygonList::from_records(&record.physics_polygons, &record.vertices, profile);
        Ok(Self {
            polygons: PolygonList::from_records(&record.polygons, &record.vertices, profile),
            portals: record.portals.clone(),
            volume: CellTree::from_record(&record.cell_bsp),
            physics: PhysicsTree::from_record(&record.physics_bsp, &list)?,
        })
    }
}
