//! Attack cones (C9).

use super::*;
use crate::dat::AttackCone;

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
