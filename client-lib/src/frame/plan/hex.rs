//! Ids as hexadecimal text in files that people read: `0xA9B4FFFF`.

/// A list of ids.
pub(super) mod list {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    use crate::frame::state::parse_hex;

    pub(in crate::frame::plan) fn text(ids: &[u32]) -> Vec<String> {
        ids.iter().map(|id| format!("0x{id:08X}")).collect()
    }

    pub(in crate::frame::plan) fn ids<E: de::Error>(text: &[String]) -> Result<Vec<u32>, E> {
        let id = |text: &String| {
            parse_hex(text).ok_or_else(|| E::custom(format!("`{text}` is no id like 0xA9B4FFFF")))
        };
        text.iter().map(id).collect()
    }

    pub(in crate::frame::plan) fn serialize<S: Serializer>(
        ids: &[u32],
        s: S,
    ) -> Result<S::Ok, S::Error> {
        text(ids).serialize(s)
    }

    pub(in crate::frame::plan) fn deserialize<'de, D: Deserializer<'de>>(
        d: D,
    ) -> Result<Vec<u32>, D::Error> {
        ids(&Vec::<String>::deserialize(d)?)
    }
}

/// A list of lists of ids.
pub(super) mod lists {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(in crate::frame::plan) fn serialize<S: Serializer>(
        ids: &[Vec<u32>],
        s: S,
    ) -> Result<S::Ok, S::Error> {
        let text: Vec<_> = ids.iter().map(|ids| super::list::text(ids)).collect();
        text.serialize(s)
    }

    pub(in crate::frame::plan) fn deserialize<'de, D: Deserializer<'de>>(
        d: D,
    ) -> Result<Vec<Vec<u32>>, D::Error> {
        let text = Vec::<Vec<String>>::deserialize(d)?;
        text.iter().map(|text| super::list::ids(text)).collect()
    }
}
