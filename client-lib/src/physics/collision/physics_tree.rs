//! Solid-leaf BSP trees of collision polygons, and the searches in them (`spec/04-collision-primitives.md`, section 10).
//!
//! A tree is laid out for traversal: nodes and leaves in two flat lists that name each other by number, polygons in the order of the leaves
//! that list them (a polygon that is listed twice is there twice), corners in one list. A search descends in a loop and recurses only where
//! a sphere straddles a splitting plane; [`PhysicsTree::new`] refuses trees deeper than [`MAX_TREE_DEPTH`], so that no search can overflow
//! the stack. Everything is in the space of the tree's owner, divided by the owner's scale.

use super::polygon::Polygon;
use super::polygon_list::PolygonList;
use crate::math::{EPSILON, Plane, Sphere, Vec3};
use crate::profile::Profile;

/// Most levels of a tree.
pub const MAX_TREE_DEPTH: usize = 512;

/// Why a tree cannot be built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TreeError {
    /// Deeper than any search may go.
    #[error("node {node} of a collision tree is more than {MAX_TREE_DEPTH} levels deep")]
    TooDeep {
        /// Number of the node.
        node: usize,
    },
    /// A child does not exist, precedes its parent, or has two parents.
    #[error("node {node} of a collision tree has the impossible child {child}")]
    BadChild {
        /// Number of the node.
        node: usize,
        /// Number of the child.
        child: usize,
    },
    /// A leaf lists a polygon that does not exist.
    #[error("leaf {node} of a collision tree lists polygon {key}, which does not exist")]
    NoPolygon {
        /// Number of the leaf.
        node: usize,
        /// Key of the polygon.
        key: u16,
    },
}

/// A node as [`PhysicsTree::new`] takes it. Children are numbers of nodes after their parent; the root is node 0.
#[derive(Debug, Clone, Copy)]
pub enum SourceNode<'a> {
    /// A splitting plane with what is in front of it and behind it.
    Inner {
        /// Splitting plane.
        plane: Plane,
        /// Holds every polygon below.
        sphere: Sphere,
        /// Child in front.
        positive: Option<usize>,
        /// Child behind.
        negative: Option<usize>,
    },
    /// Solid matter or free space.
    Leaf {
        /// Solid mark as stored.
        solid: i32,
        /// Holds every polygon of the leaf.
        sphere: Sphere,
        /// Keys of the leaf's polygons.
        polygons: &'a [u16],
    },
}

/// Number of a polygon in its tree, in the order of the leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PolygonIndex(u32);

/// Node number, leaf number with the high bit set, or nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Link(u32);

impl Link {
    const NONE: Self = Self(u32::MAX);
    const LEAF: u32 = 0x8000_0000;
}

#[derive(Debug, Clone, Copy)]
struct Node {
    plane: Plane,
    sphere: Sphere,
    positive: Link,
    negative: Link,
}

#[derive(Debug, Clone, Copy)]
struct Leaf {
    sphere: Sphere,
    first: u32,
    count: u32,
    solid: i32,
}

impl Leaf {
    fn polygons(&self) -> core::ops::Range<u32> {
        self.first..self.first + self.count
    }

    /// `04:B6`.
    fn is_solid(&self, profile: &Profile) -> bool {
        if profile.solid_leaf_nonzero {
            self.solid != 0
        } else {
            self.solid == 1
        }
    }
}

/// A tree of collision polygons.
#[derive(Debug, Clone)]
pub struct PhysicsTree {
    root: Link,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    /// Polygons in the order of the leaves.
    polygons: PolygonList,
}

impl Default for PhysicsTree {
    /// A tree without nodes: nothing is solid, nothing is hit.
    fn default() -> Self {
        Self {
            root: Link::NONE,
            nodes: Vec::new(),
            leaves: Vec::new(),
            polygons: PolygonList::default(),
        }
    }
}

/// The polygon that a mover touched, and where.
#[derive(Debug, Clone, Copy, Default)]
pub struct TouchedPolygon {
    /// The polygon; set for a polygon that was touched, whether or not the movement goes against it.
    pub polygon: Option<PolygonIndex>,
    /// The point of its plane nearest the sphere's centre.
    pub contact: Vec3,
}

/// A sphere that looks for ground (10.3): it is moved, and the walk shortened, by every polygon that it comes to rest on.
#[derive(Debug, Clone, Copy)]
pub struct WalkableSearch {
    /// The sphere as adjusted so far.
    pub sphere: Sphere,
    /// The movement that is taken back; the same for every polygon.
    pub movement: Vec3,
    /// World up.
    pub up: Vec3,
    /// Smallest slope that is ground, exclusive.
    pub walkable_allowance: f32,
    /// Part of the movement that is left.
    pub walk_interp: f32,
    /// The polygon that adjusted the sphere last.
    pub found: Option<PolygonIndex>,
}

/// A sphere that looks for the polygon that it overlaps (10.6). Nothing is cleared between searches.
#[derive(Debug, Clone, Copy, Default)]
pub struct SolidSearch {
    /// The centre was in a solid leaf.
    pub center_solid: bool,
    /// The polygon that was hit.
    pub hit: Option<PolygonIndex>,
}

/// Where a descent ends.
enum Stop<'a> {
    /// Out of the tree, or away from everything in it.
    Nothing,
    Leaf(&'a Leaf),
    /// The sphere is on both sides of a node; `h` is its distance from the splitting plane.
    Straddle(&'a Node, f32),
}

impl PhysicsTree {
    /// Builds a tree of the nodes in `source` and the polygons that its leaves name by position in `polygons`. No nodes make an empty tree.
    ///
    /// # Errors
    /// A child that does not follow its parent or has two, a polygon that does not exist, more than [`MAX_TREE_DEPTH`] levels.
    pub fn new(source: &[SourceNode<'_>], polygons: &PolygonList) -> Result<Self, TreeError> {
        check_links(source)?;
        let (mut inner, mut leaf) = (0, 0);
        let links: Vec<Link> = source
            .iter()
            .map(|node| {
                let next = |n: &mut u32| {
                    *n += 1;
                    *n - 1
                };
                match node {
                    SourceNode::Inner { .. } => Link(next(&mut inner)),
                    SourceNode::Leaf { .. } => Link(next(&mut leaf) | Link::LEAF),
                }
            })
            .collect();
        let link = |child: Option<usize>| child.map_or(Link::NONE, |c| links[c]);
        let mut tree = Self {
            root: links.first().copied().unwrap_or(Link::NONE),
            ..Self::default()
        };
        for (number, node) in source.iter().enumerate() {
            match *node {
                SourceNode::Inner {
                    plane,
                    sphere,
                    positive,
                    negative,
                } => tree.nodes.push(Node {
                    plane,
                    sphere,
                    positive: link(positive),
                    negative: link(negative),
                }),
                SourceNode::Leaf {
                    solid,
                    sphere,
                    polygons: keys,
                } => tree.push_leaf(number, solid, sphere, keys, polygons)?,
            }
        }
        Ok(tree)
    }

    fn push_leaf(
        &mut self,
        number: usize,
        solid: i32,
        sphere: Sphere,
        keys: &[u16],
        polygons: &PolygonList,
    ) -> Result<(), TreeError> {
        let first = self.polygons.len() as u32;
        for &key in keys {
            if usize::from(key) >= polygons.len() {
                return Err(TreeError::NoPolygon { node: number, key });
            }
            self.polygons.push_copy(polygons, usize::from(key));
        }
        self.leaves.push(Leaf {
            sphere,
            first,
            count: keys.len() as u32,
            solid,
        });
        Ok(())
    }

    /// Whether the tree has no nodes.
    pub fn is_empty(&self) -> bool {
        self.root == Link::NONE
    }

    /// Bounding sphere of the root (11.11); `None` for an empty tree.
    pub fn sphere(&self) -> Option<Sphere> {
        if self.root == Link::NONE {
            None
        } else if self.root.0 & Link::LEAF != 0 {
            self.leaf(self.root).map(|l| l.sphere)
        } else {
            self.nodes.get(self.root.0 as usize).map(|n| n.sphere)
        }
    }

    /// A polygon that a search answered with.
    #[inline]
    pub fn polygon(&self, index: PolygonIndex) -> Option<Polygon<'_>> {
        self.polygons.get(index.0 as usize)
    }

    /// Key in the dat files of a polygon that a search answered with.
    pub fn polygon_key(&self, index: PolygonIndex) -> Option<u16> {
        self.polygons.key(index.0 as usize)
    }

    fn leaf(&self, link: Link) -> Option<&Leaf> {
        self.leaves.get((link.0 & !Link::LEAF) as usize)
    }

    /// Follows a sphere (10.1) from `link` until it straddles a plane or arrives at a leaf. `reach` is the distance from a splitting plane
    /// from which on the sphere is on one side.
    fn descend(&self, mut link: Link, sphere: &Sphere, reach: f32, profile: &Profile) -> Stop<'_> {
        loop {
            if link.0 & Link::LEAF != 0 {
                // "No child" reads as the largest leaf number, which no tree has.
                return self.leaf(link).map_or(Stop::Nothing, Stop::Leaf);
            }
            let Some(node) = self.nodes.get(link.0 as usize) else {
                return Stop::Nothing;
            };
            if !node.sphere.intersects(sphere, profile) {
                return Stop::Nothing;
            }
            let h = node.plane.distance(sphere.center);
            if h >= reach {
                link = node.positive;
            } else if h <= -reach {
                link = node.negative;
            } else {
                return Stop::Straddle(node, h);
            }
        }
    }

    /// The leaf's polygons that `sphere` can touch, in stored order; none if the leaf's sphere does not intersect it.
    fn polygons_at(
        &self,
        leaf: &Leaf,
        sphere: &Sphere,
        profile: &Profile,
    ) -> impl Iterator<Item = (PolygonIndex, Polygon<'_>)> {
        Self::range_at(leaf, sphere, profile)
            .filter(|&i| self.polygons.is_reached(i as usize, sphere))
            .filter_map(|i| Some((PolygonIndex(i), self.polygon(PolygonIndex(i))?)))
    }

    /// Numbers of the leaf's polygons; none if its sphere does not intersect `sphere`.
    #[inline]
    fn range_at(leaf: &Leaf, sphere: &Sphere, profile: &Profile) -> core::ops::Range<u32> {
        if leaf.count > 0 && leaf.sphere.intersects(sphere, profile) {
            leaf.polygons()
        } else {
            0..0
        }
    }

    /// Looks for a polygon that a sphere hits which came by `movement` (10.2).
    ///
    /// Without a hit, `touched` may still name the last polygon that was touched but not moved against. It is never cleared here.
    pub fn sphere_intersects_poly(
        &self,
        sphere: &Sphere,
        movement: Vec3,
        touched: &mut TouchedPolygon,
        profile: &Profile,
    ) -> bool {
        self.intersects_poly_below(self.root, sphere, movement, touched, profile)
    }

    fn intersects_poly_below(
        &self,
        mut link: Link,
        sphere: &Sphere,
        movement: Vec3,
        touched: &mut TouchedPolygon,
        profile: &Profile,
    ) -> bool {
        loop {
            match self.descend(link, sphere, sphere.radius - EPSILON, profile) {
                Stop::Nothing => return false,
                Stop::Leaf(leaf) => {
                    return self
                        .polygons_at(leaf, sphere, profile)
                        .any(|(index, polygon)| {
                            let (touches, hits) =
                                polygon.pos_hits_sphere(sphere, movement, &mut touched.contact);
                            if touches {
                                touched.polygon = Some(index);
                            }
                            hits
                        });
                }
                Stop::Straddle(node, _) => {
                    if self.intersects_poly_below(node.positive, sphere, movement, touched, profile)
                    {
                        return true;
                    }
                    link = node.negative;
                }
            }
        }
    }

    /// Puts a sphere on the ground that it reaches (10.3); see [`WalkableSearch`].
    pub fn find_walkable(&self, search: &mut WalkableSearch, profile: &Profile) {
        self.find_walkable_below(self.root, search, profile);
    }

    fn find_walkable_below(&self, mut link: Link, s: &mut WalkableSearch, profile: &Profile) {
        loop {
            match self.descend(link, &s.sphere, s.sphere.radius - EPSILON, profile) {
                Stop::Nothing => return,
                Stop::Leaf(leaf) => {
                    // The sphere moves while the polygons are looked at.
                    for i in Self::range_at(leaf, &s.sphere, profile) {
                        if !self.polygons.is_reached(i as usize, &s.sphere) {
                            continue;
                        }
                        let index = PolygonIndex(i);
                        let Some(polygon) = self.polygon(index) else {
                            continue;
                        };
                        if polygon.walkable_hits_sphere(&s.sphere, s.up, s.walkable_allowance)
                            && polygon.adjust_sphere_to_plane(
                                &mut s.sphere,
                                s.movement,
                                &mut s.walk_interp,
                                profile,
                            )
                        {
                            s.found = Some(index);
                        }
                    }
                    return;
                }
                Stop::Straddle(node, _) => {
                    self.find_walkable_below(node.positive, s, profile);
                    link = node.negative;
                }
            }
        }
    }

    /// Whether there is ground under the middle of a sphere that touches it (10.4); `up` is world up in the tree's space.
    pub fn hits_walkable(
        &self,
        sphere: &Sphere,
        up: Vec3,
        walkable_allowance: f32,
        profile: &Profile,
    ) -> bool {
        self.hits_walkable_below(self.root, sphere, up, walkable_allowance, profile)
    }

    fn hits_walkable_below(
        &self,
        mut link: Link,
        sphere: &Sphere,
        up: Vec3,
        walkable_allowance: f32,
        profile: &Profile,
    ) -> bool {
        loop {
            match self.descend(link, sphere, sphere.radius - EPSILON, profile) {
                Stop::Nothing => return false,
                Stop::Leaf(leaf) => {
                    return self.polygons_at(leaf, sphere, profile).any(|(_, polygon)| {
                        polygon.walkable_hits_sphere(sphere, up, walkable_allowance)
                            && polygon.check_small_walkable(sphere, up, profile)
                    });
                }
                Stop::Straddle(node, _) => {
                    if self.hits_walkable_below(
                        node.positive,
                        sphere,
                        up,
                        walkable_allowance,
                        profile,
                    ) {
                        return true;
                    }
                    link = node.negative;
                }
            }
        }
    }

    /// Whether a sphere touches a polygon or, with `center_check`, has its centre in solid matter (10.5).
    ///
    /// A solid leaf without polygons is not solid here.
    pub fn sphere_intersects_solid(
        &self,
        sphere: &Sphere,
        center_check: bool,
        profile: &Profile,
    ) -> bool {
        self.intersects_solid_below(self.root, sphere, center_check, profile)
    }

    fn intersects_solid_below(
        &self,
        mut link: Link,
        sphere: &Sphere,
        mut center_check: bool,
        profile: &Profile,
    ) -> bool {
        loop {
            match self.descend(link, sphere, sphere.radius - EPSILON, profile) {
                Stop::Nothing => return false,
                Stop::Leaf(leaf) => {
                    if leaf.count == 0 {
                        return false;
                    }
                    return (center_check && leaf.is_solid(profile))
                        || self
                            .polygons_at(leaf, sphere, profile)
                            .any(|(_, polygon)| polygon.hits_sphere(sphere));
                }
                Stop::Straddle(node, h) => {
                    let behind = h < 0.0;
                    let in_front = center_check && !behind;
                    if self.intersects_solid_below(node.positive, sphere, in_front, profile) {
                        return true;
                    }
                    center_check &= behind;
                    link = node.negative;
                }
            }
        }
    }

    /// Looks for the polygon that a sphere overlaps (10.6): whether one was found, or the centre is solid.
    ///
    /// `search_radius` widens the descent only. Quirks: a polygon found on the nearer side of a straddled plane makes the answer
    /// "centre solid"; a hit left from an earlier search ends this one after the nearer side.
    pub fn sphere_intersects_solid_poly(
        &self,
        sphere: &Sphere,
        search_radius: f32,
        search: &mut SolidSearch,
        center_check: bool,
        profile: &Profile,
    ) -> bool {
        let reach = search_radius - EPSILON;
        self.solid_poly_below(self.root, sphere, reach, search, center_check, profile)
    }

    fn solid_poly_below(
        &self,
        mut link: Link,
        sphere: &Sphere,
        reach: f32,
        search: &mut SolidSearch,
        mut center_check: bool,
        profile: &Profile,
    ) -> bool {
        loop {
            match self.descend(link, sphere, reach, profile) {
                Stop::Nothing => return false,
                Stop::Leaf(leaf) => {
                    return self.solid_poly_in(leaf, sphere, search, center_check, profile);
                }
                Stop::Straddle(node, h) => {
                    // `04:B3`.
                    let negative_first = if profile.placement_positive_first {
                        h < 0.0
                    } else {
                        h <= 0.0
                    };
                    let (near, far) = if negative_first {
                        (node.negative, node.positive)
                    } else {
                        (node.positive, node.negative)
                    };
                    self.solid_poly_below(near, sphere, reach, search, center_check, profile);
                    if search.hit.is_some() {
                        return search.center_solid;
                    }
                    center_check = false;
                    link = far;
                }
            }
        }
    }

    fn solid_poly_in(
        &self,
        leaf: &Leaf,
        sphere: &Sphere,
        search: &mut SolidSearch,
        center_check: bool,
        profile: &Profile,
    ) -> bool {
        if leaf.count == 0 {
            return false;
        }
        if center_check && leaf.is_solid(profile) {
            search.center_solid = true;
        }
        let found = self
            .polygons_at(leaf, sphere, profile)
            .find(|(_, polygon)| polygon.hits_sphere(sphere));
        match found {
            Some((index, _)) => {
                search.hit = Some(index);
                true
            }
            None => search.center_solid,
        }
    }

    /// Whether a point is in a leaf with polygons (10.7). Nothing on the movement path asks. `04:B4` for points on a plane.
    pub fn point_intersects_solid(&self, point: Vec3, profile: &Profile) -> bool {
        let mut link = self.root;
        while let Some(node) = self.nodes.get(link.0 as usize) {
            let h = node.plane.distance(point);
            let in_front = if profile.placement_positive_first {
                h >= 0.0
            } else {
                h > 0.0
            };
            link = if in_front {
                node.positive
            } else {
                node.negative
            };
        }
        self.leaf(link).is_some_and(|leaf| leaf.count > 0)
    }
}

/// Every child follows its parent and has no other, and no node is too deep.
fn check_links(source: &[SourceNode<'_>]) -> Result<(), TreeError> {
    // Depth of each node; 0: no parent yet.
    let mut depth = vec![0_usize; source.len()];
    if let Some(root) = depth.first_mut() {
        *root = 1;
    }
    for (node, kind) in source.iter().enumerate() {
        if depth[node] > MAX_TREE_DEPTH {
            return Err(TreeError::TooDeep { node });
        }
        let SourceNode::Inner {
            positive, negative, ..
        } = kind
        else {
            continue;
        };
        for child in [positive, negative].into_iter().copied().flatten() {
            let bad = child <= node || depth.get(child) != Some(&0);
            if bad {
                return Err(TreeError::BadChild { node, child });
            }
            depth[child] = depth[node] + 1;
        }
    }
    Ok(())
}
