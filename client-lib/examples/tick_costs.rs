//! Cost of one tick as JSON lines `{case, ns, allocations}`, per object.
//!
//! `tick_costs [case [frames]]`: one case alone, for instruction counts (`valgrind --tool=callgrind --toggle-collect='*measured*'`).

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
    ("walkers_10_of_10010", || common::mostly_idle(10_000, 10), 10),
];

#[inline(never)]
fn measured(case: &mut Case, frames: u32) {
    case.run(frames);
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let only = arguments.next();
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
        println!("{{\"case\":\"{name}\",\"ns\":{ns:.1},\"allocations\":{}}}", allocations as f64 / 200.0);
    }
}
