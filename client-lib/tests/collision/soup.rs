//! Trees of polygon soups, built by splitting at the polygons' own planes.

use ac_client::math::{Plane, Sphere, Vec3};
use ac_client::physics::collision::{PhysicsTree, PolygonList, SourceNode, make_plane};
use ac_client::profile::Profile;

/// Polygons this near to a splitting plane lie on it.
const ON_PLANE: f32 = 1e-4;
/// Leaves have no more polygons than this, if splitting helps.
const LEAF_POLYGONS: usize = 3;
/// Levels that the builder makes.
const LEVELS: usize = 40;

enum Node {
    Inner {
        plane: Plane,
        sphere: Sphere,
        children: [usize; 2],
    },
    Leaf {
        solid: i32,
        sphere: Sphere,
        keys: Vec<u16>,
    },
}

struct Builder<'a> {
    polygons: &'a [Vec<Vec3>],
    planes: Vec<Plane>,
    nodes: Vec<Node>,
}

impl Builder<'_> {
    fn sphere(&self, keys: &[u16]) -> Sphere {
        let corners = || keys.iter().flat_map(|&k| &self.polygons[usize::from(k)]);
        let count = corners().count().max(1) as f32;
        let center = corners().fold(Vec3::ZERO, |a, &b| a + b) / count;
        let radius = corners()
            .map(|c| (*c - center).length())
            .fold(0.0, f32::max);
        Sphere::new(center, radius + 0.01)
    }

    fn sides(&self, plane: &Plane, keys: &[u16]) -> [Vec<u16>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        for &key in keys {
            let corners = &self.polygons[usize::from(key)];
            let front = corners.iter().any(|c| plane.distance(*c) > ON_PLANE);
            let back = corners.iter().any(|c| plane.distance(*c) < -ON_PLANE);
            // What lies on the plane bounds the matter behind it.
            if front || !back {
                sides[0].push(key);
            }
            if back || !front {
                sides[1].push(key);
            }
        }
        sides
    }

    /// The splitting plane that leaves the fewest polygons on its fuller side: of some of the polygons, and of the axes.
    fn best_split(&self, keys: &[u16]) -> Option<(Plane, [Vec<u16>; 2])> {
        let center = self.sphere(keys).center;
        let own = keys
            .iter()
            .step_by(keys.len().div_ceil(8))
            .map(|&k| self.planes[usize::from(k)]);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|n| Plane::from_normal_and_point(n, center));
        own.chain(axes)
            .filter(|plane| plane.d.is_finite() && plane.n.is_finite())
            .map(|plane| (plane, self.sides(&plane, keys)))
            .min_by_key(|(_, sides)| sides[0].len().max(sides[1].len()))
            .filter(|(_, sides)| sides[0].len().max(sides[1].len()) < keys.len())
    }

    fn add(&mut self, keys: Vec<u16>, level: usize, solid: i32) -> usize {
        let number = self.nodes.len();
        let sphere = self.sphere(&keys);
        let split = if keys.len() > LEAF_POLYGONS && level < LEVELS {
            self.best_split(&keys)
        } else {
            None
        };
        let Some((plane, [front, back])) = split else {
            self.nodes.push(Node::Leaf {
                solid,
                sphere,
                keys,
            });
            return number;
        };
        self.nodes.push(Node::Inner {
            plane,
            sphere,
            children: [0; 2],
        });
        let made = [self.add(front, level + 1, 0), self.add(back, level + 1, 1)];
        if let Node::Inner { children, .. } = &mut self.nodes[number] {
            *children = made;
        }
        number
    }
}

/// The tree of at most 65535 polygons.
pub fn tree(polygons: &[Vec<Vec3>], profile: &Profile) -> PhysicsTree {
    let mut list = PolygonList::default();
    for (key, corners) in polygons.iter().enumerate() {
        list.push(key as u16, corners.iter().copied(), true, profile);
    }
    let mut builder = Builder {
        polygons,
        planes: polygons.iter().map(|p| make_plane(p, profile)).collect(),
        nodes: Vec::new(),
    };
    builder.add((0..polygons.len() as u16).collect(), 0, 0);
    let source: Vec<SourceNode<'_>> = builder
        .nodes
        .iter()
        .map(|node| match node {
            Node::Inner {
                plane,
                sphere,
                children,
            } => SourceNode::Inner {
                plane: *plane,
                sphere: *sphere,
                positive: Some(children[0]),
                negative: Some(children[1]),
            },
            Node::Leaf {
                solid,
                sphere,
                keys,
            } => SourceNode::Leaf {
                solid: *solid,
                sphere: *sphere,
                polygons: keys,
            },
        })
        .collect();
    PhysicsTree::new(&source, &list).expect("the builder makes a tree")
}

/// The six faces of a box, seen from outside or, `inwards`, from inside.
pub fn cuboid(min: Vec3, max: Vec3, inwards: bool) -> Vec<Vec<Vec3>> {
    let corner = |i: usize| {
        Vec3::new(
            if i & 1 == 0 { min.x } else { max.x },
            if i & 2 == 0 { min.y } else { max.y },
            if i & 4 == 0 { min.z } else { max.z },
        )
    };
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    faces
        .iter()
        .map(|face| {
            let mut corners: Vec<Vec3> = face.iter().map(|&i| corner(i)).collect();
            if inwards {
                corners.reverse();
            }
            corners
        })
        .collect()
}

/// A hilly floor of `side` × `side` squares of 1 m, each of two triangles, centred on the origin.
pub fn hills(side: usize) -> Vec<Vec<Vec3>> {
    let point = |x: usize, y: usize| {
        let (a, b) = (x as f32, y as f32);
        let half = side as f32 * 0.5;
        Vec3::new(
            a - half,
            b - half,
            (a * 0.7).sin() * 0.4 + (b * 0.45).cos() * 0.5,
        )
    };
    (0..side * side)
        .flat_map(|i| {
            let (x, y) = (i % side, i / side);
            let (a, b, c, d) = (
                point(x, y),
                point(x + 1, y),
                point(x + 1, y + 1),
                point(x, y + 1),
            );
            [vec![a, b, c], vec![a, c, d]]
        })
        .collect()
}
