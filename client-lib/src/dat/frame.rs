//! A frame as it is stored: origin and orientation, without the cached matrix of `math::Frame`.

use serde::Serialize;

use crate::math::{Frame, Quat, Vec3};

/// Origin (metres) and orientation, 28 bytes on disk. The space is that of the owner: landblock for stabs and rooms, object for parts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StoredFrame {
    /// Origin in the owner's space, metres.
    pub origin: Vec3,
    /// Orientation; kept as stored, not normalised.
    #[serde(with = "quat_array")]
    pub rotation: Quat,
}

impl StoredFrame {
    /// No displacement, no rotation.
    pub const IDENTITY: Self = Self {
        origin: Vec3::ZERO,
        rotation: Quat {
            w: 1.0,
            x: 0.0,
            y: 0.0,
            z: 0.0,
        },
    };

    /// A frame at `origin` without rotation.
    #[must_use]
    pub fn at(origin: Vec3) -> Self {
        Self {
            origin,
            ..Self::IDENTITY
        }
    }
}

impl Default for StoredFrame {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// Quaternions as `[w, x, y, z]` in JSON, whatever their own form is.
mod quat_array {
    use serde::{Serialize, Serializer};

    use crate::math::Quat;

    pub(super) fn serialize<S: Serializer>(q: &Quat, s: S) -> Result<S::Ok, S::Error> {
        [q.w, q.x, q.y, q.z].serialize(s)
    }
}

impl From<StoredFrame> for Frame {
    fn from(f: StoredFrame) -> Self {
        Self::new(f.origin, f.rotation)
    }
}
