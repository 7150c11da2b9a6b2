//! What network messages do to an object (`spec/06-physics-object.md`, A4.5, G5, G6).

use crate::entity::{Entity, Timestamps};
use crate::math::{Position, Vec3};
use crate::physics::placement::{PlacementFlags, SetPosition};
use crate::world::World;

/// Distance from the local player up to which a server position is interpolated, m.
const INTERPOLATION_DISTANCE: f32 = 96.0;

/// Which counter of [`Timestamps`] (A4.5).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub enum Stamp {
    /// Position.
    Position = 0,
    /// Movement.
    Movement = 1,
    /// State word.
    State = 2,
    /// Velocity.
    Vector = 3,
    /// Teleport.
    Teleport = 4,
    /// Server-controlled move.
    ServerControl = 5,
    /// Forced position.
    ForcePosition = 6,
    /// Object description.
    Description = 7,
    /// Instance.
    Instance = 8,
}

/// Whether counter `b` is newer than the stored `a`; equal is not newer (A4.5).
pub const fn is_newer(a: u16, b: u16) -> bool {
    if a.abs_diff(b) > 32767 { b < a } else { a < b }
}

impl Timestamps {
    /// Stores a counter if it is newer (`newer_event`).
    pub const fn newer_event(&mut self, stamp: Stamp, value: u16) -> bool {
        let newer = is_newer(self.0[stamp as usize], value);
        if newer {
            self.0[stamp as usize] = value;
        }
        newer
    }
}

/// A physics description, as far as it acts on the object (A4.4); `None` fields are absent from the message and keep the defaults.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PhysicsDescription {
    /// State word.
    pub state: u32,
    /// Motion table, 0x09......
    pub motion_table: Option<u32>,
    /// The last move came from the object's own input; present with a movement buffer.
    pub autonomous: Option<bool>,
    /// Placement frame, without a movement buffer.
    pub placement: Option<u32>,
    /// Object scale.
    pub scale: Option<f32>,
    /// Friction, 0..1.
    pub friction: Option<f32>,
    /// Elasticity.
    pub elasticity: Option<f32>,
    /// Translucency, 0 opaque to 1 invisible.
    pub translucency: Option<f32>,
    /// m/s, world axes.
    pub velocity: Option<Vec3>,
    /// Default script.
    pub default_script: Option<u32>,
    /// Its intensity.
    pub default_script_intensity: Option<f32>,
    /// All counters.
    pub timestamps: Timestamps,
}

/// What is to be done with a movement event (`SetObjectMovement`, G6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MovementVerdict {
    /// Old, or the echo of the own input: dropped.
    Drop,
    /// Unpack the buffer (`spec/08-motion.md`, 15).
    Unpack,
}

impl Entity {
    /// Applies a physics description (`set_description`, G5); `false`, and nothing else applied, without parts for its motion table.
    ///
    /// The caller unpacks a movement buffer afterwards, and places or attaches the object. Acceleration is derived and omega is not applied.
    pub fn set_description(&mut self, desc: &PhysicsDescription, world: &mut World) -> bool {
        if let Some(table) = desc.motion_table
            && !self.set_motion_table(table, world)
        {
            return false;
        }
        match (desc.autonomous, desc.placement) {
            (Some(autonomous), _) => self.kin.last_move_was_autonomous = autonomous,
            (None, placement) => {
                self.set_placement_frame(placement.unwrap_or(0) as i32, world);
            }
        }
        self.set_state(desc.state, world);
        self.set_scale_static(desc.scale.unwrap_or(1.0));
        let friction = desc.friction.unwrap_or(0.95);
        if (0.0..=1.0).contains(&friction) {
            self.kin.friction = friction;
        }
        self.kin
            .set_elasticity(desc.elasticity.unwrap_or(0.05), &world.profile);
        self.translucency_original = desc.translucency.unwrap_or(0.0);
        if self.translucency_original != 0.0 {
            self.set_translucency(self.translucency_original);
        }
        self.set_velocity(desc.velocity.unwrap_or(Vec3::ZERO), world);
        self.default_script = desc.default_script.unwrap_or(0);
        self.default_script_intensity = desc.default_script_intensity.unwrap_or(0.0);
        self.timestamps = desc.timestamps;
        true
    }

    /// A server position (`MoveOrTeleport`, G6): teleports, interpolates, or is left to the caller (`false`).
    pub fn move_or_teleport(
        &mut self,
        position: &Position,
        teleport_stamp: u16,
        contact: bool,
        world: &mut World,
    ) -> bool {
        if is_newer(teleport_stamp, self.timestamps.0[Stamp::Teleport as usize]) {
            return false;
        }
        let teleports = self.timestamps.newer_event(Stamp::Teleport, teleport_stamp);
        if self.body.cell.is_none() || teleports {
            self.teleport_hook(world);
            let flags = PlacementFlags::TELEPORT | PlacementFlags::DONT_CREATE_CELLS;
            self.set_position(&SetPosition::new(*position, flags), world);
            return true;
        }
        if !contact {
            return false;
        }
        if self.player_distance < INTERPOLATION_DISTANCE {
            let keep_heading = self.is_moving_to();
            self.interpolate_to(position, keep_heading, world);
        } else {
            self.stop_interpolating();
            self.set_position_simple(position, true, world);
        }
        true
    }

    /// Whether a movement event is to be carried out (`SetObjectMovement`, G6).
    pub fn accept_movement(
        &mut self,
        movement_stamp: u16,
        server_control_stamp: u16,
        autonomous: bool,
        world: &World,
    ) -> MovementVerdict {
        if !self.timestamps.newer_event(Stamp::Movement, movement_stamp) {
            return MovementVerdict::Drop;
        }
        let control = Stamp::ServerControl as usize;
        if is_newer(server_control_stamp, self.timestamps.0[control]) {
            return MovementVerdict::Drop;
        }
        self.timestamps.0[control] = server_control_stamp;
        if autonomous && world.local_player == Some(self.id) {
            return MovementVerdict::Drop;
        }
        self.kin.last_move_was_autonomous = autonomous;
        MovementVerdict::Unpack
    }
}
