//! The queue of unfinished motions (12).

use crate::animation::fixtures::*;
use crate::animation::{MotionNotice, MotionRequest};
use crate::dat::motion_key;
use crate::profile::Profile;

const A: u32 = 0x0300_0001;
const B: u32 = 0x0300_0002;
const BOW: u32 = 0x1000_0125;

/// Ready, walk and run with links of one animation between all, and two actions.
fn actor(profile: Profile) -> Player {
    let link = || motion(&[(B, 30.0)]);
    let to = |targets: &[u32]| targets.iter().map(|t| (*t, link())).collect::<Vec<_>>();
    let table = table(TableParts {
        cycles: vec![
            (NON_COMBAT, READY, motion(&[(A, 10.0)])),
            (NON_COMBAT, WALK, motion(&[(A, 20.0)])),
            (NON_COMBAT, RUN, motion(&[(A, 30.0)])),
        ],
        links: vec![
            (motion_key(NON_COMBAT, READY), to(&[WALK, RUN, WAVE, BOW])),
            (motion_key(NON_COMBAT, WALK), to(&[READY, RUN])),
            (motion_key(NON_COMBAT, RUN), to(&[WALK, READY])),
        ],
        ..TableParts::default()
    });
    let animations = vec![animation(A, 4, None, &[]), animation(B, 3, None, &[])];
    Player::with_table(animations, table, profile)
}

#[test]
fn a_motion_that_repeats_an_unfinished_one_drops_what_lies_between() {
    let mut p = actor(Profile::retail());
    p.step(STEP);
    p.start(WALK, 1.0).unwrap();
    p.start(READY, 1.0).unwrap();
    assert_eq!(p.pending(), [(WALK, 1), (READY, 1)]);
    assert_eq!(p.list(), [B, B, A]);
    p.start(WALK, 1.0).unwrap();
    assert_eq!(p.pending(), [(WALK, 1), (READY, 0), (WALK, 0)]);
    assert_eq!(p.list(), [B, A]);
    // The links dropped are those at the back; the empty entries follow the first.
    let done: Vec<_> = (0..4).flat_map(|_| p.step(STEP).done).collect();
    let motions: Vec<_> = done.iter().map(|n| n.motion).collect();
    assert_eq!(motions, [WALK, READY, WALK]);
}

#[test]
fn an_unfinished_action_blocks_dropping() {
    let mut p = actor(Profile::retail());
    p.step(STEP);
    p.start(WALK, 1.0).unwrap();
    p.start(READY, 1.0).unwrap();
    p.start(WAVE, 1.0).unwrap();
    p.start(WALK, 1.0).unwrap();
    assert_eq!(p.pending(), [(WALK, 1), (READY, 1), (WAVE, 1), (WALK, 1)]);
}

#[test]
fn actions_leave_the_state_when_they_complete() {
    let mut p = actor(Profile::retail());
    p.step(STEP);
    p.start(WAVE, 1.0).unwrap();
    p.start(BOW, 1.0).unwrap();
    let actions = |p: &Player| {
        let actions = &p.manager.state.actions;
        actions.iter().map(|a| a.motion).collect::<Vec<_>>()
    };
    assert_eq!(actions(&p), [WAVE, BOW]);
    while p.pending().len() > 1 {
        p.step(STEP);
    }
    assert_eq!(actions(&p), [BOW]);
}

#[test]
fn actions_go_through_the_default_substate_and_back() {
    let count = |profile: Profile, back: bool| {
        let mut p = actor(profile);
        if !back {
            // Without the way back from Ready to Walk.
            let mut table = (*p.shelf.tables[0]).clone();
            let ready = motion_key(NON_COMBAT, READY);
            table.links = table
                .links
                .iter()
                .map(|(key, to)| {
                    let keep = to.iter().filter(|(t, _)| *key != ready || *t != WALK);
                    (*key, keep.cloned().collect())
                })
                .collect();
            p = Player::with_table(
                p.shelf.animations.clone(),
                std::sync::Arc::new(table),
                p.profile.clone(),
            );
            p.start(READY, 1.0).unwrap();
            p.manager.state.substate = WALK;
        } else {
            p.start(WALK, 1.0).unwrap();
        }
        p.start(WAVE, 1.0).unwrap();
        (p.pending().last().unwrap().1, p.list().len())
    };
    let mut first_link = Profile::retail();
    first_link.action_counts_first_link = true;
    assert_eq!(count(Profile::retail(), true).0, 3);
    assert_eq!(count(first_link.clone(), true).0, 3);
    assert_eq!(count(Profile::retail(), false).0, 2);
    assert_eq!(count(first_link, false).0, 2);
}

#[test]
fn what_is_queued_during_a_report_is_seen_by_the_rest_of_the_run() {
    let mut p = actor(Profile::retail());
    p.step(STEP);
    p.start(WAVE, 1.0).unwrap();
    p.hooks.clear();
    let mut run = p.manager.animation_done(true);
    let first = p.manager.next_completion(&mut run);
    assert_eq!(
        first,
        Some(MotionNotice {
            motion: WAVE,
            success: true
        })
    );
    // The entry that is being reported is still there, and the counter still raised.
    assert_eq!((p.pending().len(), p.manager.animation_counter), (1, 1));
    p.perform(MotionRequest::StopCompletely).unwrap();
    assert_eq!(p.pending().len(), 2);
    let second = p.manager.next_completion(&mut run);
    assert_eq!(second.map(|n| n.motion), Some(READY));
    assert_eq!(p.manager.next_completion(&mut run), None);
    assert_eq!((p.pending().len(), p.manager.animation_counter), (0, 0));
}

#[test]
fn an_entry_that_is_gone_after_its_report_is_not_removed_twice() {
    let mut p = actor(Profile::retail());
    p.manager.set_pending([(READY, 0), (WALK, 0), (RUN, 5)]);
    let mut run = p.manager.check_for_completed_motions();
    assert_eq!(p.manager.next_completion(&mut run).unwrap().motion, READY);
    // The object reports everything else as failed meanwhile.
    let mut flush = p.manager.handle_exit_world();
    while p.manager.next_completion(&mut flush).is_some() {}
    assert_eq!(p.manager.next_completion(&mut run), None);
    assert!(p.pending().is_empty());
}

#[test]
fn without_pending_motions_an_animation_done_counts_nothing() {
    let mut p = actor(Profile::retail());
    p.step(STEP);
    let mut run = p.manager.animation_done(true);
    assert_eq!(p.manager.next_completion(&mut run), None);
    assert_eq!(p.manager.animation_counter, 0);
}
