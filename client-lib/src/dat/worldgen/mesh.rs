//! Polygon soups: boxes, ramps, prisms, and walls with doorways.
//!
//! A face is convex and flat, counter-clockwise seen from its front. Solid matter is behind a physics polygon: the faces of an object look
//! outwards, those of a room into the room.

use glam::DVec3;

use crate::math::Vec3;

/// One polygon of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// Corners, counter-clockwise seen from the front; metres.
    pub points: Vec<Vec3>,
    /// Index into the surfaces of the owner.
    pub surface: i16,
}

impl Face {
    /// A face with surface 0.
    #[must_use]
    pub fn new(points: Vec<Vec3>) -> Self {
        Self { points, surface: 0 }
    }

    /// The same seen from the other side.
    #[must_use]
    pub fn flipped(&self) -> Self {
        Self {
            points: self.points.iter().rev().copied().collect(),
            surface: self.surface,
        }
    }

    pub(super) fn corners(&self) -> Vec<DVec3> {
        self.points.iter().map(|p| p.as_dvec3()).collect()
    }
}

/// An axis of space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// East.
    X,
    /// North.
    Y,
    /// Up.
    Z,
}

impl Axis {
    /// The two other axes, in order.
    fn others(self) -> [usize; 2] {
        match self {
            Self::X => [1, 2],
            Self::Y => [0, 2],
            Self::Z => [0, 1],
        }
    }

    fn index(self) -> usize {
        self as usize
    }

    /// A point with coordinate `a` along this axis and `u`, `v` along the others.
    fn point(self, a: f32, u: f32, v: f32) -> Vec3 {
        let mut p = [0.0; 3];
        let [i, j] = self.others();
        (p[self.index()], p[i], p[j]) = (a, u, v);
        p.into()
    }
}

/// A rectangle in the two axes other than that of its normal, in their order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// From and to in the first axis.
    pub u: [f32; 2],
    /// From and to in the second axis.
    pub v: [f32; 2],
}

/// An axis-aligned rectangle at `at` along `axis`; its front is on the side of +axis if `positive`.
#[must_use]
pub fn rectangle(axis: Axis, at: f32, rect: Rect, positive: bool) -> Face {
    let Rect {
        u: [u0, u1],
        v: [v0, v1],
    } = rect;
    let ring = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)];
    let mut points: Vec<Vec3> = ring.iter().map(|&(u, v)| axis.point(at, u, v)).collect();
    // The pair of other axes is right-handed for x and z, left-handed for y.
    if positive == (axis == Axis::Y) {
        points.reverse();
    }
    Face::new(points)
}

/// The six faces of a box, looking outwards.
#[must_use]
pub fn block(low: Vec3, high: Vec3) -> Vec<Face> {
    let (low, high) = (low.to_array(), high.to_array());
    let mut faces = Vec::with_capacity(6);
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let [i, j] = axis.others();
        let rect = Rect {
            u: [low[i], high[i]],
            v: [low[j], high[j]],
        };
        faces.push(rectangle(axis, low[axis.index()], rect, false));
        faces.push(rectangle(axis, high[axis.index()], rect, true));
    }
    faces
}

/// A ramp that rises along +x from the origin; base on z = 0, width centred on y = 0.
#[must_use]
pub fn ramp(length: f32, width: f32, height: f32) -> Vec<Face> {
    prism(
        &[[0.0, 0.0], [length, 0.0], [length, height]],
        Axis::Y,
        -width / 2.0,
        width / 2.0,
    )
}

/// Extrudes a convex profile between `low` and `high` along `axis`; faces look outwards.
///
/// The profile is counter-clockwise in the two other axes, in their order.
#[must_use]
pub fn prism(profile: &[[f32; 2]], axis: Axis, low: f32, high: f32) -> Vec<Face> {
    let cap = |a: f32| Face::new(profile.iter().map(|p| axis.point(a, p[0], p[1])).collect());
    let mut faces = vec![cap(high), cap(low).flipped()];
    for (i, p) in profile.iter().enumerate() {
        let q = profile[(i + 1) % profile.len()];
        let corners = [(low, *p), (low, q), (high, q), (high, *p)];
        faces.push(Face::new(
            corners
                .iter()
                .map(|(a, p)| axis.point(*a, p[0], p[1]))
                .collect(),
        ));
    }
    if axis == Axis::Y {
        faces = faces.iter().map(Face::flipped).collect();
    }
    faces
}

/// A wall with holes: the rectangle less the holes, cut into rectangles.
#[must_use]
pub fn wall(axis: Axis, at: f32, rect: Rect, holes: &[Rect], positive: bool) -> Vec<Face> {
    let cuts = |outer: [f32; 2], inner: &dyn Fn(&Rect) -> [f32; 2]| {
        let mut list: Vec<f32> = outer
            .into_iter()
            .chain(holes.iter().flat_map(inner))
            .collect();
        list.retain(|c| (outer[0]..=outer[1]).contains(c));
        list.sort_by(f32::total_cmp);
        list.dedup();
        list
    };
    let (us, vs) = (cuts(rect.u, &|h| h.u), cuts(rect.v, &|h| h.v));
    let open = |u: usize, v: usize| {
        let (um, vm) = ((us[u] + us[u + 1]) / 2.0, (vs[v] + vs[v + 1]) / 2.0);
        holes
            .iter()
            .any(|h| h.u[0] < um && um < h.u[1] && h.v[0] < vm && vm < h.v[1])
    };
    let mut faces = Vec::new();
    for u in 0..us.len().saturating_sub(1) {
        let mut v = 0;
        while v + 1 < vs.len() {
            let begin = v;
            while v + 1 < vs.len() && !open(u, v) {
                v += 1;
            }
            if v > begin {
                let part = Rect {
                    u: [us[u], us[u + 1]],
                    v: [vs[begin], vs[v]],
                };
                faces.push(rectangle(axis, at, part, positive));
            }
            v += 1;
        }
    }
    faces
}
