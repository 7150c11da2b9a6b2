//! Bodies of the fuzz targets in `fuzz/`. They are here so that a deterministic smoke of the very same bodies runs with the tests.
//!
//! A body takes any bytes and must return: no panic, no hang, no memory out of proportion. What it reads it also writes, and asserts that
//! writing is stable.

use super::{AnyRecord, DatFile, RecordKind, Strictness};

/// Opens the bytes as a container, strictly and leniently, and does everything that can be done with one.
pub fn container(data: &[u8]) {
    for strictness in [Strictness::Strict, Strictness::Lenient] {
        let Ok(file) = DatFile::from_bytes("fuzz", data, None, strictness) else {
            continue;
        };
        let report = file.check();
        for entry in report.entries.iter().take(256) {
            let looked_up = file.entry(entry.id);
            if report.errors.is_empty() {
                // Invariant 1 of the container: what is listed is found.
                assert_eq!(looked_up.as_ref().ok(), Some(&Some(*entry)));
            }
            if let Ok(Some(bytes)) = file.get(entry.id) {
                let _ = AnyRecord::of(file.data_set(), "fuzz", entry.id, &bytes, strictness);
            }
        }
        for id in [0, 1, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_0001, 0xFFFF_FFFF] {
            let _ = file.get(id);
        }
    }
}

/// An id of the kind, for records that begin with their own.
#[must_use]
pub fn id_of(kind: RecordKind, data: &[u8]) -> u32 {
    match (kind, data) {
        (RecordKind::Surface, _) => 0x0800_0001,
        (RecordKind::Iteration, _) => 0xFFFF_0001,
        (_, [a, b, c, d, ..]) => u32::from_le_bytes([*a, *b, *c, *d]),
        _ => 0,
    }
}

/// Reads the bytes as a record of this kind, and what could be read is written and read again.
pub fn record(kind: RecordKind, data: &[u8]) {
    let id = id_of(kind, data);
    let strict = AnyRecord::parse(kind, "fuzz", id, data, Strictness::Strict);
    let Some(Ok((read, _))) = AnyRecord::parse(kind, "fuzz", id, data, Strictness::Lenient) else {
        assert!(
            !matches!(strict, Some(Ok(_))),
            "strict reading is never more tolerant"
        );
        return;
    };
    let written = read.to_bytes().expect("what was read can be written");
    let (again, _) = AnyRecord::parse(kind, "fuzz", id, &written, Strictness::Lenient)
        .expect("the same kind")
        .expect("what was written can be read");
    // Bytes, not values: not-a-number is not equal to itself.
    assert_eq!(
        again.to_bytes().expect("written again"),
        written,
        "writing is stable"
    );
}
