//! Attack cones (C9).

use super::*;
use crate::dat::{AnimFrame, AnimationHook, AttackCone, HookAction, HookDirection};
use crate::entity::{AttackReport, CollisionReport, Weenie};

/// A cone of 90 degrees ahead (+y), 3 m long, 1 m up.
const AHEAD: AttackCone = AttackCone {
    part: 4,
    left: [-1.0, 1.0],
    right: [1.0, 1.0],
    radius: 3.0,
    height: 1.0,
};

#[test]
fn the_cone_reaches_ahead() {
    // Ahead, at its edge, beside, behind, too far; and where it hits: front and back are the target's.
    let cases = [
        (0.0, 2.0, Some(0x8 | 0x40 | 0x2)),
        (1.5, 1.8, Some(0x8 | 0x40 | 0x2)),
        (-1.5, 1.8, Some(0x10 | 0x40 | 0x2)),
        (2.6, 0.0, None),
        (0.0, -2.0, None),
        (0.0, 3.6, None),
    ];
    for (x, y, expected) in cases {
        let mut world = world();
        let a = walker(&mut world, at(36.0, 36.0, 0.0));
        let b = walker(&mut world, at(36.0 + x, 36.0 + y, 0.0));
        // A radius of the setup is that of its body.
        let mut hits = Vec::new();
        world.with_entity(a, |e, w| e.attack(&AHEAD, w, &mut hits));
        let hit = hits.first().map(|hit| hit.quadrant);
        assert_eq!(hit, expected, "({x}, {y})");
        assert!(hits.iter().all(|hit| hit.object == b && hit.part == 4));
    }
}

#[test]
fn who_is_exempt_from_attacks() {
    let mut world = world();
    let a = walker(&mut world, at(48.0, 46.0, 0.0));
    // On the border of two cells: reported once.
    let b = walker(&mut world, at(48.0, 48.0, 0.0));
    let strike = |world: &mut World, cone: AttackCone| {
        let mut hits = Vec::new();
        world.with_entity(a, |e, w| e.attack(&cone, w, &mut hits));
        hits.len()
    };
    assert_eq!(strike(&mut world, AHEAD), 1);
    let too_high = AttackCone {
        height: 1.9,
        ..AHEAD
    };
    assert_eq!(strike(&mut world, too_high), 0);
    assert_eq!(
        strike(
            &mut world,
            AttackCone {
                height: -0.1,
                ..AHEAD
            }
        ),
        0
    );
    for state in [0x418, 0x0020_0408, 0x409] {
        world.with_entity(b, |e, w| e.set_state(state, w));
        assert_eq!(strike(&mut world, AHEAD), 0, "{state:#x}");
    }
    world.with_entity(a, |e, w| e.leave_world(w));
    assert_eq!(strike(&mut world, AHEAD), 0);
}

/// A setup whose default animation strikes once in its third frame, at 30 frames a second.
fn world_with_striker(profile: Profile) -> (World, u32) {
    let mut world = WorldBuilder::new();
    let cube = world.solid(&block(Vec3::new(-0.3, -0.3, 0.0), Vec3::new(0.3, 0.3, 1.8)));
    world.setup(SetupBuilder::humanoid(cube, 1.8, 0.48));
    let frames = (0..30).map(|n| {
        let hook = AnimationHook {
            direction: HookDirection::FORWARD,
            action: HookAction::Attack(AHEAD),
        };
        let frame = AnimFrame {
            parts: vec![StoredFrame::at(Vec3::ZERO)],
            hooks: if n == 3 { vec![hook] } else { Vec::new() },
        };
        (frame, None)
    });
    let strike = world.animation(1, frames);
    let striker = world.setup(SetupBuilder::humanoid(cube, 1.8, 0.48).animation(strike));
    world.block(0x10, 0x20);
    let dats = world.surround().build().expect("the world is well formed");
    (World::with_source(profile, 100.0, Arc::new(dats)), striker)
}

/// C9, 07 section 9.1 type 3: the hook of an animation frame strikes when the frame is crossed, before the move of the same quantum, and each
/// hit is told to the own weenie. A profile that does not execute the hook tells nothing, and nobody's motion differs.
#[test]
fn the_hook_of_an_animation_strikes() {
    for (profile, strikes) in [
        (Profile::retail(), true),
        (Profile::ace(), false),
        (Profile::gdle(), false),
    ] {
        let (mut world, striker) = world_with_striker(profile);
        let a = object(&mut world, striker, 0x0040_0408, Some(at(36.0, 36.0, 0.0)));
        let b = walker(&mut world, at(36.0, 38.0, 0.0));
        walker(&mut world, at(36.0, 33.0, 0.0));
        world.entity_mut(a).expect("there").weenie = Some(Weenie {
            collects_reports: true,
            ..Weenie::default()
        });
        world.with_entity(a, |e, w| e.make_movement_manager(true, w));
        let mut told = Vec::new();
        for n in 1..=6 {
            frame(&mut world, 100.0 + f64::from(n) * 0.05);
            let reports = &mut world.entity_mut(a).expect("there").reports;
            told.extend(
                reports
                    .drain(..)
                    .filter(|r| matches!(r, CollisionReport::Attack(_))),
            );
        }
        let hit = CollisionReport::Attack(AttackReport {
            guid: world.entity(b).expect("there").guid(),
            quadrant: 0x8 | 0x40 | 0x2,
            part: 4,
        });
        assert_eq!(
            told,
            if strikes { vec![hit] } else { Vec::new() },
            "{}",
            world.profile.name
        );
    }
}
