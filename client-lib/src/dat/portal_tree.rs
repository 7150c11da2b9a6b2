//! The openings of a drawing tree: what is left of it when only its portal nodes are kept (`spec/04-collision-primitives.md`, 10.9).
//!
//! The shell of a building has its openings in the `PORT` nodes of its drawing tree. To look into a building the client needs these nodes
//! alone, in the order in which a walk over the tree leaves them. Collision does not use them.

use super::bsp::{BspPortal, BspTag, DrawingBsp, DrawingInner, DrawingNode, NodeId};

/// A node of which a walk has yet to look at the positive side, at the negative side, or at nothing.
struct Open {
    node: usize,
    sides_done: u8,
}

impl DrawingBsp {
    /// Numbers of the portal nodes below the root, in post-order: what is below the positive child, that child, what is below the negative
    /// child, that child. The root is not among them, also if it is a portal node. Every node is met once, also in a tree put together with
    /// a cycle.
    pub fn portal_nodes(&self) -> Vec<NodeId> {
        let mut met = vec![false; self.nodes.len()];
        let mut open = vec![Open {
            node: 0,
            sides_done: 0,
        }];
        let mut found = Vec::new();
        while let Some(top) = open.last_mut() {
            let (node, side) = (top.node, top.sides_done);
            top.sides_done += 1;
            let inner = self.inner(node);
            let child = match side {
                0 => inner.and_then(|n| n.positive),
                1 => inner.and_then(|n| n.negative),
                _ => {
                    open.pop();
                    let portal = inner.is_some_and(|n| n.tag == BspTag::Port);
                    found.extend(NodeId::new(node).filter(|_| portal));
                    continue;
                }
            };
            let unmet = child.and_then(|child| met.get_mut(child.index()));
            if let (Some(child), Some(met @ false)) = (child, unmet) {
                *met = true;
                open.push(Open {
                    node: child.index(),
                    sides_done: 0,
                });
            }
        }
        found
    }

    /// The tree without all nodes but the root and the portal nodes (`RemoveNonPortalNodes`): a chain of positive children that leads from
    /// the root to the last portal node of the walk, and back to the first. Planes, spheres, polygons and portals stay as they are. Such a
    /// tree is for looking at; its tags no longer say which children there are, so it cannot be written.
    #[must_use]
    pub fn portals_only(&self) -> Self {
        let Some(root) = self.nodes.first() else {
            return Self::default();
        };
        let below = self.portal_nodes();
        let kept = below.iter().rev().filter_map(|&id| self.node(id));
        let mut nodes: Vec<DrawingNode> = std::iter::once(root).chain(kept).cloned().collect();
        let count = nodes.len();
        for (index, node) in nodes.iter_mut().enumerate() {
            if let DrawingNode::Inner(inner) = node {
                inner.positive = NodeId::new(index + 1).filter(|next| next.index() < count);
                inner.negative = None;
            }
        }
        Self {
            nodes,
            polygon_keys: self.polygon_keys.clone(),
            portals: self.portals.clone(),
        }
    }

    /// The openings of the chain of [`DrawingBsp::portals_only`], from its root on, in file order within a node.
    pub fn openings(&self) -> impl Iterator<Item = BspPortal> {
        let last_first = self.portal_nodes().into_iter().rev();
        std::iter::once(0)
            .chain(last_first.map(NodeId::index))
            .filter_map(|node| self.inner(node))
            .flat_map(|node| self.portals(node.portals).iter().copied())
    }

    fn inner(&self, node: usize) -> Option<&DrawingInner> {
        match self.nodes.get(node)? {
            DrawingNode::Inner(inner) => Some(inner),
            DrawingNode::Leaf(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::dat::{CellLeaf, PoolRange};
    use crate::math::{Plane, Sphere, Vec3};

    /// A node by tag and children; a portal node has one opening, numbered after its place in the list.
    fn tree(nodes: &[(BspTag, usize, usize)]) -> DrawingBsp {
        let mut tree = DrawingBsp::default();
        for (index, &(tag, positive, negative)) in nodes.iter().enumerate() {
            if tag == BspTag::Leaf {
                tree.nodes.push(DrawingNode::Leaf(CellLeaf { index: 0 }));
                continue;
            }
            let opening = BspPortal {
                polygon: 0,
                portal: index as u16,
            };
            let portals = if tag == BspTag::Port {
                tree.add_portals(&[opening])
            } else {
                PoolRange::default()
            };
            tree.nodes.push(DrawingNode::Inner(DrawingInner {
                tag,
                plane: Plane::from_normal_and_point(Vec3::Z, Vec3::ZERO),
                positive: NodeId::new(positive),
                negative: NodeId::new(negative),
                sphere: Sphere::default(),
                polygons: PoolRange::default(),
                portals,
            }));
        }
        tree
    }

    fn chain(tree: &DrawingBsp) -> Vec<u16> {
        let mut found = Vec::new();
        let mut at = Some(0);
        while let Some(node) = at {
            let DrawingNode::Inner(inner) = &tree.nodes[node] else {
                break;
            };
            found.extend(tree.portals(inner.portals).iter().map(|p| p.portal));
            assert_eq!(inner.negative, None);
            at = inner.positive.map(NodeId::index);
        }
        found
    }

    /// Two portal nodes below each other on the positive side, one on the negative side of a plain node.
    #[test]
    fn portal_nodes_become_a_chain_from_the_last_to_the_first() {
        use BspTag::{BPIN, Leaf, Port};
        let tree = tree(&[
            (BPIN, 1, 4),
            (Port, 2, 3),
            (Port, 0, 0),
            (Leaf, 0, 0),
            (BPIN, 3, 5),
            (Port, 0, 0),
        ]);
        let order: Vec<usize> = tree.portal_nodes().iter().map(|id| id.index()).collect();
        assert_eq!(order, [2, 1, 5], "a child comes before its parent");
        let left = tree.portals_only();
        assert_eq!(left.nodes.len(), 4, "the root and the portal nodes");
        assert_eq!(chain(&left), [5, 1, 2]);
        assert_eq!(
            tree.openings().map(|p| p.portal).collect::<Vec<_>>(),
            [5, 1, 2]
        );
        // Once more changes nothing: the chain walked in post-order is the list again.
        assert_eq!(left.portals_only(), left);
    }

    #[test]
    fn trees_without_portals_keep_their_root() {
        use BspTag::{BPIN, Leaf, Port};
        assert_eq!(DrawingBsp::default().portals_only(), DrawingBsp::default());
        let leaf = tree(&[(Leaf, 0, 0)]);
        assert_eq!(leaf.portals_only(), leaf);
        let plain = tree(&[(BPIN, 1, 2), (BPIN, 0, 0), (Leaf, 0, 0)]);
        assert_eq!(plain.portals_only().nodes.len(), 1);
        assert_eq!(chain(&plain.portals_only()), [0; 0]);
        // A portal node at the root stays where it is.
        let root = tree(&[(Port, 1, 0), (Port, 0, 0)]);
        assert_eq!(chain(&root.portals_only()), [0, 1]);
    }

    proptest! {
        /// Whatever the links, each portal node is there once, after everything below it, and the walk ends.
        #[test]
        fn every_portal_node_is_kept_once(
            nodes in prop::collection::vec((0_usize..3, 0_usize..40, 0_usize..40), 1..40),
        ) {
            let tags = [BspTag::Leaf, BspTag::Port, BspTag::BPIN];
            let nodes: Vec<_> = nodes.iter().map(|&(t, p, n)| (tags[t], p, n)).collect();
            let tree = tree(&nodes);
            let found = tree.portal_nodes();
            let mut sorted: Vec<usize> = found.iter().map(|id| id.index()).collect();
            sorted.sort_unstable();
            sorted.dedup();
            prop_assert_eq!(sorted.len(), found.len());
            prop_assert!(sorted.iter().all(|&i| nodes[i].0 == BspTag::Port));
            let left = tree.portals_only();
            prop_assert_eq!(left.nodes.len(), found.len() + 1);
            let openings: Vec<u16> = tree.openings().map(|p| p.portal).collect();
            prop_assert_eq!(chain(&left), openings);
        }
    }
}
