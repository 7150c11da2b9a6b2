//! Game entities: what the server says about objects, ordered by stamps and applied to the world (`spec/10-messages.md`, 3 to 5).
//!
//! Every object has nine counters; a message acts only if its counter is newer than the stored one. Messages are applied at the start of
//! a frame, before input, each completely before the next. The local player moves itself: ordinary echoes of its own position and
//! movement change nothing; a teleport, a forced position and a movement of the server do.

mod character;
mod description;
mod waiting;

use std::collections::BTreeMap;

use description::{
    change_parts, is_finite, movement_of, physics_description, take_weenie, valid_place,
};
pub use waiting::{Waiting, WaitingLimits};

use super::messages::movement::SequencedMovement;
use super::messages::obj_desc::ObjDesc;
use super::messages::object as m;
use super::messages::physics_desc::PhysicsDesc;
use super::messages::position::{PositionPack, PositionStamps};
use super::messages::weenie_desc::WeenieDesc;
use super::messages::{GameEvent, PlainServerMessage, ServerMessage};
use crate::entity::{Entity, Timestamps};
use crate::math::{Position, Vec3};
use crate::motion::Character;
use crate::physics::attachment::Attachment;
use crate::physics::body::EntityId;
use crate::physics::network::{MovementVerdict, Stamp, is_newer};
use crate::physics::placement::{PlacementFlags, SetPosition, SetPositionError};
use crate::world::World;

/// An object that the server has described.
#[derive(Debug, Clone, PartialEq)]
pub struct GameEntity {
    /// Its body in the world.
    pub id: EntityId,
    /// Appearance.
    pub appearance: ObjDesc,
    /// Game description.
    pub weenie: WeenieDesc,
}

/// Why a message had no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dropped {
    /// The object, or its parent, is not known.
    Unknown,
    /// The message is of a later incarnation of the object.
    LaterIncarnation,
    /// The message is of an earlier incarnation of the object.
    EarlierIncarnation,
    /// A counter is not newer than the stored one.
    Old(Stamp),
    /// A movement of the player's own input.
    Echo,
    /// A place, a velocity or a movement that is none.
    Invalid,
    /// The object's setup cannot be had.
    NoObject,
    /// The object cannot be attached there.
    NotAttachable,
    /// The local player is not deleted.
    LocalPlayer,
    /// The player cannot be put where the server says; it stays in portal space.
    NoRoom,
}

/// What a message did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It was applied.
    Applied,
    /// It was not.
    Dropped(Dropped),
    /// Its object is not known yet: it waits for the description.
    Kept,
    /// It is not about objects.
    Other,
}

/// What the host has to do because of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Notice {
    /// The player is known now.
    Player(EntityId),
    /// The server moves the player: `CommandInterpreter::lose_control_to_server`.
    LostControl,
    /// The player was put somewhere; a position report with the new counter is due.
    ForcedPosition,
    /// The player is in portal space until its surroundings are loaded and LoginComplete is sent.
    PortalSpace,
    /// The server says who moves the player: `CommandInterpreter::set_autonomy_level`.
    Autonomy(u32),
}

/// All objects that the server has described, by GUID.
#[derive(Debug, Default)]
pub struct GameEntities {
    table: BTreeMap<u32, GameEntity>,
    player: Option<u32>,
    character: Option<Character>,
    autonomous_player: bool,
    in_portal_space: bool,
    has_arrived: bool,
    waiting: Waiting,
    /// What the host has to do, in order; the host empties the list.
    pub notices: Vec<Notice>,
}

type Result<T = ()> = core::result::Result<T, Dropped>;

impl GameEntities {
    /// No objects; the player decides its own positions (autonomy level 2).
    pub fn new() -> Self {
        Self {
            autonomous_player: true,
            ..Self::default()
        }
    }

    /// An object.
    pub fn get(&self, guid: u32) -> Option<&GameEntity> {
        self.table.get(&guid)
    }

    /// All objects, by GUID.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (u32, &GameEntity)> {
        self.table.iter().map(|(&guid, entity)| (guid, entity))
    }

    /// GUID of the local player, once the server has named it.
    pub const fn player(&self) -> Option<u32> {
        self.player
    }

    /// Whether movement reports rest until the surroundings are loaded.
    pub const fn in_portal_space(&self) -> bool {
        self.in_portal_space
    }

    /// Whether the place is known to which the player goes through portal space.
    pub const fn has_arrived(&self) -> bool {
        self.has_arrived
    }

    /// The surroundings are loaded; the host sends LoginComplete.
    pub const fn leave_portal_space(&mut self) {
        self.in_portal_space = false;
        self.has_arrived = false;
    }

    /// Messages that wait for their object.
    pub const fn waiting(&self) -> &Waiting {
        &self.waiting
    }

    /// Applies a message to the world: completely, or not at all.
    ///
    /// What is about an object that is not known, or about a later incarnation of one, waits for the description (section 3).
    pub fn apply(&mut self, message: &ServerMessage, world: &mut World) -> Verdict {
        let message = match message {
            ServerMessage::Plain(message) => message,
            ServerMessage::Property(update) => return self.take_property(update, world),
            ServerMessage::Event { event, .. } => {
                if let GameEvent::PlayerDescription(about) = event {
                    self.take_character(about, world);
                    return Verdict::Applied;
                }
                return Verdict::Other;
            }
        };
        let verdict = self.apply_or_keep(message, world);
        if let (Verdict::Applied, Some(guid)) = (verdict, waiting::describes(message)) {
            for late in self.waiting.take(guid) {
                self.apply_or_keep(&late, world);
            }
        }
        verdict
    }

    fn apply_or_keep(&mut self, message: &PlainServerMessage, world: &mut World) -> Verdict {
        let dropped = match self.apply_plain(message, world) {
            Some(Ok(())) => return Verdict::Applied,
            None => return Verdict::Other,
            Some(Err(dropped)) => dropped,
        };
        let early = matches!(dropped, Dropped::Unknown | Dropped::LaterIncarnation);
        let waits_for = waiting::waits_for(message, |guid| self.table.contains_key(&guid));
        match waits_for.filter(|_| early) {
            Some(guid) if self.waiting.keep(guid, message) => Verdict::Kept,
            _ => Verdict::Dropped(dropped),
        }
    }

    fn apply_plain(&mut self, message: &PlainServerMessage, world: &mut World) -> Option<Result> {
        use PlainServerMessage as P;
        Some(match message {
            P::CreateObject(o) | P::UpdateObject(o) => self.describe(o, world),
            P::PlayerCreate(m::Guid { guid }) => {
                self.name_player(*guid, world);
                Ok(())
            }
            P::DeleteObject(d) => self.delete(d, world),
            P::UpdatePosition(p) => self.position_event(p.guid, &p.position, world),
            P::PositionAndMovement(p) => {
                let instance = p.position.stamps.instance;
                // Each half has counters of its own; the movement counts although the place may not.
                let place = self.position_event(p.guid, &p.position, world);
                let movement = self.movement_event(p.guid, instance, &p.movement, world);
                place.or(movement)
            }
            P::ParentEvent(p) => self.parent_event(p, world),
            P::PickupEvent(p) => self.pickup(p, world),
            P::SetState(s) => self.set_state(s, world),
            P::UpdateMotion(u) => self.movement_event(u.guid, u.instance, &u.movement, world),
            P::VectorUpdate(v) => self.vectors(v, world),
            P::PlayerTeleport(t) => self.teleport(t.stamp, world),
            P::AutonomyLevel(a) => {
                if a.level > 2 {
                    return Some(Err(Dropped::Invalid));
                }
                self.autonomous_player = a.level == 2;
                self.notices.push(Notice::Autonomy(a.level));
                Ok(())
            }
            P::ObjDescEvent(o) => self.appearance(o, world),
            P::InventoryRemoveObject(m::Guid { guid }) => self.remove_item(*guid, world),
            _ => return None,
        })
    }

    /// Forgets the objects that have been out of sight for 25 s.
    pub fn forget_unseen(&mut self, world: &mut World) {
        for id in world.due_for_destruction() {
            if world.local_player != Some(id) {
                self.table.retain(|_, e| e.id != id);
                world.delete_entity(id);
            }
        }
    }

    fn is_player(&self, guid: u32) -> bool {
        self.player == Some(guid)
    }

    /// The instance check: first step of every message with an instance stamp.
    fn check(&self, guid: u32, instance: u16, world: &World) -> Result<EntityId> {
        let id = self.table.get(&guid).ok_or(Dropped::Unknown)?.id;
        let stored = stamps(id, world)?.0[Stamp::Instance as usize];
        if instance == stored {
            Ok(id)
        } else if is_newer(stored, instance) {
            Err(Dropped::LaterIncarnation)
        } else {
            Err(Dropped::EarlierIncarnation)
        }
    }

    fn describe(&mut self, o: &m::ObjectDescription, world: &mut World) -> Result {
        if !is_finite(&o.physics) {
            return Err(Dropped::Invalid);
        }
        let instance = o.physics.timestamps[Stamp::Instance as usize];
        match self.check(o.guid, instance, world) {
            Ok(id) => self.update(id, o, world),
            Err(Dropped::Unknown) => self.create(o, world),
            Err(Dropped::LaterIncarnation) => {
                if let Some(old) = self.table.remove(&o.guid) {
                    world.delete_entity(old.id);
                }
                self.create(o, world)
            }
            Err(dropped) => Err(dropped),
        }
    }

    fn create(&mut self, o: &m::ObjectDescription, world: &mut World) -> Result {
        let p = &o.physics;
        let setup = p.fields.setup.unwrap_or(0);
        let id = world
            .make_object(setup, o.guid, true)
            .map_err(|_| Dropped::NoObject)?;
        world.entities.register(id, o.guid);
        let entity = GameEntity {
            id,
            appearance: o.appearance.clone(),
            weenie: o.weenie.clone(),
        };
        self.table.insert(o.guid, entity);
        if self.is_player(o.guid) {
            self.name_player(o.guid, world);
        }
        let parent = p.fields.parent.and_then(|(guid, location)| {
            let parent = self.table.get(&guid)?.id;
            Some((parent, location))
        });
        world.with_entity(id, |e, world| {
            take_weenie(e, &o.weenie);
            if !o.appearance.parts.is_empty() {
                change_parts(e, &o.appearance, world);
            }
            e.set_description(&physics_description(p), world);
            if let Some(update) = movement_of(p).and_then(|(data, _)| data.update().ok()) {
                e.apply_movement_update(update, world);
            }
            // A parent wins over a place; one that is not known yet leaves the object without cell.
            match (p.fields.parent, &p.fields.position) {
                (Some(_), _) => {
                    if let Some((parent, location)) = parent {
                        e.set_parent(parent, Attachment::Location(location as i32), world);
                    }
                }
                (None, Some(place)) => {
                    e.enter_world_at(&place.to_position(), true, world);
                }
                (None, None) => {}
            }
        });
        self.attach_children(id, p, world);
        Ok(())
    }

    /// Replaces the appearance. Shapes of parts count for collisions; a part that is not named has the setup's shape again.
    fn dress(&mut self, guid: u32, appearance: &ObjDesc, world: &mut World) {
        let Some(entity) = self.table.get_mut(&guid) else {
            return;
        };
        entity.appearance = appearance.clone();
        world.with_entity(entity.id, |e, world| {
            change_parts(e, appearance, world);
        });
    }

    /// Children that are known already; those that come later bring their own parent.
    fn attach_children(&self, parent: EntityId, p: &PhysicsDesc, world: &mut World) {
        for &(guid, location) in p.fields.children.iter().flat_map(|list| &list.0) {
            let Some(child) = self.table.get(&guid) else {
                continue;
            };
            world.with_entity(child.id, |e, world| {
                if e.parent() != Some(parent) {
                    e.set_parent(parent, Attachment::Location(location as i32), world);
                }
            });
        }
    }

    /// A description of a known object: each group follows its own counter, the game description always.
    fn update(&mut self, id: EntityId, o: &m::ObjectDescription, world: &mut World) -> Result {
        let (p, guid) = (&o.physics, o.guid);
        let of = |stamp: Stamp| p.timestamps[stamp as usize];
        if let Some(entity) = self.table.get_mut(&guid) {
            entity.weenie = o.weenie.clone();
        }
        if event(id, Stamp::Description, of(Stamp::Description), world) {
            self.dress(guid, &o.appearance, world);
        }
        world.with_entity(id, |e, _| take_weenie(e, &o.weenie));
        self.give_character(world);
        if event(id, Stamp::State, of(Stamp::State), world) {
            world.with_entity(id, |e, world| e.set_state(p.state, world));
        }
        let instance = of(Stamp::Instance);
        if let Some(place) = p.fields.position {
            let stamps = PositionStamps {
                instance,
                position: of(Stamp::Position),
                teleport: of(Stamp::Teleport),
                force: of(Stamp::ForcePosition),
            };
            // A description does not tell contact: the place is followed.
            let _ = self.position_event(guid, &PositionPack::new(place, true, stamps), world);
        }
        if let Some((data, autonomous)) = movement_of(p) {
            let movement = SequencedMovement {
                movement: of(Stamp::Movement),
                server_control: of(Stamp::ServerControl),
                autonomous: u8::from(autonomous != 0),
                data: data.clone(),
            };
            let _ = self.movement_event(guid, instance, &movement, world);
        }
        let vectors = m::VectorUpdate {
            guid,
            velocity: p.fields.velocity.unwrap_or_default(),
            omega: p.fields.omega.unwrap_or_default(),
            instance,
            stamp: of(Stamp::Vector),
        };
        let _ = self.vectors(&vectors, world);
        Ok(())
    }

    fn name_player(&mut self, guid: u32, world: &mut World) {
        self.player = Some(guid);
        world.local_player = self.table.get(&guid).map(|e| e.id);
        self.give_character(world);
        if let Some(id) = world.local_player {
            self.notices.push(Notice::Player(id));
        }
    }

    fn delete(&mut self, d: &m::DeleteObject, world: &mut World) -> Result {
        match self.check(d.guid, d.instance, world) {
            Ok(_) | Err(Dropped::LaterIncarnation) => {}
            Err(dropped) => return Err(dropped),
        }
        if self.is_player(d.guid) {
            return Err(Dropped::LocalPlayer);
        }
        if let Some(entity) = self.table.remove(&d.guid) {
            world.delete_entity(entity.id);
        }
        Ok(())
    }

    /// A position event (5.2).
    fn position_event(&mut self, guid: u32, pack: &PositionPack, world: &mut World) -> Result {
        let s = pack.stamps;
        let id = self.check(guid, s.instance, world)?;
        let velocity = pack.velocity.unwrap_or_default();
        let position = valid_place(&pack.position, world).ok_or(Dropped::Invalid)?;
        if !velocity.iter().all(|v| v.is_finite()) {
            return Err(Dropped::Invalid);
        }
        let stored = stamps(id, world)?.0;
        let (teleport, force) = (
            stored[Stamp::Teleport as usize],
            stored[Stamp::ForcePosition as usize],
        );
        let player = self.is_player(guid);
        if player && is_newer(force, s.force) && !is_newer(s.teleport, teleport) {
            event(id, Stamp::ForcePosition, s.force, world);
            event(id, Stamp::Position, s.position, world);
            event(id, Stamp::Teleport, s.teleport, world);
            world.with_entity(id, |e, world| {
                e.stop_interpolating();
                e.set_position_simple(&position, true, world);
                e.apply_current_movement(false, world);
            });
            self.notices.push(Notice::ForcedPosition);
            return Ok(());
        }
        if !event(id, Stamp::Position, s.position, world) {
            return Err(Dropped::Old(Stamp::Position));
        }
        if is_newer(s.teleport, teleport) {
            return Err(Dropped::Old(Stamp::Teleport));
        }
        if player && self.autonomous_player {
            return self.place_player(id, &position, s.teleport, world);
        }
        world.with_entity(id, |e, world| {
            e.unset_parent(world);
            e.move_or_teleport(&position, s.teleport, pack.contact(), world);
            let animated = e.part_array().is_some_and(|p| p.motion_table_id() != 0);
            if let Some(placement) = pack.placement.filter(|&id| id != 0 && !animated) {
                e.set_placement_frame(placement as i32, world);
            }
        });
        Ok(())
    }

    /// A position of the player that decides its own: only a teleport moves it.
    fn place_player(
        &mut self,
        id: EntityId,
        place: &Position,
        teleport: u16,
        world: &mut World,
    ) -> Result {
        if !event(id, Stamp::Teleport, teleport, world) {
            return Ok(());
        }
        let placed = world.with_entity(id, |e, world| {
            e.unset_parent(world);
            e.teleport_hook(world);
            let flags = PlacementFlags::TELEPORT | PlacementFlags::DONT_CREATE_CELLS;
            let mut placed = e.set_position(&SetPosition::new(*place, flags), world);
            if placed != SetPositionError::Ok {
                // A placement is exact, and the server's place may be on the edge of a cell: beside it is better than where the player was.
                placed = e.set_position_simple(place, true, world);
            }
            e.set_velocity(Vec3::ZERO, world);
            placed
        });
        self.enter_portal_space();
        self.has_arrived = placed == Some(SetPositionError::Ok);
        if self.has_arrived {
            Ok(())
        } else {
            Err(Dropped::NoRoom)
        }
    }

    fn enter_portal_space(&mut self) {
        if !self.in_portal_space {
            self.in_portal_space = true;
            self.has_arrived = false;
            self.notices.push(Notice::PortalSpace);
        }
    }

    /// A movement event (5.3).
    fn movement_event(
        &mut self,
        guid: u32,
        instance: u16,
        movement: &SequencedMovement,
        world: &mut World,
    ) -> Result {
        let id = self.check(guid, instance, world)?;
        let update = movement.data.update().map_err(|_| Dropped::Invalid)?;
        if !movement.data.is_finite() {
            return Err(Dropped::Invalid);
        }
        let autonomous = movement.autonomous != 0;
        let player = self.is_player(guid);
        let done = world.with_entity(id, |e, world| {
            let (mv, sc) = (movement.movement, movement.server_control);
            if !is_newer(e.timestamps.0[Stamp::Movement as usize], mv) {
                return Err(Dropped::Old(Stamp::Movement));
            }
            match e.accept_movement(mv, sc, autonomous, world) {
                MovementVerdict::Unpack => {
                    e.apply_movement_update(update, world);
                    Ok(())
                }
                MovementVerdict::Drop if autonomous && player => Err(Dropped::Echo),
                MovementVerdict::Drop => Err(Dropped::Old(Stamp::ServerControl)),
            }
        });
        done.unwrap_or(Err(Dropped::Unknown))?;
        if player {
            self.notices.push(Notice::LostControl);
        }
        Ok(())
    }

    fn parent_event(&mut self, p: &m::ParentEvent, world: &mut World) -> Result {
        let parent = self.check(p.parent, p.parent_instance, world)?;
        let child = self.table.get(&p.child).ok_or(Dropped::Unknown)?.id;
        if !event(child, Stamp::Position, p.child_position, world) {
            return Err(Dropped::Old(Stamp::Position));
        }
        let attached = world.with_entity(child, |e, world| {
            let attached = e.set_parent(parent, Attachment::Location(p.location as i32), world);
            if attached {
                e.set_placement_frame(p.placement as i32, world);
            }
            attached
        });
        attached
            .unwrap_or(false)
            .then_some(())
            .ok_or(Dropped::NotAttachable)
    }

    fn pickup(&mut self, p: &m::PickupEvent, world: &mut World) -> Result {
        let id = self.check(p.guid, p.instance, world)?;
        if !event(id, Stamp::Position, p.position, world) {
            return Err(Dropped::Old(Stamp::Position));
        }
        world.with_entity(id, |e, world| {
            e.unset_parent(world);
            e.leave_world(world);
        });
        Ok(())
    }

    fn set_state(&mut self, s: &m::SetState, world: &mut World) -> Result {
        let id = self.check(s.guid, s.instance, world)?;
        if !event(id, Stamp::State, s.stamp, world) {
            return Err(Dropped::Old(Stamp::State));
        }
        world.with_entity(id, |e, world| e.set_state(s.state, world));
        Ok(())
    }

    fn vectors(&mut self, v: &m::VectorUpdate, world: &mut World) -> Result {
        let id = self.check(v.guid, v.instance, world)?;
        if !v.velocity.iter().chain(&v.omega).all(|x| x.is_finite()) {
            return Err(Dropped::Invalid);
        }
        if !event(id, Stamp::Vector, v.stamp, world) {
            return Err(Dropped::Old(Stamp::Vector));
        }
        if self.is_player(v.guid) && self.autonomous_player {
            return Ok(());
        }
        world.with_entity(id, |e, world| {
            e.set_velocity(Vec3::from_array(v.velocity), world);
            e.kin.omega = Vec3::from_array(v.omega);
        });
        Ok(())
    }

    /// PlayerTeleport: the stamp is looked at and not stored, or the position that follows would not be newer.
    fn teleport(&mut self, stamp: u16, world: &mut World) -> Result {
        let id = world.local_player.ok_or(Dropped::Unknown)?;
        if is_newer(stamp, stamps(id, world)?.0[Stamp::Teleport as usize]) {
            return Err(Dropped::Old(Stamp::Teleport));
        }
        world.with_entity(id, |e, world| e.cancel_moveto(world));
        self.enter_portal_space();
        Ok(())
    }

    fn appearance(&mut self, o: &m::ObjDescEvent, world: &mut World) -> Result {
        let id = self.check(o.guid, o.instance, world)?;
        if !event(id, Stamp::Description, o.stamp, world) {
            return Err(Dropped::Old(Stamp::Description));
        }
        self.dress(o.guid, &o.appearance, world);
        Ok(())
    }

    fn remove_item(&mut self, guid: u32, world: &mut World) -> Result {
        let id = self.table.get(&guid).ok_or(Dropped::Unknown)?.id;
        let carried = |e: &Entity| e.body.cell.is_none() && e.body.parent.is_none();
        if world.entity(id).is_some_and(carried) && !self.is_player(guid) {
            self.table.remove(&guid);
            world.delete_entity(id);
        }
        Ok(())
    }
}

fn stamps(id: EntityId, world: &World) -> Result<Timestamps> {
    world
        .entity(id)
        .map(|e| e.timestamps)
        .ok_or(Dropped::Unknown)
}

/// Stores a counter if it is newer.
fn event(id: EntityId, stamp: Stamp, value: u16, world: &mut World) -> bool {
    world
        .entity_mut(id)
        .is_some_and(|e| e.timestamps.newer_event(stamp, value))
}

#[cfg(test)]
mod tests;
