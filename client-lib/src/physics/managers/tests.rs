//! The managers without an object: F2 to F5, and the hard cases of H4 that concern them.

use proptest::prelude::*;

use super::target::Report;
use super::*;
use crate::math::{CellId, Frame, Position, Quat, Vec3};
use crate::profile::{ConstraintCounts, Interpolation, Profile};

const BLIP: f32 = 100.0;

fn at(x: f32, y: f32) -> Position {
    let cell = CellId(0xA9B4_0012);
    Position::new(cell, Vec3::new(x, y, 20.0), Quat::IDENTITY)
}

fn follow(position: &Position) -> Follow<'_> {
    Follow {
        position,
        contact: true,
        sticky: false,
        max_speed: 4.0,
        quantum: 0.04,
    }
}

fn interpolate(
    manager: &mut InterpolationManager,
    to: Position,
    own: Position,
) -> InterpolateOutcome {
    manager.interpolate_to(&to, false, &own, BLIP, &Profile::retail())
}

/// Adjusts an empty offset once.
fn adjust(manager: &mut InterpolationManager, own: Position) -> Frame {
    let mut offset = Frame::IDENTITY;
    manager.adjust_offset(&mut offset, &follow(&own), &Profile::retail());
    offset
}

#[test]
fn following_goes_to_the_node_and_completes_it() {
    let profile = Profile::retail();
    let mut manager = InterpolationManager::default();
    let mut own = at(60.0, 24.0);
    interpolate(&mut manager, at(61.0, 24.0), own);
    let mut quanta = 0;
    while manager.is_interpolating() {
        let offset = adjust(&mut manager, own);
        assert!(offset.origin.length() <= 8.0 * 0.04 + 1e-6);
        own.frame = own.frame.combine(&offset, &profile);
        quanta += 1;
        assert!(quanta < 10);
    }
    // Three steps of 0.32 m; the rest is nearer than what counts as reached, and is not gone.
    assert_eq!(quanta, 4);
    assert!((own.distance(&at(61.0, 24.0)) - 0.04).abs() < 1e-4);
    assert_eq!(manager, InterpolationManager::default());
}

#[test]
fn a_single_node_that_can_not_be_reached_blips_at_the_first_failure() {
    let mut manager = InterpolationManager::default();
    let own = at(60.0, 24.0);
    interpolate(&mut manager, at(65.0, 24.0), own);
    // The fifth quantum only takes the distance; the tenth finds no progress.
    for _ in 0..9 {
        adjust(&mut manager, own);
        assert!(manager.is_interpolating());
        assert_eq!(manager.blip(), None);
    }
    let offset = adjust(&mut manager, own);
    assert_eq!(offset, Frame::IDENTITY);
    assert!(!manager.is_interpolating());
    let blip = manager.blip().unwrap();
    assert_eq!((blip.target, blip.velocity), (at(65.0, 24.0), None));
    manager.stop();
    assert_eq!(manager.blip(), None);
}

#[test]
fn a_longer_queue_blips_to_its_end_at_the_fourth_failure() {
    let mut manager = InterpolationManager::default();
    let own = at(60.0, 24.0);
    for i in 1..=6_u8 {
        interpolate(&mut manager, at(60.0 + 5.0 * f32::from(i), 24.0), own);
    }
    let mut quanta = 0;
    while manager.blip().is_none() {
        adjust(&mut manager, own);
        quanta += 1;
        assert!(quanta < 100);
    }
    assert_eq!(manager.node_fail_counter, 4);
    assert_eq!(manager.blip().unwrap().target, at(90.0, 24.0));
}

#[test]
fn far_positions_blip_at_once_and_near_ones_only_turn() {
    let mut manager = InterpolationManager::default();
    let own = at(60.0, 24.0);
    assert_eq!(
        interpolate(&mut manager, at(160.5, 24.0), own),
        InterpolateOutcome::Queued
    );
    assert_eq!(manager.blip().unwrap().target, at(160.5, 24.0));
    manager.stop();
    let mut near = at(60.03, 24.0);
    near.frame.set_heading(90.0, &Profile::retail());
    let InterpolateOutcome::Reached(Some(heading)) = interpolate(&mut manager, near, own) else {
        panic!("was near");
    };
    assert!((heading - 90.0).abs() < 1e-3);
    let kept = manager.interpolate_to(&near, true, &own, BLIP, &Profile::retail());
    assert_eq!(kept, InterpolateOutcome::Reached(None));
}

#[test]
fn the_queue_is_bounded_and_drops_doubles() {
    let mut manager = InterpolationManager::default();
    let own = at(0.0, 24.0);
    for i in 1..=100_u8 {
        interpolate(&mut manager, at(f32::from(i), 24.0), own);
    }
    assert_eq!(manager.queue.len(), 20);
    assert_eq!(manager.queue[0].position, at(81.0, 24.0));
    interpolate(&mut manager, at(100.02, 24.0), own);
    assert_eq!(manager.queue.len(), 20);
    assert_eq!(manager.queue[19].position, at(100.02, 24.0));
}

#[test]
fn without_contact_nothing_is_followed() {
    let mut manager = InterpolationManager::default();
    let own = at(60.0, 24.0);
    interpolate(&mut manager, at(65.0, 24.0), own);
    let mut offset = Frame::from_origin(Vec3::Y);
    let airborne = Follow {
        contact: false,
        ..follow(&own)
    };
    assert!(!manager.needs_speed(&own, false));
    assert!(!manager.adjust_offset(&mut offset, &airborne, &Profile::retail()));
    assert_eq!(offset.origin, Vec3::Y);
    assert_eq!(manager.frame_counter, 0);
}

#[test]
fn velocity_nodes_are_taken_when_they_come() {
    let mut manager = InterpolationManager::default();
    let own = at(60.0, 24.0);
    manager.queue.push_back(InterpolationNode {
        kind: NodeKind::Velocity,
        position: own,
        velocity: Vec3::X,
    });
    assert_eq!(adjust(&mut manager, own), Frame::IDENTITY);
    assert_eq!(manager.complete_head(&own), Some(Vec3::X));
    assert_eq!(manager.complete_head(&own), None);
}

/// `01:F6`: the relative frame overwrites the node, so the next quantum goes somewhere else.
#[test]
fn a_relative_frame_that_mutates_moves_the_goal() {
    let own = at(60.0, 24.0);
    let goal = at(65.0, 24.0);
    let node_after = |relative_mutates: bool| {
        let profile = Profile {
            relative_mutates,
            ..Profile::retail()
        };
        let mut manager = InterpolationManager::default();
        interpolate(&mut manager, goal, own);
        let mut offset = Frame::IDENTITY;
        manager.adjust_offset(&mut offset, &follow(&own), &profile);
        // The step itself is the same here: no rotation, one block.
        assert!((offset.origin - Vec3::new(0.32, 0.0, 0.0)).length() < 1e-6);
        manager.queue[0].position.frame.origin
    };
    assert_eq!(node_after(false), goal.frame.origin);
    assert_eq!(node_after(true), Vec3::new(5.0, 0.0, 0.0));
}

#[test]
fn an_interpolation_that_does_not_work_breaks_the_object() {
    let mut profile = Profile::retail();
    profile.interpolation = Interpolation::NotWorking;
    let mut manager = PositionManager::default();
    assert!(!manager.is_broken());
    let interpolation = manager.interpolation.get_or_insert_default();
    let own = at(60.0, 24.0);
    interpolation.interpolate_to(&at(61.0, 24.0), false, &own, BLIP, &profile);
    assert!(manager.is_broken());
    assert!(!manager.is_interpolating());
}

/// One adjustment of an empty offset towards a target, at radii 0.5 and 0.5.
fn stick(own: &Position, target: &Position) -> Frame {
    let mut sticky = StickyManager::default();
    sticky.set(0x5000_0002, 0.5, 100.0);
    assert!(!sticky.is_pulling());
    sticky.initialized = true;
    let object = StickyPull {
        position: own,
        radius: 0.5,
        target_now: Some(target),
        max_speed: 4.0,
        quantum: 0.05,
    };
    let mut offset = Frame::from_origin(Vec3::Y);
    assert!(sticky.adjust_offset(&mut offset, &object, &Profile::retail()));
    offset
}

#[test]
fn sticking_keeps_a_gap_and_turns_to_the_target() {
    let profile = Profile::retail();
    let own = at(60.0, 24.0);
    // Far: a full step of 5 · 4 · 0.05 m.
    let far = stick(&own, &at(65.0, 24.0));
    assert!((far.origin - Vec3::X).length() < 1e-6);
    assert!((far.heading(&profile) - 90.0).abs() < 1e-3);
    // Near: as far as the gap of 0.3 m between the cylinders.
    let near = stick(&own, &at(61.5, 24.0));
    assert!((near.origin.x - 0.2).abs() < 1e-5);
    // Too near: backs off.
    let close = stick(&own, &at(61.2, 24.0));
    assert!((close.origin.x + 0.1).abs() < 1e-5);
    // Inside itself, with more to go than a step: forward all the same, but there is no direction.
    let same = stick(&own, &own);
    assert_eq!(same.origin, Vec3::ZERO);
}

#[test]
fn sticking_ends_after_a_second() {
    let mut sticky = StickyManager::default();
    assert!(!sticky.is_over(1e9));
    sticky.set(0x5000_0002, 0.5, 100.0);
    assert!(!sticky.is_over(101.0));
    assert!(sticky.is_over(101.001));
    assert!(sticky.clear());
    assert!(!sticky.clear());
    assert!(!sticky.is_over(1e9));
}

fn constrained(start: f32, max: f32) -> ConstraintManager {
    let mut constraint = ConstraintManager::default();
    constraint.constrain_to(&at(60.0, 24.0), start, max, &at(60.0, 24.0));
    constraint
}

fn walk(constraint: &mut ConstraintManager, contact: bool, profile: &Profile) -> f32 {
    let mut offset = Frame::from_origin(Vec3::Y);
    assert!(constraint.adjust_offset(&mut offset, contact, profile));
    offset.origin.y
}

#[test]
fn a_constraint_counts_the_way_by_profile() {
    let retail = Profile::retail();
    let mut constraint = constrained(2.0, 5.0);
    let way: Vec<f32> = (0..4)
        .map(|_| walk(&mut constraint, true, &retail))
        .collect();
    assert_eq!(way, [1.0, 1.0, 1.0, (5.0 - 3.0) / 3.0]);
    let mut last_step = retail.clone();
    last_step.constraint_counts = ConstraintCounts::LastStep;
    let mut constraint = constrained(2.0, 5.0);
    let way: Vec<f32> = (0..9)
        .map(|_| walk(&mut constraint, true, &last_step))
        .collect();
    assert_eq!(way, [1.0; 9]);
}

#[test]
fn a_constraint_without_contact_counts_but_does_not_hold() {
    let retail = Profile::retail();
    let mut constraint = constrained(0.0, 1.0);
    for _ in 0..3 {
        assert_eq!(walk(&mut constraint, false, &retail), 1.0);
    }
    assert_eq!(walk(&mut constraint, true, &retail), 0.0);
    assert!(constraint.is_fully_constrained(&retail));
    constraint.unconstrain();
    let mut offset = Frame::from_origin(Vec3::Y);
    assert!(!constraint.adjust_offset(&mut offset, true, &retail));
    // Not asked: whether it is on.
    assert!(constraint.is_fully_constrained(&retail));
}

#[test]
fn strange_constraints_do_not_divide_by_zero() {
    let retail = Profile::retail();
    for (start, max) in [(0.0, 0.0), (5.0, 5.0), (9.0, 2.0), (0.0, f32::INFINITY)] {
        let mut constraint = constrained(start, max);
        for _ in 0..20 {
            let step = walk(&mut constraint, true, &retail);
            assert!(max.is_infinite() || (0.0..=1.0).contains(&step), "{step}");
        }
    }
}

fn report(position: &Position, velocity: Vec3) -> Report<'_> {
    Report {
        guid: 0x5000_0001,
        position,
        velocity,
    }
}

#[test]
fn a_new_watcher_is_told_at_once_and_then_when_it_pays() {
    let mut manager = TargetManager::default();
    let own = at(60.0, 24.0);
    let first = manager
        .add_voyeur(7, 0.5, 0.5, &report(&own, Vec3::ZERO))
        .unwrap();
    assert_eq!(
        (first.status, first.target_position),
        (TargetStatus::Ok, own)
    );
    // Known already: changed, not told.
    assert!(
        manager
            .add_voyeur(7, 0.5, 1.0, &report(&own, Vec3::ZERO))
            .is_none()
    );
    assert_eq!(manager.voyeurs.len(), 1);
    let voyeur = manager.voyeurs[0];
    assert_eq!(voyeur.due(&report(&own, Vec3::X * 0.5)), None);
    let ahead = voyeur.due(&report(&own, Vec3::X * 0.75)).unwrap();
    assert_eq!(ahead, at(60.75, 24.0));
    assert!(manager.remove_voyeur(7));
    assert!(!manager.remove_voyeur(7));
}

#[test]
fn news_of_others_is_ignored() {
    let mut manager = TargetManager::default();
    let own = at(60.0, 24.0);
    let mut news = TargetInfo {
        object_id: 5,
        interpolated_position: at(60.0, 26.0),
        status: TargetStatus::Ok,
        ..TargetInfo::default()
    };
    assert!(manager.receive_update(&news, &own, 1.0).is_none());
    manager.target = Some(TargetInfo {
        object_id: 5,
        context_id: 9,
        ..TargetInfo::default()
    });
    let heard = manager.receive_update(&news, &own, 1.0).unwrap();
    assert_eq!(heard.interpolated_heading, Vec3::Y);
    assert_eq!((heard.context_id, heard.last_update_time), (0, 1.0));
    // At the same place the heading points up.
    news.interpolated_position = own;
    let heard = manager.receive_update(&news, &own, 2.0).unwrap();
    assert_eq!(heard.interpolated_heading, Vec3::Z);
    news.object_id = 6;
    assert!(manager.receive_update(&news, &own, 3.0).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// H3, 22: the constrained way never passes the limit by more than one step.
    #[test]
    fn the_constrained_way_is_bounded(start in 0.0_f32..10.0, more in 0.1_f32..20.0, steps in prop::collection::vec(0.0_f32..2.0, 1..60)) {
        let mut constraint = constrained(start, start + more);
        for step in steps {
            let mut offset = Frame::from_origin(Vec3::Y * step);
            let before = constraint.pos_offset;
            constraint.adjust_offset(&mut offset, true, &Profile::retail());
            prop_assert!(offset.origin.y <= step);
            prop_assert!(constraint.pos_offset >= before);
            prop_assert!(constraint.pos_offset <= start + more + 2.0);
        }
    }

    /// A step never goes farther than the speed allows, and always towards the node.
    #[test]
    fn a_step_of_following_is_bounded(x in -50.0_f32..50.0, y in -50.0_f32..50.0, heading in 0.0_f32..360.0) {
        let profile = Profile::retail();
        let mut own = at(60.0, 60.0);
        own.frame.set_heading(heading, &profile);
        let goal = at(60.0 + x, 60.0 + y);
        let mut manager = InterpolationManager::default();
        interpolate(&mut manager, goal, own);
        let before = own.distance(&goal);
        let offset = adjust(&mut manager, own);
        own.frame = own.frame.combine(&offset, &profile);
        prop_assert!(offset.origin.length() <= 8.0 * 0.04 + 1e-4);
        prop_assert!(own.distance(&goal) <= before + 1e-3);
    }
}
