//! Planes, rays and spheres (`spec/01`, section 9).

use super::position::Position;
use super::vector::EPSILON;
use super::{BoundingBox, Vec3};
use crate::profile::{Profile, Width};

/// Points `p` with `n·p + d = 0`; the space is that of whoever holds the plane.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Plane {
    /// Unit normal.
    pub n: Vec3,
    /// Minus the signed distance of the plane from the origin, m.
    pub d: f32,
}

/// On which side of a plane something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Sidedness {
    /// In front: the signed distance is greater than the tolerance.
    Positive = 0,
    /// Behind.
    Negative = 1,
    /// Within the tolerance, or NaN.
    InPlane = 2,
    /// On both sides.
    Crossing = 3,
}

/// A start point (m), a unit direction and a length (m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ray {
    /// Start.
    pub point: Vec3,
    /// Unit direction; zero for a ray without length, which intersects nothing.
    pub dir: Vec3,
    /// Length.
    pub length: f32,
}

/// A centre and a radius, m.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius.
    pub radius: f32,
}

impl Plane {
    /// The plane of records that nobody has set: zero normal, zero distance.
    pub const ZERO: Self = Self {
        n: Vec3::ZERO,
        d: 0.0,
    };

    /// The plane through `point` with normal `n`, taken as given.
    pub fn from_normal_and_point(n: Vec3, point: Vec3) -> Self {
        Self {
            n,
            d: -n.dot(point),
        }
    }

    /// Signed distance of a point (`dot_product`).
    #[inline]
    pub fn distance(&self, p: Vec3) -> f32 {
        self.n.dot(p) + self.d
    }

    /// Side of a point with tolerance `near`.
    pub fn which_side(&self, p: Vec3, near: f32) -> Sidedness {
        let s = self.distance(p);
        if s > near {
            Sidedness::Positive
        } else if s < -near {
            Sidedness::Negative
        } else {
            Sidedness::InPlane
        }
    }

    /// Height of the plane above (x, y) of `v`; `None` if the plane is all but vertical.
    pub fn height_at(&self, v: Vec3) -> Option<f32> {
        if self.n.z.abs() <= EPSILON {
            None
        } else {
            Some(-((v.y * self.n.y + v.x * self.n.x + self.d) / self.n.z))
        }
    }

    /// Makes an offset parallel to the plane by changing its z; nothing happens for an all but vertical plane (`01:V2`).
    pub fn snap_to_plane(&self, offset: &mut Vec3, profile: &Profile) {
        if self.n.z.abs() <= EPSILON || self.n.z.is_nan() {
            return;
        }
        let products = offset.x * self.n.x + offset.y * self.n.y;
        offset.z = match profile.snap_to_plane {
            Width::F32 => -(products + self.d) * (1.0 / self.n.z) - (1.0 / self.n.z) * -self.d,
            Width::F64 => {
                let (d, k) = (f64::from(self.d), 1.0 / f64::from(self.n.z));
                (-(f64::from(products) + d) * k - k * -d) as f32
            }
        };
    }

    /// Multiple of the ray's direction at which it meets the plane, and whether that is ahead; `None` if it runs along the plane.
    pub fn time_of_intersection(&self, ray: &Ray) -> Option<(f32, bool)> {
        let along = ray.dir.dot(self.n);
        if along.abs() < EPSILON {
            return None;
        }
        let t = (ray.point.dot(self.n) + self.d) * (-1.0 / along);
        Some((t, t >= 0.0))
    }

    /// A plane of `from`'s own space in the coordinates of `to`'s landblock.
    pub fn local_to_global(&self, to: &Position, from: &Position, profile: &Profile) -> Self {
        let n = from.frame.local_to_global_vec(self.n, profile);
        let point = to.landblock_point_of(from, self.n * -self.d, profile);
        Self {
            n,
            d: -n.dot(point),
        }
    }

    /// On which side of the plane a box is (9.1; `01:B2`).
    pub fn intersect_box(&self, bounds: &BoundingBox, profile: &Profile) -> Sidedness {
        let side = |p: Vec3| {
            if profile.box_transform_biased {
                let s = self.distance(p) + EPSILON;
                if s > 0.0 {
                    Sidedness::Positive
                } else if s < 0.0 {
                    Sidedness::Negative
                } else {
                    Sidedness::InPlane
                }
            } else {
                self.which_side(p, EPSILON)
            }
        };
        let corners = bounds.corners();
        let first = side(corners[0]);
        if first == Sidedness::InPlane || corners[1..].iter().any(|&c| side(c) != first) {
            Sidedness::Crossing
        } else {
            first
        }
    }
}

impl Ray {
    /// The ray from `start` along `offset`; a zero ray if the offset is shorter than ε in every component.
    #[inline]
    pub fn new(start: Vec3, offset: Vec3) -> Self {
        if super::vector::is_zero(offset) {
            return Self::default();
        }
        let length = offset.length();
        Self {
            point: start,
            dir: offset * (1.0 / length),
            length,
        }
    }
}

impl Sphere {
    /// A sphere.
    #[inline]
    pub const fn new(center: Vec3, radius: f32) -> Self {
        Self { center, radius }
    }

    /// Centre and radius multiplied by `scale`.
    #[inline]
    pub fn scaled(&self, scale: f32) -> Self {
        Self {
            center: self.center * scale,
            radius: self.radius * scale,
        }
    }
}
