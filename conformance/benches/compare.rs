//! How fast states are compared, on one thread, when nothing differs.

#![allow(
    missing_docs,
    reason = "the macros of criterion make undocumented functions"
)]

use std::hint::black_box;

use ac_client::frame::{FrameState, FrameStates};
use ac_conformance::compare::Comparison;
use ac_golden_traces::{
    corpus,
    trace::{ChannelKind, TraceEvent, TraceReader},
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn compare(criterion: &mut Criterion) {
    let traces = corpus::find(&corpus::bundled().join("traces"), &[".mcap"])
        .expect("the bundled traces are there");
    let mut records: Vec<FrameState> = Vec::new();
    for path in traces.iter().take(12) {
        let mut reader = TraceReader::open(path).expect("a bundled trace is readable");
        reader.select(|kind| matches!(kind, ChannelKind::Expect(_)));
        let mut states = FrameStates::new();
        while let Some(event) = reader
            .next_event(&mut states)
            .expect("a bundled trace is readable")
        {
            if let TraceEvent::States { .. } = event {
                records.extend_from_slice(&states);
            }
        }
    }
    let others = records.clone();
    let mut group = criterion.benchmark_group("compare");
    group
        .throughput(Throughput::Elements(records.len() as u64))
        .sample_size(20);
    group.bench_function("equal records", |bencher| {
        bencher.iter(|| {
            let mut comparison = Comparison::default();
            for (expected, actual) in records.iter().zip(&others) {
                comparison.frame(expected, Some(black_box(actual)));
            }
            assert_eq!(comparison.frames_exact, records.len() as u64);
            comparison
        });
    });
    group.finish();
}

criterion_group!(benches, compare);
criterion_main!(benches);
