//! Containers: round trips, extreme shapes, and damage (`spec/11-dat-files.md, 12, 15, 16`).

use std::collections::BTreeMap;
use std::io::Write as _;

use proptest::prelude::*;

use super::super::{
    DatBuilder, DatError, DatFile, DataSet, Entry, HEADER_END, ITERATION_ID, Placement, Problem,
    Strictness,
};

const STRICT: Strictness = Strictness::Strict;

fn open(bytes: Vec<u8>) -> Result<DatFile, DatError> {
    DatFile::from_bytes("test.dat", bytes, Some(DataSet::Portal), STRICT)
}

fn builder(records: impl IntoIterator<Item = (u32, Vec<u8>)>) -> DatBuilder {
    let mut b = DatBuilder::new(DataSet::Portal).block_size(64);
    for (id, bytes) in records {
        b.insert(id, bytes);
    }
    b
}

fn put(bytes: &mut [u8], at: u32, v: u32) {
    bytes[at as usize..at as usize + 4].copy_from_slice(&v.to_le_bytes());
}

fn get(bytes: &[u8], at: u32) -> u32 {
    u32::from_le_bytes(
        bytes[at as usize..at as usize + 4]
            .try_into()
            .expect("four bytes"),
    )
}

fn filled(n: usize) -> Vec<u8> {
    (0..n).map(|i| i as u8).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn what_is_written_is_read(
        records in prop::collection::btree_map(any::<u32>(), prop::collection::vec(any::<u8>(), 0..300), 0..200),
        block_size in (4u32..300).prop_map(|n| n * 4),
        seed in any::<Option<u64>>(),
        free_blocks in 0u32..5,
        strangers in prop::collection::vec(any::<u32>(), 20),
    ) {
        let placement = seed.map_or(Placement::Sequential, Placement::Scattered);
        let mut b = builder(records.clone()).block_size(block_size).placement(placement).free_blocks(free_blocks);
        b.insert(ITERATION_ID, vec![1, 2, 3]);
        let mut records = records;
        records.insert(ITERATION_ID, vec![1, 2, 3]);
        let file = open(b.write().expect("written")).expect("opened");
        let entries = file.entries().expect("walked");
        prop_assert!(entries.windows(2).all(|w| w[0].id < w[1].id));
        let mut read = BTreeMap::new();
        for e in &entries {
            prop_assert_eq!(file.entry(e.id).expect("looked up"), Some(*e));
            read.insert(e.id, file.get(e.id).expect("read").expect("listed"));
        }
        prop_assert_eq!(&read, &records);
        for id in strangers {
            prop_assert_eq!(file.contains(id).expect("looked up"), records.contains_key(&id));
        }
        let report = file.check();
        prop_assert!(report.errors.is_empty(), "{:?}", report.errors);
        prop_assert_eq!(report.blocks.lost, 0);
        prop_assert_eq!(report.blocks.free, u64::from(free_blocks));
    }
}

#[test]
fn sizes_around_the_payload_and_ids_at_the_ends() {
    let p = 60;
    let sizes = [0, 1, p - 1, p, p + 1, 2 * p, 2 * p + 1, 1000];
    let ids = [
        0,
        1,
        0x7FFF_FFFE,
        0x7FFF_FFFF,
        0x8000_0000,
        0xFFFF_0000,
        0xFFFF_FFFE,
        0xFFFF_FFFF,
    ];
    let b = builder(ids.into_iter().zip(sizes.map(filled)));
    let file = open(b.write().expect("written")).expect("opened");
    for (id, size) in ids.into_iter().zip(sizes) {
        assert_eq!(file.get(id).expect("read").expect("there"), filled(size));
    }
    assert_eq!(
        file.ids().expect("walked").last(),
        Some(&0xFFFF_FFFF),
        "unsigned order"
    );
}

#[test]
fn trees_of_one_two_and_three_levels() {
    // The iteration record counts.
    for (records, levels) in [
        (60u32, 1),
        (61, 2),
        (61 + 62 * 61 - 1, 2),
        (61 + 62 * 61, 3),
    ] {
        let b = builder((0..records).map(|i| (i * 3, Vec::new()))).block_size(1024);
        let file = open(b.write().expect("written")).expect("opened");
        let report = file.check();
        assert_eq!(
            (report.errors.len(), report.blocks.levels),
            (0, levels),
            "{records} records"
        );
        assert_eq!(report.entries.len(), records as usize + 1);
        assert!(file.contains(3).expect("looked up") && !file.contains(4).expect("looked up"));
    }
}

#[test]
fn an_empty_file() {
    let mut bytes = builder([]).write().expect("written");
    put(&mut bytes, 0x160, 0);
    let file = open(bytes).expect("opened");
    assert_eq!(file.get(1).expect("looked up"), None);
    assert_eq!(file.ids().expect("walked"), Vec::<u32>::new());
}

/// A name, what is done to the header, and the problem.
type Opening = (&'static str, fn(&mut Vec<u8>), fn(&Problem) -> bool);

#[test]
fn openings_that_are_refused() {
    let cases: [Opening; 9] = [
        (
            "short",
            |b| b.truncate(HEADER_END - 1),
            |p| matches!(p, Problem::NotADatFile { size: 399 }),
        ),
        ("empty", Vec::clear, |p| {
            matches!(p, Problem::NotADatFile { size: 0 })
        }),
        (
            "magic",
            |b| b[0x140] = 0,
            |p| {
                matches!(
                    p,
                    Problem::WrongMagic {
                        old_format: false,
                        ..
                    }
                )
            },
        ),
        (
            "old format",
            |b| {
                put(b, 0x140, 0);
                put(b, 0x12C, 0x5442);
            },
            |p| {
                matches!(
                    p,
                    Problem::WrongMagic {
                        old_format: true,
                        ..
                    }
                )
            },
        ),
        (
            "block size 0",
            |b| put(b, 0x144, 0),
            |p| matches!(p, Problem::BlockSize { found: 0 }),
        ),
        (
            "block size 66",
            |b| put(b, 0x144, 66),
            |p| matches!(p, Problem::BlockSize { .. }),
        ),
        (
            "block size 2 MiB",
            |b| put(b, 0x144, 2 << 20),
            |p| matches!(p, Problem::BlockSize { .. }),
        ),
        (
            "truncated",
            |b| b.truncate(b.len() - 1),
            |p| matches!(p, Problem::Truncated { .. }),
        ),
        (
            "data set",
            |b| put(b, 0x14C, 2),
            |p| {
                matches!(
                    p,
                    Problem::WrongDataSet {
                        expected: 1,
                        found: 2
                    }
                )
            },
        ),
    ];
    for (name, damage, expected) in cases {
        let mut bytes = builder([(1, filled(10))]).write().expect("written");
        damage(&mut bytes);
        let error = open(bytes).expect_err(name);
        assert!(expected(error.problem()), "{name}: {error}");
        assert!(
            error.to_string().starts_with("test.dat: offset 0x"),
            "{error}"
        );
        assert!(!error.help().is_empty());
    }
}

#[test]
fn a_longer_file_is_noted() {
    let mut bytes = builder([(1, filled(10))]).write().expect("written");
    bytes.push(0);
    assert!(matches!(
        open(bytes.clone()).expect_err("strict").problem(),
        Problem::TrailingBytes { .. }
    ));
    let file = DatFile::from_bytes("test.dat", bytes, None, Strictness::Lenient).expect("opened");
    assert_eq!(file.notes().len(), 1);
    assert_eq!(file.get(1).expect("read"), Some(filled(10)));
}

/// Offsets of the blocks of a record of a file written in order.
fn chain_of(bytes: &[u8], entry: Entry) -> Vec<u32> {
    let mut blocks = vec![entry.offset];
    while let next @ 1.. = get(bytes, *blocks.last().expect("one")) {
        blocks.push(next);
    }
    blocks
}

#[test]
fn chains_that_are_refused() {
    // Record 1 has three blocks, record 2 two; the file has two free blocks.
    let bytes = builder([(1, filled(150)), (2, filled(100))])
        .free_blocks(2)
        .write()
        .expect("written");
    let file = open(bytes.clone()).expect("opened");
    let entry = |id| file.entry(id).expect("looked up").expect("there");
    let (one, two) = (chain_of(&bytes, entry(1)), chain_of(&bytes, entry(2)));
    let free = file.header().first_free;
    type Case<'a> = (&'static str, u32, u32, fn(&Problem) -> bool);
    let cases: [Case<'_>; 8] = [
        ("ends early", one[0], 0, |p| {
            matches!(p, Problem::ChainEnds { missing: 90 })
        }),
        ("into the header", one[0], 64, |p| {
            matches!(p, Problem::BlockOffset { found: 64 })
        }),
        ("not a multiple", one[0], one[1] + 4, |p| {
            matches!(p, Problem::BlockOffset { .. })
        }),
        ("past the end", one[0], bytes.len() as u32, |p| {
            matches!(p, Problem::BlockOffset { .. })
        }),
        ("bit 31", one[0], one[1] | 0x8000_0000, |p| {
            matches!(p, Problem::FreeBlock { .. })
        }),
        ("into a free block", one[0], free, |p| {
            matches!(p, Problem::FreeBlock { .. })
        }),
        ("link to itself", one[0], one[0], |p| {
            matches!(p, Problem::ChainTooLong { .. })
        }),
        ("too long", one[2], two[0], |p| {
            matches!(p, Problem::ChainTooLong { .. })
        }),
    ];
    for (name, at, link, expected) in cases {
        let mut bytes = bytes.clone();
        put(&mut bytes, at, link);
        let file = open(bytes.clone()).expect("opened");
        let error = file.get(1).expect_err(name);
        assert!(expected(error.problem()), "{name}: {error}");
        assert_eq!(error.record(), Some(1));
        assert!(!file.check().errors.is_empty(), "{name}");
        // A lenient reader still ends, and reads what only goes on too long.
        let lenient =
            DatFile::from_bytes("test.dat", bytes, None, Strictness::Lenient).expect("opened");
        assert_eq!(
            lenient.get(1).is_ok(),
            matches!(error.problem(), Problem::ChainTooLong { .. }),
            "{name}"
        );
    }
    // Two chains that share their tail: each can be read, the check refuses it.
    let mut shared = bytes.clone();
    put(&mut shared, two[0], one[2]);
    let file = open(shared).expect("opened");
    assert!(file.get(2).is_ok());
    assert!(
        file.check()
            .errors
            .iter()
            .any(|e| matches!(e.problem(), Problem::SharedBlock { .. }))
    );
}

#[test]
fn sizes_that_are_refused() {
    let bytes = builder([(1, filled(10))]).write().expect("written");
    let entry_at = bytes
        .windows(8)
        .position(|w| w == [0, 0, 2, 0, 1, 0, 0, 0])
        .expect("the entry") as u32;
    for size in [bytes.len() as u32, 0x7FFF_FFFF, 0xFFFF_FFFF] {
        let mut bytes = bytes.clone();
        put(&mut bytes, entry_at + 12, size);
        let error = open(bytes).expect("opened").get(1).expect_err("too large");
        assert!(
            matches!(error.problem(), Problem::TooLarge { .. }),
            "{error}"
        );
    }
}

/// One node per file, in blocks large enough to hold it: easy to damage.
fn flat(records: u32) -> Vec<u8> {
    builder((0..records).map(|i| (i * 2 + 10, filled(4))))
        .block_size(2048)
        .write()
        .expect("written")
}

#[test]
fn directories_that_are_refused() {
    let bytes = flat(100);
    let root = get(&bytes, 0x160);
    let child = get(&bytes, root + 4);
    let other = get(&bytes, root + 8);
    assert!(child != 0 && other != 0xCDCD_CDCD || get(&bytes, root + 4 + 248) == 1);
    type Case = (&'static str, u32, u32, fn(&Problem) -> bool);
    let cases: [Case; 7] = [
        ("62 entries", root + 4 + 248, 62, |p| {
            matches!(p, Problem::EntryCount { found: 62 })
        }),
        ("many entries", root + 4 + 248, u32::MAX, |p| {
            matches!(p, Problem::EntryCount { .. })
        }),
        ("its own child", root + 4, root, |p| {
            matches!(
                p,
                Problem::DirectoryCycle { .. } | Problem::DirectoryOrder { .. }
            )
        }),
        ("the same child twice", root + 8, child, |p| {
            matches!(
                p,
                Problem::DirectoryCycle { .. } | Problem::DirectoryOrder { .. }
            )
        }),
        ("no child", root + 8, 0, |p| {
            matches!(p, Problem::MissingBranch { index: 1, found: 0 })
        }),
        ("unused child", root + 8, 0xCDCD_CDCD, |p| {
            matches!(p, Problem::MissingBranch { .. })
        }),
        ("equal ids", child + 4 + 252 + 24 + 4, 10, |p| {
            matches!(p, Problem::DirectoryOrder { id: 10 })
        }),
    ];
    for (name, at, v, expected) in cases {
        let mut bytes = bytes.clone();
        put(&mut bytes, at, v);
        let file = open(bytes).expect("opened: the directory is read when it is needed");
        let error = file.ids().expect_err(name);
        assert!(expected(error.problem()), "{name}: {error}");
        assert!(!file.check().errors.is_empty(), "{name}");
        // Lookups end as well, one way or the other.
        for id in (0..220).chain([u32::MAX]) {
            let _ = file.get(id);
        }
    }
    // The same id in parent and child.
    let mut bytes = bytes.clone();
    let middle = get(&bytes, root + 4 + 252 + 4);
    put(&mut bytes, other + 4 + 252 + 4, middle);
    let error = open(bytes)
        .expect("opened")
        .ids()
        .expect_err("equal ids in parent and child");
    assert!(
        matches!(error.problem(), Problem::DirectoryOrder { .. }),
        "{error}"
    );
}

#[test]
fn a_branch_to_a_record_and_a_deep_directory() {
    let mut bytes = flat(100);
    let root = get(&bytes, 0x160);
    let record = get(&bytes, root + 4 + 252 + 8);
    put(&mut bytes, root + 4, record);
    let file = open(bytes.clone()).expect("opened");
    // A record of zeros reads as an empty leaf; what matters is that it ends.
    let _ = (file.ids(), file.get(10), file.check().errors.len());
    // Empty inner nodes, each the child of the one before: deeper than any file.
    let size = 2048u32;
    let chain = 12;
    let start = bytes.len() as u32;
    for i in 0..chain {
        let mut node = vec![0; size as usize];
        put(&mut node, 4, start + (i + 1) * size);
        bytes.extend(node);
    }
    let total = bytes.len() as u32;
    put(&mut bytes, 0x148, total);
    put(&mut bytes, 0x160, start);
    let file = open(bytes).expect("opened");
    assert!(matches!(
        file.ids().expect_err("deep").problem(),
        Problem::DirectoryDepth { .. }
    ));
    assert!(matches!(
        file.get(1).expect_err("deep").problem(),
        Problem::DirectoryDepth { .. }
    ));
}

fn compressed(data: &[u8], stated: u32) -> Vec<u8> {
    let mut out = stated.to_le_bytes().to_vec();
    let mut z = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    z.write_all(data).expect("in memory");
    out.extend(z.finish().expect("in memory"));
    out
}

#[test]
fn compressed_records() {
    let data = filled(5000);
    let cases = [
        (compressed(&data, 5000), true),
        (compressed(&data, 4999), false),
        (compressed(&data, 5001), false),
        (compressed(&data, 100 << 20), false),
        (compressed(&data, 0), false),
        (compressed(&[], 0), true),
        (vec![1, 2, 3], false),
        (vec![10, 0, 0, 0, 1, 2, 3], false),
        ([10, 0, 0, 0].to_vec(), false),
    ];
    for (i, (stored, good)) in cases.into_iter().enumerate() {
        let mut bytes = builder([(1, stored)]).write().expect("written");
        let entry_at = bytes
            .windows(8)
            .position(|w| w == [0, 0, 2, 0, 1, 0, 0, 0])
            .expect("the entry");
        bytes[entry_at] = 1;
        let file = open(bytes).expect("opened");
        match file.get(1) {
            Ok(read) => assert!(
                good && read.is_some_and(|r| r.is_empty() || r == data),
                "case {i}"
            ),
            Err(e) => assert!(
                !good && matches!(e.problem(), Problem::Compressed { .. }),
                "case {i}: {e}"
            ),
        }
    }
}

#[test]
fn a_file_of_the_other_writer() {
    // One writer fills unused branches with 0xCDCDCDCD, in leaves too (D-01).
    let mut bytes = flat(30);
    let root = get(&bytes, 0x160);
    for i in 0..62 {
        put(&mut bytes, root + 4 + 4 * i, 0xCDCD_CDCD);
    }
    let file = open(bytes).expect("opened");
    assert_eq!(file.ids().expect("walked").len(), 31);
    assert!(file.contains(10).expect("looked up"));
}

#[test]
fn files_are_read_from_disk() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.dat");
    std::fs::write(&path, builder([(7, filled(500))]).write().expect("written")).expect("on disk");
    let file = DatFile::open(&path, Some(DataSet::Portal), STRICT).expect("opened");
    assert_eq!(file.get(7).expect("read"), Some(filled(500)));
    assert!(file.counts().file_bytes > 500);
    let error = DatFile::open(folder.path().join("b.dat"), None, STRICT).expect_err("no file");
    assert!(matches!(error.problem(), Problem::Io { .. }), "{error}");
}
