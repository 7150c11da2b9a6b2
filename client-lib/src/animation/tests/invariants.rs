//! Section 15.

use proptest::prelude::*;

use crate::animation::fixtures::*;
use crate::animation::{MotionRequest, Sequence};
use crate::dat::{AnimRange, motion_key};
use crate::math::{Frame, Vec3};
use crate::profile::{Profile, Width};

const FIRST: u32 = 0x0300_0001;
/// Frames of the animations, by position.
const FRAMES: [u32; 6] = [1, 2, 3, 7, 30, 4096];
const BOW: u32 = 0x1000_0125;
const CROUCH: u32 = 0x4100_0012;
const MAGIC: u32 = 0x8000_0049;

fn animations() -> Vec<std::sync::Arc<crate::dat::Animation>> {
    let hooks = [
        (0, 100, 0),
        (1, 101, 1),
        (1, 201, -1),
        (2, 102, 1),
        (2, 202, -1),
    ];
    let root = |i: usize| i.is_multiple_of(2).then(|| Vec3::new(0.0, 0.03, 0.0));
    let make = |(i, n): (usize, &u32)| animation(FIRST + i as u32, *n, root(i), &hooks);
    FRAMES.iter().enumerate().map(make).collect()
}

/// One operation on a sequence.
#[derive(Debug, Clone)]
enum Op {
    Append(AnimRange),
    RemoveCyclic,
    RemoveLinks(u32),
    MultiplyRate(f32),
    Update(f64),
    Clear,
}

fn range() -> impl Strategy<Value = AnimRange> {
    let rate = prop_oneof![4 => -60.0_f32..60.0, 1 => Just(0.0), 1 => Just(1e-4)];
    (0..FRAMES.len() as u32, -1..8_i32, -1..8_i32, rate).prop_map(|(a, low, high, framerate)| {
        AnimRange {
            animation: FIRST + a,
            low_frame: low,
            high_frame: high,
            framerate,
        }
    })
}

fn op() -> impl Strategy<Value = Op> {
    prop_oneof![
        4 => range().prop_map(Op::Append),
        1 => Just(Op::RemoveCyclic),
        1 => (0..3_u32).prop_map(Op::RemoveLinks),
        1 => (0.0_f32..3.0).prop_map(Op::MultiplyRate),
        6 => (0.0..0.3_f64).prop_map(Op::Update),
        1 => Just(Op::Clear),
    ]
}

/// Carries an operation out; without an offset frame if `bare`.
fn apply(p: &mut Player, op: &Op, bare: bool) {
    match op {
        Op::Append(range) => p.append(*range),
        Op::RemoveCyclic => p.sequence.remove_cyclic_animations(),
        Op::RemoveLinks(n) => p.sequence.remove_link_animations(*n),
        Op::MultiplyRate(f) => p.sequence.multiply_cyclic_rate(*f),
        Op::Clear => p.sequence.clear(),
        Op::Update(t) if bare => {
            let update = p.sequence.update(*t, None, &mut p.hooks, &p.profile);
            update.expect("sane input");
        }
        Op::Update(t) => {
            p.update(*t).expect("sane input");
        }
    }
}

/// 1, 2 and 3.
fn check_shape(sequence: &Sequence) -> Result<(), TestCaseError> {
    let head = sequence.has_animations().then_some(0);
    prop_assert_eq!(sequence.current_index(), head);
    prop_assert_eq!(sequence.first_cyclic_index().is_some(), head.is_some());
    if let Some(node) = sequence.current_node() {
        let frame = sequence.frame_number().floor();
        prop_assert!(f64::from(node.low) <= frame, "{} < {}", frame, node.low);
        prop_assert!(frame <= f64::from(node.high), "{} > {}", frame, node.high);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn lists_stay_in_shape(ops in prop::collection::vec(op(), 1..40), narrow: bool) {
        let mut profile = Profile::retail();
        if narrow {
            profile.frame_number = Width::F32;
        }
        let mut p = Player::new(animations(), profile);
        let mut bare = p.clone();
        for op in &ops {
            apply(&mut p, op, false);
            check_shape(&p.sequence)?;
            // 4: without an offset frame everything but the movement is the same.
            apply(&mut bare, op, true);
            prop_assert!(p.sequence.frame_number().is_finite());
            prop_assert_eq!(p.sequence.frame_number(), bare.sequence.frame_number());
            prop_assert_eq!(&p.hooks, &bare.hooks);
            prop_assert_eq!(p.list(), bare.list());
        }
    }

    #[test]
    fn nothing_moves_until_a_frame_is_crossed(rate in 0.5_f32..60.0, t in 0.0..0.1_f64, start in 0.0..2.0_f64) {
        let mut p = Player::new(animations(), Profile::retail());
        p.append(whole(FIRST + 4, rate));
        p.sequence.velocity = Vec3::ONE;
        p.sequence.omega = Vec3::ONE;
        p.update(start / f64::from(rate)).unwrap();
        let before = p.sequence.current_frame();
        let offset = p.update(t).unwrap();
        if p.sequence.current_frame() == before {
            prop_assert_eq!(offset.bits(), Frame::IDENTITY.bits());
        } else {
            prop_assert_ne!(offset.bits(), Frame::IDENTITY.bits());
        }
    }

    #[test]
    fn last_frames_fire_no_hooks(rate in 1.0_f32..60.0, down: bool, steps in 1..40_u32) {
        // 11: within one node indices rise or fall, and the frame at the end never fires.
        let mut p = Player::new(vec![animation(FIRST, 3, None, &[(0, 100, 1), (0, 200, -1), (1, 101, 1), (1, 201, -1), (2, 102, 1), (2, 202, -1)])], Profile::retail());
        p.append(whole(FIRST, if down { -rate } else { rate }));
        for _ in 0..steps {
            p.update(0.02).unwrap();
        }
        let fired: Vec<u32> = p.hooks.iter().map(number).collect();
        let order = if down { [202, 201] } else { [100, 101] };
        for (i, hook) in fired.iter().enumerate() {
            prop_assert_eq!(*hook, order[i % 2]);
        }
    }

    #[test]
    fn a_turn_of_a_cycle_crosses_all_its_frames(cuts in prop::collection::vec(0.01..0.2_f64, 1..30), rate in 5.0_f32..40.0) {
        // 12: straight root motion of n frames is n steps per turn, however time is cut.
        let step = 0.125_f32;
        let mut p = Player::new(vec![animation(FIRST, 8, Some(Vec3::Y * step), &[])], Profile::retail());
        p.append(whole(FIRST, rate));
        // Once around, so that the first turn's missing hand-over is behind.
        p.update(8.0 / f64::from(rate)).unwrap();
        let start = p.sequence.frame_number();
        let (mut way, mut time) = (0.0, start);
        for t in cuts {
            way += p.update(t).unwrap().origin.y;
            time += t * f64::from(rate);
        }
        let crossed = f64::from(way / step).round();
        prop_assert!((f64::from(way / step) - crossed).abs() < 1e-3);
        let expected = time.floor() - start.floor();
        prop_assert!((crossed - expected).abs() <= 1.0, "{} of {}", crossed, expected);
    }

    #[test]
    fn speed_and_time_can_be_exchanged(speed in 0.1_f32..4.0, t in 0.0..0.5_f64) {
        // 15.
        let at = |speed: f32, t: f64| {
            let mut p = Player::new(animations(), Profile::retail());
            p.append(whole(FIRST + 4, 20.0 * speed));
            p.update(t).unwrap();
            p.sequence.frame_number()
        };
        let (slow, fast) = (at(1.0, t), at(speed, t / f64::from(speed)));
        prop_assert!((slow - fast).abs() < 1e-5 * (1.0 + slow.abs()));
    }

    #[test]
    fn rates_can_be_multiplied_back(rate in 0.1_f32..100.0, factor in 0.01_f32..100.0) {
        // 19.
        let mut p = Player::new(animations(), Profile::retail());
        p.append(whole(FIRST, rate));
        p.sequence.multiply_cyclic_rate(factor);
        p.sequence.multiply_cyclic_rate(1.0 / factor);
        let ulps = p.rates()[0].to_bits().abs_diff(rate.to_bits());
        prop_assert!(ulps <= 2, "{} ulp", ulps);
    }
}

/// Ready, walk, run, crouch in two styles with links of two animations, two actions, and turning and side stepping.
fn actor() -> Player {
    let one = |i: u32, rate: f32| motion(&[(FIRST + i, rate)]);
    let two = || motion(&[(FIRST + 1, 30.0), (FIRST + 2, 25.0)]);
    let turn = |bits| moving((FIRST + 1, 10.0), bits, Vec3::ZERO, Vec3::Z);
    let side = |bits| moving((FIRST + 1, 10.0), bits, Vec3::X, Vec3::ZERO);
    let substates = [
        (READY, 2, 10.0),
        (WALK, 3, 20.0),
        (RUN, 4, 30.0),
        (CROUCH, 2, 5.0),
    ];
    let mut parts = TableParts::default();
    for style in [NON_COMBAT, MAGIC] {
        for (motion, anim, rate) in substates {
            parts.cycles.push((style, motion, one(anim, rate)));
            let targets = [READY, WALK, RUN, CROUCH, WAVE, BOW, NON_COMBAT, MAGIC];
            let others = targets.into_iter().filter(|t| *t != motion);
            let key = motion_key(style, motion);
            parts
                .links
                .push((key, others.map(|t| (t, two())).collect()));
        }
        parts.cycles.push((style, TURN, turn(2)));
        parts.cycles.push((style, SIDE, side(2)));
        parts.links.push((style << 16, vec![(READY, two())]));
    }
    parts.modifiers = vec![(0x0D, turn(0)), (0x0F, side(0))];
    let mut table = (*table(parts)).clone();
    table.style_defaults = [(NON_COMBAT, READY), (MAGIC, READY)].into_iter().collect();
    Player::with_table(animations(), std::sync::Arc::new(table), Profile::retail())
}

fn request(with_modifiers: bool) -> impl Strategy<Value = Option<MotionRequest>> {
    let base = vec![READY, WALK, RUN, CROUCH, WAVE, BOW, NON_COMBAT, MAGIC];
    let all = if with_modifiers {
        [base, vec![TURN, SIDE]].concat()
    } else {
        base
    };
    let motion = prop::sample::select(all);
    let speed = prop_oneof![3 => Just(1.0_f32), 1 => 0.2_f32..3.0, 1 => -2.0_f32..-0.2];
    let start =
        (motion.clone(), speed).prop_map(|(motion, speed)| MotionRequest::Do { motion, speed });
    let stop = motion.prop_map(|motion| MotionRequest::Stop { motion });
    prop_oneof![
        4 => start.prop_map(Some),
        2 => stop.prop_map(Some),
        1 => Just(Some(MotionRequest::StopCompletely)),
        4 => Just(None),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_queued_motion_is_reported_once_and_in_order(requests in prop::collection::vec(request(true), 1..40)) {
        let mut p = actor();
        let mut queued = vec![READY];
        let mut done = Vec::new();
        for request in requests {
            match request {
                Some(request) => {
                    let answer = p.perform(request);
                    if answer.is_ok() {
                        queued.push(match request {
                            MotionRequest::Do { motion, .. } => motion,
                            _ => READY,
                        });
                    }
                }
                None => done.extend(p.step(0.1).done.iter().map(|n| n.motion)),
            }
            // 1 to 3.
            check_shape(&p.sequence)?;
            // 5: one action in the state for each one that waits.
            let waiting = p.pending().iter().filter(|e| e.0 & 0x1000_0000 != 0).count();
            prop_assert_eq!(waiting, p.manager.state.actions.len());
            // 7.
            match p.pending().first() {
                None => prop_assert!(done.is_empty() || p.manager.animation_counter == 0),
                Some(&(_, n)) if n > 0 => prop_assert!(p.manager.animation_counter < n),
                Some(_) => {}
            }
        }
        // 14, 16: entering the world reports the rest as failed.
        p.sequence.remove_all_link_animations();
        let mut run = p.manager.handle_exit_world();
        while let Some(notice) = p.manager.next_completion(&mut run) {
            prop_assert!(!notice.success);
            done.push(notice.motion);
        }
        prop_assert_eq!(done, queued);
        prop_assert_eq!((p.pending().len(), p.manager.animation_counter), (0, 0));
        prop_assert!(p.sequence.nodes().len() <= 1);
        check_shape(&p.sequence)?;
    }

    #[test]
    fn links_in_the_list_are_those_that_are_counted(requests in prop::collection::vec(request(false), 1..40)) {
        // 6: with one animation per cycle and no modifiers.
        let mut p = actor();
        p.step(0.01);
        for request in requests {
            match request {
                Some(request) => drop(p.perform(request)),
                None => drop(p.step(0.1)),
            }
            let counted: u32 = p.pending().iter().map(|e| e.1).sum();
            let links = p.sequence.first_cyclic_index().unwrap_or(0) as u32;
            prop_assert_eq!(counted - p.manager.animation_counter, links);
            // 13: the tail is the cycle of the substate.
            let cycle = match p.manager.state.substate {
                WALK => 3,
                RUN => 4,
                _ => 2,
            };
            prop_assert_eq!(p.list().last().copied(), Some(FIRST + cycle));
        }
    }

    #[test]
    fn repeating_and_undoing_change_nothing(motion in prop::sample::select(vec![WALK, RUN, CROUCH]), speed in 0.2_f32..3.0, t in 0.0..0.5_f64) {
        let mut p = actor();
        p.start(motion, speed).unwrap();
        p.step(t);
        // 8.
        let (list, frame, rates) = (p.list(), p.sequence.frame_number(), p.rates());
        p.start(motion, speed).unwrap();
        prop_assert_eq!(p.list(), list);
        prop_assert_eq!(p.sequence.frame_number(), frame);
        prop_assert_eq!(p.rates(), rates);
        prop_assert_eq!(p.pending().last().copied(), Some((motion, 0)));
        // 9.
        let (modifiers, velocity, omega) = (p.modifiers(), p.sequence.velocity, p.sequence.omega);
        p.start(TURN, speed).unwrap();
        p.stop(TURN).unwrap();
        prop_assert_eq!(p.modifiers(), modifiers);
        prop_assert!((p.sequence.velocity - velocity).length() < 1e-5);
        prop_assert!((p.sequence.omega - omega).length() < 1e-5);
    }
}
