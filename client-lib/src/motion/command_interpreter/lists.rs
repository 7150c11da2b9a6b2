//! Stacks of held commands, one per axis (`spec/08-motion.md`, 13.1 and 13.5).

use crate::motion::Command;

/// A held command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandEntry {
    /// Command.
    pub command: Command,
    /// Factor of the animation's rate.
    pub speed: f32,
    /// For the mouse: run.
    pub hold_run: bool,
    /// Held by the mouse, not by a key.
    pub mouse: bool,
}

/// Held commands of one axis; the newest is the head and acts. At most one is the mouse's.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CommandList(Vec<CommandEntry>);

impl CommandList {
    /// The newest entry.
    pub fn head(&self) -> Option<&CommandEntry> {
        self.0.last()
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether nothing is held.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds an entry at the head; the mouse's replaces the mouse's old one.
    pub fn push(&mut self, entry: CommandEntry) {
        if entry.mouse {
            self.0.retain(|held| !held.mouse);
        }
        self.0.push(entry);
    }

    /// Removes the newest entry of a key with this command, or the mouse's; whether it was the head.
    pub fn remove(&mut self, command: Command, mouse: bool) -> bool {
        let found = self.0.iter().rposition(|held| {
            if mouse {
                held.mouse
            } else {
                !held.mouse && held.command == command
            }
        });
        let was_head = found.is_some_and(|at| at + 1 == self.0.len());
        if let Some(at) = found {
            self.0.remove(at);
        }
        was_head
    }

    /// Forgets all entries.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Forgets the entries of keys.
    pub fn clear_keys(&mut self) {
        self.0.retain(|held| held.mouse);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(command: Command, mouse: bool) -> CommandEntry {
        CommandEntry {
            command,
            speed: 1.0,
            hold_run: false,
            mouse,
        }
    }

    #[test]
    fn the_newest_is_the_head() {
        let mut list = CommandList::default();
        list.push(entry(Command::TURN_LEFT, false));
        list.push(entry(Command::TURN_RIGHT, true));
        list.push(entry(Command::TURN_LEFT, true));
        assert_eq!(list.len(), 2);
        assert!(!list.remove(Command::TURN_RIGHT, false));
        assert!(!list.remove(Command::TURN_LEFT, false));
        assert!(list.remove(Command::TURN_RIGHT, true));
        assert!(list.is_empty() && list.head().is_none());
    }
}
