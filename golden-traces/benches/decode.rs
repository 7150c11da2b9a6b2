//! How fast records are read, on one thread.

#![allow(
    missing_docs,
    reason = "the macros of criterion make undocumented functions"
)]

use std::{hint::black_box, path::Path};

use ac_client::frame::{FrameState, FrameStates};
use ac_golden_traces::{
    corpus,
    record::{Unknown, read_line, write_line},
    trace::{ChannelKind, TraceEvent, TraceReader},
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// Reads all expectations of a trace; calls `each` with the records of each frame.
fn read(bytes: &[u8], mut each: impl FnMut(&[FrameState])) {
    let mut reader =
        TraceReader::new(bytes, Path::new("bench.mcap")).expect("a bundled trace is readable");
    reader.select(|kind| matches!(kind, ChannelKind::Expect(_)));
    let mut states = FrameStates::new();
    while let Some(event) = reader
        .next_event(&mut states)
        .expect("a bundled trace is readable")
    {
        if let TraceEvent::States { .. } = event {
            each(&states);
        }
    }
}

fn decode(criterion: &mut Criterion) {
    // The largest traces: what a long run looks like.
    let mut files: Vec<Vec<u8>> = corpus::find(&corpus::bundled().join("traces"), &[".mcap"])
        .expect("the bundled traces are there")
        .iter()
        .map(|path| std::fs::read(path).expect("a bundled trace is readable"))
        .collect();
    files.sort_by_key(|bytes| std::cmp::Reverse(bytes.len()));
    files.truncate(8);
    let mut records = Vec::new();
    for bytes in &files {
        read(bytes, |states| records.extend_from_slice(states));
    }
    let lines: Vec<Vec<u8>> = records
        .iter()
        .map(|record| {
            let mut line = Vec::new();
            write_line(&mut line, record);
            line
        })
        .collect();
    let mut group = criterion.benchmark_group("decode");
    group
        .throughput(Throughput::Elements(records.len() as u64))
        .sample_size(20);
    group.bench_function("records", |bencher| {
        let mut state = FrameState::default();
        bencher.iter(|| {
            for line in &lines {
                read_line(line, Unknown::Refuse, &mut state).expect("it was written by us");
                black_box(&state);
            }
        });
    });
    group.bench_function("trace files", |bencher| {
        bencher.iter(|| {
            for bytes in &files {
                read(bytes, |states| {
                    black_box(states);
                });
            }
        });
    });
    group.bench_function("write records", |bencher| {
        let mut text = Vec::new();
        bencher.iter(|| {
            for record in &records {
                text.clear();
                write_line(&mut text, record);
                black_box(&text);
            }
        });
    });
    group.finish();
}

criterion_group!(benches, decode);
criterion_main!(benches);
