//! Per-frame entries besides `update_object` (`spec/06-physics-object.md`, B9).

use crate::animation::is_executed;
use crate::dat::HookAction;
use crate::entity::Entity;
use crate::frame::probe::NoProbe;
use crate::math::{EPSILON, Frame, Vec3};
use crate::physics::state::PhysicsState;
use crate::physics::update::Quantum;
use crate::profile::{Profile, StaticAnimation};
use crate::world::{StaticObject, World};

/// A gap longer than this, s, is dropped.
const HUGE_QUANTUM: f64 = 2.0;

impl World {
    /// Advances the animations of static objects, those of the dat files included (B1 step 5).
    pub fn animate_statics(&mut self) {
        for index in 0..self.static_animations.len() {
            let id = self.static_animations[index];
            self.with_entity(id, |entity, world| entity.animate_static(world));
        }
        for index in 0..self.land.animated_statics().len() {
            let id = self.land.animated_statics()[index];
            self.clock.sim_time = self.clock.now;
            if let Some(object) = self.land.static_object_mut(id) {
                object.animate(self.clock.now, &self.profile);
            }
        }
        self.end_planned_animations();
    }
}

/// What the gap since the last update means for a static object.
enum StaticGap {
    /// Too short: time goes on adding up.
    Wait,
    /// Without parts, or too long: nothing is played, and the clock is set.
    Drop,
    /// The animation goes on by that much, s.
    Play(f32),
}

/// The time gates of a static object (O-41).
fn static_gap(gap: f64, has_parts: bool, profile: &Profile) -> StaticGap {
    let rule = profile.static_animation;
    if rule != StaticAnimation::UngatedNormalised && gap < profile.min_quantum {
        return StaticGap::Wait;
    }
    let too_long = match rule {
        StaticAnimation::Gated => gap > HUGE_QUANTUM,
        StaticAnimation::MaxQuantumLocal => gap > profile.max_quantum,
        StaticAnimation::UngatedNormalised => false,
    };
    if !has_parts || gap < f64::from(EPSILON) || too_long {
        return StaticGap::Drop;
    }
    StaticGap::Play(gap as f32)
}

/// Turns a static object, by the whole omega, not multiplied by the time: the client's.
fn turn_static(frame: &mut Frame, omega: &mut Vec3, profile: &Profile) {
    match profile.static_animation {
        StaticAnimation::MaxQuantumLocal => frame.rotate(*omega, profile),
        StaticAnimation::Gated | StaticAnimation::UngatedNormalised => {
            frame.grotate(*omega, profile);
        }
    }
    let length = omega.length();
    if profile.static_animation == StaticAnimation::UngatedNormalised && length >= EPSILON {
        // The rotation normalises the field as a side effect.
        *omega *= 1.0 / length;
    }
}

impl StaticObject {
    /// Advances the default animation to `now`, s (`animate_static_object`; O-41). The parts move, and are collided with where they are; the
    /// shadows stay.
    ///
    /// Of the hooks, those that change what is collided with are executed: passable or not (without the test for room: nothing would try
    /// again), and rotation.
    pub(crate) fn animate(&mut self, now: f64, profile: &Profile) {
        if self.body.cell.is_none() {
            return;
        }
        let gap = now - self.update_time;
        let has_parts = self.body.part_array.is_some();
        match static_gap(gap, has_parts, profile) {
            StaticGap::Wait => return,
            StaticGap::Drop => {}
            StaticGap::Play(quantum) => self.play(quantum, profile),
        }
        self.update_time = now;
    }

    fn play(&mut self, quantum: f32, profile: &Profile) {
        let Some(parts) = &mut self.body.part_array else {
            return;
        };
        if let Err(error) = parts.update(f64::from(quantum), None, profile) {
            tracing::warn!(model = self.model, %error, "static animation stopped");
        }
        turn_static(&mut self.body.position.frame, &mut self.omega, profile);
        parts.update_parts(&self.body.position.frame, profile);
        for hook in parts.hooks.drain(..).filter(|h| is_executed(h, profile)) {
            match hook {
                HookAction::SetOmega { axis } => self.omega = axis,
                HookAction::Ethereal { value } => {
                    self.body.state.set(PhysicsState::ETHEREAL, value != 0);
                }
                _ => {}
            }
        }
    }
}

impl Entity {
    /// Advances an object shown outside the world: one step of any length, no cell, no collision (`update_position`; O-41).
    pub fn update_outside_world(&mut self, world: &mut World) {
        if self.body.parent.is_some() {
            return;
        }
        let now = world.clock.now;
        world.clock.sim_time = now;
        let gap = now - self.kin.update_time;
        if gap <= f64::from(EPSILON) {
            self.kin.update_time = now;
            return;
        }
        if gap < world.profile.min_quantum {
            return;
        }
        // The upper gate of profile `ace` is disabled.
        let gated = world.profile.static_animation == StaticAnimation::Gated;
        if !(gated && gap > HUGE_QUANTUM) {
            let quantum = Quantum::new(gap, &world.profile);
            let frame = self.update_position(quantum, world, &mut NoProbe);
            self.set_frame(frame, world);
        }
        self.kin.update_time = now;
    }

    /// Advances the animation of a static object (`animate_static_object`; O-41). Its shadows stay where they are.
    pub fn animate_static(&mut self, world: &mut World) {
        if self.body.cell.is_none() {
            return;
        }
        let now = world.clock.now;
        world.clock.sim_time = now;
        let gap = now - self.kin.update_time;
        let has_parts = self.body.part_array.is_some();
        match static_gap(gap, has_parts, &world.profile) {
            StaticGap::Wait => return,
            StaticGap::Drop => {}
            StaticGap::Play(quantum) => {
                if self.body.state.contains(PhysicsState::HAS_DEFAULT_ANIM) {
                    self.play_static_animation(quantum, world);
                }
                self.process_hooks(world);
            }
        }
        self.kin.update_time = now;
    }

    fn play_static_animation(&mut self, quantum: f32, world: &mut World) {
        if let Some(parts) = &mut self.body.part_array
            && let Err(error) = parts.update(f64::from(quantum), None, &world.profile)
        {
            tracing::warn!(%error, "static animation stopped");
        }
        let frame = &mut self.body.position.frame;
        turn_static(frame, &mut self.kin.omega, &world.profile);
        self.update_parts(world);
        self.update_children(world);
    }
}
