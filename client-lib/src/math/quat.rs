//! Quaternions in the order w, x, y, z (`spec/01`, section 6).

use glam::Vec4;

use super::vector::EPSILON;
use super::{Vec3, vector};
use crate::profile::{Profile, RotateVector};

/// A rotation `(w, x, y, z)`, Hamilton product, rotating column vectors: `v' = q v q*`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quat {
    /// Real part.
    pub w: f32,
    /// First imaginary part.
    pub x: f32,
    /// Second imaginary part.
    pub y: f32,
    /// Third imaginary part.
    pub z: f32,
}

impl Quat {
    /// No rotation.
    pub const IDENTITY: Self = Self::new(1.0, 0.0, 0.0, 0.0);

    /// A quaternion from its components; not normalised.
    pub const fn new(w: f32, x: f32, y: f32, z: f32) -> Self {
        Self { w, x, y, z }
    }

    /// The product `self · rhs`: first `rhs`, then `self`. Terms are added in the order of the specification (6.1).
    #[inline]
    pub fn product(self, rhs: Self) -> Self {
        // Lanes w, x, y, z. A difference is the sum with the negated term, bit for bit.
        let (a, b) = (self, rhs);
        let sum = Vec4::new(b.w, b.x, b.y, b.z) * a.w
            + Vec4::new(-b.x, b.w, -b.z, b.y) * a.x
            + Vec4::new(-b.y, b.z, b.w, -b.x) * a.y
            + Vec4::new(-b.z, -b.y, b.x, b.w) * a.z;
        Self::new(sum.x, sum.y, sum.z, sum.w)
    }

    /// The conjugate `(w, −x, −y, −z)`.
    #[inline]
    pub fn conjugate(self) -> Self {
        Self::new(self.w, -self.x, -self.y, -self.z)
    }

    /// All four components negated: the same rotation.
    pub fn negated(self) -> Self {
        Self::new(-self.w, -self.x, -self.y, -self.z)
    }

    /// The inverse as profile `ace` computes it: the conjugate divided by the squared length.
    pub fn inverse(self) -> Self {
        let k = (self.x * self.x + self.y * self.y) + (self.z * self.z + self.w * self.w);
        Self::new(self.w / k, -self.x / k, -self.y / k, -self.z / k)
    }

    /// Sum of the products of the components: w, x, y, z.
    #[inline]
    pub fn dot(self, rhs: Self) -> f32 {
        self.w * rhs.w + self.x * rhs.x + self.y * rhs.y + self.z * rhs.z
    }

    /// Length; terms added in the order x, y, z, w.
    #[inline]
    pub fn length(self) -> f32 {
        (self.x * self.x + self.y * self.y + self.z * self.z + self.w * self.w).sqrt()
    }

    /// Unit quaternion; NaN for the zero quaternion.
    #[inline]
    pub fn normalized(self, profile: &Profile) -> Self {
        match profile.rotate_vector {
            RotateVector::Matrix => {
                let k = 1.0 / self.length();
                Self::new(self.w * k, self.x * k, self.y * k, self.z * k)
            }
            RotateVector::Quaternion => {
                let l = ((self.x * self.x + self.y * self.y) + (self.z * self.z + self.w * self.w))
                    .sqrt();
                Self::new(self.w / l, self.x / l, self.y / l, self.z / l)
            }
        }
    }

    /// Whether no component is NaN and the squared length (`01:F10`: the length) is within 5 ε of 1.
    #[inline]
    pub fn is_valid(self, profile: &Profile) -> bool {
        let s = self.w * self.w + self.x * self.x + self.y * self.y + self.z * self.z;
        let measure = if profile.rotation_valid_by_length {
            s.sqrt()
        } else {
            s
        };
        // A NaN component makes the sum NaN, and the comparison false.
        (measure - 1.0).abs() <= EPSILON * 5.0
    }

    /// Whether all four components differ by less than ε. `q` and `−q` are not equal.
    pub fn is_equal(self, rhs: Self, profile: &Profile) -> bool {
        vector::near(self.w, rhs.w, profile)
            && vector::near(self.x, rhs.x, profile)
            && vector::near(self.y, rhs.y, profile)
            && vector::near(self.z, rhs.z, profile)
    }

    /// Rotates a vector by the quaternion form of `spec/oracles.md`, 4.2 (profile `ace`).
    #[inline(never)]
    pub(super) fn rotate(self, v: Vec3) -> Vec3 {
        let Self { w, x, y, z } = self;
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (wx2, wy2, wz2) = (w * x2, w * y2, w * z2);
        let (xx2, xy2, xz2) = (x * x2, x * y2, x * z2);
        let (yy2, yz2, zz2) = (y * y2, y * z2, z * z2);
        Vec3::new(
            v.x * (1.0 - yy2 - zz2) + v.y * (xy2 - wz2) + v.z * (xz2 + wy2),
            v.x * (xy2 + wz2) + v.y * (1.0 - xx2 - zz2) + v.z * (yz2 - wx2),
            v.x * (xz2 - wy2) + v.y * (yz2 + wx2) + v.z * (1.0 - xx2 - yy2),
        )
    }

    /// Rows of the rotation's matrix in the form of `spec/oracles.md`, 4.2 (profile `ace`): row i is the image of axis i.
    pub(super) fn matrix_rows(self) -> [Vec3; 3] {
        let Self { w, x, y, z } = self;
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let (wx, wy, wz) = (w * x, w * y, w * z);
        [
            Vec3::new(1.0 - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)),
            Vec3::new(2.0 * (xy - wz), 1.0 - 2.0 * (zz + xx), 2.0 * (yz + wx)),
            Vec3::new(2.0 * (xz + wy), 2.0 * (yz - wx), 1.0 - 2.0 * (yy + xx)),
        ]
    }

    /// Rotates a vector back through [`Quat::matrix_rows`]; the sum ends with an addition of 0, which turns −0 into 0.
    #[inline(never)]
    pub(super) fn rotate_back(self, v: Vec3) -> Vec3 {
        let rows = self.matrix_rows();
        Vec3::new(v.dot(rows[0]), v.dot(rows[1]), v.dot(rows[2])) + Vec3::ZERO
    }
}

impl Default for Quat {
    fn default() -> Self {
        Self::IDENTITY
    }
}
