//! What the server is told, and when (`spec/08-motion.md`, section 14).

use super::{AutonomyLevel, CommandInterpreter, Scene};
use crate::entity::Entity;
use crate::math::{EPSILON, Frame, Plane, Position, Vec3};
use crate::motion::constants::POSITION_EVENT_INTERVAL;
use crate::motion::wire::{pad, put_f32, put_u16, put_u32};
use crate::motion::{Command, HoldKey, MovementParameters, RawMotionState};

/// The four counters that travel with positions of the player.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SequenceStamps {
    /// Instance.
    pub instance: u16,
    /// Server control.
    pub server_control: u16,
    /// Teleport.
    pub teleport: u16,
    /// Force position.
    pub force_position: u16,
}

impl SequenceStamps {
    /// Those of an object.
    pub fn of(player: &Entity) -> Self {
        let stamps = &player.timestamps.0;
        Self {
            instance: stamps[8],
            server_control: stamps[5],
            teleport: stamps[4],
            force_position: stamps[6],
        }
    }
}

/// A message to the server.
#[derive(Debug, Clone, PartialEq)]
pub enum Outgoing {
    /// The raw motion state and where the player is (0xF61C).
    MoveToState {
        /// What the input wants.
        state: RawMotionState,
        /// Where.
        position: Position,
        /// Counters.
        stamps: SequenceStamps,
        /// Stands on walkable ground.
        contact: bool,
        /// Charges a jump from a standstill.
        standing_longjump: bool,
    },
    /// Where the player is (0xF753); only sent from walkable ground.
    AutonomousPosition {
        /// Where.
        position: Position,
        /// Counters.
        stamps: SequenceStamps,
    },
    /// The player has jumped (0xF61B).
    Jump {
        /// 0..=1.
        extent: f32,
        /// Launch velocity in the player's own axes, m/s.
        velocity: Vec3,
        /// Where.
        position: Position,
        /// Counters.
        stamps: SequenceStamps,
    },
    /// A command for a player that the server moves (0xF61E).
    DoMovementCommand {
        /// Command.
        command: Command,
        /// Factor of the animation's rate.
        speed: f32,
        /// Walk or run.
        hold_key: HoldKey,
    },
    /// Its end (0xF661).
    StopMovementCommand {
        /// Command.
        command: Command,
        /// Walk or run.
        hold_key: HoldKey,
    },
    /// A jump of a player that the server moves (0xF7C9).
    JumpNonAutonomous {
        /// 0..=1.
        extent: f32,
    },
    /// Who is to move the player from now on (0xF752).
    AutonomyLevel(AutonomyLevel),
    /// A turn to a heading (0xF649). Nothing here sends it: its body is not documented, that of a server's turn is written.
    TurnTo(MovementParameters),
}

impl Outgoing {
    /// Message type.
    pub const fn opcode(&self) -> u32 {
        match self {
            Self::MoveToState { .. } => 0xF61C,
            Self::AutonomousPosition { .. } => 0xF753,
            Self::Jump { .. } => 0xF61B,
            Self::DoMovementCommand { .. } => 0xF61E,
            Self::StopMovementCommand { .. } => 0xF661,
            Self::JumpNonAutonomous { .. } => 0xF7C9,
            Self::AutonomyLevel(_) => 0xF752,
            Self::TurnTo(_) => 0xF649,
        }
    }

    /// Appends the body, after the message type, padded from the start of `message`.
    pub fn pack(&self, message: &mut Vec<u8>) {
        match self {
            Self::MoveToState {
                state,
                position,
                stamps,
                contact,
                standing_longjump,
            } => {
                state.pack(message);
                pack_position(position, message);
                pack_stamps(stamps, message);
                message.push(u8::from(*contact) | u8::from(*standing_longjump) << 1);
                pad(message);
            }
            Self::AutonomousPosition { position, stamps } => {
                pack_position(position, message);
                pack_stamps(stamps, message);
                message.push(1);
                pad(message);
            }
            Self::Jump {
                extent,
                velocity,
                position,
                stamps,
            } => {
                put_f32(message, *extent);
                for component in velocity.to_array() {
                    put_f32(message, component);
                }
                pack_position(position, message);
                pack_stamps(stamps, message);
                pad(message);
            }
            Self::DoMovementCommand {
                command,
                speed,
                hold_key,
            } => {
                put_u32(message, command.0);
                put_f32(message, *speed);
                put_u32(message, hold_key.code());
            }
            Self::StopMovementCommand { command, hold_key } => {
                put_u32(message, command.0);
                put_u32(message, hold_key.code());
            }
            Self::JumpNonAutonomous { extent } => put_f32(message, *extent),
            Self::AutonomyLevel(level) => put_u32(message, *level as u32),
            Self::TurnTo(params) => params.pack_turn(message),
        }
    }
}

fn pack_position(position: &Position, message: &mut Vec<u8>) {
    put_u32(message, position.cell.0);
    let (origin, q) = (position.frame.origin, position.frame.rotation());
    for number in [origin.x, origin.y, origin.z, q.w, q.x, q.y, q.z] {
        put_f32(message, number);
    }
}

fn pack_stamps(stamps: &SequenceStamps, message: &mut Vec<u8>) {
    for stamp in [
        stamps.instance,
        stamps.server_control,
        stamps.teleport,
        stamps.force_position,
    ] {
        put_u16(message, stamp);
    }
}

impl CommandInterpreter {
    /// Sends the raw motion state; it is not compared with the last one (14.1). The position of the last report stays.
    pub(super) fn send_movement_event(&mut self, scene: &mut Scene<'_>) {
        let Some(player) = scene.player.as_deref() else {
            return;
        };
        let Some(interp) = player.interp() else {
            return;
        };
        if self.autonomy_level == AutonomyLevel::None {
            return;
        }
        self.outbox.push(Outgoing::MoveToState {
            state: interp.raw.clone(),
            position: player.body.position,
            stamps: SequenceStamps::of(player),
            contact: player.kin.on_ground(),
            standing_longjump: interp.standing_longjump,
        });
        self.last_sent_time = scene.world.clock.now;
    }

    /// Whether the position is to be reported now (14.2): when it has changed and a second has passed, or at once in another cell or on
    /// another contact plane.
    pub fn should_send_position_event(&self, scene: &Scene<'_>) -> bool {
        let Some(player) = scene.player.as_deref().filter(|_| self.is_active(scene)) else {
            return false;
        };
        if self.autonomy_level != AutonomyLevel::Full {
            return false;
        }
        let (here, last) = (&player.body.position, &self.last_sent_position);
        let moved = here.cell != last.cell;
        if self.last_sent_time + POSITION_EVENT_INTERVAL < scene.world.clock.now {
            moved || !frames_equal(&here.frame, &last.frame)
        } else {
            moved || !planes_equal(&player.kin.contact_plane, &self.last_sent_plane)
        }
    }

    /// Reports the position from walkable ground; in the air nothing is sent and nothing is noted, so the test is true again next frame.
    pub(super) fn send_position_event(&mut self, scene: &mut Scene<'_>) {
        let Some(player) = scene.player.as_deref() else {
            return;
        };
        let position = player.body.position;
        let valid =
            position.cell.is_inbound_valid() && position.frame.is_valid(&scene.world.profile);
        if !player.kin.on_ground() || !valid {
            return;
        }
        self.outbox.push(Outgoing::AutonomousPosition {
            position,
            stamps: SequenceStamps::of(player),
        });
        self.last_sent_time = scene.world.clock.now;
        self.last_sent_position = position;
        self.last_sent_plane = player.kin.contact_plane;
    }
}

fn all_near<const N: usize>(a: [f32; N], b: [f32; N]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < EPSILON)
}

fn frames_equal(a: &Frame, b: &Frame) -> bool {
    let (p, q) = (a.rotation(), b.rotation());
    all_near(a.origin.to_array(), b.origin.to_array())
        && all_near([p.w, p.x, p.y, p.z], [q.w, q.x, q.y, q.z])
}

fn planes_equal(a: &Plane, b: &Plane) -> bool {
    all_near([a.n.x, a.n.y, a.n.z, a.d], [b.n.x, b.n.y, b.n.z, b.d])
}
