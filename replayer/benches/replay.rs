//! Speed of a whole scene: setting it up, and its frames with their records.

#![allow(
    missing_docs,
    reason = "the macros of criterion make undocumented functions"
)]

use ac_client::frame::FrameStates;
use ac_client::profile::Profile;
use ac_golden_traces::Scene;
use ac_golden_traces::corpus;
use ac_golden_traces::trace::TraceReader;
use ac_replayer::client::ClientSimulator;
use ac_replayer::{Simulation, Simulator};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn scene(name: &str) -> Scene {
    let path = corpus::bundled().join("traces").join(name);
    let reader = TraceReader::open(&path).expect("a bundled trace is readable");
    reader.scene().clone()
}

/// Runs a scene to its end; answers how many records were written.
fn run(mut simulation: Box<dyn Simulation>, frames: u32, states: &mut FrameStates) -> usize {
    let mut count = 0;
    for frame in 0..frames {
        simulation
            .step(frame, states)
            .expect("a bundled scene runs");
        count += states.len();
    }
    count
}

fn replay(c: &mut Criterion) {
    let simulator = ClientSimulator::new(corpus::bundled().join("worlds"));
    let profile = Profile::retail();
    let mut group = c.benchmark_group("replay");
    for name in ["terrain/walk-flat", "terrain/rolling", "dungeon/corridor"] {
        let scene = scene(&format!("{name}.mcap"));
        let frames = scene.frames.iter().map(|run| run.count).sum();
        let mut states = FrameStates::new();
        group.throughput(Throughput::Elements(u64::from(frames)));
        group.bench_function(name, |b| {
            b.iter(|| {
                let simulation = simulator
                    .start(&scene, &profile)
                    .expect("a bundled scene starts");
                run(simulation, frames, &mut states)
            });
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(2));
    targets = replay
}
criterion_main!(benches);
