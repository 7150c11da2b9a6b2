//! Stage `integrate`: friction, rest, translation, rotation.

use ac_client::entity::Kinetics;
use ac_client::math::Vec3;
use ac_client::physics::state::{PhysicsState, TransientState};
use ac_client::profile::Profile;
use ac_golden_traces::number;
use ac_golden_traces::scene::OffsetSpec;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::shapes::{frame, frame_spec};

#[derive(Debug, Deserialize)]
pub(super) struct Input {
    #[serde(with = "number::f32")]
    quantum: f32,
    #[serde(with = "number::f32")]
    friction: f32,
    #[serde(with = "number::hex")]
    state: u32,
    #[serde(with = "number::hex")]
    transient: u32,
    frame: OffsetSpec,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    #[serde(with = "number::floats")]
    acceleration: [f32; 3],
    #[serde(with = "number::floats")]
    omega: [f32; 3],
    #[serde(with = "number::opt_vec3")]
    contact_normal: Option<[f32; 3]>,
    movement_manager: bool,
}

#[derive(Debug, Serialize)]
struct Output {
    frame: OffsetSpec,
    #[serde(with = "number::floats")]
    velocity: [f32; 3],
    #[serde(with = "number::hex")]
    transient: u32,
}

pub(super) fn run(input: &Input, profile: &Profile) -> Value {
    let mut kin = Kinetics::new(0.0);
    kin.transient = TransientState::from_bits_retain(input.transient);
    kin.velocity = Vec3::from(input.velocity);
    kin.acceleration = Vec3::from(input.acceleration);
    kin.omega = Vec3::from(input.omega);
    kin.friction = input.friction;
    kin.contact_plane.n = input.contact_normal.map_or(Vec3::ZERO, Vec3::from);
    let mut moved = frame(&input.frame);
    kin.update_physics(
        &mut moved,
        input.quantum,
        PhysicsState::from_bits_retain(input.state),
        input.movement_manager,
        profile,
    );
    let output = Output {
        frame: frame_spec(&moved),
        velocity: kin.velocity.into(),
        transient: kin.transient.bits(),
    };
    super::write(&output).unwrap_or_else(|_| json!(null))
}
