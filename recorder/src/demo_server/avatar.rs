//! The client's player in the server's simulation (`spec/10-messages.md`, 6.1; `spec/08-motion.md`, 14.5).

use ac_client::entity::{Entity, Weenie};
use ac_client::math::{CellId, Position, Quat, Vec3};
use ac_client::motion::Character;
use ac_client::net::messages::action::ReportStamps;
use ac_client::net::messages::common::WirePosition;
use ac_client::net::messages::{GameAction, PlainServerMessage as P};
use ac_client::net::transport::Queue;
use ac_client::physics::body::{EntityId, WeenieFlags};
use ac_client::physics::network::{Stamp, is_newer};
use ac_client::physics::placement::{PlacementFlags, SetPosition, SetPositionError};
use ac_client::world::World;
use ac_golden_traces::scene::{EntityKind, EntitySpec};
use ac_replayer::client::SceneRun;

use super::describe::{STAMINA, STRENGTH};
use super::{DemoConfig, DemoError, DemoNote, DemoServer, GUEST};

/// Whom the client plays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Played {
    /// A player that the scene does not know, near its first entity.
    Guest,
    /// An entity of the scene: its script moves it, as a server moves a player. The client's keys do not count, so that the scene stays what
    /// it is; where the client says it is is compared.
    Entity(u32),
}

/// Whose position of the player counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Authority {
    /// The client's: the server puts the player where it is reported, up to 10 m away.
    Client,
    /// The server's: it walks the player itself, and puts the client right when a report is further away than this, m.
    Server(f32),
}

/// Reports further away than this are not believed, m.
const BELIEVED: f32 = 10.0;

impl Default for Authority {
    fn default() -> Self {
        Self::Server(1.0)
    }
}

/// When a report was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Age {
    /// Before the last correction: its keys count, its place does not.
    BeforeCorrection,
    /// After everything that the server has done to the player.
    Current,
}

/// The player's body and what the client has reported.
#[derive(Debug)]
pub(super) struct Avatar {
    pub id: EntityId,
    pub spec: EntitySpec,
    guest: bool,
    /// The client is in portal space: its reports do not count.
    pub teleporting: bool,
    /// Its motion was last changed by its own input.
    pub autonomous: bool,
    last_action: u32,
    /// The last move was a jump that the next frame shows.
    pub jumped: bool,
}

/// Setup and motion table of a guest, and its state word.
const GUEST_SETUP: u32 = 0x0200_0001;
const GUEST_MOTIONS: u32 = 0x0900_0001;

impl Avatar {
    pub fn new(config: &DemoConfig, run: &mut SceneRun) -> Result<Self, DemoError> {
        let scene = config.scene.name.clone();
        let (id, spec, guest) = match config.played {
            Played::Entity(guid) => {
                let spec = config.scene.entities.iter().find(|e| e.guid == guid);
                let found = spec.and_then(|spec| Some((run.object(guid)?, *spec)));
                let (id, spec) = found.ok_or(DemoError::NoPlayer { scene, guid })?;
                (id, spec, false)
            }
            Played::Guest => {
                let (id, spec) = guest(config, run).ok_or(DemoError::NoRoom { scene })?;
                (id, spec, true)
            }
        };
        Ok(Self {
            id,
            spec,
            guest,
            teleporting: false,
            autonomous: false,
            last_action: 0,
            jumped: false,
        })
    }

    /// A guest's callbacks of the frame before are forgotten; the scene does that for its own.
    pub fn begin_frame(&self, world: &mut World) {
        if let Some(entity) = world.entity_mut(self.id).filter(|_| self.guest) {
            entity.begin_frame();
        }
    }
}

/// Places beside the first entity where a guest may stand, m.
const BESIDE: [(f32, f32); 5] = [
    (-4.0, -2.0),
    (4.0, -2.0),
    (0.0, -4.0),
    (0.0, 4.0),
    (1.5, 0.0),
];

fn guest(config: &DemoConfig, run: &mut SceneRun) -> Option<(EntityId, EntitySpec)> {
    let first = config.scene.entities.first()?;
    let world = &mut run.world;
    let id = world.make_object(GUEST_SETUP, GUEST, true).ok()?;
    world.entities.register(id, GUEST);
    if let Some(entity) = world.entity_mut(id) {
        entity.body.weenie = WeenieFlags {
            present: true,
            player: true,
            creature: true,
            ..WeenieFlags::default()
        };
        entity.weenie = Some(Weenie {
            character: Some(Character {
                local_player: true,
                strength: STRENGTH as i32,
                run_skill: Some(config.abilities.run.into()),
                jump_skill: Some(config.abilities.jump.into()),
                stamina: Some(STAMINA),
                ..Character::default()
            }),
            ..Weenie::default()
        });
    }
    let near = |(x, y): (f32, f32)| {
        let mut spec = *first;
        spec.position.origin[0] += x;
        spec.position.origin[1] += y;
        spec.position
    };
    let place = world.with_entity(id, |entity, world| {
        entity.set_motion_table(GUEST_MOTIONS, world);
        entity.set_state(Entity::DEFAULT_STATE, world);
        BESIDE.into_iter().map(near).find(|spec| {
            let [w, x, y, z] = spec.rotation;
            let rotation = Quat::new(w, x, y, z);
            let wanted = Position::new(CellId(spec.cell), Vec3::from(spec.origin), rotation);
            let entered = entity.enter_world_at(&wanted, true, world);
            entered && entity.body.cell.is_some()
        })
    })??;
    let spec = EntitySpec {
        guid: GUEST,
        kind: EntityKind::Player,
        setup: GUEST_SETUP,
        motion_table: GUEST_MOTIONS,
        scale: 1.0,
        position: place,
        state: Entity::DEFAULT_STATE,
        parent: None,
        ..*first
    };
    Some((id, spec))
}

impl DemoServer {
    /// A movement message of the client.
    pub(super) fn take_movement(&mut self, action: &GameAction) {
        let (position, stamps) = match action {
            GameAction::MoveToState(m) => (m.position, m.stamps),
            GameAction::AutonomousPosition(a) => (a.position, a.stamps),
            GameAction::Jump(j) => (j.position, j.stamps),
            _ => return,
        };
        self.stats.reports += 1;
        let Some(age) = self.age_of(stamps) else {
            return;
        };
        let id = self.avatar.id;
        match action {
            _ if !self.avatar.guest => {}
            GameAction::MoveToState(m) => {
                let last_action = &mut self.avatar.last_action;
                self.run.world.with_entity(id, |player, world| {
                    player.apply_raw_state(m.state.state(), m.bits & 2 != 0, last_action, world);
                });
                self.avatar.autonomous = true;
            }
            GameAction::Jump(j) => {
                self.run.world.with_entity(id, |player, world| {
                    player.kin.last_move_was_autonomous = true;
                    // A refused jump shows in the position.
                    let _ = player.jump(j.extent, world);
                });
                self.avatar.jumped = true;
            }
            _ => {}
        }
        if age == Age::Current {
            self.judge(&position);
        }
    }

    /// When a report was made; `None` if it is of another life of the player, or from before a teleport.
    fn age_of(&self, stamps: ReportStamps) -> Option<Age> {
        let known = self.known.iter().find(|known| known.id == self.avatar.id)?;
        let stored = |stamp: Stamp| known.stamps[stamp as usize];
        let same_life = stamps.instance == stored(Stamp::Instance);
        let here = !is_newer(stamps.teleport, stored(Stamp::Teleport));
        if self.avatar.teleporting || !same_life || !here {
            return None;
        }
        let old = is_newer(stamps.force, stored(Stamp::ForcePosition));
        Some(if old {
            Age::BeforeCorrection
        } else {
            Age::Current
        })
    }

    /// Compares where the client says it is with where it is.
    fn judge(&mut self, place: &WirePosition) {
        let reported = place.to_position();
        let valid = reported.cell.is_inbound_valid()
            && reported.frame.is_valid(&self.config.profile)
            && place
                .origin
                .iter()
                .chain(&place.rotation)
                .all(|v| v.is_finite());
        let Some(here) = self.run.world.entity(self.avatar.id) else {
            return;
        };
        let distance = if valid {
            here.body.position.distance(&reported)
        } else {
            f32::INFINITY
        };
        match self.config.authority {
            Authority::Server(over) if distance > over => self.correct(distance),
            Authority::Client if distance > BELIEVED => self.correct(distance),
            Authority::Client if distance > 0.0 => self.follow(reported),
            _ => {}
        }
    }

    /// The server's position counts: the client is told, with a newer counter.
    fn correct(&mut self, distance: f32) {
        let now = self.run.world.clock.now;
        let Some(entity) = self.run.world.entity(self.avatar.id) else {
            return;
        };
        let Some(known) = self.known.iter_mut().find(|k| k.id == entity.id) else {
            return;
        };
        known.raise(Stamp::ForcePosition);
        let message: P = known.update_position(entity, now);
        self.stats.corrections += 1;
        self.notes.push_back(DemoNote::Corrected(distance));
        self.say(Queue::SMARTBOX, message);
    }

    /// The client's position counts.
    fn follow(&mut self, to: Position) {
        let placed = self.run.world.with_entity(self.avatar.id, |player, world| {
            player.set_position(&SetPosition::new(to, PlacementFlags::SLIDE), world)
        });
        if placed.is_some_and(|result| result != SetPositionError::Ok) {
            self.correct(0.0);
        }
    }
}
