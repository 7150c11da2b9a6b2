//! Managers at work on objects (part F; H3: 20 to 23; H4: 20 to 22).

use super::*;
use crate::math::Frame;
use crate::physics::managers::StickyManager;

fn sticky(world: &World, id: EntityId) -> Option<StickyManager> {
    let manager = world.entity(id)?.position_manager.as_ref()?;
    manager.sticky.filter(|s| s.target_id != 0)
}

/// Places two walkers; the first sticks to the second, or to itself.
fn stuck(to_itself: bool) -> (World, EntityId, EntityId) {
    let mut world = world();
    let a = walker(&mut world, at(30.0, 30.0, 0.0));
    let b = walker(&mut world, at(36.0, 30.0, 0.0));
    let guid = world
        .entity(if to_itself { a } else { b })
        .expect("there")
        .guid();
    world.with_entity(a, |e, w| e.stick_to(guid, 0.48, 1.8, w));
    (world, a, b)
}

/// H3, 22: a step is no longer than speed and distance allow, level, and it ends after a second.
#[test]
fn sticking_ends_within_a_step_after_a_second() {
    let (mut world, a, _) = stuck(false);
    assert!(sticky(&world, a).is_some_and(|s| s.initialized));
    let mut offset = Frame::from_origin(Vec3::Z);
    world.with_entity(a, |e, w| e.adjust_offset(&mut offset, 0.05, w));
    let speed = world
        .with_entity(a, |e, w| 5.0 * e.max_speed(w))
        .expect("there");
    assert_eq!(offset.origin.z, 0.0);
    assert!(offset.origin.length() <= speed * 0.05 + 1e-5 && offset.origin.length() > 0.0);
    let mut ended = None;
    for n in 1..40 {
        let now = 100.0 + f64::from(n) * 0.05;
        frame(&mut world, now);
        if sticky(&world, a).is_none() {
            ended = ended.or(Some(now));
        }
    }
    let ended = ended.expect("it ends");
    assert!(ended > 101.0 && ended <= 101.0 + 0.05 + 1e-9, "{ended}");
    let watchers = world
        .entities
        .table()
        .iter()
        .filter_map(|&id| world.entity(id)?.target_manager.as_ref());
    assert!(
        watchers
            .into_iter()
            .all(|m| m.target.is_none() && m.voyeurs.is_empty())
    );
}

/// H4, 21: a target that leaves ends it; one that is the object itself pulls nowhere.
#[test]
fn sticking_to_what_leaves_and_to_oneself() {
    let (mut world, a, b) = stuck(false);
    frame(&mut world, 100.05);
    world.with_entity(b, |e, w| e.exit_world(w));
    assert!(sticky(&world, a).is_none());
    frame(&mut world, 100.1);
    let (mut world, a, _) = stuck(true);
    let before = world.entity(a).expect("there").body.position.frame.origin;
    for n in 1..30 {
        frame(&mut world, 100.0 + f64::from(n) * 0.05);
    }
    let after = world.entity(a).expect("there").body.position.frame.origin;
    assert!(sticky(&world, a).is_none());
    assert!((after - before).length() < 1e-3);
}

/// H3, 20; H4, 22: no offset is left once the way is used up, whatever the limits.
#[test]
fn a_used_up_constraint_holds() {
    for (start, max) in [(0.0, 0.0), (5.0, 1.0), (1.0, 2.0), (f32::NAN, 0.5)] {
        let mut world = world();
        let a = walker(&mut world, at(30.0, 30.0, 0.0));
        frame(&mut world, 100.05);
        let own = world.entity(a).expect("there").body.position;
        world.with_entity(a, |e, w| e.constrain_to(&own, start, max, w));
        let mut way = 0.0;
        let mut last = Vec3::ONE;
        for _ in 0..60 {
            let mut offset = Frame::from_origin(Vec3::new(0.0, 0.3, 0.1));
            world.with_entity(a, |e, w| e.adjust_offset(&mut offset, 0.05, w));
            last = offset.origin;
            way += last.length();
        }
        assert!(way <= max + 0.4, "{start} {max}: {way}");
        // Between start and limit the way only tends to the limit.
        assert!(last.length() < 0.01, "{start} {max}: {last}");
    }
}

/// H4, 22: without a limit nothing is held.
#[test]
fn a_constraint_without_limit_does_not_hold() {
    let mut world = world();
    let a = walker(&mut world, at(30.0, 30.0, 0.0));
    let own = world.entity(a).expect("there").body.position;
    world.with_entity(a, |e, w| e.constrain_to(&own, 5.0, f32::INFINITY, w));
    for _ in 0..10 {
        let mut offset = Frame::from_origin(Vec3::Y * 0.3);
        world.with_entity(a, |e, w| e.adjust_offset(&mut offset, 0.05, w));
        assert_eq!(offset.origin, Vec3::Y * 0.3);
    }
}

/// H3, 21; H4, 20: a flood of positions leaves a bounded queue, and the object ends at the last of them.
#[test]
fn a_flood_of_positions_is_followed_to_its_end() {
    let mut world = world();
    let a = walker(&mut world, at(30.0, 30.0, 0.0));
    frame(&mut world, 100.05);
    for n in 1..=100 {
        let to = at(30.0 + 0.1 * n as f32, 30.0, 0.0);
        world.with_entity(a, |e, w| e.interpolate_to(&to, false, w));
        let manager = world.entity(a).and_then(|e| e.position_manager.as_ref());
        let queue = manager
            .and_then(|m| m.interpolation.as_ref())
            .map_or(0, |i| i.queue.len());
        assert!(queue <= 20);
    }
    let goal = at(40.0, 30.0, 0.0);
    let mut distance = f32::MAX;
    for n in 2..120 {
        frame(&mut world, 100.0 + f64::from(n) * 0.05);
        let now = world
            .entity(a)
            .expect("there")
            .body
            .position
            .distance(&goal);
        assert!(now <= distance + 1e-3, "it never goes back");
        distance = now;
    }
    assert!(distance < 0.1, "{distance}");
    assert!(!world.entity(a).expect("there").is_interpolating());
}

/// H4, 20: a goal inside the crate: the object does not get there, and gives up or is placed beside it.
#[test]
fn a_goal_inside_a_wall_ends() {
    let mut world = world();
    let a = walker(&mut world, at(57.0, 60.0, 0.0));
    frame(&mut world, 100.05);
    world.with_entity(a, |e, w| e.interpolate_to(&at(60.0, 60.0, 0.0), false, w));
    for n in 2..100 {
        frame(&mut world, 100.0 + f64::from(n) * 0.05);
        let at = world.entity(a).expect("there").body.position.frame.origin;
        assert!(
            (at.x - 60.0).abs() > 0.9 || (at.y - 60.0).abs() > 0.9 || at.z > 1.9,
            "{at}"
        );
    }
}

/// H3, 23: a watcher hears at most every half second, and only of real moves.
#[test]
fn watchers_hear_every_half_second_at_most() {
    let mut world = world();
    let a = walker(&mut world, at(30.0, 30.0, 0.0));
    let b = walker(&mut world, at(36.0, 30.0, 0.0));
    let guid = world.entity(b).expect("there").guid();
    world.with_entity(a, |e, w| e.set_target(0, guid, 0.5, 0.0, w));
    let heard = |world: &World| {
        let manager = world.entity(a)?.target_manager.as_ref()?;
        manager.target.map(|t| t.last_update_time)
    };
    assert_eq!(heard(&world), Some(100.0), "at once");
    let mut times = Vec::new();
    for n in 1..=60 {
        let now = 100.0 + f64::from(n) * 0.05;
        // It moves in the middle third only.
        let speed = if (20..40).contains(&n) { 6.0 } else { 0.0 };
        world.with_entity(b, |e, w| e.set_velocity(Vec3::X * speed, w));
        let before = heard(&world);
        frame(&mut world, now);
        if heard(&world) != before {
            times.push(now);
        }
    }
    assert!((2..=4).contains(&times.len()), "{times:?}");
    assert!(
        times.windows(2).all(|t| t[1] - t[0] > 0.5 - 1e-9),
        "{times:?}"
    );
    assert!(
        times.iter().all(|&t| (100.9..102.6).contains(&t)),
        "{times:?}"
    );
}

/// O-20: the interval of half a second is counted on the clock inside the step, or on that of the frame.
#[test]
fn the_interval_counts_on_the_clock_of_the_profile() {
    for (profile, expected) in [(Profile::retail(), 100.65), (Profile::ace(), 100.95)] {
        let mut world = world_of(profile);
        let a = walker(&mut world, at(30.0, 30.0, 0.0));
        let b = walker(&mut world, at(36.0, 30.0, 0.0));
        let guid = world.entity(b).expect("there").guid();
        world.with_entity(a, |e, w| {
            e.make_movement_manager(true, w);
            e.set_target(0, guid, 0.5, 0.0, w);
        });
        frame(&mut world, 100.05);
        // Steps of 0.2 s (retail) or 0.1 s (ace) inside one frame.
        frame(&mut world, 100.95);
        let manager = world.entity(a).and_then(|e| e.target_manager.as_ref());
        let last = manager.expect("there").last_update;
        assert!(
            (last - expected).abs() < 1e-6,
            "{}: {last}",
            world.profile.name
        );
    }
}
