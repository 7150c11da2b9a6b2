//! What the client has been told about each object, and what it has to be told next.
//!
//! After each frame of the simulation the objects are compared with what was last sent; the differences become messages, with the counters
//! that order them (`spec/10-messages.md`, 3 and 5).

use std::collections::BTreeMap;

use ac_client::entity::Entity;
use ac_client::math::Position;
use ac_client::motion::{Action, Command, InterpretedMotionState};
use ac_client::net::messages::PlainServerMessage as P;
use ac_client::net::messages::movement::{MovementData, SequencedMovement};
use ac_client::net::messages::object as m;
use ac_client::physics::body::EntityId;
use ac_client::physics::network::Stamp;
use ac_client::world::World;
use ac_golden_traces::scene::EntitySpec;

use super::describe::{self, Stamps};

/// An object that the client knows.
#[derive(Debug)]
pub(super) struct Known {
    pub id: EntityId,
    pub spec: EntitySpec,
    pub stamps: Stamps,
    state: u32,
    motion: Option<InterpretedMotionState>,
    moving_to: bool,
    position: Position,
    sent_at: f64,
    /// Position after the frame before: an object that has come to rest is told at once.
    before: Position,
    parent: Option<EntityId>,
    in_world: bool,
    last_action: u32,
}

/// What happened to an object in a frame beside what its state shows.
#[derive(Debug, Default)]
pub(super) struct Hints {
    /// The script did something to it.
    pub scripted: bool,
    /// It was put somewhere.
    pub teleported: bool,
    /// Its velocity was set.
    pub thrown: bool,
    /// It was turned at once.
    pub turned: bool,
    /// It is the client's own player, which does not follow ordinary positions: what the script did to its place is forced on it.
    pub own: bool,
    /// A movement other than a state began.
    pub movement: Option<MovementData>,
    /// It began to stick to an object.
    pub stick_to: Option<u32>,
    /// Actions that it was asked for.
    pub actions: Vec<(Command, f32)>,
    /// Its motion comes from the client's own input.
    pub autonomous: bool,
}

impl Known {
    /// An object and the message that introduces it.
    pub fn introduce(
        entity: &Entity,
        spec: &EntitySpec,
        instance: u16,
        world: &World,
    ) -> (Self, P) {
        let mut stamps = [0; 9];
        stamps[Stamp::Instance as usize] = instance;
        let known = Self {
            id: entity.id,
            spec: *spec,
            stamps,
            state: entity.body.state.bits(),
            motion: describe::state_of(entity),
            moving_to: entity.is_moving_to(),
            position: entity.body.position,
            sent_at: world.clock.now,
            before: entity.body.position,
            parent: entity.parent(),
            in_world: entity.body.cell.is_some(),
            last_action: 0,
        };
        let description = describe::describe(entity, spec, &stamps, world);
        (known, P::CreateObject(Box::new(description)))
    }

    pub const fn guid(&self) -> u32 {
        self.spec.guid
    }

    fn stamp(&self, stamp: Stamp) -> u16 {
        self.stamps[stamp as usize]
    }

    /// Raises a counter.
    pub fn raise(&mut self, stamp: Stamp) -> u16 {
        let value = &mut self.stamps[stamp as usize];
        *value = value.wrapping_add(1);
        *value
    }

    /// Messages about what changed in the frame that has just run.
    pub fn tell(
        &mut self,
        world: &World,
        hints: &Hints,
        interval: f64,
        instances: &BTreeMap<u32, u16>,
        out: &mut Vec<P>,
    ) {
        let Some(entity) = world.entity(self.id) else {
            return;
        };
        self.tell_parent(entity, world, instances, out);
        self.tell_state(entity, out);
        self.tell_motion(entity, hints, out);
        if hints.thrown {
            out.push(P::VectorUpdate(m::VectorUpdate {
                guid: self.guid(),
                velocity: entity.kin.velocity.to_array(),
                omega: entity.kin.omega.to_array(),
                instance: self.stamp(Stamp::Instance),
                stamp: self.raise(Stamp::Vector),
            }));
        }
        self.tell_place(entity, hints, interval, world.clock.now, out);
    }

    fn tell_parent(
        &mut self,
        entity: &Entity,
        world: &World,
        instances: &BTreeMap<u32, u16>,
        out: &mut Vec<P>,
    ) {
        let parent = entity.parent();
        let in_world = entity.body.cell.is_some();
        let new = parent.filter(|_| parent != self.parent);
        if let Some(holder) = new.and_then(|id| world.entity(id)) {
            let location = describe::holding_location(holder);
            out.push(P::ParentEvent(m::ParentEvent {
                parent: holder.guid(),
                child: self.guid(),
                location,
                placement: RESTING,
                parent_instance: instances.get(&holder.guid()).copied().unwrap_or(0),
                child_position: self.raise(Stamp::Position),
            }));
        } else if self.in_world && !in_world {
            out.push(P::PickupEvent(m::PickupEvent {
                guid: self.guid(),
                instance: self.stamp(Stamp::Instance),
                position: self.raise(Stamp::Position),
            }));
        }
        if parent.is_none() && in_world && (self.parent.is_some() || !self.in_world) {
            // It is in the world again, and the client has to see it there.
            self.sent_at = f64::NEG_INFINITY;
            self.before = entity.body.position;
            self.position = Position::default();
        }
        (self.parent, self.in_world) = (parent, in_world);
    }

    fn tell_state(&mut self, entity: &Entity, out: &mut Vec<P>) {
        let state = entity.body.state.bits();
        if state != self.state {
            self.state = state;
            out.push(P::SetState(m::SetState {
                guid: self.guid(),
                state,
                instance: self.stamp(Stamp::Instance),
                stamp: self.raise(Stamp::State),
            }));
        }
    }

    fn tell_motion(&mut self, entity: &Entity, hints: &Hints, out: &mut Vec<P>) {
        let moving_to = entity.is_moving_to();
        let ended = self.moving_to && !moving_to;
        self.moving_to = moving_to;
        let state = describe::state_of(entity);
        let actions = self.new_actions(entity, hints);
        if let Some(data) = &hints.movement {
            self.motion = state;
            return out.push(self.update_motion(data.clone(), false));
        }
        let Some(now) = state else {
            return;
        };
        let changed = self.motion.as_ref() != Some(&now) || ended;
        // A move-to makes its own motions, here and in the client.
        let own = moving_to && hints.stick_to.is_none() && actions.is_empty();
        self.motion = Some(now.clone());
        if own || !(changed || hints.stick_to.is_some() || !actions.is_empty()) {
            return;
        }
        let longjump = entity.interp().is_some_and(|i| i.standing_longjump);
        let data = describe::movement(&now, &actions, hints.stick_to, longjump);
        out.push(self.update_motion(data, hints.autonomous));
    }

    /// The actions of this frame that were accepted, with their numbers.
    fn new_actions(&mut self, entity: &Entity, hints: &Hints) -> Vec<Action> {
        let waiting = entity.interp().map(|interp| &interp.interpreted.actions);
        let accepted = |command| waiting.is_some_and(|w| w.iter().any(|a| a.command == command));
        let mut actions = Vec::new();
        for &(command, speed) in hints.actions.iter().filter(|(c, _)| accepted(*c)) {
            self.last_action = (self.last_action + 1) & 0x7FFF;
            actions.push(Action {
                command,
                speed,
                stamp: self.last_action,
                autonomous: hints.autonomous,
            });
        }
        actions
    }

    fn update_motion(&mut self, data: MovementData, autonomous: bool) -> P {
        let movement = self.raise(Stamp::Movement);
        let server_control = if autonomous {
            self.stamp(Stamp::ServerControl)
        } else {
            self.raise(Stamp::ServerControl)
        };
        P::UpdateMotion(m::UpdateMotion {
            guid: self.guid(),
            instance: self.stamp(Stamp::Instance),
            movement: SequencedMovement {
                movement,
                server_control,
                autonomous: autonomous.into(),
                data,
            },
        })
    }

    fn tell_place(
        &mut self,
        entity: &Entity,
        hints: &Hints,
        interval: f64,
        now: f64,
        out: &mut Vec<P>,
    ) {
        let here = entity.body.position;
        let stopped = here == self.before;
        self.before = here;
        if entity.body.cell.is_none() || entity.parent().is_some() {
            return;
        }
        if hints.teleported {
            self.raise(Stamp::Teleport);
        } else if hints.turned && hints.own {
            self.raise(Stamp::ForcePosition);
        }
        let at_once = hints.teleported || hints.turned;
        let due = stopped || now - self.sent_at >= interval;
        if at_once || here != self.position && due {
            out.push(self.update_position(entity, now));
        }
    }

    /// Where the object is.
    pub fn update_position(&mut self, entity: &Entity, now: f64) -> P {
        self.raise(Stamp::Position);
        self.position = entity.body.position;
        self.sent_at = now;
        P::UpdatePosition(m::UpdatePosition {
            guid: self.guid(),
            position: describe::position_pack(entity, &self.stamps),
        })
    }
}

/// Placement frame of things at rest.
const RESTING: u32 = 0x65;
