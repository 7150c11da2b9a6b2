//! Section 14.

use crate::animation::fixtures::*;
use crate::dat::motion_key;
use crate::math::{Frame, Vec3};
use crate::profile::Profile;

const R: u32 = 0x0300_0001;
const L: u32 = 0x0300_0002;
const W: u32 = 0x0300_0003;

/// The table of 14.1 and 14.2.
fn walker() -> Player {
    let y = |y| Some(Vec3::new(0.0, y, 0.0));
    let animations = vec![
        animation(R, 4, None, &[]),
        animation(
            L,
            3,
            y(0.05),
            &[
                (0, 20, 1),
                (1, 21, 1),
                (1, 121, -1),
                (2, 22, 1),
                (2, 122, -1),
            ],
        ),
        animation(
            W,
            6,
            y(0.1),
            &[(0, 30, 1), (1, 31, 0), (5, 35, 1), (5, 135, -1)],
        ),
    ];
    let walk = moving((W, 24.0), 0, Vec3::new(0.0, 0.6, 0.0), Vec3::ZERO);
    let link = || motion(&[(L, 30.0)]);
    let table = table(TableParts {
        cycles: vec![
            (NON_COMBAT, READY, motion(&[(R, 10.0)])),
            (NON_COMBAT, WALK, walk),
        ],
        links: vec![
            (motion_key(NON_COMBAT, READY), vec![(WALK, link())]),
            (motion_key(NON_COMBAT, WALK), vec![(READY, link())]),
        ],
        ..TableParts::default()
    });
    Player::with_table(animations, table, Profile::retail())
}

/// One row of a table: list, frame number, Δy, hooks, motions done.
type Row<'a> = (&'a [u32], f64, f32, &'a [u32], &'a [u32]);

fn check_steps(player: &mut Player, rows: &[Row<'_>]) {
    for (i, (list, frame_number, dy, hooks, done)) in rows.iter().enumerate() {
        let outcome = player.step(STEP);
        assert_eq!(player.list(), *list, "list, row {i}");
        assert_eq!(player.sequence.frame_number(), *frame_number, "row {i}");
        let offset = outcome.offset.origin;
        assert!((offset.y - dy).abs() < 1e-6, "dy {} of row {i}", offset.y);
        assert_eq!(outcome.hooks, *hooks, "hooks, row {i}");
        let motions: Vec<_> = outcome.done.iter().map(|n| n.motion).collect();
        assert_eq!(motions, *done, "done, row {i}");
        assert!(outcome.done.iter().all(|n| n.success));
        assert_eq!(player.sequence.current_index(), Some(0));
    }
}

#[test]
#[allow(
    clippy::excessive_precision,
    reason = "as the specification prints them"
)]
fn forward() {
    let mut p = walker();
    assert_eq!(p.pending(), [(READY, 0)]);
    let (lw, w, lr, r): (&[u32], &[u32], &[u32], &[u32]) = (&[L, W], &[W], &[L, R], &[R]);
    check_steps(
        &mut p,
        &[
            (r, 0.33333335071802139, 0.0, &[], &[READY]),
            (r, 0.66666670143604279, 0.0, &[], &[]),
        ],
    );
    p.start(WALK, 1.0).unwrap();
    assert_eq!((p.list(), p.sequence.frame_number()), (vec![L, W], 0.0));
    assert_eq!(p.pending(), [(WALK, 1)]);
    assert_eq!(p.sequence.velocity, Vec3::new(0.0, 0.6, 0.0));
    check_steps(
        &mut p,
        &[
            (lw, 1.0000000521540642, 0.07, &[20], &[]),
            (lw, 2.0000001043081284, 0.07, &[21], &[]),
            (w, 1.2516975402832029e-07, 0.125, &[4], &[WALK]),
            (w, 0.80000016689300535, 0.0, &[], &[]),
            (w, 1.6000002086162568, 0.125, &[30], &[]),
            (w, 2.4000002503395081, 0.125, &[31], &[]),
            (w, 3.2000002920627595, 0.125, &[], &[]),
            (w, 4.0000003337860104, 0.125, &[], &[]),
            (w, 4.8000003755092617, 0.0, &[], &[]),
            (w, 5.6000004172325131, 0.125, &[], &[]),
            (w, 0.40000045895576442, 0.125, &[], &[]),
            (w, 1.2000005006790158, 0.125, &[30], &[]),
            (w, 2.0000005424022671, 0.125, &[31], &[]),
        ],
    );
    p.stop(WALK).unwrap();
    assert_eq!((p.list(), p.sequence.frame_number()), (vec![L, R], 0.0));
    assert_eq!(p.pending(), [(READY, 1)]);
    assert_eq!(p.sequence.velocity, Vec3::ZERO);
    check_steps(
        &mut p,
        &[
            (lr, 1.0000000521540642, 0.05, &[20], &[]),
            (lr, 2.0000001043081284, 0.05, &[21], &[]),
            (r, 5.2154064178466797e-08, 0.0, &[4], &[READY]),
            (r, 0.33333340287208557, 0.0, &[], &[]),
        ],
    );
}

#[test]
#[allow(
    clippy::excessive_precision,
    reason = "as the specification prints them"
)]
fn reverse() {
    let mut p = walker();
    let (lw, w, lr, r): (&[u32], &[u32], &[u32], &[u32]) = (&[L, W], &[W], &[L, R], &[R]);
    p.step(STEP);
    p.start(WALK, -1.0).unwrap();
    assert_eq!(p.list(), lw);
    assert_eq!(p.rates(), [-30.0, -24.0]);
    assert_eq!(p.sequence.frame_number(), 2.9997999668121338);
    assert_eq!(p.pending(), [(WALK, 1)]);
    let bits = p.sequence.velocity.to_array().map(f32::to_bits);
    assert_eq!(bits, [-0.0_f32, -0.6, -0.0].map(f32::to_bits));
    check_steps(
        &mut p,
        &[
            (lw, 1.9997999146580696, -0.07, &[122], &[]),
            (lw, 0.99979986250400543, -0.07, &[121], &[]),
            (w, 5.9996400535106655, -0.07, &[4], &[WALK]),
            (w, 5.1996400117874142, 0.0, &[], &[]),
            (w, 4.3996399700641629, -0.125, &[135], &[]),
            (w, 3.5996399283409115, -0.125, &[], &[]),
            (w, 2.7996398866176602, -0.125, &[], &[]),
            (w, 1.9996398448944088, -0.125, &[], &[]),
            (w, 1.1996398031711575, 0.0, &[], &[]),
            (w, 0.39963976144790614, -0.125, &[31], &[]),
            (w, 5.5994399249553677, -0.125, &[], &[]),
            (w, 4.7994398832321163, -0.125, &[135], &[]),
        ],
    );
    p.stop(WALK).unwrap();
    assert_eq!((p.list(), p.rates()), (lr.to_vec(), vec![-30.0, 10.0]));
    assert_eq!(p.sequence.frame_number(), 2.9997999668121338);
    check_steps(
        &mut p,
        &[
            (lr, 1.9997999146580696, -0.05, &[122], &[]),
            (lr, 0.99979986250400543, -0.05, &[121], &[]),
            (r, 6.672988335291545e-05, -0.05, &[4], &[READY]),
            (r, 0.33340008060137433, 0.0, &[], &[]),
        ],
    );
}

/// The table of 14.3.
fn turner() -> Player {
    const A: u32 = 0x0300_0001;
    let turn = Vec3::new(0.0, 0.0, -1.5);
    let side = Vec3::new(1.25, 0.0, 0.0);
    let y = |y| Vec3::new(0.0, y, 0.0);
    let cycle = |bits, velocity, omega| moving((A, 10.0), bits, velocity, omega);
    let link = || motion(&[(A, 30.0)]);
    let table = table(TableParts {
        cycles: vec![
            (NON_COMBAT, READY, cycle(0, Vec3::ZERO, Vec3::ZERO)),
            (NON_COMBAT, WALK, cycle(0, y(3.0), Vec3::ZERO)),
            (NON_COMBAT, RUN, cycle(0, y(4.0), Vec3::ZERO)),
            (NON_COMBAT, TURN, cycle(2, Vec3::ZERO, turn)),
            (NON_COMBAT, SIDE, cycle(2, side, Vec3::ZERO)),
        ],
        modifiers: vec![
            (0x0D, moving((A, 0.0), 0, Vec3::ZERO, turn)),
            (0x0F, moving((A, 0.0), 0, side, Vec3::ZERO)),
        ],
        links: vec![
            (motion_key(NON_COMBAT, READY), vec![(WALK, link())]),
            (motion_key(NON_COMBAT, WALK), vec![(RUN, link())]),
        ],
    });
    Player::with_table(vec![animation(A, 1, None, &[])], table, Profile::retail())
}

#[test]
fn modifiers() {
    let mut p = turner();
    let state = |p: &Player| {
        let sequence = &p.sequence;
        let last = p.pending().last().copied();
        (
            sequence.velocity.to_array(),
            sequence.omega.z,
            p.modifiers(),
            last,
        )
    };
    p.start(WALK, 1.0).unwrap();
    assert_eq!(state(&p), ([0.0, 3.0, 0.0], 0.0, vec![], Some((WALK, 1))));
    p.start(TURN, 1.0).unwrap();
    assert_eq!(
        state(&p),
        ([0.0, 3.0, 0.0], -1.5, vec![TURN], Some((TURN, 0)))
    );
    p.start(SIDE, 1.0).unwrap();
    let both = vec![SIDE, TURN];
    assert_eq!(
        state(&p),
        ([1.25, 3.0, 0.0], -1.5, both.clone(), Some((SIDE, 0)))
    );
    // The newest modifier is put back twice, the other never.
    p.start(RUN, 1.0).unwrap();
    assert_eq!(state(&p), ([2.5, 4.0, 0.0], 0.0, both, Some((RUN, 1))));
    p.stop(RUN).unwrap();
    assert_eq!(
        state(&p),
        ([1.25, 0.0, 0.0], -3.0, vec![TURN], Some((READY, 0)))
    );
    assert_eq!(p.manager.state.substate, SIDE);
}

#[test]
fn several_ends_in_one_update() {
    let animations = vec![animation(L, 3, None, &[]), animation(W, 1, None, &[])];
    let mut p = Player::new(animations, Profile::retail());
    p.append(whole(L, 30.0));
    p.append(whole(W, 30.0));
    p.manager.set_pending([(WAVE, 1)]);
    p.step(0.05);
    let outcome = p.step(0.1);
    assert_eq!(outcome.hooks, [4, 4]);
    assert_eq!(outcome.done.len(), 1);
    assert_eq!(p.manager.animation_counter, 0);
    assert_eq!(outcome.offset, Frame::IDENTITY);
}
