//! Reads and writes the common JSON forms of vectors and stages (`spec/vector-format.md`, "Common forms").
//!
//! Readers answer `None` for anything malformed. An f32 is read by parsing to f64 and narrowing, and written widened to f64:
//! both directions are exact. Not-a-number and infinities are the texts `"nan"`, `"inf"`, `"-inf"`.

use serde_json::Value;

/// Origin and orientation `[w, x, y, z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameJson {
    /// Metres.
    pub origin: [f32; 3],
    /// `[w, x, y, z]`.
    pub rotation: [f32; 4],
}

/// A frame in the coordinates of a cell's landblock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionJson {
    /// Cell id.
    pub cell: u32,
    /// Metres.
    pub origin: [f32; 3],
    /// `[w, x, y, z]`.
    pub rotation: [f32; 4],
}

/// Points with `n·p + d = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneJson {
    /// Normal.
    pub n: [f32; 3],
    /// Distance, metres.
    pub d: f32,
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereJson {
    /// Metres.
    pub center: [f32; 3],
    /// Metres.
    pub radius: f32,
}

/// An upright cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderJson {
    /// Middle of the bottom disc, metres.
    pub low: [f32; 3],
    /// Metres.
    pub radius: f32,
    /// Metres.
    pub height: f32,
}

/// A double.
pub fn f64(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => number.as_f64(),
        Value::String(text) => match text.as_str() {
            "nan" => Some(f64::NAN),
            "inf" => Some(f64::INFINITY),
            "-inf" => Some(f64::NEG_INFINITY),
            _ => None,
        },
        _ => None,
    }
}

/// A float.
pub fn f32(value: &Value) -> Option<f32> {
    // Narrowing the widened value gives back the float.
    f64(value).map(|wide| wide as f32)
}

/// A plain signed integer.
pub fn int(value: &Value) -> Option<i64> {
    value.as_i64()
}

/// A boolean.
pub fn boolean(value: &Value) -> Option<bool> {
    value.as_bool()
}

/// An id, command or flag word: `"0x…"`.
pub fn id(value: &Value) -> Option<u32> {
    ac_client::frame::state::parse_hex(value.as_str()?)
}

/// A list of exactly `N` floats.
pub fn floats<const N: usize>(value: &Value) -> Option<[f32; N]> {
    let items = value.as_array().filter(|items| items.len() == N)?;
    let mut numbers = [0.0; N];
    for (number, item) in numbers.iter_mut().zip(items) {
        *number = f32(item)?;
    }
    Some(numbers)
}

/// A *vec*: `[x, y, z]`.
pub fn vec3(value: &Value) -> Option<[f32; 3]> {
    floats(value)
}

/// A *quat*: `[w, x, y, z]`.
pub fn quat(value: &Value) -> Option<[f32; 4]> {
    floats(value)
}

/// A *frame*.
pub fn frame(value: &Value) -> Option<FrameJson> {
    Some(FrameJson {
        origin: vec3(value.get("origin")?)?,
        rotation: quat(value.get("rotation")?)?,
    })
}

/// A *position*.
pub fn position(value: &Value) -> Option<PositionJson> {
    let FrameJson { origin, rotation } = frame(value)?;
    Some(PositionJson {
        cell: id(value.get("cell")?)?,
        origin,
        rotation,
    })
}

/// A *plane*.
pub fn plane(value: &Value) -> Option<PlaneJson> {
    Some(PlaneJson {
        n: vec3(value.get("n")?)?,
        d: f32(value.get("d")?)?,
    })
}

/// A *sphere*.
pub fn sphere(value: &Value) -> Option<SphereJson> {
    Some(SphereJson {
        center: vec3(value.get("center")?)?,
        radius: f32(value.get("radius")?)?,
    })
}

/// A *cylinder*.
pub fn cylinder(value: &Value) -> Option<CylinderJson> {
    Some(CylinderJson {
        low: vec3(value.get("low")?)?,
        radius: f32(value.get("radius")?)?,
        height: f32(value.get("height")?)?,
    })
}

/// A list, each item read by `item`.
pub fn list<T>(value: &Value, item: impl Fn(&Value) -> Option<T>) -> Option<Vec<T>> {
    value.as_array()?.iter().map(item).collect()
}

/// A *polygon*: its vertices in order.
pub fn polygon(value: &Value) -> Option<Vec<[f32; 3]>> {
    list(value, vec3)
}

/// `null`, or what `item` reads.
pub fn nullable<T>(value: &Value, item: impl Fn(&Value) -> Option<T>) -> Option<Option<T>> {
    if value.is_null() {
        Some(None)
    } else {
        item(value).map(Some)
    }
}

/// Writers: the same forms the other way.
pub mod put {
    use serde_json::{Value, json};

    use super::{FrameJson, PlaneJson, PositionJson, SphereJson};

    /// A double; the three special values as texts.
    pub fn f64(number: f64) -> Value {
        if number.is_nan() {
            "nan".into()
        } else if number.is_infinite() {
            if number > 0.0 {
                "inf".into()
            } else {
                "-inf".into()
            }
        } else {
            Value::from(number)
        }
    }

    /// A float, widened.
    pub fn f32(number: f32) -> Value {
        f64(number.into())
    }

    /// An id, command or flag word.
    pub fn id(id: u32) -> Value {
        format!("{id:#X}").replacen("0X", "0x", 1).into()
    }

    /// A list of floats.
    pub fn floats(numbers: &[f32]) -> Value {
        numbers.iter().map(|number| f32(*number)).collect()
    }

    /// A *vec*.
    pub fn vec3(v: [f32; 3]) -> Value {
        floats(&v)
    }

    /// A *quat*, `[w, x, y, z]`.
    pub fn quat(q: [f32; 4]) -> Value {
        floats(&q)
    }

    /// A *frame*.
    pub fn frame(frame: FrameJson) -> Value {
        json!({"origin": vec3(frame.origin), "rotation": quat(frame.rotation)})
    }

    /// A *position*.
    pub fn position(position: PositionJson) -> Value {
        json!({"cell": id(position.cell), "origin": vec3(position.origin), "rotation": quat(position.rotation)})
    }

    /// A *plane*.
    pub fn plane(plane: PlaneJson) -> Value {
        json!({"n": vec3(plane.n), "d": f32(plane.d)})
    }

    /// A *sphere*.
    pub fn sphere(sphere: SphereJson) -> Value {
        json!({"center": vec3(sphere.center), "radius": f32(sphere.radius)})
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::json;

    use super::*;

    proptest! {
        #[test]
        fn floats_survive_text(bits: u32) {
            let number = f32::from_bits(bits);
            let text = put::f32(number).to_string();
            let back = f32(&serde_json::from_str(&text).unwrap()).unwrap();
            prop_assert!(back.to_bits() == bits || number.is_nan() && back.is_nan());
        }

        #[test]
        fn doubles_survive_text(bits: u64) {
            let number = f64::from_bits(bits);
            let text = put::f64(number).to_string();
            let back = f64(&serde_json::from_str(&text).unwrap()).unwrap();
            prop_assert!(back.to_bits() == bits || number.is_nan() && back.is_nan());
        }
    }

    #[test]
    fn ids_are_hexadecimal_text() {
        assert_eq!(id(&json!("0xA9B40019")), Some(0xA9B4_0019));
        assert_eq!(put::id(0xA9B4_0019), json!("0xA9B40019"));
        assert_eq!(put::id(0), json!("0x0"));
        assert_eq!(id(&json!(12)), None);
        assert_eq!(id(&json!("0x123456789")), None);
    }

    #[test]
    fn negative_zero_stays_negative() {
        let value: Value = serde_json::from_str("[-0.0, -0, 0]").unwrap();
        assert_eq!(
            vec3(&value).unwrap().map(f32::to_bits),
            [0x8000_0000, 0x8000_0000, 0]
        );
    }
}
