//! What a scripted player does: one command per line, one after another.
//!
//! | command | what it does |
//! |---|---|
//! | `wait S` | nothing for S seconds |
//! | `forward S`, `backward S`, `left S`, `right S` | holds the key for S seconds (`left` and `right` sidestep) |
//! | `turn-left D`, `turn-right D` | turns by D degrees, with the key held |
//! | `face D` | turns to the compass heading D, as the client does by itself |
//! | `run on`, `run off` | presses or releases the run key |
//! | `hold KEY`, `release KEY` | keys: `forward`, `backward`, `left`, `right`, `turn-left`, `turn-right` |
//! | `jump [S]` | charges a jump for S seconds (default 0.5) and jumps |
//! | `say TEXT` | says TEXT |
//! | `logoff` | leaves the world; so does the end of the script |
//!
//! Empty lines and what follows `#` are left out.

use ac_client::motion::{Command, CommandInterpreter, Scene};
use ac_client::net::client::GameClient;
use ac_client::net::messages::GameAction;
use ac_client::net::messages::common::Text;
use miette::Diagnostic;
use thiserror::Error;

/// Longest time that a command may take, s, and largest turn, degrees.
const LONGEST: f64 = 3600.0;
/// A turn that gets nowhere ends after this time, s.
const TURN_LIMIT: f64 = 20.0;

/// Why a text is no script.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("script, line {line}: {reason}")]
#[diagnostic(help(
    "commands: wait S, forward S, backward S, left S, right S, turn-left D, turn-right D, face D, run on|off, hold KEY, release KEY, jump [S], say TEXT, logoff"
))]
pub struct ScriptError {
    /// Line, from 1.
    pub line: usize,
    /// What is wrong.
    pub reason: String,
}

/// A key of the keyboard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "names of the field")]
pub enum Key {
    Forward,
    Backward,
    Left,
    Right,
    TurnLeft,
    TurnRight,
}

impl Key {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "forward" => Self::Forward,
            "backward" => Self::Backward,
            "left" => Self::Left,
            "right" => Self::Right,
            "turn-left" => Self::TurnLeft,
            "turn-right" => Self::TurnRight,
            _ => return None,
        })
    }

    const fn command(self) -> Command {
        match self {
            Self::Forward => Command::WALK_FORWARD,
            Self::Backward => Command::WALK_BACKWARDS,
            Self::Left => Command::SIDE_STEP_LEFT,
            Self::Right => Command::SIDE_STEP_RIGHT,
            Self::TurnLeft => Command::TURN_LEFT,
            Self::TurnRight => Command::TURN_RIGHT,
        }
    }
}

/// A command of a script; times in seconds, angles in degrees.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Nothing.
    Wait(f64),
    /// A key is held.
    Press(Key, f64),
    /// A key is held until the player has turned.
    Turn(Key, f64),
    /// A turn to a heading.
    Face(f64),
    /// The run key.
    Run(bool),
    /// A key goes down and stays there.
    Hold(Key),
    /// A key goes up.
    Release(Key),
    /// A jump is charged and done.
    Jump(f64),
    /// Chat.
    Say(String),
    /// The end.
    LogOff,
}

/// A script.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Script {
    steps: Vec<Step>,
}

impl Script {
    /// Reads a script.
    ///
    /// # Errors
    /// The first line that is no command.
    pub fn parse(text: &str) -> Result<Self, ScriptError> {
        let mut steps = Vec::new();
        for (line, text) in (1..).zip(text.lines()) {
            let text = text.split('#').next().unwrap_or_default().trim();
            if !text.is_empty() {
                steps.push(step(text).map_err(|reason| ScriptError { line, reason })?);
            }
        }
        Ok(Self { steps })
    }

    /// The commands.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }
}

fn step(text: &str) -> Result<Step, String> {
    let (name, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let rest = rest.trim();
    let number = |text: &str| match text.parse::<f64>() {
        Ok(n) if (0.0..=LONGEST).contains(&n) => Ok(n),
        _ => Err(format!(
            "`{name}` needs a number from 0 to {LONGEST}, not `{text}`"
        )),
    };
    let key = |text: &str| Key::named(text).ok_or_else(|| format!("`{text}` is no key"));
    Ok(match (name, rest) {
        ("wait", n) => Step::Wait(number(n)?),
        ("turn-left" | "turn-right", n) => Step::Turn(key(name)?, number(n)?),
        ("forward" | "backward" | "left" | "right", n) => Step::Press(key(name)?, number(n)?),
        ("face", n) => Step::Face(number(n)?),
        ("run", "on") => Step::Run(true),
        ("run", "off") => Step::Run(false),
        ("hold", k) => Step::Hold(key(k)?),
        ("release", k) => Step::Release(key(k)?),
        ("jump", "") => Step::Jump(0.5),
        ("jump", n) => Step::Jump(number(n)?),
        ("say", "") => return Err("`say` needs a text".into()),
        ("say", text) => Step::Say(text.into()),
        ("logoff", "") => Step::LogOff,
        _ => return Err(format!("`{text}` is no command")),
    })
}

/// A command that is being carried out.
#[derive(Debug, Clone, Copy)]
struct Running {
    until: f64,
    /// Degrees turned so far, and the heading before.
    turned: f32,
    heading: f32,
}

/// Carries a script out, frame by frame, while the player is in the world.
#[derive(Debug, Clone)]
pub struct Player {
    script: Script,
    next: usize,
    running: Option<Running>,
    says: Vec<String>,
    log_off: bool,
}

impl Player {
    /// A player at the start of a script.
    pub const fn new(script: Script) -> Self {
        Self {
            script,
            next: 0,
            running: None,
            says: Vec::new(),
            log_off: false,
        }
    }

    /// Whether nothing is left to do.
    pub const fn is_over(&self) -> bool {
        self.log_off
    }

    /// Whether the player wants to leave.
    pub const fn wants_log_off(&self) -> bool {
        self.log_off
    }

    /// The keys of the frame at `now`, s.
    pub fn frame(&mut self, now: f64, keys: &mut CommandInterpreter, scene: &mut Scene<'_>) {
        while !self.log_off {
            let Some(step) = self.script.steps.get(self.next).cloned() else {
                self.log_off = true;
                return;
            };
            let heading = heading(scene);
            let running = match self.running {
                Some(running) => running,
                None => {
                    self.begin(&step, keys, scene);
                    let until = now + length(&step);
                    Running {
                        until,
                        turned: 0.0,
                        heading,
                    }
                }
            };
            let running = turn_on(running, heading);
            if !is_done(&step, &running, now) {
                self.running = Some(running);
                return;
            }
            self.running = None;
            self.next += 1;
            end(&step, keys, scene);
        }
    }

    fn begin(&mut self, step: &Step, keys: &mut CommandInterpreter, scene: &mut Scene<'_>) {
        match step {
            Step::Press(key, _) | Step::Turn(key, _) | Step::Hold(key) => {
                keys.handle_keyboard_command(key.command(), true, 1.0, scene);
            }
            Step::Release(key) => keys.handle_keyboard_command(key.command(), false, 1.0, scene),
            Step::Run(on) => keys.handle_keyboard_command(Command::HOLD_RUN, *on, 1.0, scene),
            Step::Jump(_) => keys.commence_jump(scene),
            Step::Face(heading) => keys.turn_to_heading(*heading as f32, false, scene),
            Step::Say(text) => self.says.push(text.clone()),
            Step::LogOff => self.log_off = true,
            Step::Wait(_) => {}
        }
    }

    /// Sends what the player has said.
    pub fn speak(&mut self, client: &mut GameClient, now: f64) {
        for text in self.says.drain(..) {
            client.act(GameAction::Talk(Text::new(&text)), now);
        }
    }
}

fn heading(scene: &Scene<'_>) -> f32 {
    let player = scene.player.as_ref();
    player.map_or(0.0, |player| player.heading(scene.world))
}

/// Seconds that a command takes; a turn at most.
const fn length(step: &Step) -> f64 {
    match step {
        Step::Wait(s) | Step::Press(_, s) | Step::Jump(s) => *s,
        Step::Turn(..) => TURN_LIMIT,
        _ => 0.0,
    }
}

fn turn_on(mut running: Running, heading: f32) -> Running {
    let change = (heading - running.heading + 540.0).rem_euclid(360.0) - 180.0;
    running.turned += change.abs();
    running.heading = heading;
    running
}

fn is_done(step: &Step, running: &Running, now: f64) -> bool {
    let turned = matches!(step, Step::Turn(_, by) if f64::from(running.turned) >= *by);
    // Frames are not at round times: half a millisecond belongs to the frame.
    turned || now >= running.until - 0.0005
}

fn end(step: &Step, keys: &mut CommandInterpreter, scene: &mut Scene<'_>) {
    match step {
        Step::Press(key, _) | Step::Turn(key, _) => {
            keys.handle_keyboard_command(key.command(), false, 1.0, scene);
        }
        Step::Jump(_) => keys.do_jump(scene),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_are_read() {
        let text = "# a walk\nrun on\nforward 2\nturn-left 90 # to the west\n\njump\njump 1\nsay well met\nhold right\nrelease right\nface 10\nlogoff";
        let script = Script::parse(text).expect("a script");
        assert_eq!(
            script.steps(),
            [
                Step::Run(true),
                Step::Press(Key::Forward, 2.0),
                Step::Turn(Key::TurnLeft, 90.0),
                Step::Jump(0.5),
                Step::Jump(1.0),
                Step::Say("well met".into()),
                Step::Hold(Key::Right),
                Step::Release(Key::Right),
                Step::Face(10.0),
                Step::LogOff,
            ]
        );
    }

    #[test]
    fn errors_name_line_and_command() {
        for (text, error) in [
            ("wait 1\nfly 2", "script, line 2: `fly 2` is no command"),
            (
                "forward",
                "script, line 1: `forward` needs a number from 0 to 3600, not ``",
            ),
            (
                "wait -1",
                "script, line 1: `wait` needs a number from 0 to 3600, not `-1`",
            ),
            (
                "wait nan",
                "script, line 1: `wait` needs a number from 0 to 3600, not `nan`",
            ),
            ("hold up", "script, line 1: `up` is no key"),
            ("say", "script, line 1: `say` needs a text"),
            ("logoff now", "script, line 1: `logoff now` is no command"),
        ] {
            assert_eq!(Script::parse(text).expect_err(text).to_string(), error);
        }
    }
}
