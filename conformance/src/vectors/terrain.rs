//! Vector family `terrain` (`spec/vector-format.md`; defined in `spec/02-terrain.md`).

use serde_json::Value;

use super::VectorContext;

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(_ctx: &VectorContext<'_>, _vector: &Value) -> Option<Value> {
    None
}
