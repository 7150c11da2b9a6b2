//! The mouse: turning, and what turning keys mean while it turns (`spec/08-motion.md`, 13.7 and 13.8).

use super::keyboard::Press;
use super::{CommandEntry, CommandInterpreter, Scene};
use crate::motion::{Command, HoldKey, MovementFlags, MovementParameters};

/// Which motions end before a remapped one starts, in this order: sidestep right, sidestep left, turn right, turn left.
#[derive(Debug, Clone, Copy, Default)]
struct Stops {
    side_right: bool,
    turn_right: bool,
    turn_left: bool,
}

impl CommandInterpreter {
    /// The mouse starts or ends a motion.
    pub fn handle_mouse_movement_command(
        &mut self,
        command: Command,
        start: bool,
        speed: f32,
        hold_run: bool,
        scene: &mut Scene<'_>,
    ) {
        if !self.is_active(scene) {
            return;
        }
        self.take_control_from_server(scene);
        let entry = CommandEntry {
            command,
            speed,
            hold_run,
            mouse: true,
        };
        if let Some(press) = self.bookkeep(Press { entry, start }, scene) {
            self.move_player(press, scene);
            self.send_movement_event(scene);
        }
    }

    /// The left mouse button: walks while the mouse turns.
    pub fn handle_select_left(&mut self, start: bool, scene: &mut Scene<'_>) {
        self.mouse_left_down = start;
        if self.options.mouse_turning && self.mouse_look {
            let entry = CommandEntry {
                command: Command::WALK_FORWARD,
                speed: 1.0,
                hold_run: true,
                mouse: true,
            };
            self.move_player(Press { entry, start }, scene);
            self.send_movement_event(scene);
        }
    }

    /// Ends turns that the mouse left behind.
    pub fn stop_drift(&mut self, scene: &mut Scene<'_>) {
        let mut params =
            MovementParameters::new(&scene.world.profile).with(MovementFlags::SET_HOLD_KEY, false);
        params.hold_key = HoldKey::None;
        if let Some(player) = scene.player.as_deref_mut() {
            for turn in [Command::TURN_RIGHT, Command::TURN_LEFT] {
                // Nothing is shown if there was no turn.
                let _ = player.stop_motion(turn, &params, scene.world);
            }
        }
    }

    /// What a motion means while the mouse may turn (13.7).
    pub(super) fn remap(&mut self, press: Press, scene: &mut Scene<'_>) -> Press {
        if !press.entry.mouse && !self.mouse_look {
            return press;
        }
        let (stops, start) = if press.entry.mouse {
            self.remap_mouse(press.entry.command)
        } else {
            remap_key(press)
        };
        self.take_control_from_server(scene);
        for (stop, command) in [
            (stops.side_right, Command::SIDE_STEP_RIGHT),
            (stops.turn_right, Command::TURN_RIGHT),
            (stops.turn_left, Command::TURN_LEFT),
        ] {
            if stop {
                self.stop_player(command, &press.entry, scene);
            }
        }
        let Some(command) = start else {
            return press;
        };
        let mut entry = CommandEntry {
            command,
            ..press.entry
        };
        if command.is_sidestep() {
            entry.speed = 1.0;
        }
        Press { entry, start: true }
    }

    fn remap_mouse(&self, command: Command) -> (Stops, Option<Command>) {
        let turn = self.turns.head().map(|entry| entry.command);
        let side = self.sidesteps.head().map(|entry| entry.command);
        let mut stops = Stops::default();
        let start = match (self.mouse_look, command, turn) {
            (false, _, Some(Command::TURN_RIGHT)) => {
                stops.side_right = true;
                Some(Command::TURN_RIGHT)
            }
            (false, _, Some(Command::TURN_LEFT)) => {
                stops.side_right = true;
                Some(Command::TURN_LEFT)
            }
            (true, Command::MOUSE_LOOK, Some(Command::TURN_RIGHT)) => {
                stops.turn_right = true;
                Some(if side == Some(Command::SIDE_STEP_LEFT) {
                    Command::SIDE_STEP_LEFT
                } else {
                    Command::SIDE_STEP_RIGHT
                })
            }
            (true, Command::MOUSE_LOOK, Some(Command::TURN_LEFT)) => {
                if side == Some(Command::SIDE_STEP_RIGHT) {
                    stops.turn_right = true;
                    side
                } else {
                    stops.turn_left = true;
                    Some(Command::SIDE_STEP_LEFT)
                }
            }
            (true, Command::MOUSE_LOOK, None) if self.mouse_left_down => {
                Some(Command::WALK_FORWARD)
            }
            _ => None,
        };
        (stops, start)
    }
}

/// Turning keys sidestep while the mouse turns.
fn remap_key(press: Press) -> (Stops, Option<Command>) {
    let mut stops = Stops::default();
    let start = match (press.entry.command, press.start) {
        (Command::TURN_RIGHT, true) => {
            stops.turn_right = true;
            Some(Command::SIDE_STEP_RIGHT)
        }
        (Command::TURN_LEFT, true) => {
            stops.turn_left = true;
            Some(Command::SIDE_STEP_LEFT)
        }
        (Command::TURN_RIGHT | Command::TURN_LEFT, false) => {
            stops.side_right = press.entry.command == Command::TURN_RIGHT;
            None
        }
        _ => {
            stops.turn_right = true;
            stops.turn_left = true;
            None
        }
    };
    (stops, start)
}
