//! Reading records and looking them up.

use std::hint::black_box;
use std::path::PathBuf;

use ac_client::dat::{
    AnyRecord, CELL_FILE, DatBuilder, DatFile, DataSet, PORTAL_FILE, RecordKind, Strictness,
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn world(file: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../golden-traces/worlds/testbed")
        .join(file);
    std::fs::read(path).expect("a file of this repository")
}

/// All records of one kind of the testbed.
fn records(kind: RecordKind) -> Vec<(u32, Vec<u8>)> {
    let mut list = Vec::new();
    for name in [PORTAL_FILE, CELL_FILE] {
        let file =
            DatFile::from_bytes(name, world(name), None, Strictness::Strict).expect("opened");
        for id in file.ids().expect("directory") {
            if RecordKind::of(file.data_set(), id) == kind {
                list.push((id, file.get(id).expect("read").expect("listed")));
            }
        }
    }
    list
}

fn parse(c: &mut Criterion) {
    let mut group = c.benchmark_group("parse");
    for kind in [
        RecordKind::Landblock,
        RecordKind::LandblockInfo,
        RecordKind::EnvCell,
        RecordKind::GfxObj,
        RecordKind::Setup,
        RecordKind::Animation,
        RecordKind::MotionTable,
        RecordKind::Environment,
        RecordKind::Region,
        RecordKind::Scene,
    ] {
        let list = records(kind);
        group.throughput(Throughput::Bytes(
            list.iter().map(|r| r.1.len() as u64).sum(),
        ));
        group.bench_function(format!("{kind} x{}", list.len()), |b| {
            b.iter(|| {
                for (id, bytes) in &list {
                    let _ = black_box(AnyRecord::parse(
                        kind,
                        "bench",
                        *id,
                        black_box(bytes),
                        Strictness::Lenient,
                    ));
                }
            });
        });
    }
    group.finish();
}

fn lookup(c: &mut Criterion) {
    let mut group = c.benchmark_group("lookup");
    // As many records as the largest retail portal file, three levels.
    let mut builder = DatBuilder::new(DataSet::Portal);
    for i in 0..80_000u32 {
        builder.insert(0x0100_0000 + 3 * i, i.to_le_bytes().to_vec());
    }
    let bytes = builder.write().expect("written");
    let file =
        DatFile::from_bytes("bench", bytes.clone(), None, Strictness::Strict).expect("opened");
    let mut at = 0u32;
    group.bench_function("entry, nodes kept", |b| {
        b.iter(|| {
            at = (at + 7919) % 80_000;
            black_box(file.entry(0x0100_0000 + 3 * at))
        });
    });
    group.bench_function("record of 4 bytes, nodes kept", |b| {
        b.iter(|| {
            at = (at + 7919) % 80_000;
            black_box(file.get(0x0100_0000 + 3 * at))
        });
    });
    let shared: std::sync::Arc<[u8]> = bytes.into();
    group.bench_function("open and first record", |b| {
        b.iter(|| {
            at = (at + 7919) % 80_000;
            let file = DatFile::from_bytes("bench", shared.clone(), None, Strictness::Strict)
                .expect("opened");
            black_box(file.get(0x0100_0000 + 3 * at))
        });
    });
    group.bench_function("all 80000 entries, nodes kept", |b| {
        b.iter(|| black_box(file.entries().map(|e| e.len())))
    });
    group.finish();
}

criterion_group!(benches, parse, lookup);
criterion_main!(benches);
