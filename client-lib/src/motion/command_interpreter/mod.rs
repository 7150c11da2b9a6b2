//! The command interpreter: from keys and mouse to raw motions of the player, and when the server is told.
//!
//! A state machine without I/O. Every entry gets the player, the world and the time that it needs as [`Scene`]; messages for the server are
//! appended to [`CommandInterpreter::outbox`], refusals to show to [`CommandInterpreter::notices`]. Once per frame, after the input,
//! [`CommandInterpreter::use_time`] decides about the position report.
//!
//! Held keys are kept per axis in stacks: the newest key of an axis acts, and when it is released the one below takes over.
//!
//! Source: `spec/08-motion.md`, sections 13 and 14. No oracle exercises this part.

mod jump;
mod keyboard;
mod lists;
mod mouse;
mod outgoing;
mod player;
#[cfg(test)]
mod tests;

pub use lists::{CommandEntry, CommandList};
pub use outgoing::{Outgoing, SequenceStamps};

use super::{Command, MotionError};
use crate::entity::Entity;
use crate::math::{Plane, Position};
use crate::world::World;

/// What an entry of the interpreter works on: the world and the player, taken out of it; `None` before there is a player.
#[derive(Debug)]
pub struct Scene<'a> {
    /// The player.
    pub player: Option<&'a mut Entity>,
    /// The world.
    pub world: &'a mut World,
}

/// Who moves the player.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum AutonomyLevel {
    /// The server: commands are sent one by one.
    None = 0,
    /// The client, which follows positions of the server.
    Follows = 1,
    /// The client.
    Full = 2,
}

impl AutonomyLevel {
    /// The level of a number; `None` above 2.
    pub const fn from_code(code: u32) -> Option<Self> {
        match code {
            0 => Some(Self::None),
            1 => Some(Self::Follows),
            2 => Some(Self::Full),
            _ => None,
        }
    }
}

/// Choices of the player.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct InputOptions {
    /// The mouse turns the player.
    pub mouse_turning: bool,
    /// Without the run key the player runs.
    pub run_by_default: bool,
    /// Input actions that start an emote.
    pub emotes: Vec<(u32, Command)>,
}

/// Keys and mouse to raw motions. Retail: `CommandInterpreter`.
#[derive(Debug, Clone)]
pub struct CommandInterpreter {
    /// Held walking keys.
    pub substates: CommandList,
    /// Held turning keys.
    pub turns: CommandList,
    /// Held sidestepping keys.
    pub sidesteps: CommandList,
    /// Who moves the player.
    pub autonomy_level: AutonomyLevel,
    /// The server has moved the player, and no input has taken over yet.
    pub controlled_by_server: bool,
    /// The run key.
    pub hold_run: bool,
    /// The "turns sidestep" key.
    pub hold_sidestep: bool,
    /// A forward state that no key holds (an emote's posture) is active: Ready is not forced.
    pub transient: bool,
    /// Input is processed.
    pub enabled: bool,
    /// Running without a key.
    pub auto_run: bool,
    /// Speed of that.
    pub autorun_speed: f32,
    /// The mouse turns at the moment.
    pub mouse_look: bool,
    /// The left mouse button.
    pub mouse_left_down: bool,
    /// Serial number of the next action.
    pub action_stamp: u32,
    /// Choices.
    pub options: InputOptions,
    /// When the server was last told anything, s.
    pub last_sent_time: f64,
    /// Position of the last report.
    pub last_sent_position: Position,
    /// Contact plane of the last report.
    pub last_sent_plane: Plane,
    /// Since when a jump is being charged, s.
    pub jump_charged_since: Option<f64>,
    /// Messages to send, in order; the host empties the list.
    pub outbox: Vec<Outgoing>,
    /// Refusals to show, in order; the host empties the list.
    pub notices: Vec<MotionError>,
    /// The player's death is being handled.
    losing_focus: bool,
}

impl CommandInterpreter {
    /// An interpreter at time `now`, s. Until the first input the server is in control.
    pub fn new(now: f64) -> Self {
        Self {
            substates: CommandList::default(),
            turns: CommandList::default(),
            sidesteps: CommandList::default(),
            autonomy_level: AutonomyLevel::Full,
            controlled_by_server: true,
            hold_run: false,
            hold_sidestep: false,
            transient: false,
            enabled: true,
            auto_run: false,
            autorun_speed: 1.0,
            mouse_look: false,
            mouse_left_down: false,
            action_stamp: 1,
            options: InputOptions::default(),
            last_sent_time: now,
            last_sent_position: Position::default(),
            last_sent_plane: Plane::ZERO,
            jump_charged_since: None,
            outbox: Vec::new(),
            notices: Vec::new(),
            losing_focus: false,
        }
    }

    /// Whether input is processed: enabled, and there is a player.
    pub fn is_active(&self, scene: &Scene<'_>) -> bool {
        self.enabled && scene.player.is_some()
    }

    /// Whether positions of the server are followed.
    pub fn uses_server_positions(&self) -> bool {
        self.autonomy_level != AutonomyLevel::Full
    }

    /// Changes who moves the player; `false` for a level above 2, which is refused.
    pub fn set_autonomy_level(&mut self, level: u32) -> bool {
        let level = AutonomyLevel::from_code(level);
        self.autonomy_level = level.unwrap_or(self.autonomy_level);
        level.is_some()
    }

    /// On the ground, not moving, not turning; also without a player.
    pub fn is_standing_still(&self, scene: &Scene<'_>) -> bool {
        scene.player.as_ref().is_none_or(|player| {
            player
                .interp()
                .is_none_or(|interp| interp.is_standing_still(&player.mover(scene.world)))
        })
    }

    /// The list that keeps a held command (13.4).
    pub fn list_of(&mut self, command: Command) -> Option<&mut CommandList> {
        if command.is_turn() {
            Some(&mut self.turns)
        } else if command.is_sidestep() {
            Some(&mut self.sidesteps)
        } else if is_walking(command) {
            Some(&mut self.substates)
        } else {
            None
        }
    }

    /// Once per frame, after the input: the position report, and taking over when the server has nothing left to do (13.8).
    pub fn use_time(&mut self, scene: &mut Scene<'_>) {
        if self.should_send_position_event(scene) {
            self.send_position_event(scene);
        }
        let idle = scene
            .player
            .as_ref()
            .is_some_and(|player| !player.motions_pending() && !player.is_moving_to());
        let held = self.auto_run
            || [&self.substates, &self.turns, &self.sidesteps]
                .iter()
                .any(|list| list.head().is_some());
        if idle && self.enabled && self.controlled_by_server && held {
            self.take_control_from_server(scene);
        }
    }
}

/// Whether a command belongs to the list of walking keys.
fn is_walking(command: Command) -> bool {
    command.is_sub_state()
        && command.has(super::TOGGLE)
        && !command.is_turn()
        && !command.is_sidestep()
}
