//! Objects that are made otherwise than by one data id: without parts at first, of particles, or as a copy for the interface
//! (`spec/06-physics-object.md`, G1).

use crate::animation::{PartArray, PartArrayError};
use crate::entity::Entity;
use crate::math::Sphere;
use crate::physics::body::EntityId;
use crate::physics::lifecycle::RESTING;
use crate::physics::state::PhysicsState;
use crate::world::World;

impl World {
    /// Makes an object without parts under a GUID, outside the world and not yet in the object table (`makeNullObject`). It can be in no cell
    /// until [`Entity::init_null_object`] gives it parts.
    pub fn make_null_object(&mut self, guid: u32, dynamic: bool) -> EntityId {
        let mut entity = self.entities.create(guid, self.clock.now);
        entity.body.state.set(PhysicsState::STATIC, !dynamic);
        let id = entity.id;
        self.entities.put(entity);
        id
    }

    /// Makes a particle object of `count` empty parts without a GUID (`makeParticleObject`). It collides with nothing, has one shadow in its
    /// own cell, and its size there is `sorting` (own space, m).
    ///
    /// # Errors
    /// No parts, or more than any emitter has.
    pub fn make_particle_object(
        &mut self,
        count: usize,
        sorting: Sphere,
    ) -> Result<EntityId, PartArrayError> {
        let parts = PartArray::particle(count)?.with_sorting_sphere(sorting);
        let id = self.make_null_object(0, false);
        if let Some(entity) = self.entities.get_mut(id) {
            entity.body.state |= PhysicsState::PARTICLE_EMITTER;
            entity.body.part_array = Some(parts);
        }
        Ok(id)
    }

    /// Makes an object like another one, without a GUID, for the interface (`makeObject` with a template): its parts, and its looks. `None` if
    /// the template is taken out, is gone, or has no parts.
    pub fn make_examination_object(&mut self, template: EntityId) -> Option<EntityId> {
        let template = self.entity(template)?;
        let parts = template.body.part_array.clone()?;
        let (translucency, original) = (template.translucency, template.translucency_original);
        let id = self.make_null_object(0, true);
        let profile = &self.profile;
        let entity = self.entities.get_mut(id)?;
        let mut own = parts;
        // What the template was playing and waiting for is not taken over.
        own.motion_table = None;
        own.hooks.clear();
        own.sequence.clear_animations();
        own.set_placement_frame(RESTING);
        own.update_parts(&entity.body.position.frame, profile);
        entity.body.part_array = Some(own);
        entity.cache_has_physics_bsp();
        (entity.translucency, entity.translucency_original) = (translucency, original);
        entity.examination_object = true;
        Some(id)
    }
}

impl Entity {
    /// Gives an object the parts of a data id (`InitNullObject`). Where there were parts already, these are replaced, and only then the
    /// setup's default motion table takes effect.
    ///
    /// # Errors
    /// The shape or setup cannot be had; the object keeps what it had.
    pub fn init_null_object(
        &mut self,
        data_id: u32,
        world: &mut World,
    ) -> Result<(), PartArrayError> {
        let had_parts = self.body.part_array.is_some();
        self.init_part_array(data_id, world)?;
        let parts = self.body.part_array.as_ref();
        let table = parts
            .and_then(|p| p.setup())
            .map_or(0, |s| s.default_motion_table);
        if had_parts && table != 0 {
            self.set_motion_table(table, world);
        }
        self.set_placement_frame(RESTING, world);
        Ok(())
    }
}
