//! The common forms as the client library's own types.

use ac_client::math::{CellId, Frame, Plane, Position, Quat, Sphere, Vec3};
use serde_json::Value;

use super::json::{self, FrameJson, PlaneJson, PositionJson, SphereJson, put};

/// A *vec*.
pub fn vec3(value: &Value) -> Option<Vec3> {
    json::vec3(value).map(Vec3::from)
}

/// A *quat*.
pub fn quat(value: &Value) -> Option<Quat> {
    json::quat(value).map(|[w, x, y, z]| Quat::new(w, x, y, z))
}

/// A *frame*; the rotation as it stands.
pub fn frame(value: &Value) -> Option<Frame> {
    Some(Frame::new(
        vec3(&value["origin"])?,
        quat(&value["rotation"])?,
    ))
}

/// A *position*; the rotation as it stands.
pub fn position(value: &Value) -> Option<Position> {
    Some(Position {
        cell: CellId(json::id(&value["cell"])?),
        frame: frame(value)?,
    })
}

/// A *plane*.
pub fn plane(value: &Value) -> Option<Plane> {
    Some(Plane {
        n: vec3(&value["n"])?,
        d: json::f32(&value["d"])?,
    })
}

/// A *sphere*.
pub fn sphere(value: &Value) -> Option<Sphere> {
    Some(Sphere {
        center: vec3(&value["center"])?,
        radius: json::f32(&value["radius"])?,
    })
}

fn quat_array(q: Quat) -> [f32; 4] {
    [q.w, q.x, q.y, q.z]
}

/// Writes a *vec*.
pub fn put_vec3(v: Vec3) -> Value {
    put::vec3(v.to_array())
}

/// Writes a *frame*.
pub fn put_frame(f: &Frame) -> Value {
    put::frame(FrameJson {
        origin: f.origin.to_array(),
        rotation: quat_array(f.rotation()),
    })
}

/// Writes a *position*.
pub fn put_position(p: &Position) -> Value {
    let (origin, rotation) = (p.frame.origin.to_array(), quat_array(p.frame.rotation()));
    put::position(PositionJson {
        cell: p.cell.0,
        origin,
        rotation,
    })
}

/// Writes a *plane*.
pub fn put_plane(p: &Plane) -> Value {
    put::plane(PlaneJson {
        n: p.n.to_array(),
        d: p.d,
    })
}

/// Writes a *sphere*.
pub fn put_sphere(s: &Sphere) -> Value {
    put::sphere(SphereJson {
        center: s.center.to_array(),
        radius: s.radius,
    })
}
