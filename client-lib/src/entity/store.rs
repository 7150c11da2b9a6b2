//! The store of entities: handles, creation order, lookup by GUID.

use std::collections::HashMap;

use super::Entity;
use crate::math::Vec3;
use crate::physics::body::{Body, EntityId, ObjectRef};
use crate::world::World;

/// Owns every entity. Handles are never reused; iteration is in order of registration.
///
/// An entity that is being worked on is taken out of the store (a pointer moves) and put back afterwards, so that its functions can have the
/// world as an argument. While it is out, lookups do not find it: what it needs of itself it has.
#[derive(Debug, Default)]
pub struct Entities {
    pub(crate) slots: Vec<Option<Box<Entity>>>,
    /// The object table in order of registration.
    pub(crate) table: Vec<EntityId>,
    /// By handle: is in the table.
    pub(crate) registered: Vec<bool>,
    pub(crate) by_guid: HashMap<u32, EntityId>,
    /// By handle: the clock of an object that rests, s; [`AWAKE`] for the others.
    ///
    /// An object at rest does nothing but keep its clock. So that it is not even looked at, its clock is kept here until somebody takes the
    /// object or changes it; until then its own [`update_time`](super::Kinetics::update_time) is old, and nothing reads it.
    pub(crate) resting: Vec<f64>,
    /// By handle: has ended; its handle names nothing any more.
    pub(crate) gone: Vec<bool>,
    /// Objects that are to end when they are put back, and how.
    pub(crate) ending: Vec<(EntityId, Ending)>,
}

/// How an object ends that was taken out when somebody asked for its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// It leaves the world and goes on existing outside.
    Destroyed,
    /// It is gone.
    Deleted,
}

/// Not a clock.
const AWAKE: f64 = f64::NAN;

impl Entities {
    /// Makes an object (not yet in the object table) whose clock starts at `now`, s, and takes it out at once.
    pub fn create(&mut self, guid: u32, now: f64) -> Box<Entity> {
        let id = EntityId(self.slots.len() as u32);
        self.slots.push(None);
        self.registered.push(false);
        self.resting.push(AWAKE);
        self.gone.push(false);
        Box::new(Entity::new(id, guid, now))
    }

    /// Enters an object in the object table under its GUID; a former holder of the GUID leaves the table.
    pub fn register(&mut self, id: EntityId, guid: u32) {
        if let Some(former) = self.by_guid.insert(guid, id) {
            self.table.retain(|&e| e != former);
            self.mark(former, false);
        }
        self.table.push(id);
        self.mark(id, true);
    }

    /// Takes an object out of the object table. The object goes on existing until [`Entities::remove`].
    pub fn unregister(&mut self, id: EntityId) {
        self.table.retain(|&e| e != id);
        self.by_guid.retain(|_, e| *e != id);
        self.mark(id, false);
    }

    /// The handle that the next object gets.
    pub(crate) fn next_id(&self) -> EntityId {
        EntityId(self.slots.len() as u32)
    }

    /// Moves an object, which is the last of the object table, before the first that `comes_later`.
    pub(crate) fn move_before(&mut self, id: EntityId, comes_later: impl Fn(EntityId) -> bool) {
        let at = self.table.iter().position(|&e| comes_later(e));
        if let Some(at) = at.filter(|_| self.table.last() == Some(&id)) {
            self.table[at..].rotate_right(1);
        }
    }

    fn mark(&mut self, id: EntityId, registered: bool) {
        if let Some(mark) = self.registered.get_mut(id.0 as usize) {
            *mark = registered;
        }
    }

    /// Ends an object's existence.
    pub fn remove(&mut self, id: EntityId) -> Option<Box<Entity>> {
        self.unregister(id);
        if let Some(gone) = self.gone.get_mut(id.0 as usize) {
            *gone = true;
        }
        self.take(id)
    }

    /// Whether an object exists but is taken out.
    pub(crate) fn is_out(&self, id: EntityId) -> bool {
        let index = id.0 as usize;
        matches!(
            (self.slots.get(index), self.gone.get(index)),
            (Some(None), Some(false))
        )
    }

    /// An object that is taken out is to end when it is back.
    pub(crate) fn end_later(&mut self, id: EntityId, ending: Ending) {
        self.ending.push((id, ending));
    }

    /// Takes off one object that is to end and is back.
    fn next_ending(&mut self) -> Option<(EntityId, Ending)> {
        let at = self
            .ending
            .iter()
            .position(|&(id, _)| self.get(id).is_some())?;
        Some(self.ending.remove(at))
    }

    /// Whether an object is in the object table.
    pub fn is_registered(&self, id: EntityId) -> bool {
        self.registered.get(id.0 as usize).copied().unwrap_or(false)
    }

    /// The object table in order of registration.
    pub fn table(&self) -> &[EntityId] {
        &self.table
    }

    /// Handle of a GUID in the object table.
    pub fn id_of(&self, guid: u32) -> Option<EntityId> {
        self.by_guid.get(&guid).copied()
    }

    /// An object, in the table or not; `None` if it is taken out or gone.
    pub fn get(&self, id: EntityId) -> Option<&Entity> {
        self.slots.get(id.0 as usize)?.as_deref()
    }

    /// An object, in the table or not; `None` if it is taken out or gone.
    pub fn get_mut(&mut self, id: EntityId) -> Option<&mut Entity> {
        self.wake(id);
        self.slots.get_mut(id.0 as usize)?.as_deref_mut()
    }

    /// Somebody may change the object: it keeps its clock itself, and no longer counts as standing still.
    #[inline]
    fn wake(&mut self, id: EntityId) {
        if let Some(Some(entity)) = self.slots.get_mut(id.0 as usize) {
            entity.note_stand(false);
        }
        self.end_rest(id);
    }

    /// The object keeps its clock itself.
    #[inline]
    fn end_rest(&mut self, id: EntityId) {
        let Some(clock) = self.resting.get_mut(id.0 as usize) else {
            return;
        };
        if clock.is_nan() {
            return;
        }
        if let Some(Some(entity)) = self.slots.get_mut(id.0 as usize) {
            entity.kin.update_time = *clock;
        }
        *clock = AWAKE;
    }

    /// Takes an object out for its own tick, to be [put](Entities::put) back.
    #[inline]
    pub(crate) fn take_for_tick(&mut self, id: EntityId) -> Option<Box<Entity>> {
        self.end_rest(id);
        self.slots.get_mut(id.0 as usize)?.take()
    }

    /// Has an object forget what was recorded of its last frame; see [`Entity::begin_frame`]. Not a change of the object: it goes on resting,
    /// or standing still.
    #[inline]
    pub fn begin_frame(&mut self, id: EntityId) {
        if let Some(Some(entity)) = self.slots.get_mut(id.0 as usize) {
            entity.begin_frame();
        }
    }

    /// The clock of an object that rests, s.
    #[inline]
    pub(crate) fn resting_since(&self, id: EntityId) -> Option<f64> {
        let clock = self.resting.get(id.0 as usize).copied()?;
        (!clock.is_nan()).then_some(clock)
    }

    /// An object rests, or goes on resting, and its clock stands at `clock`, s.
    #[inline]
    pub(crate) fn rest(&mut self, id: EntityId, clock: f64) {
        if let Some(own) = self.resting.get_mut(id.0 as usize) {
            *own = clock;
        }
    }

    /// How an object looks from the local player, m; it goes on resting if it rests.
    #[inline]
    pub(crate) fn see_from_player(&mut self, id: EntityId, vector: Vec3, distance: f32) {
        if let Some(Some(entity)) = self.slots.get_mut(id.0 as usize) {
            (entity.player_vector, entity.player_distance) = (vector, distance);
        }
    }

    /// Takes an object out, to be [put](Entities::put) back.
    pub fn take(&mut self, id: EntityId) -> Option<Box<Entity>> {
        self.wake(id);
        self.slots.get_mut(id.0 as usize)?.take()
    }

    /// Every object that is not taken out, in the object table or not, in order of creation.
    pub fn iter(&self) -> impl Iterator<Item = &Entity> {
        self.slots.iter().filter_map(Option::as_deref)
    }

    /// Takes in an object of another store under the handle it has there, and enters it in the object table if it was `registered` there.
    /// What was known under that handle ends.
    pub fn adopt(&mut self, entity: Box<Entity>, registered: bool) {
        let (id, guid) = (entity.id, entity.guid());
        let index = id.0 as usize;
        if self.slots.len() <= index {
            self.slots.resize_with(index + 1, || None);
            self.registered.resize(index + 1, false);
            self.gone.resize(index + 1, true);
        }
        self.remove(id);
        if let Some(gone) = self.gone.get_mut(index) {
            *gone = false;
        }
        self.put(entity);
        if registered {
            self.register(id, guid);
        }
    }

    /// Ends the existence of all objects.
    pub fn clear(&mut self) {
        self.slots.iter_mut().for_each(|slot| *slot = None);
        self.registered.fill(false);
        self.gone.fill(true);
        self.ending.clear();
        self.table.clear();
        self.by_guid.clear();
    }

    /// Puts an object back, unless it was [removed](Entities::remove) meanwhile.
    pub fn put(&mut self, entity: Box<Entity>) {
        let index = entity.id.0 as usize;
        if self.gone.get(index).copied().unwrap_or(true) {
            return;
        }
        if let Some(slot) = self.slots.get_mut(index) {
            *slot = Some(entity);
        }
    }
}

impl World {
    /// An entity; `None` if it is taken out at the moment, or gone.
    pub fn entity(&self, id: EntityId) -> Option<&Entity> {
        self.entities.get(id)
    }

    /// An entity; `None` if it is taken out at the moment, or gone.
    pub fn entity_mut(&mut self, id: EntityId) -> Option<&mut Entity> {
        self.catch_up(id);
        self.entities.get_mut(id)
    }

    /// Handle of a GUID in the object table.
    pub fn entity_of_guid(&self, guid: u32) -> Option<EntityId> {
        self.entities.id_of(guid)
    }

    /// Runs `f` on an entity that is taken out for that time; `None` if it is out already, or gone.
    pub fn with_entity<R>(
        &mut self,
        id: EntityId,
        f: impl FnOnce(&mut Entity, &mut Self) -> R,
    ) -> Option<R> {
        self.catch_up(id);
        let mut entity = self.entities.take(id)?;
        let result = f(&mut entity, self);
        self.entities.put(entity);
        self.end_what_waits();
        Some(result)
    }

    /// Ends objects whose end was asked for while they were taken out, now that they are back.
    #[inline]
    pub(crate) fn end_what_waits(&mut self) {
        while !self.entities.ending.is_empty()
            && let Some((id, ending)) = self.entities.next_ending()
        {
            match ending {
                Ending::Destroyed => self.destroy_entity(id),
                Ending::Deleted => self.delete_entity(id),
            }
        }
    }

    /// Place, shape and state of an object; `None` if it is not loaded, or is an entity that is taken out.
    pub fn body(&self, object: ObjectRef) -> Option<&Body> {
        match object {
            ObjectRef::Entity(id) => self.entity(id).map(|e| &e.body),
            ObjectRef::Static(id) => self.land.static_body(id),
        }
    }
}

impl Entity {
    /// Puts a taken-out entity back into the world while `f` runs, so that what `f` calls can find it and call back into it.
    ///
    /// Rare paths only (voyeur updates, notifications): it moves the whole object twice.
    pub fn lend<R>(&mut self, world: &mut World, f: impl FnOnce(&mut World) -> R) -> R {
        let id = self.id;
        let spare = world.scratch.spare_entity.take();
        let mut own = spare.unwrap_or_else(|| Box::new(Self::new(id, 0, 0.0)));
        std::mem::swap(self, &mut own);
        world.entities.put(own);
        let result = f(world);
        if let Some(mut own) = world.entities.take(id) {
            std::mem::swap(self, &mut own);
            world.scratch.spare_entity = Some(own);
        }
        result
    }
}
