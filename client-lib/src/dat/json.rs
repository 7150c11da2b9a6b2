//! How ids look in JSON: as people write them.

use serde::Serializer;

/// An id as `"0x01000001"`.
pub(super) fn hex<S: Serializer>(id: &u32, s: S) -> Result<S::Ok, S::Error> {
    s.collect_str(&format_args!("0x{id:08X}"))
}

/// Ids as strings.
pub(super) fn hex_list<S: Serializer>(ids: &[u32], s: S) -> Result<S::Ok, S::Error> {
    s.collect_seq(ids.iter().map(|id| format!("0x{id:08X}")))
}
