//! One step of f32 around the limits of velocity, friction, contact and ground (H4: 2 to 4), and bounces between walls (H4: 8).

use super::*;
use crate::entity::Kinetics;
use crate::math::{Frame, Plane};
use crate::physics::state::{PhysicsState, TransientState};
use crate::physics::transition::{CollisionInfo, is_valid_walkable};

const GROUND: TransientState = TransientState::CONTACT.union(TransientState::ON_WALKABLE);

/// The f32 before a number, the number, and the one after.
fn around(x: f32) -> [f32; 3] {
    [x.next_down(), x, x.next_up()]
}

/// Velocity after one quantum of 0.05 s in free air, without gravity.
fn after_a_step(velocity: Vec3) -> Vec3 {
    let mut kin = Kinetics {
        velocity,
        ..Kinetics::new(0.0)
    };
    let state = PhysicsState::empty();
    kin.update_physics(
        &mut Frame::IDENTITY.clone(),
        0.05,
        state,
        true,
        &Profile::retail(),
    );
    kin.velocity
}

/// Share of a velocity of `speed` m/s across a slope whose normal has this z that a quantum of 0.1 s leaves to a sled.
fn sled_keeps(speed: f32, normal_z: f32) -> f32 {
    let mut kin = Kinetics {
        velocity: Vec3::Y * speed,
        transient: GROUND,
        contact_plane: Plane {
            n: Vec3::new((1.0 - normal_z * normal_z).sqrt(), 0.0, normal_z),
            d: 0.0,
        },
        ..Kinetics::new(0.0)
    };
    kin.apply_friction(
        0.1,
        speed * speed,
        PhysicsState::SLEDDING,
        &Profile::retail(),
    );
    kin.velocity.y / speed
}

/// H4, 2: the limit of 50 m/s is exclusive, both when a velocity is set and when it is integrated.
#[test]
fn speeds_around_the_limit() {
    let [below, at, above] = around(50.0);
    assert_eq!(after_a_step(Vec3::X * below), Vec3::X * below);
    assert_eq!(after_a_step(Vec3::X * at), Vec3::X * at);
    // Normalising rounds.
    let limited = |x: f32| (49.999_99..=50.0).contains(&x);
    assert!(limited(after_a_step(Vec3::X * above).x));
    let set = |x: f32| {
        let mut kin = Kinetics::new(0.0);
        kin.set_velocity(Vec3::X * x, PhysicsState::empty(), 0.0, &Profile::retail());
        kin.velocity.x
    };
    assert_eq!([below, at].map(set), [below, at]);
    assert!(limited(set(above)));
}

/// H4, 2: what counts as rest: a squared speed of 0.0625 + ε in f32, that is 0.0627 but for rounding, is the first that moves.
#[test]
fn speeds_around_rest() {
    let moves = |x: f32| after_a_step(Vec3::X * x) != Vec3::ZERO;
    let (mut low, mut high) = (0.25_f32.to_bits(), 0.26_f32.to_bits());
    assert!(!moves(f32::from_bits(low)) && moves(f32::from_bits(high)));
    while high - low > 1 {
        let middle = (low + high) / 2;
        if moves(f32::from_bits(middle)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    let [rest, first] = [low, high].map(f32::from_bits);
    assert!(rest * rest - 0.0625 < 0.0002 && first * first - 0.0625 >= 0.0002);
    assert!((first - 0.2504).abs() < 1e-5, "{first}");
}

/// H4, 2: a sled slower than 1.25 m/s stops, one of 2.5 m/s glides; both limits belong to the faster side.
#[test]
fn sleds_around_their_limits() {
    let steep = 0.8;
    let usual = libm::pow(f64::from(1.0 - 0.95_f32), f64::from(0.1_f32)) as f32;
    let glides = libm::pow(0.8, f64::from(0.1_f32)) as f32;
    let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
    let [below, at, above] = around(1.25);
    assert_eq!(sled_keeps(below, steep), 0.0);
    assert!(near(sled_keeps(at, steep), usual) && near(sled_keeps(above, steep), usual));
    let [below, at, above] = around(2.5);
    assert!(near(sled_keeps(below, steep), usual));
    assert!(near(sled_keeps(at, steep), glides) && near(sled_keeps(above, steep), glides));
}

/// H4, 4: ten degrees, compared in f64: the f32 nearest to the cosine is above it.
#[test]
fn slopes_around_ten_degrees() {
    let limit = 0.984_807_753_012_208_f64;
    let usual = sled_keeps(3.0, 1.0);
    for z in around(limit as f32) {
        let glides = sled_keeps(3.0, z) > usual + 0.1;
        assert_eq!(glides, f64::from(z) < limit, "{z}");
    }
}

/// H4, 4: the smallest walkable normal is walkable; with the limit in f64 (O-15) it depends on which side of it the f32 lies.
#[test]
fn slopes_around_the_walkable_limit() {
    let limit = 0.664_174_14_f32;
    assert_eq!(limit.to_bits(), 0x3F2A_0751);
    let walkable = |z: f32, profile: &Profile| is_valid_walkable(Vec3::new(0.0, 0.0, z), profile);
    let retail = Profile::retail();
    assert_eq!(
        around(limit).map(|z| walkable(z, &retail)),
        [false, true, true]
    );
    let exact = 0.664_174_146_186_627_6_f64;
    for z in around(limit) {
        assert_eq!(walkable(z, &Profile::gdle()), f64::from(z) >= exact, "{z}");
    }
    assert!(!walkable(f32::NAN, &retail));
}

/// H4, 3: friction acts below 0.25 m/s away from the ground; contact lasts up to ε m/s away from it.
#[test]
fn leaving_speeds_around_their_limits() {
    let ground = |z: f32| Kinetics {
        velocity: Vec3::new(3.0, 0.0, z),
        transient: GROUND,
        contact_plane: Plane { n: Vec3::Z, d: 0.0 },
        ..Kinetics::new(0.0)
    };
    let slows = |z: f32| {
        let mut kin = ground(z);
        kin.apply_friction(0.1, 9.0, PhysicsState::empty(), &Profile::retail());
        assert_eq!(kin.velocity.z == z, kin.velocity.x == 3.0, "all or nothing");
        kin.velocity.x < 3.0
    };
    assert_eq!(around(0.25).map(slows), [true, false, false]);
    let keeps = |z: f32| ground(z).check_contact(true);
    assert_eq!(around(0.0002).map(keeps), [true, true, false]);
    assert!(!ground(0.0).check_contact(false));
    // Without contact the velocity is not asked.
    let mut airborne = ground(5.0);
    airborne.transient = TransientState::empty();
    assert!(airborne.check_contact(true));
}

fn bounce(elasticity: f32, velocity: Vec3, normal: Vec3) -> Vec3 {
    let mut world = world();
    let id = object(&mut world, CRATE, 0x8, None);
    let info = CollisionInfo {
        collision_normal_valid: true,
        collision_normal: normal,
        ..CollisionInfo::default()
    };
    world
        .with_entity(id, |e, w| {
            (e.kin.elasticity, e.kin.velocity) = (elasticity, velocity);
            e.handle_all_collisions(&info, false, false, w);
            e.kin.velocity
        })
        .expect("there")
}

/// H4, 8: least and greatest elasticity, and a normal that is not of unit length (profile `ace`, T-01): the factor is the same, so a normal
/// twice as long throws back four times as far.
#[test]
fn bounces_by_elasticity_and_length_of_the_normal() {
    let into = Vec3::new(-8.0, 3.0, 0.0);
    assert_eq!(bounce(0.0, into, Vec3::X), Vec3::new(0.0, 3.0, 0.0));
    let e = 0.1_f32;
    let back = bounce(e, into, Vec3::X);
    assert_eq!(back, Vec3::new(-8.0 + 8.0 * (e + 1.0), 3.0, 0.0));
    assert_eq!(
        bounce(e, into, Vec3::X * 2.0).x,
        -8.0 + 2.0 * (16.0 * (e + 1.0))
    );
    assert_eq!(bounce(e, into, Vec3::ZERO), into, "no normal, no bounce");
    assert_eq!(bounce(e, into, Vec3::NEG_X), into, "moving away");
}

/// H4, 8: to and fro between two walls within one frame: each quantum turns the velocity, and none gives it back whole.
#[test]
fn between_two_walls_in_one_frame() {
    for (elasticity, turns) in [(0.0, false), (0.1, true)] {
        let mut world = world();
        // The crate of the block ends at x = 61; this one begins at 63.
        object(&mut world, CRATE, 0x0001_0408, Some(at(64.0, 60.0, 0.0)));
        // No gravity, above the ground.
        let id = object(&mut world, WALKER, 0x8, Some(at(62.0, 60.0, 0.05)));
        world.with_entity(id, |e, w| {
            e.kin.elasticity = elasticity;
            e.make_movement_manager(true, w);
            e.set_velocity(Vec3::new(40.0, 0.0, 0.0), w);
        });
        let mut speeds = vec![40.0_f32];
        for n in 1..=3 {
            frame(&mut world, 100.0 + f64::from(n));
            let e = world.entity_mut(id).expect("there");
            assert!(e.steps.drain(..).count() >= 5, "quanta of 0.2 s");
            let x = e.body.position.frame.origin.x;
            assert!((61.4..=62.6).contains(&x), "{x}");
            speeds.push(e.kin.velocity.x.abs());
        }
        assert!(speeds.windows(2).all(|v| v[1] <= v[0]), "{speeds:?}");
        assert!(speeds[1] < if turns { 4.1 } else { 0.1 }, "{speeds:?}");
        check(&world, id);
    }
}

fn check(world: &World, id: EntityId) {
    crate::physics::fuzzing::check_membership(world, id);
}
