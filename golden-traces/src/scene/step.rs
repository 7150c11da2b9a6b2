//! Script steps (`spec/scene-format.md`, "Script steps").

use serde::{Deserialize, Serialize};

use super::{EntitySpec, OffsetSpec, PositionSpec};
use crate::number;

/// One input: what is done to which entity in which frame, after the clock advanced and before the frame's update.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Raw", into = "Raw")]
pub struct ScriptStep {
    /// 0-based frame.
    pub frame: u32,
    /// The entity; for [`Action::Create`] that of the new one.
    pub guid: u32,
    /// What is done.
    pub action: Action,
}

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Last move autonomous, then movement type 1 with default parameters.
    DoMotion {
        /// Motion command.
        command: u32,
        /// Speed.
        speed: f32,
        /// Hold key.
        hold_key: HoldKey,
    },
    /// Movement type 2.
    DoInterpretedMotion {
        /// Motion command.
        command: u32,
        /// Speed.
        speed: f32,
    },
    /// Last move autonomous, then movement type 3.
    StopMotion {
        /// Motion command.
        command: u32,
        /// Speed.
        speed: f32,
        /// Hold key.
        hold_key: HoldKey,
    },
    /// Movement type 4.
    StopInterpretedMotion {
        /// Motion command.
        command: u32,
        /// Speed.
        speed: f32,
    },
    /// Movement type 5.
    StopCompletely,
    /// Last move autonomous, then the interpreter's jump.
    Jump {
        /// 0 to 1.
        extent: f32,
    },
    /// Movement type 7.
    MoveToPosition {
        /// Where to.
        position: PositionSpec,
        /// How.
        params: MoveParams,
    },
    /// Movement type 6.
    MoveToObject {
        /// GUID of the object.
        target: u32,
        /// How.
        params: MoveParams,
    },
    /// Movement type 9.
    TurnToHeading {
        /// Compass degrees; goes into `desired_heading`.
        heading: f32,
        /// How.
        params: MoveParams,
    },
    /// Movement type 8.
    TurnToObject {
        /// GUID of the object.
        target: u32,
        /// How.
        params: MoveParams,
    },
    /// Position manager: stick to an object.
    StickTo {
        /// GUID of the object.
        target: u32,
        /// Its radius, metres.
        radius: f32,
        /// Its height, metres.
        height: f32,
    },
    /// Constraint manager.
    ConstrainTo {
        /// Centre.
        position: PositionSpec,
        /// Distance at which the constraint begins, metres.
        start: f32,
        /// Distance that is never exceeded, metres.
        max: f32,
    },
    /// Sets the world-space velocity.
    SetVelocity {
        /// m/s.
        velocity: [f32; 3],
    },
    /// Teleport or placement.
    SetPosition {
        /// Where to.
        position: PositionSpec,
        /// Set-position flags.
        flags: u32,
    },
    /// Interpolation manager: a position update of the server.
    InterpolateTo {
        /// Where to.
        position: PositionSpec,
        /// Keep the heading on the way.
        keep_heading: bool,
    },
    /// Sets the physics state word.
    SetState {
        /// The word.
        state: u32,
    },
    /// Sets the heading.
    SetHeading {
        /// Compass degrees.
        heading: f32,
    },
    /// Creates an entity as at the start.
    Create {
        /// The entity.
        entity: EntitySpec,
    },
    /// Removes the entity.
    Destroy,
    /// Attaches it to a parent.
    SetParent {
        /// GUID of the parent.
        parent: u32,
        /// Part of the parent; -1: none.
        part: i32,
        /// Offset from it.
        offset: OffsetSpec,
    },
    /// Detaches it.
    UnsetParent,
}

/// Hold key of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HoldKey {
    /// None (1).
    #[default]
    None,
    /// Run (2).
    Run,
}

/// Movement parameters; what is absent has the default of `spec/08-motion.md`, section 5.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MoveParams {
    /// Flag word.
    #[serde(
        with = "number::opt_hex",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub bitfield: Option<u32>,
    /// Metres.
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub distance_to_object: Option<f32>,
    /// Metres.
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub min_distance: Option<f32>,
    /// Compass degrees.
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub desired_heading: Option<f32>,
    /// Speed.
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub speed: Option<f32>,
    /// Metres.
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub fail_distance: Option<f32>,
    /// Metres.
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub walk_run_threshold: Option<f32>,
    /// Hold key; absent: invalid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold_key: Option<HoldKey>,
}

/// A step as it is in the file: every argument that any step has.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    frame: u32,
    #[serde(with = "number::hex")]
    guid: u32,
    #[serde(rename = "do")]
    action: String,
    #[serde(
        with = "number::opt_hex",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    command: Option<u32>,
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    speed: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hold_key: Option<HoldKey>,
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    extent: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    position: Option<PositionSpec>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    params: Option<MoveParams>,
    #[serde(
        with = "number::opt_hex",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    target: Option<u32>,
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    heading: Option<f32>,
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    radius: Option<f32>,
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    height: Option<f32>,
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    start: Option<f32>,
    #[serde(
        with = "number::opt_f32",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    max: Option<f32>,
    #[serde(
        with = "number::opt_vec3",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    velocity: Option<[f32; 3]>,
    #[serde(
        with = "number::opt_hex",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    flags: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    keep_heading: Option<bool>,
    #[serde(
        with = "number::opt_hex",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    state: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    entity: Option<EntitySpec>,
    #[serde(
        with = "number::opt_hex",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    parent: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    part: Option<i32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    offset: Option<OffsetSpec>,
}

impl TryFrom<Raw> for ScriptStep {
    type Error = String;

    fn try_from(mut raw: Raw) -> Result<Self, String> {
        let name = std::mem::take(&mut raw.action);
        let action = raw.take_action(&name)?;
        match raw.leftover() {
            Some(field) => Err(format!("`{name}` takes no `{field}`")),
            None => Ok(Self {
                frame: raw.frame,
                guid: raw.guid,
                action,
            }),
        }
    }
}

/// A required argument.
fn need<T>(slot: &mut Option<T>, action: &str, field: &str) -> Result<T, String> {
    slot.take()
        .ok_or_else(|| format!("`{action}` needs `{field}`"))
}

impl Raw {
    /// Takes the arguments of the action out of the record.
    fn take_action(&mut self, name: &str) -> Result<Action, String> {
        let speed = |raw: &mut Self| raw.speed.take().unwrap_or(1.0);
        Ok(match name {
            "do_motion" => Action::DoMotion {
                command: need(&mut self.command, name, "command")?,
                speed: speed(self),
                hold_key: self.hold_key.take().unwrap_or_default(),
            },
            "do_interpreted_motion" => Action::DoInterpretedMotion {
                command: need(&mut self.command, name, "command")?,
                speed: speed(self),
            },
            "stop_motion" => Action::StopMotion {
                command: need(&mut self.command, name, "command")?,
                speed: speed(self),
                hold_key: self.hold_key.take().unwrap_or_default(),
            },
            "stop_interpreted_motion" => Action::StopInterpretedMotion {
                command: need(&mut self.command, name, "command")?,
                speed: speed(self),
            },
            "stop_completely" => Action::StopCompletely,
            "jump" => Action::Jump {
                extent: need(&mut self.extent, name, "extent")?,
            },
            "set_velocity" => Action::SetVelocity {
                velocity: need(&mut self.velocity, name, "velocity")?,
            },
            "set_state" => Action::SetState {
                state: need(&mut self.state, name, "state")?,
            },
            "set_heading" => Action::SetHeading {
                heading: need(&mut self.heading, name, "heading")?,
            },
            "create" => Action::Create {
                entity: need(&mut self.entity, name, "entity")?,
            },
            "destroy" => Action::Destroy,
            "unset_parent" => Action::UnsetParent,
            _ => return self.take_placed_action(name),
        })
    }

    /// The actions with a place or an object to go to.
    fn take_placed_action(&mut self, name: &str) -> Result<Action, String> {
        let params = |raw: &mut Self| raw.params.take().unwrap_or_default();
        Ok(match name {
            "move_to_position" => Action::MoveToPosition {
                position: need(&mut self.position, name, "position")?,
                params: params(self),
            },
            "move_to_object" => Action::MoveToObject {
                target: need(&mut self.target, name, "target")?,
                params: params(self),
            },
            "turn_to_heading" => Action::TurnToHeading {
                heading: need(&mut self.heading, name, "heading")?,
                params: params(self),
            },
            "turn_to_object" => Action::TurnToObject {
                target: need(&mut self.target, name, "target")?,
                params: params(self),
            },
            "stick_to" => Action::StickTo {
                target: need(&mut self.target, name, "target")?,
                radius: need(&mut self.radius, name, "radius")?,
                height: need(&mut self.height, name, "height")?,
            },
            "constrain_to" => Action::ConstrainTo {
                position: need(&mut self.position, name, "position")?,
                start: need(&mut self.start, name, "start")?,
                max: need(&mut self.max, name, "max")?,
            },
            "set_position" => Action::SetPosition {
                position: need(&mut self.position, name, "position")?,
                flags: need(&mut self.flags, name, "flags")?,
            },
            "interpolate_to" => Action::InterpolateTo {
                position: need(&mut self.position, name, "position")?,
                keep_heading: self.keep_heading.take().unwrap_or(false),
            },
            "set_parent" => Action::SetParent {
                parent: need(&mut self.parent, name, "parent")?,
                part: self.part.take().unwrap_or(-1),
                offset: need(&mut self.offset, name, "offset")?,
            },
            _ => return Err(format!("no step is called `{name}`")),
        })
    }

    /// The first argument that nobody took.
    fn leftover(&self) -> Option<&'static str> {
        let present = [
            ("command", self.command.is_some()),
            ("speed", self.speed.is_some()),
            ("hold_key", self.hold_key.is_some()),
            ("extent", self.extent.is_some()),
            ("position", self.position.is_some()),
            ("params", self.params.is_some()),
            ("target", self.target.is_some()),
            ("heading", self.heading.is_some()),
            ("radius", self.radius.is_some()),
            ("height", self.height.is_some()),
            ("start", self.start.is_some()),
            ("max", self.max.is_some()),
            ("velocity", self.velocity.is_some()),
            ("flags", self.flags.is_some()),
            ("keep_heading", self.keep_heading.is_some()),
            ("state", self.state.is_some()),
            ("entity", self.entity.is_some()),
            ("parent", self.parent.is_some()),
            ("part", self.part.is_some()),
            ("offset", self.offset.is_some()),
        ];
        present
            .into_iter()
            .find(|(_, present)| *present)
            .map(|(name, _)| name)
    }
}

impl From<ScriptStep> for Raw {
    fn from(step: ScriptStep) -> Self {
        let raw = Self {
            frame: step.frame,
            guid: step.guid,
            action: step.action.name().into(),
            ..Self::default()
        };
        match step.action {
            Action::DoMotion {
                command,
                speed,
                hold_key,
            }
            | Action::StopMotion {
                command,
                speed,
                hold_key,
            } => Self {
                command: Some(command),
                speed: Some(speed),
                hold_key: Some(hold_key),
                ..raw
            },
            Action::DoInterpretedMotion { command, speed }
            | Action::StopInterpretedMotion { command, speed } => Self {
                command: Some(command),
                speed: Some(speed),
                ..raw
            },
            Action::StopCompletely | Action::Destroy | Action::UnsetParent => raw,
            Action::Jump { extent } => Self {
                extent: Some(extent),
                ..raw
            },
            Action::MoveToPosition { position, params } => Self {
                position: Some(position),
                params: Some(params),
                ..raw
            },
            Action::MoveToObject { target, params } | Action::TurnToObject { target, params } => {
                Self {
                    target: Some(target),
                    params: Some(params),
                    ..raw
                }
            }
            Action::TurnToHeading { heading, params } => Self {
                heading: Some(heading),
                params: Some(params),
                ..raw
            },
            Action::StickTo {
                target,
                radius,
                height,
            } => Self {
                target: Some(target),
                radius: Some(radius),
                height: Some(height),
                ..raw
            },
            Action::ConstrainTo {
                position,
                start,
                max,
            } => Self {
                position: Some(position),
                start: Some(start),
                max: Some(max),
                ..raw
            },
            Action::SetVelocity { velocity } => Self {
                velocity: Some(velocity),
                ..raw
            },
            Action::SetPosition { position, flags } => Self {
                position: Some(position),
                flags: Some(flags),
                ..raw
            },
            Action::InterpolateTo {
                position,
                keep_heading,
            } => Self {
                position: Some(position),
                keep_heading: Some(keep_heading),
                ..raw
            },
            Action::SetState { state } => Self {
                state: Some(state),
                ..raw
            },
            Action::SetHeading { heading } => Self {
                heading: Some(heading),
                ..raw
            },
            Action::Create { entity } => Self {
                entity: Some(entity),
                ..raw
            },
            Action::SetParent {
                parent,
                part,
                offset,
            } => Self {
                parent: Some(parent),
                part: Some(part),
                offset: Some(offset),
                ..raw
            },
        }
    }
}

impl Action {
    /// The name in the file.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::DoMotion { .. } => "do_motion",
            Self::DoInterpretedMotion { .. } => "do_interpreted_motion",
            Self::StopMotion { .. } => "stop_motion",
            Self::StopInterpretedMotion { .. } => "stop_interpreted_motion",
            Self::StopCompletely => "stop_completely",
            Self::Jump { .. } => "jump",
            Self::MoveToPosition { .. } => "move_to_position",
            Self::MoveToObject { .. } => "move_to_object",
            Self::TurnToHeading { .. } => "turn_to_heading",
            Self::TurnToObject { .. } => "turn_to_object",
            Self::StickTo { .. } => "stick_to",
            Self::ConstrainTo { .. } => "constrain_to",
            Self::SetVelocity { .. } => "set_velocity",
            Self::SetPosition { .. } => "set_position",
            Self::InterpolateTo { .. } => "interpolate_to",
            Self::SetState { .. } => "set_state",
            Self::SetHeading { .. } => "set_heading",
            Self::Create { .. } => "create",
            Self::Destroy => "destroy",
            Self::SetParent { .. } => "set_parent",
            Self::UnsetParent => "unset_parent",
        }
    }
}
