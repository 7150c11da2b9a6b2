//! Common shapes of stage records (`spec/stage-format.md`, "File").

use ac_client::math::{CellId, Frame, Plane, Position, Quat, Sphere, Vec3};
use ac_client::physics::transition::ContactPlane;
use ac_golden_traces::number;
use serde::{Deserialize, Serialize};

/// An id or flag word.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Hex(#[serde(with = "number::hex")] pub u32);

/// A vector.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Vector(#[serde(with = "number::floats")] pub [f32; 3]);

/// A quaternion, w first.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Rotation(#[serde(with = "number::floats")] pub [f32; 4]);

/// A position.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct PositionJson {
    pub cell: Hex,
    pub origin: Vector,
    pub rotation: Rotation,
}

/// A frame.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct FrameJson {
    pub origin: Vector,
    pub rotation: Rotation,
}

/// A sphere in the object's own frame.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct SphereJson {
    pub center: Vector,
    #[serde(with = "number::f32")]
    pub radius: f32,
}

/// A plane with what goes with it.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct PlaneJson {
    pub valid: bool,
    pub n: Vector,
    #[serde(with = "number::f32")]
    pub d: f32,
    pub cell: Hex,
    pub water: bool,
}

impl From<Vector> for Vec3 {
    fn from(v: Vector) -> Self {
        Self::from_array(v.0)
    }
}

impl From<Vec3> for Vector {
    fn from(v: Vec3) -> Self {
        Self(v.to_array())
    }
}

impl From<Rotation> for Quat {
    fn from(r: Rotation) -> Self {
        let [w, x, y, z] = r.0;
        Self::new(w, x, y, z)
    }
}

impl From<PositionJson> for Position {
    fn from(p: PositionJson) -> Self {
        Self::new(CellId(p.cell.0), p.origin.into(), p.rotation.into())
    }
}

impl From<&Position> for PositionJson {
    fn from(p: &Position) -> Self {
        let q = p.frame.rotation();
        Self {
            cell: Hex(p.cell.0),
            origin: p.frame.origin.into(),
            rotation: Rotation([q.w, q.x, q.y, q.z]),
        }
    }
}

impl From<&FrameJson> for Frame {
    fn from(f: &FrameJson) -> Self {
        Self::new(f.origin.into(), f.rotation.into())
    }
}

impl From<&Frame> for FrameJson {
    fn from(f: &Frame) -> Self {
        let q = f.rotation();
        Self {
            origin: f.origin.into(),
            rotation: Rotation([q.w, q.x, q.y, q.z]),
        }
    }
}

impl From<SphereJson> for Sphere {
    fn from(s: SphereJson) -> Self {
        Self::new(s.center.into(), s.radius)
    }
}

impl From<PlaneJson> for ContactPlane {
    fn from(p: PlaneJson) -> Self {
        Self {
            valid: p.valid,
            plane: Plane {
                n: p.n.into(),
                d: p.d,
            },
            cell_id: CellId(p.cell.0),
            is_water: p.water,
        }
    }
}

impl From<&ContactPlane> for PlaneJson {
    fn from(p: &ContactPlane) -> Self {
        Self {
            valid: p.valid,
            n: p.plane.n.into(),
            d: p.plane.d,
            cell: Hex(p.cell_id.0),
            water: p.is_water,
        }
    }
}
