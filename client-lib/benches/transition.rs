//! Speed of one transition: a quantum of running from where the mover is after a while, on terrain, at a wall, in a room, in a crowd.

#![allow(
    missing_docs,
    reason = "the macros of criterion make undocumented functions"
)]

mod common;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};

use common::Case;

/// Name of a case and how its world is made.
type Named = (&'static str, fn() -> Case);

fn transition(c: &mut Criterion) {
    let cases: [Named; 4] = [
        ("terrain", common::running_on_slopes),
        ("wall", common::against_a_wall),
        ("room", common::running_in_a_room),
        ("crowd_50", || common::crowd(50)),
    ];
    let mut group = c.benchmark_group("transition");
    for (name, make) in cases {
        let mut case = make();
        case.run(60);
        let mut world = case.world;
        // As during its own tick, the mover is taken out of the world.
        let mover = world
            .entities
            .take(case.moving[0])
            .expect("the mover is there");
        let mut goal = mover.body.position;
        goal.frame.origin += goal.frame.forward(&world.profile) * 0.25;
        let input = mover.movement_input(&goal, &world);
        group.bench_function(name, |b| {
            b.iter(|| {
                let made = world.slots.make(&world.profile);
                let mut transit = made.expect("nothing is nested");
                let valid = world.run_transition(&mut transit, black_box(&input));
                world.slots.cleanup();
                world.slots.recycle(transit);
                valid
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
        .measurement_time(std::time::Duration::from_secs(1));
    targets = transition
}
criterion_main!(benches);
