//! Keys: input actions, held commands, run and sidestep modifiers, autorun (`spec/08-motion.md`, 13.2 to 13.5 and 13.8).

use super::{AutonomyLevel, CommandEntry, CommandInterpreter, Scene, is_walking};
use crate::motion::{Command, MovementFlags, MovementParameters, UI};

/// A command as it leaves the bookkeeping: what is to be done, which is not always what the key said.
#[derive(Debug, Clone, Copy)]
pub(super) struct Press {
    pub entry: CommandEntry,
    pub start: bool,
}

impl CommandInterpreter {
    /// An input action of the key map (13.2); `false` if it is not handled here.
    pub fn handle_action(&mut self, action: u32, press: bool, scene: &mut Scene<'_>) -> bool {
        if !self.is_active(scene) {
            return true;
        }
        let command = match action {
            0x29 => Command::WALK_FORWARD,
            0x2A => Command::WALK_BACKWARDS,
            0x2C => Command::SIDE_STEP_RIGHT,
            0x2D => Command::SIDE_STEP_LEFT,
            0x2E => Command::TURN_RIGHT,
            0x2F => Command::TURN_LEFT,
            _ => return self.handle_other_action(action, press, scene),
        };
        self.handle_keyboard_command(command, press, 1.0, scene);
        true
    }

    fn handle_other_action(&mut self, action: u32, press: bool, scene: &mut Scene<'_>) -> bool {
        match action {
            0x2B => self.handle_keyboard_command(Command::READY, true, 1.0, scene),
            0x30 => self.handle_keyboard_command(Command::AUTO_RUN, press, 1.0, scene),
            0x31 if press => self.commence_jump(scene),
            0x31 => self.do_jump(scene),
            0x32 => self.set_hold_run(press, scene),
            _ => {
                let mut emotes = self.options.emotes.iter();
                let Some(&(_, emote)) = emotes.find(|(known, _)| *known == action) else {
                    return false;
                };
                self.handle_keyboard_command(emote, true, 1.0, scene);
            }
        }
        true
    }

    /// A key of a command is pressed or released (13.3).
    pub fn handle_keyboard_command(
        &mut self,
        command: Command,
        start: bool,
        speed: f32,
        scene: &mut Scene<'_>,
    ) {
        if !self.is_active(scene) {
            return;
        }
        if command == Command::AUTO_RUN {
            self.autorun_speed = speed;
            self.set_auto_run(!self.auto_run, true, scene);
            self.send_movement_event(scene);
            return;
        }
        if command.has(UI) {
            return;
        }
        if self.controlled_by_server && !start {
            if let Some(list) = self.list_of(command) {
                list.remove(command, false);
            }
            return;
        }
        self.take_control_from_server(scene);
        let modifier = match command {
            Command::HOLD_RUN => {
                self.set_hold_run(start, scene);
                true
            }
            Command::HOLD_SIDESTEP => {
                self.set_hold_sidestep(start, scene);
                true
            }
            _ => false,
        };
        if modifier {
            if !self.is_standing_still(scene) {
                self.send_movement_event(scene);
            }
            return;
        }
        let entry = CommandEntry {
            command,
            speed,
            hold_run: false,
            mouse: false,
        };
        self.handle_command(Press { entry, start }, scene);
    }

    fn handle_command(&mut self, press: Press, scene: &mut Scene<'_>) {
        if let Some(mut press) = self.bookkeep(press, scene) {
            press.entry.command = self.mapped(press.entry.command);
            self.move_player(press, scene);
            if press.entry.command == Command::JUMP {
                return;
            }
        }
        self.send_movement_event(scene);
    }

    /// The command that a turning key stands for.
    pub(super) fn mapped(&self, command: Command) -> Command {
        match command {
            Command::TURN_RIGHT if self.hold_sidestep => Command::SIDE_STEP_RIGHT,
            Command::TURN_LEFT if self.hold_sidestep => Command::SIDE_STEP_LEFT,
            command => command,
        }
    }

    /// Notes what is held (13.5). `None`: nothing is to be done. A release may become the press of the key below.
    pub(super) fn bookkeep(&mut self, press: Press, scene: &mut Scene<'_>) -> Option<Press> {
        let entry = press.entry;
        if entry.command == Command::JUMP {
            return Some(press);
        }
        if press.start {
            self.add_command(entry, scene);
            return Some(press);
        }
        let (transient, auto_run) = (self.transient, self.auto_run);
        let list = self.list_of(entry.command)?;
        let was_head = list.remove(entry.command, entry.mouse);
        let below = list.head().copied();
        if !was_head || transient || auto_run && is_walking(entry.command) {
            return None;
        }
        Some(match below {
            Some(entry) => Press { entry, start: true },
            None => press,
        })
    }

    fn add_command(&mut self, entry: CommandEntry, scene: &mut Scene<'_>) {
        let command = entry.command;
        if let Some(list) = self.list_of(command) {
            list.push(entry);
            if is_walking(command) {
                self.set_auto_run(false, true, scene);
                self.transient = false;
            }
        } else if command.is_sub_state() {
            self.set_auto_run(false, true, scene);
            if command != Command::READY {
                self.transient = true;
            }
        }
    }

    /// The run key; nothing is remembered without a player.
    pub fn set_hold_run(&mut self, hold: bool, scene: &mut Scene<'_>) {
        let Some(player) = scene.player.as_deref_mut() else {
            return;
        };
        self.hold_run = hold;
        let run = hold != self.options.run_by_default;
        if self.autonomy_level != AutonomyLevel::None {
            player.set_hold_run(run, scene.world);
        }
    }

    /// The "turns sidestep" key.
    pub fn set_hold_sidestep(&mut self, hold: bool, scene: &mut Scene<'_>) {
        if let Some(mut entry) = self.turns.head().copied() {
            entry.command = self.mapped(entry.command);
            let press = Press {
                entry,
                start: false,
            };
            self.move_player(press, scene);
        }
        self.hold_sidestep = hold;
        self.apply_current_movement(scene);
    }

    /// Running without a key.
    pub fn set_auto_run(&mut self, run: bool, apply: bool, scene: &mut Scene<'_>) {
        if run == self.auto_run {
            return;
        }
        self.auto_run = run;
        self.transient = false;
        if run {
            self.take_control_from_server(scene);
        }
        if apply {
            self.apply_current_movement(scene);
        }
    }

    /// Forgets what keys hold, for instance because a text field has the keyboard now.
    pub fn lose_keyboard_focus(&mut self, scene: &mut Scene<'_>) {
        for list in self.lists() {
            list.clear_keys();
        }
        self.let_go(scene);
        self.finish_jump(scene);
        if self.autonomy_level != AutonomyLevel::None && !self.controlled_by_server {
            self.apply_current_movement(scene);
        }
        self.send_movement_event(scene);
    }

    /// Input is ignored from now on; what was held ends.
    pub fn disable(&mut self, scene: &mut Scene<'_>) {
        for list in self.lists() {
            list.clear();
        }
        self.let_go(scene);
        let moves = self.autonomy_level != AutonomyLevel::None && !self.controlled_by_server;
        if moves && scene.player.is_some() {
            self.apply_current_movement(scene);
        }
        self.send_movement_event(scene);
        self.enabled = false;
    }

    /// Input counts again.
    pub fn enable(&mut self, scene: &mut Scene<'_>) {
        self.enabled = true;
        self.set_hold_run(self.hold_run, scene);
    }

    fn let_go(&mut self, scene: &mut Scene<'_>) {
        self.set_hold_run(false, scene);
        self.hold_sidestep = false;
    }

    fn lists(&mut self) -> [&mut super::CommandList; 3] {
        [&mut self.substates, &mut self.turns, &mut self.sidesteps]
    }

    /// Everything ends: held keys, autorun, the player's motions.
    pub fn stop_completely(&mut self, scene: &mut Scene<'_>) {
        for list in self.lists() {
            list.clear();
        }
        self.set_auto_run(false, false, scene);
        if let Some(player) = scene.player.as_deref_mut() {
            player.stop_completely(scene.world);
        }
        self.send_movement_event(scene);
    }

    /// [`stop_completely`](Self::stop_completely), unless the server is in control.
    pub fn maybe_stop_completely(&mut self, scene: &mut Scene<'_>) {
        if !self.controlled_by_server {
            self.stop_completely(scene);
        }
    }

    /// The player was teleported.
    pub fn player_teleported(&mut self, scene: &mut Scene<'_>) {
        self.set_auto_run(false, true, scene);
        self.send_movement_event(scene);
    }

    /// The player's stamina ran out or came back.
    pub fn handle_exhaustion(&mut self, scene: &mut Scene<'_>) {
        if let Some(player) = scene.player.as_deref_mut() {
            player.report_exhaustion(scene.world);
        }
    }

    /// Turns the player to a compass heading, degrees.
    pub fn turn_to_heading(&mut self, heading: f32, run: bool, scene: &mut Scene<'_>) {
        if !self.is_active(scene) {
            return;
        }
        let mut params = MovementParameters::new(&scene.world.profile)
            .with(MovementFlags::STOP_COMPLETELY, false);
        params.desired_heading = heading;
        if run {
            params.hold_key = crate::motion::HoldKey::Run;
        }
        if let Some(player) = scene.player.as_deref_mut() {
            player.turn_to_heading(&params, scene.world);
        }
    }
}
