//! Axis-aligned boxes (`spec/01`, 9.3).

use super::Vec3;
use super::position::Position;
use crate::profile::Profile;

/// An axis-aligned box, m; the space is that of whoever holds it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoundingBox {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl BoundingBox {
    /// The box that contains nothing and that [`BoundingBox::adjust`] grows.
    pub const EMPTY: Self = Self {
        min: Vec3::splat(f32::MAX),
        max: Vec3::splat(-f32::MAX),
    };

    /// Extends the box to contain `p`.
    pub fn adjust(&mut self, p: Vec3) {
        for i in 0..3 {
            if p[i] < self.min[i] {
                self.min[i] = p[i];
            }
            if p[i] > self.max[i] {
                self.max[i] = p[i];
            }
        }
    }

    /// Extends `other` to contain this box (`spec/04`, 6 item 2). A bound that is not a number extends nothing.
    pub fn merge_into(&self, other: &mut Self) {
        for i in 0..3 {
            if self.min[i] < other.min[i] {
                other.min[i] = self.min[i];
            }
            if self.max[i] > other.max[i] {
                other.max[i] = self.max[i];
            }
        }
    }

    /// Whether `p` is inside; all six faces count.
    pub fn contains(&self, p: Vec3) -> bool {
        (0..3).all(|i| self.min[i] <= p[i] && p[i] <= self.max[i])
    }

    /// The eight corners, x slowest and z fastest.
    pub fn corners(&self) -> [Vec3; 8] {
        let (a, b) = (self.min, self.max);
        [
            a,
            Vec3::new(a.x, a.y, b.z),
            Vec3::new(a.x, b.y, a.z),
            Vec3::new(a.x, b.y, b.z),
            Vec3::new(b.x, a.y, a.z),
            Vec3::new(b.x, a.y, b.z),
            Vec3::new(b.x, b.y, a.z),
            b,
        ]
    }

    /// The box, local to `from`, in the coordinates of `to`'s landblock.
    pub fn local_to_global(&self, from: &Position, to: &Position, profile: &Profile) -> Self {
        self.transformed(profile, |p| to.landblock_point_of(from, p, profile))
    }

    /// The box, local to `from`, in `to`'s own space.
    pub fn local_to_local(&self, from: &Position, to: &Position, profile: &Profile) -> Self {
        self.transformed(profile, |p| to.local_to_local(from, p, profile))
    }

    /// `01:B1`: profile `ace` starts from the images of both corners as if they were already smallest and largest.
    fn transformed(&self, profile: &Profile, image: impl Fn(Vec3) -> Vec3) -> Self {
        let (a, b) = (self.min, self.max);
        let first = image(a);
        let mut result = if profile.box_transform_biased {
            Self {
                min: first,
                max: image(b),
            }
        } else {
            let mut one = Self {
                min: first,
                max: first,
            };
            one.adjust(image(b));
            one
        };
        let rest = [
            Vec3::new(b.x, b.y, a.z),
            Vec3::new(b.x, a.y, b.z),
            Vec3::new(a.x, b.y, b.z),
            Vec3::new(b.x, a.y, a.z),
            Vec3::new(a.x, b.y, a.z),
            Vec3::new(a.x, a.y, b.z),
        ];
        for corner in rest {
            result.adjust(image(corner));
        }
        result
    }
}
