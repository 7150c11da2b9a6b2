//! Numbers in the JSON of scenes and traces (`spec/scene-format.md`, "Numbers"), for use with `#[serde(with = …)]`.

use serde::{Deserialize, Deserializer, Serializer, de::Error};
use serde_json::Value;

/// A number, or one of the three special values as text.
pub(crate) fn double(value: &Value) -> Option<f64> {
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

fn put(number: f64) -> Value {
    match number {
        _ if number.is_nan() => "nan".into(),
        f64::INFINITY => "inf".into(),
        f64::NEG_INFINITY => "-inf".into(),
        _ => number.into(),
    }
}

/// A hexadecimal id as text.
pub mod hex {
    use ac_client::frame::state::parse_hex;

    use super::{Deserialize, Deserializer, Error, Serializer};

    /// Writes `"0x…"`, not padded.
    pub fn serialize<S: Serializer>(id: &u32, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("0x{id:X}"))
    }

    /// Reads `"0x"` and 1 to 8 digits.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
        let text = String::deserialize(deserializer)?;
        parse_hex(&text).ok_or_else(|| {
            D::Error::custom(format!("`{text}` is no hexadecimal id like \"0xA9B40019\""))
        })
    }
}

/// A list of hexadecimal ids.
pub mod hex_list {
    use serde::Serialize;

    use super::{Deserialize, Deserializer, Serializer, hex};

    #[derive(Deserialize, Serialize)]
    struct Id(#[serde(with = "hex")] u32);

    /// Writes a list of texts.
    pub fn serialize<S: Serializer>(ids: &[u32], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(ids.iter().map(|id| Id(*id)))
    }

    /// Reads a list of texts.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u32>, D::Error> {
        Ok(Vec::<Id>::deserialize(deserializer)?
            .into_iter()
            .map(|id| id.0)
            .collect())
    }
}

/// An f32, exact in both directions.
pub mod f32 {
    use serde::Serialize;

    use super::{Deserialize, Deserializer, Error, Serializer, Value, double, put};

    /// Writes it widened.
    pub fn serialize<S: Serializer>(number: &f32, serializer: S) -> Result<S::Ok, S::Error> {
        put((*number).into()).serialize(serializer)
    }

    /// Reads a double and narrows it.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
        let value = Value::deserialize(deserializer)?;
        double(&value).map(|wide| wide as f32).ok_or_else(|| {
            D::Error::custom(format!(
                "`{value}` is no number, \"nan\", \"inf\" or \"-inf\""
            ))
        })
    }
}

/// A list of `N` f32, exact in both directions.
pub mod floats {
    use serde::Serialize;

    use super::{Deserialize, Deserializer, Error, Serializer, f32};

    #[derive(Deserialize, Serialize)]
    struct Number(#[serde(with = "f32")] std::primitive::f32);

    /// Writes a list of widened numbers.
    pub fn serialize<const N: usize, S: Serializer>(
        numbers: &[std::primitive::f32; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(numbers.iter().map(|number| Number(*number)))
    }

    /// Reads exactly `N` numbers.
    pub fn deserialize<'de, const N: usize, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<[std::primitive::f32; N], D::Error> {
        let numbers: Vec<Number> = Vec::deserialize(deserializer)?;
        let count = numbers.len();
        let numbers: [Number; N] = numbers
            .try_into()
            .map_err(|_| D::Error::custom(format!("{count} numbers where {N} are needed")))?;
        Ok(numbers.map(|number| number.0))
    }
}

/// An optional value of one of the other modules.
macro_rules! optional {
    ($(#[$doc:meta])* $name:ident, $module:ident, $with:literal, $type:ty) => {
        $(#[$doc])*
        pub mod $name {
            use serde::Serialize;

            use super::{Deserialize, Deserializer, Serializer, $module};

            #[derive(Deserialize, Serialize)]
            struct Wrapped(#[serde(with = $with)] $type);

            /// Writes the value or null.
            pub fn serialize<S: Serializer>(value: &Option<$type>, serializer: S) -> Result<S::Ok, S::Error> {
                value.map(Wrapped).serialize(serializer)
            }

            /// Reads the value; null is `None`.
            pub fn deserialize<'de, D: Deserializer<'de>>(
                deserializer: D,
            ) -> Result<Option<$type>, D::Error> {
                Ok(Option::<Wrapped>::deserialize(deserializer)?.map(|wrapped| wrapped.0))
            }
        }
    };
}

optional!(
    /// An optional id.
    opt_hex, hex, "hex", u32
);
optional!(
    /// An optional f32.
    opt_f32, f32, "f32", ::std::primitive::f32
);
optional!(
    /// An optional vector.
    opt_vec3, floats, "floats", [::std::primitive::f32; 3]
);
