//! Frames: an origin and a rotation, with the rotation's matrix kept beside it (`spec/01`, section 7).

use glam::Vec4;

use super::Vec3;
use super::quat::Quat;
use super::trig::{acos, cos, sin};
use super::vector::{self, EPSILON};
use crate::profile::{Profile, RotateVector, RotationVector, UndoCombine, Unmoved};

/// Origin (m) and rotation of one coordinate space in another, its parent.
///
/// The matrix of the rotation is computed whenever the rotation is written and read by every transformation of a point: a frame is
/// transformed through far more often than it turns. Retail name: `AFrame`, `Frame`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Frame {
    /// Row i is the image of local axis i in the parent's space. The fields are in this order so that every vector is followed by a number
    /// and can be read as four lanes at once.
    rows: [Vec3; 3],
    /// Place of the local origin in the parent's space, m.
    pub origin: Vec3,
    rotation: Quat,
}

impl Frame {
    /// No translation, no rotation.
    pub const IDENTITY: Self = Self {
        origin: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        rows: [Vec3::X, Vec3::Y, Vec3::Z],
    };

    /// A frame from data: the rotation is taken as it is, without normalising (7.1).
    pub fn new(origin: Vec3, rotation: Quat) -> Self {
        let mut frame = Self {
            origin,
            rotation,
            rows: [Vec3::ZERO; 3],
        };
        frame.cache();
        frame
    }

    /// A frame without rotation.
    pub const fn from_origin(origin: Vec3) -> Self {
        Self {
            origin,
            ..Self::IDENTITY
        }
    }

    /// Origin and rotation: all that is not computed from something else.
    pub(crate) const fn parts(&self) -> (Vec3, Quat) {
        let Self {
            origin,
            rotation,
            rows: _,
        } = *self;
        (origin, rotation)
    }

    /// The rotation.
    pub const fn rotation(&self) -> Quat {
        self.rotation
    }

    /// The matrix as it is kept: row i is the image of local axis i in the parent's space.
    #[inline]
    pub(crate) const fn rows(&self) -> &[Vec3; 3] {
        &self.rows
    }

    /// The axes as the profile computes them: row i is the image of local axis i in the parent's space. Profile `ace` builds
    /// the matrix in another form (`spec/oracles.md`, 4.2).
    pub fn axes(&self, profile: &Profile) -> [Vec3; 3] {
        match profile.rotate_vector {
            RotateVector::Matrix => self.rows,
            RotateVector::Quaternion => self.rotation.matrix_rows(),
        }
    }

    /// The local +Y axis in the parent's space (`get_vector_heading`).
    pub fn forward(&self, profile: &Profile) -> Vec3 {
        self.axes(profile)[1]
    }

    /// Takes a rotation as it is, without normalising: for state that was stored by another program.
    #[inline]
    pub fn set_rotation_raw(&mut self, rotation: Quat) {
        self.rotation = rotation;
        self.cache();
    }

    /// Normalises a rotation and takes it (`set_rotate`, 7.1).
    #[inline]
    pub fn set_rotation(&mut self, rotation: Quat, profile: &Profile) {
        self.set_rotation_raw(rotation.normalized(profile));
    }

    /// The rows of the matrix as lanes; the fourth lane means nothing.
    #[inline(always)]
    fn row_lanes(&self) -> [Vec4; 3] {
        let ([r0, r1, r2], o) = (&self.rows, &self.origin);
        [
            Vec4::new(r0.x, r0.y, r0.z, r1.x),
            Vec4::new(r1.x, r1.y, r1.z, r2.x),
            Vec4::new(r2.x, r2.y, r2.z, o.x),
        ]
    }

    /// The origin as lanes; the fourth lane means nothing.
    #[inline(always)]
    fn origin_lanes(&self) -> Vec4 {
        let o = &self.origin;
        Vec4::new(o.x, o.y, o.z, self.rotation.w)
    }

    #[inline]
    fn cache(&mut self) {
        let Quat { w, x, y, z } = self.rotation;
        let (x2, y2, z2) = (x * 2.0, y * 2.0, z * 2.0);
        self.rows = [
            Vec3::new(1.0 - y * y2 - z * z2, x * y2 + w * z2, x * z2 - w * y2),
            Vec3::new(x * y2 - w * z2, 1.0 - x * x2 - z * z2, y * z2 + w * x2),
            Vec3::new(x * z2 + w * y2, y * z2 - w * x2, 1.0 - x * x2 - y * y2),
        ];
    }

    /// A direction of this space in the parent's space.
    #[inline(always)]
    pub fn local_to_global_vec(&self, p: Vec3, profile: &Profile) -> Vec3 {
        match profile.rotate_vector {
            RotateVector::Matrix => {
                let [r0, r1, r2] = self.row_lanes();
                (r0 * p.x + r1 * p.y + r2 * p.z).truncate()
            }
            RotateVector::Quaternion => self.rotation.rotate(p),
        }
    }

    /// A point of this space in the parent's space.
    #[inline(always)]
    pub fn local_to_global(&self, p: Vec3, profile: &Profile) -> Vec3 {
        match profile.rotate_vector {
            // The origin is the first term.
            RotateVector::Matrix => {
                let [r0, r1, r2] = self.row_lanes();
                (self.origin_lanes() + r0 * p.x + r1 * p.y + r2 * p.z).truncate()
            }
            RotateVector::Quaternion => self.origin + self.rotation.rotate(p),
        }
    }

    /// A direction of the parent's space in this space.
    #[inline(always)]
    pub fn global_to_local_vec(&self, p: Vec3, profile: &Profile) -> Vec3 {
        match profile.rotate_vector {
            RotateVector::Matrix => Vec3::new(
                p.dot(self.rows[0]),
                p.dot(self.rows[1]),
                p.dot(self.rows[2]),
            ),
            RotateVector::Quaternion => self.rotation.rotate_back(p),
        }
    }

    /// A point of the parent's space in this space.
    #[inline(always)]
    pub fn global_to_local(&self, p: Vec3, profile: &Profile) -> Vec3 {
        self.global_to_local_vec(p - self.origin, profile)
    }

    /// A point of another frame's space in this space; both frames have the same parent.
    #[inline]
    pub fn local_to_local(&self, other: &Self, p: Vec3, profile: &Profile) -> Vec3 {
        self.global_to_local(other.local_to_global(p, profile), profile)
    }

    /// Frame `b`, expressed in `self`, brought to `self`'s parent (`combine`, 7.3).
    #[inline]
    pub fn combine(&self, b: &Self, profile: &Profile) -> Self {
        self.combine_origin(b.origin, b.rotation, profile)
    }

    /// As [`Frame::combine`], with `b`'s origin multiplied per component by `scale`.
    #[inline]
    pub fn combine_scaled(&self, b: &Self, scale: Vec3, profile: &Profile) -> Self {
        self.combine_origin(b.origin * scale, b.rotation, profile)
    }

    /// As [`Frame::combine`], for a frame that is stored without its matrix, which is not needed.
    #[inline]
    pub fn combine_origin(&self, origin: Vec3, rotation: Quat, profile: &Profile) -> Self {
        let mut result = Self::from_origin(self.local_to_global(origin, profile));
        result.set_combined_rotation(self.rotation.product(rotation), profile);
        result
    }

    /// `01:F1`: profile `ace` does not normalise products of rotations.
    #[inline]
    fn set_combined_rotation(&mut self, rotation: Quat, profile: &Profile) {
        if profile.combine_normalizes {
            self.set_rotation(rotation, profile);
        } else {
            self.set_rotation_raw(rotation);
        }
    }

    /// Takes `b` off again: undoes a [`Frame::combine`] (`subtract1`, 7.4; `01:F5`).
    pub fn subtract_animation(&self, b: &Self, profile: &Profile) -> Self {
        let (a, c) = (self.rotation, b.rotation.conjugate());
        let mut result = Self::from_origin(self.origin);
        match profile.undo_combine {
            UndoCombine::OriginByB => {
                result.origin = self.origin - b.local_to_global_vec(b.origin, profile);
                result.set_combined_rotation(a.product(b.rotation.inverse()), profile);
            }
            UndoCombine::Inverse | UndoCombine::SignSlip => {
                let mut q = a.product(c);
                if profile.undo_combine == UndoCombine::SignSlip {
                    q.z = a.product(b.rotation).z;
                }
                result.set_combined_rotation(q, profile);
                let (o, [r0, r1, r2]) = (b.origin, &result.rows);
                result.origin = self.origin + r0 * -o.x + r1 * -o.y + r2 * -o.z;
            }
        }
        result
    }

    /// `self` as seen from `base` (`subtract2`, 7.4).
    pub fn relative_to(&self, base: &Self, profile: &Profile) -> Self {
        let mut result = Self::from_origin(base.global_to_local(self.origin, profile));
        let (b, q) = (base.rotation.conjugate(), self.rotation);
        let mut product = b.product(q);
        // The reference sums this one real part in another order; the vectors show it.
        product.w = b.w * q.w - b.y * q.y - b.x * q.x - b.z * q.z;
        result.set_rotation(product, profile);
        result
    }

    /// Turns by a rotation vector (axis times angle, rad) in the parent's axes (7.5; `01:F2`, `01:F3`).
    pub fn grotate(&mut self, angles: Vec3, profile: &Profile) {
        let magnitude = angles.length();
        if profile.grotate_skips_tiny && magnitude < EPSILON {
            return;
        }
        match profile.rotation_vector {
            RotationVector::AxisAngle => {
                let axis = angles * (1.0 / magnitude);
                let half = magnitude * 0.5;
                let (c, v) = (cos(half), axis * sin(half));
                self.set_rotation(Quat::new(c, v.x, v.y, v.z).product(self.rotation), profile);
            }
            RotationVector::YawPitchRoll => {
                let turn = yaw_pitch_roll(angles.x, angles.y, angles.z);
                self.set_rotation(self.rotation.product(turn), profile);
            }
        }
    }

    /// Turns by a rotation vector (axis times angle, rad) in the frame's own axes (7.5).
    pub fn rotate(&mut self, angles: Vec3, profile: &Profile) {
        self.grotate(self.local_to_global_vec(angles, profile), profile);
    }

    /// Takes the rotation given by three angles (rad) about the static axes x, y, z in this order (6.3).
    pub fn set_rotation_euler(&mut self, angles: Vec3, profile: &Profile) {
        let (i, j, h) = (angles.x * 0.5, angles.y * 0.5, angles.z * 0.5);
        let (ci, cj, ch) = (cos(i), cos(j), cos(h));
        let (si, sj, sh) = (sin(i), sin(j), sin(h));
        let (cc, cs, sc, ss) = (ci * ch, ci * sh, si * ch, si * sh);
        let q = Quat::new(
            cj * cc + sj * ss,
            cj * sc - sj * cs,
            cj * ss + sj * cc,
            cj * cs - sj * sc,
        );
        self.set_rotation(q, profile);
    }

    /// Takes a rotation between those of two frames; `t` = 0 gives `from`, 1 gives ±`to` (7.6; `01:F12`). The origin stays.
    pub fn interpolate_rotation(&mut self, from: &Self, to: &Self, t: f32, profile: &Profile) {
        let q1 = from.rotation;
        let mut c = q1.dot(to.rotation);
        let q2 = if c < 0.0 {
            c = -c;
            to.rotation.negated()
        } else {
            to.rotation
        };
        let (k1, k2) = if profile.substep_rotation_linear {
            (1.0 - t, t)
        } else {
            spherical_weights(c, t)
        };
        let mix = |a: f32, b: f32| a * k1 + b * k2;
        let q = Quat::new(
            mix(q1.w, q2.w),
            mix(q1.x, q2.x),
            mix(q1.y, q2.y),
            mix(q1.z, q2.z),
        );
        self.set_rotation(q, profile);
    }

    /// Whether origin and rotation are valid.
    pub fn is_valid(&self, profile: &Profile) -> bool {
        vector::is_valid(self.origin) && self.rotation.is_valid(profile)
    }

    /// Whether only the rotation is invalid.
    pub fn is_valid_except_for_heading(&self, profile: &Profile) -> bool {
        vector::is_valid(self.origin) && !self.rotation.is_valid(profile)
    }

    /// Whether the origins are equal within ε (`01:F7` for the comparison).
    pub fn is_vector_equal(&self, rhs: &Self, profile: &Profile) -> bool {
        match profile.unmoved {
            Unmoved::Strict => vector::is_equal(self.origin, rhs.origin, profile),
            Unmoved::Inclusive => {
                let d = (self.origin - rhs.origin).abs();
                d.x <= EPSILON && d.y <= EPSILON && d.z <= EPSILON
            }
        }
    }

    /// Whether the rotations are equal within ε, component by component.
    pub fn is_quaternion_equal(&self, rhs: &Self, profile: &Profile) -> bool {
        self.rotation.is_equal(rhs.rotation, profile)
    }

    /// Whether origins and rotations are equal within ε. Profile `ace` compares the origins only (`01:F7`).
    pub fn is_equal(&self, rhs: &Self, profile: &Profile) -> bool {
        let rotations =
            profile.unmoved == Unmoved::Inclusive || self.is_quaternion_equal(rhs, profile);
        self.is_vector_equal(rhs, profile) && rotations
    }

    /// Rotation of the current matrix (`cache_quaternion`, 7.8); only billboards use it.
    pub fn set_rotation_from_rows(&mut self, rows: [Vec3; 3], profile: &Profile) {
        let [r0, r1, r2] = rows;
        let trace = r0.x + r1.y + r2.z + 1.0;
        let q = if trace > EPSILON {
            let s = 2.0 * trace.sqrt();
            Quat::new(
                s / 4.0,
                (r1.z - r2.y) / s,
                (r2.x - r0.z) / s,
                (r0.y - r1.x) / s,
            )
        } else if r0.x > r1.y && r0.x > r2.z {
            let s = 2.0 * (1.0 + r0.x - r1.y - r2.z).sqrt();
            Quat::new(
                (r1.z - r2.y) / s,
                s / 4.0,
                (r0.y + r1.x) / s,
                (r2.x + r0.z) / s,
            )
        } else if r1.y > r2.z {
            let s = 2.0 * (1.0 + r1.y - r0.x - r2.z).sqrt();
            Quat::new(
                (r2.x - r0.z) / s,
                (r0.y + r1.x) / s,
                s / 4.0,
                (r1.z + r2.y) / s,
            )
        } else {
            let s = 2.0 * (1.0 + r2.z - r0.x - r1.y).sqrt();
            Quat::new(
                (r0.y - r1.x) / s,
                (r2.x + r0.z) / s,
                (r1.z + r2.y) / s,
                s / 4.0,
            )
        };
        self.set_rotation(q, profile);
    }

    /// Bits of origin and rotation, for exact comparison and hashing.
    pub fn bits(&self) -> [u32; 7] {
        let (o, q) = (self.origin, self.rotation);
        [o.x, o.y, o.z, q.w, q.x, q.y, q.z].map(f32::to_bits)
    }
}

impl Default for Frame {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl PartialEq for Frame {
    fn eq(&self, rhs: &Self) -> bool {
        self.origin == rhs.origin && self.rotation == rhs.rotation
    }
}

/// Weights of the two rotations for spherical interpolation, with the engine's fallbacks (7.6, steps 2 and 3).
fn spherical_weights(c: f32, t: f32) -> (f32, f32) {
    let rest = (1.0 - f64::from(t)) as f32;
    if 1.0 - f64::from(c) <= f64::from(EPSILON) {
        return (rest, t);
    }
    let v = acos(c);
    let s = (1.0 / f64::from(sin(v))) as f32;
    let (k1, k2) = (s * sin(v * rest), sin(t * v) * s);
    let outside = |k: f32| !(0.0..=1.0).contains(&k) && !k.is_nan();
    if outside(k1) || outside(k2) {
        (rest, t)
    } else {
        (k1, k2)
    }
}

/// Yaw about Y, pitch about X, roll about Z (`spec/oracles.md`, 4.2).
pub(super) fn yaw_pitch_roll(yaw: f32, pitch: f32, roll: f32) -> Quat {
    let (sy, cy) = (sin(yaw * 0.5), cos(yaw * 0.5));
    let (sp, cp) = (sin(pitch * 0.5), cos(pitch * 0.5));
    let (sr, cr) = (sin(roll * 0.5), cos(roll * 0.5));
    Quat::new(
        cy * cp * cr + sy * sp * sr,
        cy * sp * cr + sy * cp * sr,
        sy * cp * cr - cy * sp * sr,
        cy * cp * sr - sy * sp * cr,
    )
}
