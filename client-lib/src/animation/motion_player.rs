//! Motion table operations: from a motion command to nodes of the sequence (`spec/07-animation.md`, 10; retail `CMotionTable`).

use super::motion_class::{ACTION, INDEX, MODIFIER, STYLE, SUBSTATE, has};
use super::motion_state::{MotionEntry, MotionState};
use super::sequence::Sequence;
use super::source::AnimationSource;
use crate::dat::{AnimRange, MotionBits, MotionData, MotionTable, motion_key};
use crate::math::EPSILON;
use crate::profile::{ModifierKey, Profile};

/// Nesting of operations at which a table is refused: the references overflow their stack.
const DEPTH_LIMIT: u32 = 64;
/// Operations that one command may cause in total. Sane tables need a few per modifier.
const CALL_LIMIT: u32 = 4096;

/// Number of animations that will end before the motion is done (u32, wrapping: a motion without any gives `u32::MAX`); `None`: refused.
pub(super) type Answer = Option<u32>;

/// One motion command on its way through the table.
pub(super) struct MotionPlayer<'a> {
    pub table: &'a MotionTable,
    pub state: &'a mut MotionState,
    pub sequence: &'a mut Sequence,
    pub source: &'a mut dyn AnimationSource,
    pub profile: &'a Profile,
    depth: u32,
    calls: u32,
    endless: bool,
}

/// Whether two speeds point the same way (`N-13`).
fn same_sign(a: f32, b: f32, profile: &Profile) -> bool {
    if profile.zero_speed_keeps_sign {
        let sign = |x: f32| i32::from(x > 0.0) - i32::from(x < 0.0);
        return sign(a) == sign(b);
    }
    if a < 0.0 { b < 0.0 } else { b >= 0.0 }
}

/// Animations of a motion, 0 without one.
fn count(data: Option<&MotionData>) -> u32 {
    data.map_or(0, |d| d.anims.len() as u32)
}

impl<'a> MotionPlayer<'a> {
    pub fn new(
        table: &'a MotionTable,
        state: &'a mut MotionState,
        sequence: &'a mut Sequence,
        source: &'a mut dyn AnimationSource,
        profile: &'a Profile,
    ) -> Self {
        Self {
            table,
            state,
            sequence,
            source,
            profile,
            depth: 0,
            calls: 0,
            endless: false,
        }
    }

    /// Whether the table installs modifiers without end; what was asked for last is then incomplete.
    pub fn is_endless(&self) -> bool {
        self.endless
    }

    /// Default substate of a style; 0 if there is none.
    fn style_default(&self, style: u32) -> u32 {
        self.table.style_defaults.get(style).copied().unwrap_or(0)
    }

    fn cycle(&self, style: u32, motion: u32) -> Option<&'a MotionData> {
        self.table.cycles.get(motion_key(style, motion))
    }

    /// The motion that leads from one to another (`get_link`). With a negative speed it is the one of the opposite way, to be played backwards.
    fn link(&self, style: u32, from: MotionEntry, to: MotionEntry) -> Option<&'a MotionData> {
        let table = self.table;
        if to.speed < 0.0 || from.speed < 0.0 {
            let reversed = table.link(motion_key(style, to.motion), from.motion);
            return reversed.or_else(|| {
                let default = table.style_defaults.get(style)?;
                table.link(motion_key(style, from.motion), *default)
            });
        }
        let direct = table.link(motion_key(style, from.motion), to.motion);
        direct.or_else(|| table.link(style << 16, to.motion))
    }

    /// Whether a cycle may be entered from the present substate.
    fn is_allowed(&self, motion: u32, cycle: &MotionData) -> bool {
        !cycle.bits.contains(MotionBits::FROM_DEFAULT_ONLY)
            || motion == self.state.substate
            || self.style_default(self.state.style) == self.state.substate
    }

    /// Appends the animations of a motion; its velocities replace those of the sequence, also while earlier links play.
    fn add_motion(&mut self, data: Option<&MotionData>, speed: f32) {
        let Some(data) = data else { return };
        self.sequence.velocity = data.velocity * speed;
        self.sequence.omega = data.omega * speed;
        for anim in &data.anims {
            let range = AnimRange {
                framerate: anim.framerate * speed,
                ..*anim
            };
            self.sequence
                .append_animation(&range, self.source, self.profile);
        }
    }

    fn combine_motion(&mut self, data: &MotionData, speed: f32) {
        self.sequence
            .combine_physics(data.velocity * speed, data.omega * speed);
    }

    fn subtract_motion(&mut self, data: &MotionData, speed: f32) {
        self.sequence
            .subtract_physics(data.velocity * speed, data.omega * speed);
    }

    /// A cycle whose rate was once set to 0 is not revived by this.
    fn change_cycle_speed(&mut self, old: f32, new: f32) {
        if old.abs() > EPSILON {
            self.sequence.multiply_cyclic_rate(new / old);
        } else if new.abs() < EPSILON {
            self.sequence.multiply_cyclic_rate(0.0);
        }
    }

    /// Removes what the old base motion left: velocities and the cycle. Links that are playing stay.
    fn leave_base(&mut self) {
        self.sequence.clear_physics();
        self.sequence.remove_cyclic_animations();
    }

    /// Puts the modifiers back on after a new base motion. An accepted one returns to the head of the list, so of several only the newest is
    /// ever taken: the references do the same.
    fn re_modify(&mut self) {
        for _ in 0..self.state.modifiers.len() {
            if self.endless {
                return;
            }
            let Some(entry) = self.state.modifiers.pop_front() else {
                return;
            };
            let _ = self.play(entry.motion, entry.speed, false);
        }
    }

    /// Starts a motion (`GetObjectSequence`). `stop_modifiers`: asked for by a stop, so Ready is also entered from a turn in place.
    pub fn play(&mut self, motion: u32, speed: f32, stop_modifiers: bool) -> Answer {
        if self.state.style == 0 || self.state.substate == 0 {
            return None;
        }
        self.calls += 1;
        if self.depth >= DEPTH_LIMIT || self.calls > CALL_LIMIT {
            self.endless = true;
            return None;
        }
        let default = self.style_default(self.state.style);
        if motion == default && !stop_modifiers && has(self.state.substate, MODIFIER) {
            return Some(0);
        }
        self.depth += 1;
        let answer = self.play_by_class(motion, speed, default);
        self.depth -= 1;
        answer
    }

    /// The classes are tried in this order; a command with several falls through from one to the next.
    fn play_by_class(&mut self, motion: u32, speed: f32, default: u32) -> Answer {
        let asked = MotionEntry { motion, speed };
        let mut answer = None;
        if has(motion, STYLE) {
            answer = self.play_style(asked, default);
        }
        if answer.is_none() && has(motion, SUBSTATE) {
            answer = self.play_substate(asked, default);
        }
        if answer.is_none() && has(motion, ACTION) {
            answer = self.play_action(asked, default);
        }
        if answer.is_none() && has(motion, MODIFIER) {
            answer = self.play_modifier(asked);
        }
        answer
    }

    /// The present substate with its speed.
    fn old(&self) -> MotionEntry {
        MotionEntry {
            motion: self.state.substate,
            speed: self.state.substate_speed,
        }
    }

    fn play_style(&mut self, asked: MotionEntry, default: u32) -> Answer {
        let (style, old) = (self.state.style, self.old());
        if style == asked.motion {
            return Some(0);
        }
        // The old style's default substate is used for the new style, too.
        let cycle = self.cycle(asked.motion, default).filter(|_| default != 0)?;
        let at_default = |speed| MotionEntry {
            motion: default,
            speed,
        };
        let out = (default != old.motion)
            .then(|| self.link(style, old, at_default(asked.speed)))
            .flatten();
        self.clear_modifiers_for(cycle);
        let mut change = self.link(style, at_default(self.state.substate_speed), asked);
        let mut change2 = None;
        if change.is_none() {
            let base = self.table.default_style;
            let entry = |motion| MotionEntry { motion, speed: 1.0 };
            change = self.link(style, entry(default), entry(base));
            change2 = self.link(base, entry(self.style_default(base)), entry(asked.motion));
        }
        self.leave_base();
        for data in [out, change, change2, Some(cycle)] {
            self.add_motion(data, asked.speed);
        }
        self.state.substate = default;
        self.state.style = asked.motion;
        self.state.substate_speed = asked.speed;
        self.re_modify();
        let all = count(out) + count(change) + count(change2) + count(Some(cycle));
        Some(all.wrapping_sub(1))
    }

    fn clear_modifiers_for(&mut self, cycle: &MotionData) {
        if cycle.bits.contains(MotionBits::CLEARS_MODIFIERS) {
            self.state.modifiers.clear();
        }
    }

    fn play_substate(&mut self, asked: MotionEntry, default: u32) -> Answer {
        let style = self.state.style;
        let cycle = self
            .cycle(style, asked.motion)
            .or_else(|| self.cycle(self.table.default_style, asked.motion))
            .filter(|c| self.is_allowed(asked.motion, c))?;
        let old = self.old();
        let same_way = same_sign(asked.speed, old.speed, self.profile);
        if asked.motion == old.motion && same_way && self.sequence.has_animations() {
            self.change_cycle_speed(old.speed, asked.speed);
            self.subtract_motion(cycle, old.speed);
            self.combine_motion(cycle, asked.speed);
            self.state.substate_speed = asked.speed;
            return Some(0);
        }
        self.clear_modifiers_for(cycle);
        let mut link = self.link(style, old, asked);
        let mut link2 = None;
        if link.is_none() || !same_way {
            let through = MotionEntry {
                motion: default,
                speed: 1.0,
            };
            link = self.link(style, old, through);
            link2 = self.link(style, through, asked);
        }
        self.leave_base();
        if link2.is_some() {
            self.add_motion(link, old.speed);
            self.add_motion(link2, asked.speed);
        } else {
            let backwards = old.speed < 0.0 && asked.speed > 0.0;
            self.add_motion(link, if backwards { -asked.speed } else { asked.speed });
        }
        self.add_motion(Some(cycle), asked.speed);
        if old.motion != asked.motion && has(old.motion, MODIFIER) && default != asked.motion {
            // A turn in place becomes a turn on top of the new substate.
            self.state.add_modifier_no_check(old.motion, old.speed);
        }
        self.state.substate_speed = asked.speed;
        self.state.substate = asked.motion;
        self.re_modify();
        Some((count(Some(cycle)) + count(link) + count(link2)).wrapping_sub(1))
    }

    fn play_action(&mut self, asked: MotionEntry, default: u32) -> Answer {
        let (style, old) = (self.state.style, self.old());
        let cycle = self.cycle(style, old.motion)?;
        if let Some(link) = self.link(style, old, asked) {
            self.state.add_action(asked.motion, asked.speed);
            self.leave_base();
            self.add_motion(Some(link), asked.speed);
            self.add_motion(Some(cycle), old.speed);
            self.re_modify();
            return Some(count(Some(link)));
        }
        let through = MotionEntry {
            motion: default,
            speed: 1.0,
        };
        let out = self.link(style, old, through)?;
        let link = self.link(style, through, asked)?;
        let back = self.link(style, through, old);
        self.state.add_action(asked.motion, asked.speed);
        self.leave_base();
        self.add_motion(Some(out), 1.0);
        self.add_motion(Some(link), asked.speed);
        self.add_motion(back, 1.0);
        self.add_motion(Some(cycle), old.speed);
        self.re_modify();
        // `N-14`: one reference counts the first link a second time, if there is a way back.
        let third = back.map(|back| {
            if self.profile.action_counts_first_link {
                out
            } else {
                back
            }
        });
        Some(count(Some(out)) + count(Some(link)) + count(third))
    }

    fn play_modifier(&mut self, asked: MotionEntry) -> Answer {
        let cycle = self.cycle(self.state.style, self.state.substate)?;
        if cycle.bits.contains(MotionBits::CLEARS_MODIFIERS) {
            return None;
        }
        // `N-15`: one reference leaves the class bits in the key, so that a style's own modifiers are never found.
        let key = match self.profile.modifier_key {
            ModifierKey::StyleAndIndex => motion_key(self.state.style, asked.motion),
            ModifierKey::ByMotion => (self.state.style << 16) | asked.motion,
        };
        let data = self.modifier_data(key, asked.motion)?;
        if !self.state.add_modifier(asked.motion, asked.speed) {
            self.stop(asked.motion);
            if !self.state.add_modifier(asked.motion, asked.speed) {
                return None;
            }
        }
        self.combine_motion(data, asked.speed);
        Some(0)
    }

    fn modifier_data(&self, key: u32, motion: u32) -> Option<&'a MotionData> {
        let modifiers = &self.table.modifiers;
        modifiers.get(key).or_else(|| modifiers.get(motion & INDEX))
    }

    /// Ends a substate (by going to the default one) or a modifier (`StopSequenceMotion`).
    pub fn stop(&mut self, motion: u32) -> Answer {
        if has(motion, SUBSTATE) && motion == self.state.substate {
            let default = self.style_default(self.state.style);
            return Some(self.play(default, 1.0, true).unwrap_or(0));
        }
        if !has(motion, MODIFIER) {
            return None;
        }
        let position = self.state.modifier(motion)?;
        let key = match self.profile.modifier_key {
            ModifierKey::StyleAndIndex => motion_key(self.state.style, motion),
            ModifierKey::ByMotion => motion_key(motion, motion),
        };
        let data = self.modifier_data(key, motion)?;
        let entry = self.state.modifiers.remove(position)?;
        self.subtract_motion(data, entry.speed);
        Some(0)
    }

    /// Ends all modifiers and the substate (`StopObjectCompletely`). The count is that of the substate.
    pub fn stop_completely(&mut self) -> Answer {
        let mut stopped = false;
        while let Some(head) = self.state.modifiers.front().copied() {
            if self.stop(head.motion).is_some() {
                stopped = true;
            } else {
                // A modifier that the table does not know can not be stopped; the references try for ever.
                self.state.modifiers.pop_front();
                self.endless = true;
            }
        }
        let substate = self.stop(self.state.substate);
        substate.or(stopped.then_some(0))
    }

    /// Starts the default style's default substate from nothing (`SetDefaultState`).
    pub fn set_default_state(&mut self) -> Answer {
        let style = self.table.default_style;
        let default = self.style_default(style);
        if default == 0 {
            return None;
        }
        self.state.modifiers.clear();
        self.state.actions.clear();
        let cycle = self.cycle(style, default)?;
        self.state.style = style;
        self.state.substate = default;
        self.state.substate_speed = 1.0;
        self.sequence.clear_physics();
        self.sequence.clear_animations();
        self.add_motion(Some(cycle), 1.0);
        Some(count(Some(cycle)).wrapping_sub(1))
    }
}
