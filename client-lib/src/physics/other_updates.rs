//! Per-frame entries besides `update_object` (`spec/06-physics-object.md`, B9).

use crate::entity::Entity;
use crate::frame::probe::NoProbe;
use crate::math::EPSILON;
use crate::physics::state::PhysicsState;
use crate::physics::update::Quantum;
use crate::profile::StaticAnimation;
use crate::world::World;

/// A gap longer than this, s, is dropped.
const HUGE_QUANTUM: f64 = 2.0;

impl World {
    /// Advances the animations of static entities (B1 step 5).
    pub fn animate_statics(&mut self) {
        for index in 0..self.static_animations.len() {
            let id = self.static_animations[index];
            self.with_entity(id, |entity, world| entity.animate_static(world));
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
        let rule = world.profile.static_animation;
        world.clock.sim_time = now;
        let gap = now - self.kin.update_time;
        if rule != StaticAnimation::UngatedNormalised && gap < world.profile.min_quantum {
            return;
        }
        let too_long = match rule {
            StaticAnimation::Gated => gap > HUGE_QUANTUM,
            StaticAnimation::MaxQuantumLocal => gap > world.profile.max_quantum,
            StaticAnimation::UngatedNormalised => false,
        };
        if self.body.part_array.is_none() || gap < f64::from(EPSILON) || too_long {
            self.kin.update_time = now;
            return;
        }
        if self.body.state.contains(PhysicsState::HAS_DEFAULT_ANIM) {
            self.play_static_animation(gap as f32, rule, world);
        }
        self.process_hooks(world);
        self.kin.update_time = now;
    }

    /// The rotation is by the whole omega, not multiplied by the time: the client's.
    fn play_static_animation(&mut self, quantum: f32, rule: StaticAnimation, world: &mut World) {
        if let Some(parts) = &mut self.body.part_array
            && let Err(error) = parts.update(f64::from(quantum), None, &world.profile)
        {
            tracing::warn!(%error, "static animation stopped");
        }
        let omega = self.kin.omega;
        let frame = &mut self.body.position.frame;
        match rule {
            StaticAnimation::MaxQuantumLocal => frame.rotate(omega, &world.profile),
            StaticAnimation::Gated | StaticAnimation::UngatedNormalised => {
                frame.grotate(omega, &world.profile);
            }
        }
        if rule == StaticAnimation::UngatedNormalised && omega.length() >= EPSILON {
            // The rotation normalises the field as a side effect.
            self.kin.omega = omega * (1.0 / omega.length());
        }
        self.update_parts(world);
        self.update_children(world);
    }
}
