//! Time and quanta (B3, H2; H3: 3 to 7; H4: 1).

use proptest::prelude::*;

use super::*;
use crate::frame::{Host, Pacing};
use crate::physics::state::{PhysicsState, TransientState};

/// Quanta of one call, and the gap that is left, for an active object without spheres whose clock stands at 0.
fn quanta(profile: Profile, gap: f64) -> (Vec<f32>, f64) {
    quanta_from(profile, 0.0, gap)
}

fn quanta_from(profile: Profile, start: f64, now: f64) -> (Vec<f32>, f64) {
    let mut world = world_of(profile);
    let id = object(&mut world, CRATE, 0x8, None);
    let cell = world.visible_cell(CellId(0x1020_0001));
    world.clock.now = now;
    world
        .with_entity(id, |e, w| {
            e.body.cell = cell;
            e.kin.transient |= TransientState::ACTIVE;
            e.kin.update_time = start;
            e.update_object(w, &mut crate::frame::probe::NoProbe);
            let steps = e.steps.iter().map(|s| s.dt).collect();
            (steps, now - e.kin.update_time)
        })
        .expect("there")
}

/// H2: the table.
#[test]
fn quanta_of_one_call() {
    let (retail, ace) = (Profile::retail, Profile::ace);
    let none: &[f32] = &[];
    for gap in [1.0 / 60.0, 1.0 / 30.0] {
        assert_eq!(quanta(retail(), gap), (none.to_vec(), gap));
        assert_eq!(quanta(ace(), gap), (none.to_vec(), gap));
    }
    let exact: [(f64, &[f32]); 7] = [
        (0.0334, &[0.0334]),
        (0.11, &[0.11]),
        (0.15, &[0.15]),
        (0.21, &[0.2]),
        (0.25, &[0.2, 0.05]),
        (0.35, &[0.2, 0.15]),
        (1.0, &[0.2; 5]),
    ];
    for (gap, steps) in exact {
        let got = quanta(retail(), gap).0;
        // The last one is a difference of f64: the f32 nearest to it.
        assert_eq!(got.len(), steps.len(), "{gap}");
        assert!(
            got.iter().zip(steps).all(|(a, b)| (a - b).abs() < 1e-8),
            "{gap}: {got:?}"
        );
    }
    let exact: [(f64, usize, Option<f32>); 6] = [
        (0.11, 1, None),
        (0.15, 1, Some(0.049_999_997)),
        (0.21, 2, None),
        (0.25, 2, Some(0.049_999_997)),
        (1.0, 9, Some(0.099_999_99)),
        (2.0, 19, Some(0.099_999_97)),
    ];
    for (gap, full, rest) in exact {
        let mut expected = vec![0.1_f32; full];
        expected.extend(rest);
        assert_eq!(quanta(ace(), gap).0, expected, "{gap}");
    }
    assert!((quanta(retail(), 0.21).1 - 0.01).abs() < 1e-12);
    assert!((quanta(ace(), 0.11).1 - 0.009_999_998_5).abs() < 1e-10);
    for gap in [0.4, 0.6, 1.0, 2.0] {
        let steps = quanta(retail(), gap).0;
        assert_eq!(steps.len(), (gap * 5.0_f64).round() as usize);
    }
    assert_eq!(quanta(retail(), 2.000_000_1), (none.to_vec(), 0.0));
    assert_eq!(quanta(ace(), 2.000_000_1), (none.to_vec(), 0.0));
}

/// H4, 1: one step of f64 around the limits, and gaps that are none.
#[test]
fn limits_of_the_gap() {
    let shortest = 1.0_f64 / 30.0;
    let count = |gap: f64| quanta(Profile::retail(), gap).0.len();
    assert_eq!(
        [shortest.next_down(), shortest, shortest.next_up()].map(count),
        [0, 0, 1]
    );
    assert_eq!(
        [0.2_f64.next_down(), 0.2, 0.2_f64.next_up()].map(count),
        [1, 1, 1]
    );
    assert_eq!(
        [2.0_f64.next_down(), 2.0, 2.0_f64.next_up()].map(count),
        [10, 10, 0]
    );
    assert_eq!(
        [0.0, -0.0, -1.0, f64::NEG_INFINITY, f64::INFINITY].map(count),
        [0; 5]
    );
    // Nothing compares with what is no number: no step, and the clock stays.
    let mut world = world();
    let id = walker(&mut world, at(30.0, 30.0, 0.0));
    let before = bits(&world, id);
    frame(&mut world, f64::NAN);
    assert_eq!(bits(&world, id), before);
    frame(&mut world, 50.0);
    assert_eq!(bits(&world, id), before);
    frame(&mut world, 100.05);
    assert_ne!(bits(&world, id), before);
}

/// H4, 1: far from zero the clock is coarse; steps stay within their limits.
#[test]
fn a_late_clock() {
    let (start, now) = (1e9, 1e9 + 0.5);
    let (steps, rest) = quanta_from(Profile::retail(), start, now);
    assert_eq!(steps.len(), 3);
    assert!(rest.abs() < 1e-6);
}

/// H3, 3 and 4: static, carried, frozen and cell-less objects stay as they are.
#[test]
fn who_is_not_updated() {
    let mut world = world();
    let place = at(30.0, 30.0, 0.0);
    let fixed = object(&mut world, WALKER, 0x409, Some(place));
    let frozen = object(&mut world, WALKER, 0x0100_0408, Some(at(40.0, 30.0, 5.0)));
    let outside = object(&mut world, WALKER, 0x408, None);
    let ids = [fixed, frozen, outside];
    for id in ids {
        world.with_entity(id, |e, w| {
            e.set_velocity(Vec3::new(3.0, 4.0, 5.0), w);
            e.kin.omega = Vec3::Z;
        });
    }
    let idle = |world: &World, id| {
        let (frame, mut words, time) = bits(world, id);
        words[1] &= !TransientState::ACTIVE.bits();
        (frame, words, time)
    };
    let before = ids.map(|id| idle(&world, id));
    for n in 1..10 {
        frame(&mut world, 100.0 + f64::from(n) * 0.1);
    }
    let after = ids.map(|id| idle(&world, id));
    assert_eq!((&before[1..], before[0].0), (&after[1..], after[0].0));
    assert_eq!(before[0].1, after[0].1);
    for id in ids {
        let transient = world.entity(id).expect("there").kin.transient;
        assert!(!transient.contains(TransientState::ACTIVE));
    }
}

/// H4, 25: a moving object that becomes static goes on until something stops it.
#[test]
fn a_static_word_on_a_moving_object() {
    let mut world = world();
    let id = walker(&mut world, at(30.0, 30.0, 3.0));
    world.with_entity(id, |e, w| e.set_state(0x0040_0409, w));
    frame(&mut world, 100.1);
    let entity = world.entity(id).expect("there");
    assert!(entity.kin.transient.contains(TransientState::ACTIVE));
    assert!(entity.body.state.contains(PhysicsState::STATIC));
    world.with_entity(id, |e, w| {
        e.set_active(false, w);
        assert!(!e.set_active(true, w));
    });
}

/// B1: the gate of the live client: shorter frames than 1/30 s do nothing and add up, a clock that runs backwards begins anew, and the player's
/// callback comes once per tick, after the player was advanced and before the next object.
#[test]
fn the_engine_gate_lets_time_add_up() {
    #[derive(Default)]
    struct Camera {
        ticks: u32,
        saw: Vec<usize>,
        created: Option<EntityId>,
    }
    impl Host for Camera {
        fn player_updated(&mut self, world: &mut World) {
            self.ticks += 1;
            self.saw = world.entities.iter().map(|e| e.steps.len()).collect();
            // Created in the middle of a tick: first visited in the next one.
            let created = *self
                .created
                .get_or_insert_with(|| walker(world, at(50.0, 30.0, 5.0)));
            let steps = &world.entity(created).expect("there").steps;
            self.saw.push(steps.len());
        }
    }
    let mut world = world_of(Profile {
        distance_culling: false,
        ..Profile::retail()
    });
    let ids = [30.0, 36.0, 42.0].map(|x| walker(&mut world, at(x, 30.0, 5.0)));
    world.local_player = Some(ids[1]);
    let (mut camera, mut pipeline) = (Camera::default(), Pipeline::new(Pacing::EngineGate));
    let mut run = |now: f64| {
        pipeline.run_frame(&mut world, now, &mut camera);
        (camera.ticks, camera.saw.clone())
    };
    assert_eq!(
        run(100.05),
        (1, vec![1, 1, 0, 0]),
        "in order of registration"
    );
    assert_eq!(run(100.07).0, 1);
    assert_eq!(
        run(100.09),
        (2, vec![2, 2, 1, 0, 0]),
        "what was created is last"
    );
    assert_eq!(run(60.0).0, 2, "backwards: the gate begins anew");
    assert_eq!(run(60.02).0, 2);
    assert_eq!(
        run(60.05).0,
        3,
        "a tick, in which no object's time has come"
    );
    assert_eq!(run(100.3).0, 4);
    assert_eq!(run(f64::NAN).0, 4);
}

/// H2, frame pacing: counting up by 1/30 executes a step of 2/30 every second frame; at 60 Hz every third, hardly ever the second.
#[test]
fn pacing_of_steady_frames() {
    let run = |start: f64, rate: f64, frames: u32| {
        let mut world = World::with_source(Profile::retail(), start, dats());
        let id = walker(&mut world, at(30.0, 30.0, 0.0));
        // Without one it would come to rest.
        world.with_entity(id, |e, w| e.make_movement_manager(true, w));
        let mut now = start;
        let mut steps = Vec::new();
        for _ in 0..frames {
            now += rate;
            frame(&mut world, now);
            steps.append(&mut world.entity_mut(id).expect("there").steps);
        }
        steps
            .iter()
            .map(|s| (f64::from(s.dt) / rate).round() as u32)
            .collect::<Vec<_>>()
    };
    assert_eq!(run(1000.0, 1.0 / 30.0, 8), [2, 2, 2, 2]);
    assert_eq!(run(0.0, 1.0 / 60.0, 11), [3, 3, 2, 3]);
    assert_eq!(run(0.0, 0.05, 4), [1, 1, 1, 1]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// H3, 5 and 6: every quantum is within its limits, and together they are the way the clock went.
    #[test]
    fn quanta_sum_up(gap in 0.0_f64..2.0, start in 0.0_f64..1e6) {
        let (steps, rest) = quanta_from(Profile::retail(), start, start + gap);
        for &step in &steps {
            prop_assert!(f64::from(step) > 1.0 / 30.0 - 1e-9 && step <= 0.2);
        }
        let sum: f64 = steps.iter().map(|&s| f64::from(s)).sum();
        prop_assert!((sum - (gap - rest)).abs() < 1e-6);
        prop_assert!(rest <= 1.0 / 30.0 + 1e-9);
    }

    /// H3, 7: idle frames between the steps change no bit.
    #[test]
    fn idle_frames_change_nothing(
        ends in prop::collection::vec((0.04_f64..0.19, 0.0_f64..0.033), 1..12),
        velocity in (-5.0_f32..5.0, -5.0_f32..5.0, -1.0_f32..6.0),
    ) {
        let run = |idle: bool| {
            let mut world = world();
            let id = walker(&mut world, at(66.0, 57.0, 2.0));
            let velocity = Vec3::new(velocity.0, velocity.1, velocity.2);
            world.with_entity(id, |e, w| e.set_velocity(velocity, w));
            let mut now = 100.0;
            for &(step, between) in &ends {
                if idle {
                    let simulated = world.entity(id).expect("there").kin.update_time;
                    frame(&mut world, simulated + between / 2.0);
                    frame(&mut world, simulated + between);
                }
                now += step;
                frame(&mut world, now);
            }
            bits(&world, id)
        };
        prop_assert_eq!(run(false), run(true));
    }
}
