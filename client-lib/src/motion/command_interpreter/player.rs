//! Moving the player, and who is in control (`spec/08-motion.md`, 13.6 and 13.8).

use super::keyboard::Press;
use super::{AutonomyLevel, CommandEntry, CommandInterpreter, Outgoing, Scene};
use crate::motion::{Command, HoldKey, MotionError, MovementFlags, MovementParameters};

impl CommandInterpreter {
    /// Starts or ends a motion of the player (13.6).
    pub(super) fn move_player(&mut self, press: Press, scene: &mut Scene<'_>) {
        let state = scene.player.as_deref().and_then(|p| p.interp());
        let Some(forward) = state.map(|interp| interp.interpreted.forward_command) else {
            return;
        };
        if forward == Command::DEAD {
            self.handle_death(scene);
            return;
        }
        let press = if self.options.mouse_turning {
            self.remap(press, scene)
        } else {
            press
        };
        let entry = press.entry;
        if self.autonomy_level == AutonomyLevel::None {
            self.send_command(&press);
        } else if entry.command == Command::JUMP {
            // The jump key acts through its own input action.
        } else if press.start {
            self.start_player(&entry, scene);
        } else {
            self.stop_player(entry.command, &entry, scene);
        }
    }

    /// Death takes the keyboard away. Losing the focus re-applies the movement, which comes here again: once is enough.
    fn handle_death(&mut self, scene: &mut Scene<'_>) {
        if self.losing_focus {
            return;
        }
        self.losing_focus = true;
        self.lose_keyboard_focus(scene);
        self.set_auto_run(false, false, scene);
        self.losing_focus = false;
    }

    fn send_command(&mut self, press: &Press) {
        let CommandEntry { command, speed, .. } = press.entry;
        let hold_key = hold_key_of(&press.entry);
        if command == Command::JUMP {
            return;
        }
        self.outbox.push(if press.start {
            Outgoing::DoMovementCommand {
                command,
                speed,
                hold_key,
            }
        } else {
            Outgoing::StopMovementCommand { command, hold_key }
        });
    }

    fn start_player(&mut self, entry: &CommandEntry, scene: &mut Scene<'_>) {
        if entry.command.is_action() {
            self.stop_completely(scene);
        }
        let mut params = entry.params(scene).with(MovementFlags::AUTONOMOUS, true);
        params.action_stamp = self.action_stamp;
        params.speed = entry.speed;
        let Some(player) = scene.player.as_deref_mut() else {
            return;
        };
        match player.do_motion(entry.command, &params, scene.world) {
            Ok(()) if entry.command.is_action() => {
                self.action_stamp = self.action_stamp.wrapping_add(1);
            }
            Ok(()) => {}
            Err(error) if is_shown(error) => self.notices.push(error),
            Err(_) => {}
        }
    }

    /// Ends a motion of the player, with the hold key of `entry`. A motion that is not running is no error.
    pub(super) fn stop_player(
        &mut self,
        command: Command,
        entry: &CommandEntry,
        scene: &mut Scene<'_>,
    ) {
        let params = entry.params(scene);
        if let Some(player) = scene.player.as_deref_mut() {
            let _ = player.stop_motion(command, &params, scene.world);
        }
    }

    /// Moves the player as the held commands say.
    pub fn apply_current_movement(&mut self, scene: &mut Scene<'_>) {
        if scene.player.is_none() {
            return;
        }
        let key = |command, speed| CommandEntry {
            command,
            speed,
            hold_run: false,
            mouse: false,
        };
        if self.auto_run {
            let entry = CommandEntry {
                hold_run: true,
                mouse: true,
                ..key(Command::WALK_FORWARD, self.autorun_speed)
            };
            self.move_player(Press { entry, start: true }, scene);
        } else if let Some(head) = self.substates.head().copied() {
            self.apply_head(head, scene);
        } else if !self.transient {
            let entry = key(Command::READY, 1.0);
            self.move_player(Press { entry, start: true }, scene);
        }
        let stops = [Command::SIDE_STEP_RIGHT, Command::TURN_RIGHT];
        self.apply_or_stop(self.turns.head().copied(), &stops, scene);
        self.apply_or_stop(self.sidesteps.head().copied(), &stops[..1], scene);
    }

    fn apply_or_stop(
        &mut self,
        head: Option<CommandEntry>,
        stops: &[Command],
        scene: &mut Scene<'_>,
    ) {
        if let Some(head) = head {
            self.apply_head(head, scene);
            return;
        }
        for &command in stops {
            let entry = CommandEntry {
                command,
                speed: 1.0,
                hold_run: false,
                mouse: false,
            };
            let press = Press {
                entry,
                start: false,
            };
            self.move_player(press, scene);
        }
    }

    fn apply_head(&mut self, mut entry: CommandEntry, scene: &mut Scene<'_>) {
        if !entry.mouse {
            entry.command = self.mapped(entry.command);
        }
        self.move_player(Press { entry, start: true }, scene);
    }

    /// The player's input takes over from the server.
    pub fn take_control_from_server(&mut self, scene: &mut Scene<'_>) {
        if !self.controlled_by_server || self.autonomy_level == AutonomyLevel::None {
            return;
        }
        let Some(player) = scene.player.as_deref_mut() else {
            return;
        };
        let forward = player.interp().map(|i| i.interpreted.forward_command);
        if forward == Some(Command::DEAD) {
            return;
        }
        self.controlled_by_server = false;
        player.kin.last_move_was_autonomous = true;
        player.stop_completely(scene.world);
        player.stop_interpolating();
        self.set_hold_run(self.hold_run, scene);
        self.apply_current_movement(scene);
    }

    /// The server has moved the player.
    pub fn lose_control_to_server(&mut self, scene: &mut Scene<'_>) {
        if self.autonomy_level != AutonomyLevel::None {
            self.controlled_by_server = true;
            self.set_auto_run(false, false, scene);
            self.finish_jump(scene);
        }
    }

    /// There is a player now; unless its movement is its own, the server is in control.
    pub fn new_player(&mut self, autonomous: bool, scene: &mut Scene<'_>) {
        if autonomous {
            self.apply_current_movement(scene);
        } else {
            self.lose_control_to_server(scene);
        }
    }
}

impl CommandEntry {
    /// Parameters of a start or an end of this command: a key leaves the hold key alone, the mouse brings its own.
    fn params(&self, scene: &Scene<'_>) -> MovementParameters {
        let mut params = MovementParameters::new(&scene.world.profile)
            .with(MovementFlags::SET_HOLD_KEY, !self.mouse);
        params.hold_key = hold_key_of(self);
        params
    }
}

fn hold_key_of(entry: &CommandEntry) -> HoldKey {
    if entry.mouse {
        HoldKey::running(entry.hold_run)
    } else {
        HoldKey::Invalid
    }
}

/// Whether a refusal has a text.
fn is_shown(error: MotionError) -> bool {
    matches!(
        error,
        MotionError::StaminaTooLow
            | MotionError::CantCrouchInCombat
            | MotionError::CantSitInCombat
            | MotionError::CantLieDownInCombat
            | MotionError::CantChatEmoteInCombat
            | MotionError::CantChatEmoteNotStanding
    )
}
