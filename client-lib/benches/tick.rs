//! Speed of the entity tick: one frame of the worlds of `common`.

#![allow(
    missing_docs,
    reason = "the macros of criterion make undocumented functions"
)]

mod common;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

use common::Case;

/// Frames until everything has settled.
const WARM_UP: u32 = 200;

/// Name of a case and how its world is made.
type Named = (&'static str, fn() -> Case);

fn single(c: &mut Criterion) {
    let cases: [Named; 6] = [
        ("resting", common::resting),
        ("sliding", common::sliding),
        ("idle_npc", || common::idle_npcs(1)),
        ("walking_flat", common::walking),
        ("running_slopes", common::running_on_slopes),
        ("running_room", common::running_in_a_room),
    ];
    let mut group = c.benchmark_group("tick");
    for (name, make) in cases {
        let mut case = make();
        case.run(WARM_UP);
        group.bench_function(name, |b| b.iter(|| case.step()));
    }
    group.finish();
}

/// Per creature.
fn many(c: &mut Criterion) {
    let cases: [(&str, usize, Case); 2] = [
        ("crowd_50", 50, common::crowd(50)),
        ("idle_npcs_1000", 1000, common::idle_npcs(1000)),
    ];
    let mut group = c.benchmark_group("tick_per_creature");
    for (name, count, mut case) in cases {
        case.run(WARM_UP);
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(name, |b| b.iter(|| case.step()));
    }
    group.finish();
}

/// Objects at rest alone (`idle`), and beside ten that walk (`with_10_walkers`).
fn scaling(c: &mut Criterion) {
    let mut group = c.benchmark_group("tick_scaling");
    for count in [10, 100, 1000, 10_000] {
        for (name, walkers) in [("idle", 0), ("with_10_walkers", 10)] {
            let mut case = common::mostly_idle(count, walkers);
            case.run(WARM_UP);
            group.throughput(Throughput::Elements(count as u64));
            group.bench_function(BenchmarkId::new(name, count), |b| b.iter(|| case.step()));
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = single, many, scaling
}
criterion_main!(benches);
