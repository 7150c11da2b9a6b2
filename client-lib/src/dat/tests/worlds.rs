//! Every record of both worlds of the repository (`spec/11-dat-files.md, 15`: 12 and 13).

use std::collections::BTreeMap;

use serde_json::Value;

use super::super::{AnyRecord, DatSet, RecordKind, Strictness};
use super::{files, world};

fn checksums(name: &str, part: &str) -> BTreeMap<u32, (usize, u32)> {
    let text = std::fs::read_to_string(world(name).join("world.json")).expect("world.json");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let list = json["files"][part]["checksums"]
        .as_object()
        .expect("checksums");
    let hex = |s: &str| u32::from_str_radix(s.trim_start_matches("0x"), 16).expect("hex");
    list.iter()
        .map(|(id, v)| {
            (
                hex(id),
                (
                    v[0].as_u64().expect("size") as usize,
                    hex(v[1].as_str().expect("crc")),
                ),
            )
        })
        .collect()
}

fn crc(bytes: &[u8]) -> u32 {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum()
}

#[test]
fn every_record_parses_to_its_end_and_writes_the_same_bytes() {
    for name in ["testbed", "testbed2"] {
        let mut kinds: BTreeMap<RecordKind, usize> = BTreeMap::new();
        for (file, part) in files(name)
            .into_iter()
            .zip(["client_portal.dat", "client_cell_1.dat"])
        {
            let sums = checksums(name, part);
            let ids = file.ids().expect("directory");
            assert_eq!(ids, sums.keys().copied().collect::<Vec<_>>());
            for id in ids {
                let bytes = file.get(id).expect("chain").expect("listed id");
                assert_eq!((bytes.len(), crc(&bytes)), sums[&id], "{id:08X}");
                let (record, notes) =
                    AnyRecord::of(file.data_set(), file.name(), id, &bytes, Strictness::Strict)
                        .expect("a kind that is read")
                        .unwrap_or_else(|e| panic!("{e}"));
                assert!(notes.is_empty());
                let kind = RecordKind::of(file.data_set(), id);
                let size = AnyRecord::measure(kind, file.name(), id, &bytes)
                    .expect("known")
                    .expect("parsed");
                assert_eq!(size, bytes.len(), "{id:08X}");
                assert_eq!(record.to_bytes().expect("written"), bytes, "{id:08X}");
                *kinds.entry(kind).or_default() += 1;
            }
        }
        println!("{name}: {kinds:?}");
        assert!(kinds.len() >= 16, "{kinds:?}");
    }
}

#[test]
fn containers_are_consistent() {
    for file in ["testbed", "testbed2"].into_iter().flat_map(files) {
        let report = file.check();
        assert!(report.errors.is_empty(), "{:?}", report.errors);
        assert_eq!(report.blocks.lost, 0, "{:?}", report.blocks);
        assert_eq!(report.entries.len(), file.ids().expect("directory").len());
    }
}

#[test]
fn lookups_read_only_the_nodes_on_their_way() {
    let dats = DatSet::open(world("testbed"), Strictness::Strict).expect("world");
    let before = dats.portal().counts();
    let setup = dats.setup(0x0200_0001).expect("readable").expect("there");
    assert_eq!(setup.id, 0x0200_0001);
    let after = dats.portal().counts();
    assert!(after.nodes - before.nodes <= 2, "{after:?}");
    assert_eq!(after.records - before.records, 1);
    dats.setup(0x0200_0001).expect("kept").expect("there");
    assert_eq!(dats.portal().counts(), after, "a record is read once");
    assert!(dats.setup(0x0100_0001).expect("another kind").is_none());
    assert!(dats.setup(0x0200_FFFF).expect("not there").is_none());
    let error = dats
        .require::<super::super::Setup>(0x0200_FFFF, Some(7))
        .expect_err("not there");
    assert!(
        error
            .to_string()
            .contains("no such setup, wanted by 0x00000007"),
        "{error}"
    );
}

#[test]
fn landblocks_are_found_by_any_cell_of_theirs() {
    let dats = DatSet::open(world("testbed"), Strictness::Strict).expect("world");
    let block = dats
        .landblock_of(0xA9B4_0105)
        .expect("readable")
        .expect("there");
    assert_eq!(block.id, 0xA9B4_FFFF);
    assert_eq!(
        dats.landblock_info_of(0xA9B4_0001)
            .expect("readable")
            .expect("there")
            .id,
        0xA9B4_FFFE
    );
    let room = dats
        .env_cell(0xA9B4_0105)
        .expect("readable")
        .expect("there");
    let environment = dats
        .environment(room.environment_id())
        .expect("readable")
        .expect("there");
    assert!(environment.structure(room.structure).is_some());
}

#[test]
fn worlds_have_no_lints_but_the_known_ones() {
    for name in ["testbed", "testbed2"] {
        let dats = DatSet::open(world(name), Strictness::Strict).expect("world");
        let lints = super::super::lint::world(&dats).expect("readable");
        let texts: Vec<String> = lints.iter().map(ToString::to_string).collect();
        assert!(texts.is_empty(), "{name}: {texts:#?}");
    }
}
