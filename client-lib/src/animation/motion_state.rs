//! What the motion table is doing (`spec/07-animation.md`, 10.7; retail `MotionState`).

use std::collections::VecDeque;

/// A motion and the speed factor it was asked for with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionEntry {
    /// Motion command.
    pub motion: u32,
    /// Factor on rates and velocities; negative plays backwards.
    pub speed: f32,
}

/// Style, substate, modifiers and actions of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionState {
    /// Stance; 0 before initialisation.
    pub style: u32,
    /// Continuous motion; 0 before initialisation.
    pub substate: u32,
    /// Speed factor of the substate (`substate_mod`).
    pub substate_speed: f32,
    /// Movements on top of the substate, newest first.
    pub modifiers: VecDeque<MotionEntry>,
    /// One-shot motions that are not finished, oldest first.
    pub actions: VecDeque<MotionEntry>,
}

impl Default for MotionState {
    fn default() -> Self {
        Self {
            style: 0,
            substate: 0,
            substate_speed: 1.0,
            modifiers: VecDeque::new(),
            actions: VecDeque::new(),
        }
    }
}

impl MotionState {
    /// Puts a modifier in front, whatever is listed.
    pub fn add_modifier_no_check(&mut self, motion: u32, speed: f32) {
        self.modifiers.push_front(MotionEntry { motion, speed });
    }

    /// Puts a modifier in front; `false` if it is listed already or is the substate.
    pub fn add_modifier(&mut self, motion: u32, speed: f32) -> bool {
        if motion == self.substate || self.modifier(motion).is_some() {
            return false;
        }
        self.add_modifier_no_check(motion, speed);
        true
    }

    /// Position of a modifier in the list.
    pub fn modifier(&self, motion: u32) -> Option<usize> {
        self.modifiers.iter().position(|m| m.motion == motion)
    }

    /// Appends an action.
    pub fn add_action(&mut self, motion: u32, speed: f32) {
        self.actions.push_back(MotionEntry { motion, speed });
    }

    /// Drops the oldest action.
    pub fn remove_action_head(&mut self) {
        self.actions.pop_front();
    }
}
