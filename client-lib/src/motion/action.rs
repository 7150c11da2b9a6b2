//! Actions that wait in a motion state: a first-in-first-out list.

use std::collections::VecDeque;

use super::Command;
use super::wire::{Reader, WireError, put_f32, put_u16};

/// Largest number of actions that a wire form holds.
pub const WIRE_ACTIONS: usize = 31;

/// A one-shot motion that waits for its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Action {
    /// Command, with the class bit Action.
    pub command: Command,
    /// Factor of the animation's rate.
    pub speed: f32,
    /// Serial number; 15 bits travel.
    pub stamp: u32,
    /// Whether the local input asked for it.
    pub autonomous: bool,
}

/// Waiting actions, oldest first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Actions(VecDeque<Action>);

impl Actions {
    /// Number of waiting actions.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Appends one.
    pub fn add(&mut self, action: Action) {
        self.0.push_back(action);
    }

    /// Removes the oldest; its command, or [`Command::NONE`] if there is none.
    pub fn remove(&mut self) -> Command {
        self.0
            .pop_front()
            .map_or(Command::NONE, |action| action.command)
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Oldest first.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Action> {
        self.0.iter()
    }

    /// Number of nodes that the wire form holds: only five bits are there.
    pub(super) fn wire_len(&self) -> usize {
        self.len() & WIRE_ACTIONS
    }

    pub(super) fn pack(&self, message: &mut Vec<u8>) {
        for action in self.iter().take(self.wire_len()) {
            let autonomous = if action.autonomous { 0x8000 } else { 0 };
            put_u16(message, action.command.index());
            put_u16(message, (action.stamp & 0x7FFF) as u16 | autonomous);
            put_f32(message, action.speed);
        }
    }

    pub(super) fn unpack(
        &mut self,
        count: usize,
        reader: &mut Reader<'_>,
    ) -> Result<(), WireError> {
        for _ in 0..count {
            let command = Command::from_index(reader.u16()?);
            let stamp = reader.u16()?;
            self.add(Action {
                command,
                speed: reader.f32()?,
                stamp: u32::from(stamp & 0x7FFF),
                autonomous: stamp & 0x8000 != 0,
            });
        }
        Ok(())
    }
}
