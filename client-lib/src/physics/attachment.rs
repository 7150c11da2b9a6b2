//! Parents and children (`spec/06-physics-object.md`, D4).

use crate::entity::{Child, Entity};
use crate::math::Frame;
use crate::physics::body::{EntityId, ObjectRef};
use crate::physics::membership::MAX_ATTACHMENT_DEPTH;
use crate::physics::state::{PhysicsState, TransientState};
use crate::profile::ChildRemoval;
use crate::world::World;

/// Where a child is attached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Attachment {
    /// To a part ([`Child::NO_PART`]: to the parent itself), at a frame in its space.
    Part {
        /// Part index.
        part: u32,
        /// Place in the part's space.
        frame: Frame,
    },
    /// To a holding location of the parent's setup, by its id.
    Location(i32),
}

impl Entity {
    /// The parent, if it is an entity.
    pub const fn parent(&self) -> Option<EntityId> {
        match self.body.parent {
            Some(ObjectRef::Entity(id)) => Some(id),
            _ => None,
        }
    }

    /// Enters a child in the list (`add_child`); `false` when it cannot be attached there.
    fn add_child(&mut self, child: EntityId, attachment: Attachment) -> bool {
        let Some(parts) = self.body.part_array.as_ref() else {
            let Attachment::Part { part, frame } = attachment else {
                return false;
            };
            if part != Child::NO_PART {
                return false;
            }
            self.children.push(Child {
                object: child,
                frame,
                part,
                location: 0,
            });
            return true;
        };
        let (part, frame, location) = match attachment {
            Attachment::Part { part, frame } => (part, frame, 0),
            Attachment::Location(id) => match parts.holding_location(id) {
                Some(place) => {
                    let frame = Frame::new(place.frame.origin, place.frame.rotation);
                    (place.part as u32, frame, id)
                }
                None => return false,
            },
        };
        let known = part == Child::NO_PART || (part as usize) < parts.parts.len();
        if matches!(attachment, Attachment::Part { .. }) && !known {
            return false;
        }
        self.children.push(Child {
            object: child,
            frame,
            part,
            location,
        });
        true
    }

    /// Attaches this object to `parent` (`set_parent`); `false`, and nothing changes, when that is not possible.
    ///
    /// The object leaves the world, enters its parent's cell, and is moved only by its parent from now on. A carrier of the parent cannot
    /// become its child: retail does not check this and recurses without end.
    pub fn set_parent(
        &mut self,
        parent: EntityId,
        attachment: Attachment,
        world: &mut World,
    ) -> bool {
        if parent == self.id || self.carries(parent, world) {
            return false;
        }
        let own = self.id;
        world.with_entity(parent, |holder, world| {
            // Its parts were not placed as long as nobody needed them.
            if std::mem::take(&mut holder.unposed) {
                holder.update_parts(world);
            }
            holder.settle_parts(&world.profile);
        });
        let Some(holder) = world.entity_mut(parent) else {
            return false;
        };
        if !holder.add_child(own, attachment) {
            return false;
        }
        let (examination, hidden) = (
            holder.examination_object,
            holder.body.state.contains(PhysicsState::HIDDEN),
        );
        let by_location = matches!(attachment, Attachment::Location(_));
        if !by_location {
            self.examination_object = examination;
        }
        self.unset_parent(world);
        self.leave_world(world);
        self.body.parent = Some(ObjectRef::Entity(parent));
        if let Some(cell) = world.entity(parent).and_then(|p| p.body.cell) {
            self.change_cell(Some(cell), world);
            self.follow_parent(world);
            self.recalc_cross_cells(world);
        }
        if by_location && hidden {
            self.body.state.insert(PhysicsState::NODRAW);
        }
        true
    }

    /// Whether `id` is carried by this object, directly or not.
    fn carries(&self, id: EntityId, world: &World) -> bool {
        let mut carrier = world.entity(id).and_then(Self::parent);
        for _ in 0..MAX_ATTACHMENT_DEPTH {
            match carrier {
                Some(c) if c == self.id => return true,
                Some(c) => carrier = world.entity(c).and_then(Self::parent),
                None => return false,
            }
        }
        true
    }

    /// Detaches this object from its parent (`unset_parent`). It keeps its cell and place; the caller places it again.
    pub fn unset_parent(&mut self, world: &mut World) {
        let Some(parent) = self.parent() else { return };
        let removal = world.profile.child_removal;
        let own = self.id;
        if let Some(holder) = world.entity_mut(parent) {
            holder.remove_child(own, removal);
            if holder.body.state.contains(PhysicsState::HIDDEN) {
                self.body.state.remove(PhysicsState::NODRAW);
            }
        }
        self.body.parent = None;
        self.kin.update_time = world.clock.now;
        self.clear_transient_states(world);
    }

    fn remove_child(&mut self, child: EntityId, removal: ChildRemoval) {
        match self.children.iter().position(|c| c.object == child) {
            Some(index) => {
                self.children.remove(index);
            }
            None if removal == ChildRemoval::AbsentDropsLast => {
                self.children.pop();
            }
            None => {}
        }
    }

    /// Detaches every child (`unparent_children`).
    pub fn unparent_children(&mut self, world: &mut World) {
        while let Some(child) = self.children.first().copied() {
            let hidden = self.body.state.contains(PhysicsState::HIDDEN);
            self.children.remove(0);
            world.with_entity(child.object, |c, world| {
                if hidden {
                    c.body.state.remove(PhysicsState::NODRAW);
                }
                c.body.parent = None;
                c.kin.update_time = world.clock.now;
                c.clear_transient_states(world);
            });
        }
    }

    /// Where a child of this object is (`UpdateChild`): the part's frame, or the own one, with the attachment's frame in it.
    fn child_frame(&self, child: &Child, world: &World) -> Frame {
        let base = self
            .body
            .part_array
            .as_ref()
            .and_then(|parts| parts.parts.get(child.part as usize)?.as_ref())
            .map_or(&self.body.position.frame, |part| &part.position.frame);
        base.combine(&child.frame, &world.profile)
    }

    /// Moves this object to where its parent carries it.
    fn follow_parent(&mut self, world: &mut World) {
        let own = self.id;
        let place = self.parent().and_then(|id| world.entity(id)).and_then(|p| {
            // The newest entry is the one just made.
            let child = p.children.iter().rfind(|c| c.object == own)?;
            Some(p.child_frame(child, world))
        });
        if let Some(frame) = place {
            self.set_frame(frame, world);
        }
    }

    /// Moves all children to where this object carries them (`UpdateChildrenInternal`).
    pub(crate) fn update_children(&mut self, world: &mut World) {
        if self.children.is_empty() || self.body.part_array.is_none() {
            return;
        }
        for index in 0..self.children.len() {
            let child = self.children[index];
            let frame = self.child_frame(&child, world);
            world.with_entity(child.object, |c, world| c.set_frame(frame, world));
        }
    }

    /// Forgets contact and ground (`clear_transient_states`): all transient bits are clear afterwards.
    pub(crate) fn clear_transient_states(&mut self, world: &mut World) {
        self.kin.transient.remove(TransientState::CONTACT);
        self.kin.calc_acceleration(self.body.state, &world.profile);
        let was_walkable = self.kin.transient.contains(TransientState::ON_WALKABLE);
        self.kin
            .transient
            .remove(TransientState::ON_WALKABLE | TransientState::WATER_CONTACT);
        if was_walkable {
            self.leave_ground(world);
        }
        self.kin.calc_acceleration(self.body.state, &world.profile);
        self.kin.transient.remove(LEAVING_MASK);
    }
}

/// Bits cleared when an object leaves the world (A4.2).
pub(crate) const LEAVING_MASK: TransientState = TransientState::from_bits_retain(0x1F4);
