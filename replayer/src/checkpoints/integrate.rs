//! Stage `integrate`: friction, translation, velocity, rotation.

use ac_client::frame::{StageData, StageView};
use ac_client::math::Frame;
use ac_client::physics::state::TransientState;
use serde_json::{Value, json};

use super::shapes::{self, hex, number, optional_vector, position, vector};

pub(super) fn input(view: &StageView<'_>) -> Value {
    let entity = view.entity;
    let kin = &entity.kin;
    let (offset, frame) = frames(view);
    let touches = (kin.transient)
        .intersects(TransientState::CONTACT | TransientState::ON_WALKABLE)
        .then_some(kin.contact_plane.n);
    json!({
        "quantum": number(view.quantum),
        "position": position(&entity.body.position),
        "offset": shapes::frame(offset),
        "frame": shapes::frame(frame),
        "velocity": vector(kin.velocity),
        "acceleration": vector(kin.acceleration),
        "omega": vector(kin.omega),
        "state": hex(entity.body.state.bits()),
        "transient": hex(kin.transient.bits()),
        "friction": number(kin.friction),
        "elasticity": number(kin.elasticity),
        "contact_normal": optional_vector(touches),
        "movement_manager": entity.movement.is_some(),
    })
}

pub(super) fn output(view: &StageView<'_>) -> Value {
    let (_, frame) = frames(view);
    json!({
        "frame": shapes::frame(frame),
        "velocity": vector(view.entity.kin.velocity),
        "transient": hex(view.entity.kin.transient.bits()),
    })
}

/// Offset, and the frame that is integrated.
fn frames<'a>(view: &StageView<'a>) -> (&'a Frame, &'a Frame) {
    match view.data {
        StageData::Integrate { offset, frame } => (offset, frame),
        _ => (&Frame::IDENTITY, &Frame::IDENTITY),
    }
}
