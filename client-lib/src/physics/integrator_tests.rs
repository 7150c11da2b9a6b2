//! Worked numbers and invariants of the integrator (`spec/06-physics-object.md`, H2 to H4).

use proptest::prelude::*;

use crate::entity::Kinetics;
use crate::math::{Frame, Plane, Vec3};
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::Profile;

const GROUND: TransientState = TransientState::CONTACT.union(TransientState::ON_WALKABLE);

fn kinetics(velocity: Vec3) -> Kinetics {
    Kinetics {
        velocity,
        ..Kinetics::new(0.0)
    }
}

fn on_ground(velocity: Vec3) -> Kinetics {
    Kinetics {
        transient: GROUND,
        contact_plane: Plane { n: Vec3::Z, d: 0.0 },
        ..kinetics(velocity)
    }
}

fn step(kin: &mut Kinetics, frame: &mut Frame, quantum: f32) {
    kin.update_physics(
        frame,
        quantum,
        PhysicsState::GRAVITY,
        true,
        &Profile::retail(),
    );
}

#[test]
fn free_fall_starts_one_step_late() {
    let mut kin = kinetics(Vec3::ZERO);
    kin.calc_acceleration(PhysicsState::GRAVITY, &Profile::retail());
    let mut frame = Frame::from_origin(Vec3::new(0.0, 0.0, 10.0));
    let expected = [
        (-0.490_000_009_536_743_16, 10.0),
        (-0.980_000_019_073_486_3, 9.963_250_160_217_285),
        (-1.470_000_028_610_229_5, 9.902_000_427_246_094),
        (-1.960_000_038_146_972_7, 9.816_250_801_086_426),
    ];
    for (velocity, height) in expected {
        step(&mut kin, &mut frame, 0.05);
        assert_eq!(f64::from(kin.velocity.z), velocity);
        assert_eq!(f64::from(frame.origin.z), height);
    }
}

#[test]
fn friction_factors() {
    let factors = [
        (1.0 / 30.0, 0.904_966_175_556_182_9),
        (0.05, 0.860_891_640_186_309_8),
        (0.1, 0.741_134_464_740_753_2),
        (0.2, 0.549_280_285_835_266_1),
    ];
    for (quantum, factor) in factors {
        let mut kin = on_ground(Vec3::X);
        kin.apply_friction(quantum, 1.0, PhysicsState::empty(), &Profile::retail());
        assert_eq!(f64::from(kin.velocity.x), factor);
    }
    let mut kin = on_ground(Vec3::new(3.0, 0.0, 0.0));
    kin.apply_friction(0.05, 9.0, PhysicsState::empty(), &Profile::retail());
    assert_eq!(f64::from(kin.velocity.x), 2.582_674_980_163_574);
}

#[test]
fn sleds_glide_on_steep_ground_and_stop_when_slow() {
    let steep = Plane {
        n: Vec3::new(0.6, 0.0, 0.8),
        d: 0.0,
    };
    let sled = |speed_squared, contact_plane, profile: &Profile| {
        let mut kin = Kinetics {
            contact_plane,
            ..on_ground(Vec3::Y)
        };
        kin.apply_friction(0.1, speed_squared, PhysicsState::SLEDDING, profile);
        f64::from(kin.velocity.y)
    };
    let flat = Plane { n: Vec3::Z, d: 0.0 };
    let (retail, ace) = (Profile::retail(), Profile::ace());
    assert_eq!(sled(6.25, steep, &retail), 0.977_932_751_178_741_5);
    assert_eq!(sled(1.5, steep, &retail), 0.0);
    assert_eq!(sled(6.25, flat, &retail), 0.741_134_464_740_753_2);
    assert_eq!(sled(6.25, flat, &ace), 0.977_932_751_178_741_5);
    assert_eq!(sled(6.25, steep, &ace), 0.741_134_464_740_753_2);
}

#[test]
fn the_speed_is_limited_to_fifty() {
    let mut kin = kinetics(Vec3::ZERO);
    kin.set_velocity(
        Vec3::new(30.0, 40.0, 10.0),
        PhysicsState::empty(),
        5.0,
        &Profile::retail(),
    );
    let expected = [
        29.417_419_433_593_75,
        39.223_228_454_589_844,
        9.805_807_113_647_461,
    ];
    assert_eq!(kin.velocity.to_array().map(f64::from), expected);
    assert!(kin.transient.contains(TransientState::ACTIVE));
    assert_eq!(kin.update_time, 5.0);
}

#[test]
fn not_a_number_passes_the_limit() {
    let mut kin = kinetics(Vec3::ZERO);
    let nan = Vec3::new(f32::NAN, 60.0, 0.0);
    kin.set_velocity(nan, PhysicsState::empty(), 0.0, &Profile::retail());
    assert!(kin.velocity.x.is_nan());
    assert_eq!(kin.velocity.y, 60.0);
    // A difference that is not a number counts as none in profile `gdle`.
    let mut kin = kinetics(Vec3::ZERO);
    let only_nan = Vec3::new(f32::NAN, 0.0, 0.0);
    kin.set_velocity(only_nan, PhysicsState::empty(), 0.0, &Profile::gdle());
    assert_eq!(kin.velocity, Vec3::ZERO);
}

#[test]
fn a_static_object_takes_a_velocity_and_stays_inactive() {
    let mut kin = kinetics(Vec3::ZERO);
    kin.set_velocity(Vec3::X, PhysicsState::STATIC, 1.0, &Profile::retail());
    assert_eq!(kin.velocity, Vec3::X);
    assert!(kin.transient.is_empty());
    assert!(!kin.set_active(true, PhysicsState::STATIC, 1.0));
}

#[test]
fn a_resting_object_without_movement_manager_becomes_inactive() {
    for has_manager in [false, true] {
        let mut kin = on_ground(Vec3::ZERO);
        kin.transient |= TransientState::ACTIVE;
        let mut frame = Frame::IDENTITY;
        kin.update_physics(
            &mut frame,
            0.05,
            PhysicsState::empty(),
            has_manager,
            &Profile::retail(),
        );
        assert_eq!(kin.transient.contains(TransientState::ACTIVE), has_manager);
    }
}

#[test]
fn elasticity_is_kept_within_bounds() {
    let of = |elasticity, profile: &Profile| {
        let mut kin = kinetics(Vec3::ZERO);
        kin.set_elasticity(elasticity, profile);
        kin.elasticity
    };
    let retail = Profile::retail();
    assert_eq!(of(-1.0, &retail), 0.0);
    assert_eq!(of(0.07, &retail), 0.07);
    assert_eq!(of(0.5, &retail), 0.1);
    assert_eq!(of(f32::NAN, &retail), 0.1);
    assert_eq!(of(0.5, &Profile::gdle()), 0.5);
}

#[test]
fn a_slow_spin_does_not_turn_at_all() {
    let mut kin = kinetics(Vec3::ZERO);
    let mut frame = Frame::IDENTITY;
    kin.omega = Vec3::new(0.0, 0.0, 0.0039);
    for _ in 0..1000 {
        step(&mut kin, &mut frame, 0.05);
    }
    assert_eq!(frame.bits(), Frame::IDENTITY.bits());
    kin.omega.z = 0.0041;
    step(&mut kin, &mut frame, 0.05);
    assert_ne!(frame.bits(), Frame::IDENTITY.bits());
}

#[test]
fn a_spinning_object_keeps_a_unit_rotation() {
    let mut kin = kinetics(Vec3::ZERO);
    kin.omega = Vec3::new(1.0, -2.0, 30.0);
    let mut frame = Frame::IDENTITY;
    for _ in 0..100_000 {
        step(&mut kin, &mut frame, 0.05);
    }
    assert!((frame.rotation().length() - 1.0).abs() < 1e-6);
}

fn vector(range: f32) -> impl Strategy<Value = Vec3> {
    let one = -range..range;
    (one.clone(), one.clone(), one).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

proptest! {
    #[test]
    fn velocity_never_exceeds_the_limit(v in vector(200.0)) {
        let mut kin = kinetics(Vec3::ZERO);
        kin.set_velocity(v, PhysicsState::empty(), 0.0, &Profile::retail());
        prop_assert!(kin.velocity.length() <= 50.0 * (1.0 + 2.0_f32.powi(-22)));
    }

    #[test]
    fn friction_never_speeds_up_and_spares_what_leaves_the_ground(
        v in vector(20.0), quantum in 0.034_f32..0.2, friction in 0.0_f32..1.0,
    ) {
        let mut kin = on_ground(v);
        kin.friction = friction;
        kin.apply_friction(quantum, v.dot(v), PhysicsState::empty(), &Profile::retail());
        if v.z >= 0.25 {
            prop_assert_eq!(kin.velocity, v);
        } else {
            prop_assert!(kin.velocity.length() <= v.length());
            prop_assert!(kin.velocity.x * v.x >= 0.0 && kin.velocity.y * v.y >= 0.0);
        }
    }

    #[test]
    fn a_mover_is_fast_or_at_rest(v in vector(1.0), quantum in 0.034_f32..0.2) {
        let mut kin = kinetics(v);
        let mut frame = Frame::IDENTITY;
        step(&mut kin, &mut frame, quantum);
        if v.dot(v) < 0.0626 {
            prop_assert_eq!(kin.velocity, Vec3::ZERO);
            prop_assert_eq!(frame.origin, Vec3::ZERO);
        } else if v.dot(v) > 0.0628 {
            prop_assert_eq!(kin.velocity, v);
        }
    }

    #[test]
    fn acceleration_follows_contact_and_gravity(
        transient in 0_u32..4, state in prop::sample::select(vec![0_u32, 0x400, 0x80_0000, 0x80_0400]),
        omega in vector(3.0),
    ) {
        let mut kin = kinetics(Vec3::ZERO);
        kin.transient = TransientState::from_bits_retain(transient);
        kin.omega = omega;
        let state = PhysicsState::from_bits_retain(state);
        kin.calc_acceleration(state, &Profile::retail());
        let stands = transient == 3 && !state.contains(PhysicsState::SLEDDING);
        let falls = !stands && state.contains(PhysicsState::GRAVITY);
        prop_assert_eq!(kin.acceleration.z, if falls { -9.8 } else { 0.0 });
        prop_assert_eq!(kin.omega, if stands { Vec3::ZERO } else { omega });
    }
}
