//! Cost of one tick as JSON lines `{case, ns, allocations}`, per object.
//!
//! `tick_costs [case [frames]]`: one case alone, for instruction counts (`valgrind --tool=callgrind --toggle-collect='*measured*'`).
//! `tick_costs memory`: bytes of heap per object instead, as `{objects, bytes}`.

#[path = "../benches/common/mod.rs"]
mod common;

use std::time::Instant;

use common::Case;

/// Frames until everything has settled.
const WARM_UP: u32 = 200;

/// The best of so many batches of frames counts: the machine may be busy.
const BATCHES: u32 = 10;

/// A case, how to make it, and how many objects share its cost.
type Entry = (&'static str, fn() -> Case, u32);

const CASES: [Entry; 10] = [
    ("resting", common::resting, 1),
    ("sliding", common::sliding, 1),
    ("idle_npc", || common::idle_npcs(1), 1),
    ("walking_flat", common::walking, 1),
    ("running_slopes", common::running_on_slopes, 1),
    ("running_room", common::running_in_a_room, 1),
    ("crowd_50", || common::crowd(50), 50),
    ("idle_npcs_1000", || common::idle_npcs(1000), 1000),
    ("idle_10000", || common::mostly_idle(10_000, 0), 10_000),
    (
        "walkers_10_of_10010",
        || common::mostly_idle(10_000, 10),
        10,
    ),
];

#[inline(never)]
fn measured(case: &mut Case, frames: u32) {
    case.run(frames);
}

/// Heap that a case keeps per object when there are many, in bytes: the entity and all it owns; shared shapes and the map do not count.
fn bytes_per_object(make: impl Fn(usize) -> Case) -> f64 {
    const MANY: usize = 1000;
    let keeps = |count: usize| {
        let mut case = None;
        let use_of_heap = allocation_counter::measure(|| {
            let made = case.insert(make(count));
            made.run(WARM_UP);
        });
        use_of_heap.bytes_current as f64
    };
    // What is loaded once is loaded before.
    keeps(1);
    (keeps(MANY + 1) - keeps(1)) / MANY as f64
}

fn report_memory() {
    type Make = fn(usize) -> Case;
    let cases: [(&str, Make); 2] = [
        ("idle_npc", common::idle_npcs),
        ("at_rest", |count| common::mostly_idle(count, 0)),
    ];
    for (name, make) in cases {
        println!(
            "{{\"objects\":\"{name}\",\"bytes\":{:.0}}}",
            bytes_per_object(make)
        );
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let only = arguments.next();
    if only.as_deref() == Some("memory") {
        report_memory();
        return;
    }
    let frames = arguments.next().and_then(|f| f.parse().ok()).unwrap_or(100);
    for (name, make, objects) in CASES {
        if only.as_ref().is_some_and(|o| o != name) {
            continue;
        }
        let mut case = make();
        case.run(WARM_UP);
        let mut ns = f64::INFINITY;
        for _ in 0..BATCHES {
            let start = Instant::now();
            measured(&mut case, frames);
            ns = ns.min(start.elapsed().as_nanos() as f64 / f64::from(frames * objects));
        }
        let allocations = allocation_counter::measure(|| case.run(200)).count_total;
        println!(
            "{{\"case\":\"{name}\",\"ns\":{ns:.1},\"allocations\":{}}}",
            allocations as f64 / 200.0
        );
    }
}
