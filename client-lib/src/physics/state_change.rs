//! State words, hiding, becoming solid, scale and placement of an object (`spec/06-physics-object.md`, E1 to E4).

use crate::animation::{TimedHook, TimedHookKind};
use crate::entity::Entity;
use crate::math::{EPSILON, Vec3};
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::{SetHidden, TimedHooks};
use crate::world::World;

impl Entity {
    /// Makes the object passable, or solid again if nobody stands in it (`set_ethereal`); `false` when it could not become solid yet.
    pub fn set_ethereal(&mut self, on: bool, world: &mut World) -> bool {
        if on {
            self.body.state.insert(PhysicsState::ETHEREAL);
            self.kin.transient.remove(TransientState::CHECK_ETHEREAL);
            return true;
        }
        // The check itself is a solid test.
        self.body.state.remove(PhysicsState::ETHEREAL);
        let free = self.body.parent.is_some()
            || self.body.cell.is_none()
            || !self.ethereal_check_for_collisions(world);
        if free {
            self.kin.transient.remove(TransientState::CHECK_ETHEREAL);
        } else {
            self.body.state.insert(PhysicsState::ETHEREAL);
            self.kin.transient.insert(TransientState::CHECK_ETHEREAL);
        }
        free
    }

    /// Hides or shows the object (`set_hidden`; O-32).
    pub fn set_hidden(&mut self, on: bool, world: &mut World) {
        if world.profile.set_hidden == SetHidden::Empty {
            return;
        }
        self.body.state.set(PhysicsState::HIDDEN, on);
        self.for_each_child(world, |child, _, _| {
            child.body.state.set(PhysicsState::NODRAW, on);
        });
        if on {
            if self.body.state.contains(PhysicsState::REPORT_COLLISIONS) {
                self.report_collision_end(true, world);
                self.body.state.remove(PhysicsState::REPORT_COLLISIONS);
            }
            self.body.state.insert(PhysicsState::IGNORE_COLLISIONS);
        } else {
            self.body.state.remove(PhysicsState::IGNORE_COLLISIONS);
            if !self.body.state.contains(PhysicsState::REPORT_COLLISIONS) {
                self.body.state.insert(PhysicsState::REPORT_COLLISIONS);
                self.report_collision_start(world);
            }
        }
        self.remove_link_animations(world);
    }

    /// Takes a state word: all bits are replaced, STATIC and HAS_PHYSICS_BSP included (`set_state`).
    ///
    /// Nothing is derived from it at once: gravity takes effect at the next `calc_acceleration`, shadows stay.
    pub fn set_state(&mut self, word: u32, world: &mut World) {
        let new = PhysicsState::from_bits_retain(word);
        let changed = self.body.state.symmetric_difference(new);
        if world.profile.state_word_stored {
            self.body.state = new;
        } else {
            // O-31: only the lights follow the word; the other two act with the old bits.
            self.body.state.set(
                PhysicsState::LIGHTING_ON,
                new.contains(PhysicsState::LIGHTING_ON),
            );
        }
        let word = self.body.state;
        if changed.contains(PhysicsState::NODRAW) {
            self.set_no_draw(word.contains(PhysicsState::NODRAW));
        }
        if changed.contains(PhysicsState::HIDDEN) {
            self.set_hidden(word.contains(PhysicsState::HIDDEN), world);
        }
    }

    /// Sets or clears NODRAW (`set_nodraw`); cosmetic but for the bit.
    pub fn set_no_draw(&mut self, on: bool) {
        self.body.state.set(PhysicsState::NODRAW, on);
        if let Some(parts) = &mut self.body.part_array {
            parts.set_no_draw(on);
        }
    }

    /// Sets or clears LIGHTING_ON (`set_lights`); cosmetic but for the bit.
    pub fn set_lights(&mut self, on: bool) {
        self.body.state.set(PhysicsState::LIGHTING_ON, on);
    }

    /// Scales object and parts at once (`SetScaleStatic`); shadows stay as they are.
    pub fn set_scale_static(&mut self, scale: f32) {
        self.body.scale = scale;
        self.set_part_scale(scale);
    }

    fn set_part_scale(&mut self, scale: f32) {
        if let Some(parts) = &mut self.body.part_array {
            parts.set_scale(Vec3::splat(scale));
        }
    }

    /// Scales within `seconds` (`SetScale`). At once, only the parts are scaled: a quirk of the only reference (O-34).
    pub fn set_scale(&mut self, scale: f32, seconds: f64, world: &World) {
        if world.profile.timed_hooks == TimedHooks::None {
            return;
        }
        if seconds < f64::from(EPSILON) {
            self.set_part_scale(scale);
            return;
        }
        self.hooks.push(TimedHook {
            kind: TimedHookKind::Scale,
            created: world.clock.sim_time,
            duration: seconds,
            start: self.body.scale,
            end: scale,
        });
    }

    /// Translucency, at once; never below the object's own (`SetTranslucencyInternal`). Cosmetic.
    pub fn set_translucency(&mut self, translucency: f32) {
        self.translucency = translucency.max(self.translucency_original);
    }

    /// Takes the placement frame with this id, or frame 0 (`SetPlacementFrame`); `false` when there is neither.
    pub fn set_placement_frame(&mut self, id: i32, world: &World) -> bool {
        let found = self
            .body
            .part_array
            .as_mut()
            .is_some_and(|parts| parts.set_placement_frame(id));
        self.update_parts(world);
        found
    }

    /// Sets or clears HAS_PHYSICS_BSP by the parts (`CacheHasPhysicsBSP`).
    pub fn cache_has_physics_bsp(&mut self) {
        let has = self
            .body
            .part_array
            .as_ref()
            .is_some_and(|parts| parts.has_physics_bsp());
        self.body.state.set(PhysicsState::HAS_PHYSICS_BSP, has);
    }
}
