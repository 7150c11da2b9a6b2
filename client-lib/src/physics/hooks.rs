//! Execution of hooks (`spec/06-physics-object.md`, E5; `spec/07-animation.md`, 9.2).
//!
//! Runs after integration and before the transition of the same quantum, with the object still at its old place.

use crate::animation::{TimedHook, TimedHookKind, is_executed};
use crate::dat::HookAction;
use crate::entity::Entity;
use crate::frame::state::FrameEvent;
use crate::profile::TimedHooks;
use crate::world::World;

/// Hooks executed in one pass: hooks that queue hooks without end are cut here.
const HOOK_LIMIT: usize = 1 << 16;

impl Entity {
    /// Executes timed hooks, then the queued animation hooks, those included that are queued meanwhile (`process_hooks`).
    pub fn process_hooks(&mut self, world: &mut World) {
        if !self.hooks.is_empty() {
            self.process_timed_hooks(world);
        }
        let mut index = 0;
        while let Some(hook) = self.queued_hook(index) {
            index += 1;
            // Traces name every hook, also one that this profile does nothing about.
            self.events.push(FrameEvent::AnimHook(hook.kind()));
            if is_executed(&hook, &world.profile) {
                self.execute_hook(hook, world);
            }
        }
        if let Some(parts) = self.body.part_array.as_mut().filter(|_| index > 0) {
            parts.hooks.clear();
        }
    }

    fn queued_hook(&self, index: usize) -> Option<HookAction> {
        let hooks = &self.body.part_array.as_ref()?.hooks;
        hooks.get(index).filter(|_| index < HOOK_LIMIT).copied()
    }

    /// Whether a hook waits to be executed.
    pub fn has_hooks(&self) -> bool {
        !self.hooks.is_empty()
            || self
                .body
                .part_array
                .as_ref()
                .is_some_and(|p| !p.hooks.is_empty())
    }

    fn process_timed_hooks(&mut self, world: &World) {
        let once = world.profile.timed_hooks == TimedHooks::Once;
        let now = world.clock.sim_time;
        let mut index = 0;
        while let Some(hook) = self.hooks.get(index).copied() {
            let finished = self.execute_timed_hook(&hook, now);
            if finished || once {
                self.hooks.remove(index);
            } else {
                index += 1;
            }
        }
    }

    fn execute_timed_hook(&mut self, hook: &TimedHook, now: f64) -> bool {
        let at = hook.at(now);
        match hook.kind {
            TimedHookKind::Scale => self.set_scale_static(at.value),
            TimedHookKind::Translucency => self.set_translucency(at.value),
            // Cosmetic: parts, luminosity, diffusion, scripts.
            _ => {}
        }
        at.finished
    }

    fn execute_hook(&mut self, hook: HookAction, world: &mut World) {
        match hook {
            HookAction::AnimationDone => self.hook_animation_done(world),
            HookAction::Ethereal { value } => {
                self.set_ethereal(value != 0, world);
            }
            HookAction::Scale { end, time } => self.set_scale(end, f64::from(time), world),
            HookAction::NoDraw { value } => self.set_no_draw(value != 0),
            HookAction::SetOmega { axis } => self.kin.omega = axis,
            HookAction::SetLight { on } => self.set_lights(on != 0),
            HookAction::Attack(cone) => self.strike(&cone, world),
            // Particles (13 to 15, 26), scripts (17 to 19), and what only draws or sounds.
            _ => {}
        }
    }
}
