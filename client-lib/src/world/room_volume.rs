//! The volume of an indoor cell in block coordinates: quick answers about spheres and points where rounding cannot matter.
//!
//! The exact tests (`spec/04-collision-primitives.md`, 10.8) are made in the cell's own space. The same planes, brought to block coordinates once,
//! give the same distances but for rounding, so whatever is farther from every limit than a margin needs no exact test.

use crate::math::{EPSILON, Frame, Plane, Vec3};
use crate::physics::collision::CellTree;

/// What rounding cannot amount to, m: a hundred times what it does within [`FARTHEST`].
const MARGIN: f32 = 0.02;
/// Coordinates beyond this, m, get no quick answer.
const FARTHEST: f32 = 2000.0;
/// How far squared lengths may be from 1.
const UNIT_TOLERANCE: f32 = 0.01;

/// Planes that bound a room, block coordinates; their normals point inwards.
#[derive(Debug, Clone, Default)]
pub struct RoomVolume {
    /// `None`: something about the planes is unusual, and there are no quick answers.
    planes: Option<Box<[Plane]>>,
}

/// A quick answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quick {
    /// What the exact test says.
    pub answer: bool,
    /// It says so of every place nearer than this, m.
    pub holds_within: f32,
}

fn is_unit(length_squared: f32) -> bool {
    (length_squared - 1.0).abs() <= UNIT_TOLERANCE
}

fn is_far(p: Vec3) -> bool {
    let near = p.x.abs() < FARTHEST && p.y.abs() < FARTHEST && p.z.abs() < FARTHEST;
    !near
}

impl RoomVolume {
    /// The volume of a room at `frame`.
    pub fn new(tree: &CellTree, frame: &Frame) -> Self {
        let rotation = frame.rotation();
        let turns = is_unit(rotation.dot(rotation)) && !is_far(frame.origin);
        // The plane that stands for a leaf bounds nothing.
        let walls = tree.planes().iter().filter(|&&p| p != Plane::ZERO);
        let usual = |p: &Plane| is_unit(p.n.length_squared()) && p.d.abs() < FARTHEST;
        if !turns || !walls.clone().all(usual) {
            return Self::default();
        }
        let rows = frame.rows();
        Self {
            planes: Some(
                walls
                    .map(|p| {
                        let n = rows[0] * p.n.x + rows[1] * p.n.y + rows[2] * p.n.z;
                        let d = p.d - n.dot(frame.origin);
                        Plane { n, d }
                    })
                    .collect(),
            ),
        }
    }

    /// Whether all planes have a point farther in front than `limit`, by more than the margin, or one has it farther behind.
    #[inline]
    fn is_in_front(&self, point: Vec3, limit: f32) -> Option<Quick> {
        let planes = self.planes.as_deref()?;
        if is_far(point) {
            return None;
        }
        let mut least = FARTHEST;
        for plane in planes {
            let h = plane.distance(point);
            if h < least {
                least = h;
            }
        }
        let beyond = least - limit;
        let sure = beyond.abs() > MARGIN;
        sure.then(|| Quick {
            answer: beyond > 0.0,
            // Normals are not exactly of length 1.
            holds_within: (beyond.abs() - MARGIN) * 0.9,
        })
    }

    /// Whether a sphere reaches into the room; `None` where only the exact test can tell.
    #[inline]
    pub fn touches(&self, center: Vec3, radius: f32) -> Option<Quick> {
        /// A sphere counts as that much wider, m.
        const WIDER: f32 = 0.01;
        if radius >= 0.0 {
            self.is_in_front(center, -(radius + WIDER))
        } else {
            None
        }
    }

    /// Whether a point is in the room; `None` where only the exact test can tell.
    #[inline]
    pub fn contains(&self, point: Vec3) -> Option<Quick> {
        self.is_in_front(point, -EPSILON)
    }
}

#[cfg(test)]
mod tests {
    use super::{Quick, RoomVolume};
    use crate::math::{Frame, Plane, Quat, Sphere, Vec3};
    use crate::physics::collision::{BoundingType, CellTree};
    use crate::profile::Profile;
    use proptest::prelude::*;

    fn vectors(reach: f32) -> impl Strategy<Value = Vec3> {
        [-reach..reach, -reach..reach, -reach..reach].prop_map(|[x, y, z]| Vec3::new(x, y, z))
    }

    fn room() -> impl Strategy<Value = (CellTree, Frame)> {
        let plane = (vectors(1.0), -1.0f32..6.0).prop_filter_map("a direction", |(n, d)| {
            Some(Plane {
                n: n.try_normalize()?,
                d,
            })
        });
        let turn = (vectors(1.0), -1.0f32..1.0).prop_filter_map("a turn", |(v, w)| {
            let length = (v.length_squared() + w * w).sqrt();
            (length > 0.1).then(|| Quat::new(w / length, v.x / length, v.y / length, v.z / length))
        });
        let planes = proptest::collection::vec(plane, 0..8);
        (planes, any::<bool>(), turn, vectors(300.0)).prop_map(|(planes, leaf, turn, origin)| {
            (CellTree::new(planes, leaf), Frame::new(origin, turn))
        })
    }

    proptest! {
        #[test]
        fn quick_answers_are_those_of_the_exact_tests(
            (tree, frame) in room(), at in vectors(8.0), step in vectors(1.0), radius in 0.0f32..2.0, ace: bool,
        ) {
            let profile = if ace { Profile::ace() } else { Profile::retail() };
            let point = frame.origin + at;
            let volume = RoomVolume::new(&tree, &frame);
            let places = |quick: Quick| {
                let near = point + step.normalize_or_zero() * quick.holds_within.min(20.0);
                [point, near].map(|p| frame.global_to_local(p, &profile))
            };
            if let Some(quick) = volume.contains(point) {
                for local in places(quick) {
                    prop_assert_eq!(quick.answer, tree.contains(local));
                }
            }
            if let Some(quick) = volume.touches(point, radius) {
                for local in places(quick) {
                    let exact = tree.intersects_sphere(&Sphere::new(local, radius));
                    prop_assert_eq!(quick.answer, exact != BoundingType::Outside);
                }
            }
        }
    }

    #[test]
    fn unusual_rooms_and_places_get_no_quick_answer() {
        let wall = |length: f32| {
            CellTree::new(
                [Plane {
                    n: Vec3::X * length,
                    d: 0.0,
                }],
                false,
            )
        };
        let usual = RoomVolume::new(&wall(1.0), &Frame::IDENTITY);
        let answer = |quick: Option<Quick>| quick.map(|q| q.answer);
        assert_eq!(answer(usual.contains(Vec3::X)), Some(true));
        assert_eq!(usual.contains(Vec3::ZERO), None);
        assert_eq!(usual.contains(Vec3::splat(f32::NAN)), None);
        assert_eq!(usual.touches(Vec3::X, f32::NAN), None);
        assert_eq!(answer(usual.touches(Vec3::X * -9.0, 1.0)), Some(false));
        let scaled = RoomVolume::new(&wall(2.0), &Frame::IDENTITY);
        assert_eq!(scaled.contains(Vec3::X), None);
    }
}
