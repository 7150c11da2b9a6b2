//! Script steps (`spec/scene-format.md`, "Script steps"; `spec/08-motion.md`, 10.12).

use ac_client::entity::Entity;
use ac_client::math::{Frame, Vec3};
use ac_client::motion::{Command, HoldKey, Movement, MovementFlags, MovementParameters};
use ac_client::physics::attachment::Attachment;
use ac_client::physics::body::EntityId;
use ac_client::physics::placement::{PlacementFlags, SetPosition};
use ac_client::profile::Profile;
use ac_client::world::World;
use ac_golden_traces::scene::{Action, HoldKey as HoldKeySpec, MoveParams};

use super::entity::{position, quat};

/// Carries out a step that acts on an existing object. `parent` is the object that a `set_parent` names.
///
/// A step that is refused changes nothing beyond what its function says; the script goes on.
pub(super) fn act(
    entity: &mut Entity,
    action: &Action,
    parent: Option<EntityId>,
    world: &mut World,
) {
    match action {
        Action::DoMotion { .. }
        | Action::DoInterpretedMotion { .. }
        | Action::StopMotion { .. }
        | Action::StopInterpretedMotion { .. }
        | Action::StopCompletely
        | Action::Jump { .. } => command(entity, action, world),
        Action::MoveToPosition { .. }
        | Action::MoveToObject { .. }
        | Action::TurnToHeading { .. }
        | Action::TurnToObject { .. } => move_to(entity, action, world),
        Action::Create { .. } | Action::Destroy => {}
        _ => place(entity, action, parent, world),
    }
}

fn plain(speed: f32, profile: &Profile) -> MovementParameters {
    MovementParameters {
        speed,
        ..MovementParameters::new(profile)
    }
}

fn held(speed: f32, key: HoldKeySpec, profile: &Profile) -> MovementParameters {
    MovementParameters {
        hold_key: hold_key(key),
        ..plain(speed, profile)
    }
}

const fn hold_key(key: HoldKeySpec) -> HoldKey {
    match key {
        HoldKeySpec::None => HoldKey::None,
        HoldKeySpec::Run => HoldKey::Run,
    }
}

fn command(entity: &mut Entity, action: &Action, world: &mut World) {
    let profile = world.profile.clone();
    let movement = match *action {
        Action::DoMotion {
            command,
            speed,
            hold_key,
        } => {
            entity.kin.last_move_was_autonomous = true;
            Movement::Raw(Command(command), held(speed, hold_key, &profile))
        }
        Action::StopMotion {
            command,
            speed,
            hold_key,
        } => {
            entity.kin.last_move_was_autonomous = true;
            Movement::StopRaw(Command(command), held(speed, hold_key, &profile))
        }
        Action::DoInterpretedMotion { command, speed } => {
            Movement::Interpreted(Command(command), plain(speed, &profile))
        }
        Action::StopInterpretedMotion { command, speed } => {
            Movement::StopInterpreted(Command(command), plain(speed, &profile))
        }
        Action::Jump { extent } => {
            entity.kin.last_move_was_autonomous = true;
            // A refused jump only ends a charge.
            let _ = entity.jump(extent, world);
            return;
        }
        _ => {
            entity.stop_completely(world);
            return;
        }
    };
    // A refused motion changes nothing.
    let _ = entity.perform_movement(&movement, world);
}

/// Parameters of a move-to: what is absent has the default.
pub fn params(spec: &MoveParams, profile: &Profile) -> MovementParameters {
    let mut params = MovementParameters::new(profile);
    if let Some(bits) = spec.bitfield {
        params.flags = MovementFlags::from_bits_retain(bits);
    }
    let fields = [
        (spec.distance_to_object, &mut params.distance_to_object),
        (spec.min_distance, &mut params.min_distance),
        (spec.desired_heading, &mut params.desired_heading),
        (spec.speed, &mut params.speed),
        (spec.fail_distance, &mut params.fail_distance),
        (spec.walk_run_threshold, &mut params.walk_run_threshold),
    ];
    for (given, field) in fields {
        *field = given.unwrap_or(*field);
    }
    params.hold_key = spec.hold_key.map_or(HoldKey::Invalid, hold_key);
    params
}

fn move_to(entity: &mut Entity, action: &Action, world: &mut World) {
    let profile = world.profile.clone();
    match action {
        Action::MoveToPosition {
            position: to,
            params: how,
        } => entity.move_to_position(&position(to), &params(how, &profile), world),
        Action::MoveToObject {
            target,
            params: how,
        } => {
            entity.move_to_object(*target, &params(how, &profile), world);
        }
        Action::TurnToObject {
            target,
            params: how,
        } => {
            entity.turn_to_object(*target, &params(how, &profile), world);
        }
        Action::TurnToHeading {
            heading,
            params: how,
        } => {
            let mut params = params(how, &profile);
            params.desired_heading = *heading;
            entity.turn_to_heading(&params, world);
        }
        _ => {}
    }
}

fn place(entity: &mut Entity, action: &Action, parent: Option<EntityId>, world: &mut World) {
    match action {
        Action::StickTo {
            target,
            radius,
            height,
        } => entity.stick_to(*target, *radius, *height, world),
        Action::ConstrainTo {
            position: to,
            start,
            max,
        } => entity.constrain_to(&position(to), *start, *max, world),
        Action::SetVelocity { velocity } => entity.set_velocity(Vec3::from(*velocity), world),
        Action::SetPosition {
            position: to,
            flags,
        } => {
            let flags = PlacementFlags::from_bits_retain(*flags);
            entity.set_position(&SetPosition::new(position(to), flags), world);
        }
        Action::InterpolateTo {
            position: to,
            keep_heading,
        } => entity.interpolate_to(&position(to), *keep_heading, world),
        Action::SetState { state } => entity.set_state(*state, world),
        Action::SetHeading { heading } => entity.set_heading(*heading, world),
        Action::SetParent { part, offset, .. } => {
            if let Some(parent) = parent {
                let at = Attachment::Part {
                    part: *part as u32,
                    frame: Frame::new(Vec3::from(offset.origin), quat(offset.rotation)),
                };
                entity.set_parent(parent, at, world);
            }
        }
        Action::UnsetParent => entity.unset_parent(world),
        _ => {}
    }
}
