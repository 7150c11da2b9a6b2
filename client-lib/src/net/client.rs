//! A complete client without a screen: session, network stage, prediction of the own player, and what it tells the server.
//!
//! Sans-IO: datagrams and times go in, datagrams and happenings come out. [`GameClient::frame`] runs the stages in the order of
//! `spec/10-messages.md`, 9.7: messages, input, reports, entity tick.

use super::actions::ActionWriter;
use super::entities::{Notice, Verdict};
use super::messages::session::{CharacterEntry, CharacterList, EnterWorld};
use super::messages::{
    ClientMessage, GameAction, PlainClientMessage, PlainServerMessage, ServerMessage,
};
use super::session::{
    ClientConfig, ClientEvent, ClientSession, ClientState, SessionFailure, Transmit,
};
use super::stage::NetworkStage;
use super::transport::{Anomaly, LoginError, LoginRequest, Message, Queue};
use crate::frame::{NoHost, NoProbe, Pipeline};
use crate::math::CellId;
use crate::motion::{CommandInterpreter, Outgoing, Scene};
use crate::physics::body::EntityId;
use crate::world::World;

/// Which character enters the world.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum CharacterChoice {
    /// The first of the list.
    #[default]
    First,
    /// The one of this name, whatever the case of its letters.
    Named(String),
}

impl CharacterChoice {
    fn of<'a>(&self, list: &'a CharacterList) -> Option<&'a CharacterEntry> {
        list.characters.0.iter().find(|entry| match self {
            Self::First => true,
            Self::Named(name) => entry.name.to_str().eq_ignore_ascii_case(name),
        })
    }
}

/// What happened, in order.
#[derive(Debug, Clone, PartialEq)]
pub enum Happening {
    /// The session is in another state.
    State(ClientState),
    /// A message and what it did.
    Message(Box<ServerMessage>, Verdict),
    /// Something odd was received.
    Anomaly(Anomaly),
    /// The account has no such character.
    NoCharacter,
    /// The session failed.
    Failed(SessionFailure),
}

/// A client without a screen.
#[derive(Debug)]
pub struct GameClient {
    /// What the client knows of the world.
    pub world: World,
    /// Messages to objects.
    pub stage: NetworkStage,
    /// Keys to motions.
    pub interpreter: CommandInterpreter,
    /// Numbers of the actions.
    pub actions: ActionWriter,
    session: ClientSession,
    choice: CharacterChoice,
    list: Option<CharacterList>,
    pipeline: Pipeline,
    happenings: Vec<Happening>,
}

impl GameClient {
    /// A client that logs in at time `now` (s) into a world whose map is known.
    ///
    /// # Errors
    /// When a text of the login cannot be sent.
    pub fn new(
        login: &LoginRequest,
        config: ClientConfig,
        choice: CharacterChoice,
        world: World,
        now: f64,
    ) -> Result<Self, LoginError> {
        Ok(Self {
            world,
            stage: NetworkStage::new(),
            interpreter: CommandInterpreter::new(now),
            actions: ActionWriter::default(),
            session: ClientSession::new(login, config, now)?,
            choice,
            list: None,
            pipeline: Pipeline::default(),
            happenings: Vec::new(),
        })
    }

    /// Where the session is.
    pub const fn state(&self) -> ClientState {
        self.session.state()
    }

    /// The session.
    pub const fn session(&self) -> &ClientSession {
        &self.session
    }

    /// Whether the player is in the world and not on its way through portal space.
    pub fn is_playing(&self) -> bool {
        self.state() == ClientState::InWorld && !self.stage.entities.in_portal_space()
    }

    /// The own body, once it is described.
    pub const fn player(&self) -> Option<EntityId> {
        self.world.local_player
    }

    /// Takes a datagram that arrived at `now` (s). Its messages act in the next frame.
    pub fn receive(&mut self, datagram: &[u8], now: f64) {
        self.session.receive(datagram, now);
    }

    /// The next datagram to send.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        self.session.poll_transmit()
    }

    /// What happened since the last call, in order.
    pub fn take_happenings(&mut self) -> Vec<Happening> {
        core::mem::take(&mut self.happenings)
    }

    /// Sends a game action.
    pub fn act(&mut self, action: GameAction, now: f64) {
        let message = self.actions.action(action);
        self.session.send(Queue::WEENIE, &message, now);
    }

    /// Asks the server to let the player leave the world.
    pub fn log_off(&mut self, now: f64) {
        self.with_interpreter(|interpreter, scene| interpreter.disable(scene));
        self.interpreter.outbox.clear();
        self.send_plain(PlainClientMessage::LogOff(Default::default()), now);
    }

    /// Ends the session.
    pub fn disconnect(&mut self) {
        self.session.disconnect();
    }

    /// Runs the frame at `now` (s): what was received acts, then `input`, then everything is advanced.
    pub fn frame(&mut self, now: f64, input: impl FnOnce(&mut CommandInterpreter, &mut Scene<'_>)) {
        self.world.clock.now = now;
        for (_, entity) in self.stage.entities.iter() {
            if let Some(entity) = self.world.entity_mut(entity.id) {
                entity.begin_frame();
            }
        }
        self.network(now);
        if self.is_playing() {
            self.with_interpreter(|interpreter, scene| {
                input(interpreter, scene);
                interpreter.use_time(scene);
            });
        }
        self.send_reports(now);
        self.pipeline
            .entity_tick(&mut self.world, &mut NoHost, &mut NoProbe);
    }

    fn network(&mut self, now: f64) {
        self.session.handle_timeout(now);
        while let Some(event) = self.session.poll_event() {
            match event {
                ClientEvent::Message(message) => self.deliver(&message, now),
                ClientEvent::State(state) => self.happenings.push(Happening::State(state)),
                ClientEvent::Anomaly(anomaly) => self.happenings.push(Happening::Anomaly(anomaly)),
                ClientEvent::Failed(failure) => self.happenings.push(Happening::Failed(failure)),
                ClientEvent::TimeSync(_) => {}
            }
            self.take_notices();
        }
        self.arrive(now);
        self.stage.end_of_frame(&mut self.world);
    }

    fn deliver(&mut self, message: &Message, now: f64) {
        let Ok((message, verdict)) = self.stage.deliver(&message.bytes, &mut self.world) else {
            return;
        };
        if let ServerMessage::Plain(plain) = &message {
            self.select(plain, now);
        }
        let happening = Happening::Message(Box::new(message), verdict);
        self.happenings.push(happening);
    }

    /// Character selection: the chosen character enters the world as soon as the server is ready.
    fn select(&mut self, message: &PlainServerMessage, now: f64) {
        match message {
            PlainServerMessage::CharacterList(list) if self.list.is_none() => {
                if self.choice.of(list).is_none() {
                    return self.happenings.push(Happening::NoCharacter);
                }
                self.list = Some(list.clone());
                self.send_plain(PlainClientMessage::EnterWorldRequest(()), now);
            }
            PlainServerMessage::ServerReady(()) => {
                let enter = self.list.as_ref().and_then(|list| {
                    Some(EnterWorld {
                        guid: self.choice.of(list)?.guid,
                        account: list.account.clone(),
                    })
                });
                if let Some(enter) = enter {
                    self.send_plain(PlainClientMessage::EnterWorld(enter), now);
                }
            }
            _ => {}
        }
    }

    fn send_plain(&mut self, message: PlainClientMessage, now: f64) {
        let bytes = ClientMessage::Plain(message).to_bytes();
        self.session.send(Queue::LOGIN, &bytes, now);
    }

    fn take_notices(&mut self) {
        for notice in core::mem::take(&mut self.stage.entities.notices) {
            match notice {
                Notice::Player(_) => {
                    let now = self.world.clock.now;
                    // The interpreter of another character keeps nothing.
                    self.interpreter = CommandInterpreter::new(now);
                    self.with_interpreter(|interpreter, scene| {
                        interpreter.new_player(false, scene)
                    });
                }
                Notice::LostControl => {
                    self.with_interpreter(|interpreter, scene| {
                        interpreter.lose_control_to_server(scene);
                    });
                }
                // The next position check finds a place that was never reported.
                Notice::ForcedPosition => {
                    self.interpreter.last_sent_position.cell = CellId::NONE;
                }
                Notice::PortalSpace => {}
                Notice::Autonomy(level) => {
                    self.interpreter.set_autonomy_level(level);
                }
            }
        }
    }

    /// Leaves portal space when the place is known and loaded.
    fn arrive(&mut self, now: f64) {
        let entities = &self.stage.entities;
        let waits = self.state() == ClientState::PortalSpace || entities.in_portal_space();
        let placed = !entities.in_portal_space() || entities.has_arrived();
        let place = self
            .player()
            .and_then(|id| self.world.entity(id))
            .filter(|player| player.body.cell.is_some())
            .map(|player| player.body.position);
        let Some(place) = place.filter(|_| waits && placed) else {
            return;
        };
        self.world.ensure_loaded_around(&place);
        let was_there = self.stage.entities.in_portal_space();
        self.stage.entities.leave_portal_space();
        self.act(GameAction::LoginComplete(()), now);
        if was_there {
            self.with_interpreter(|interpreter, scene| interpreter.player_teleported(scene));
            self.interpreter.last_sent_position.cell = CellId::NONE;
        }
    }

    fn send_reports(&mut self, now: f64) {
        let playing = self.is_playing();
        let mut outbox = core::mem::take(&mut self.interpreter.outbox);
        for report in outbox.drain(..) {
            let level = matches!(report, Outgoing::AutonomyLevel(_));
            if !playing && !level {
                continue;
            }
            if let Some(message) = self.actions.report(&report) {
                self.session.send(Queue::WEENIE, &message, now);
            }
        }
        self.interpreter.outbox = outbox;
    }

    /// Runs `f` with the interpreter and the player taken out of the world.
    pub fn with_interpreter(&mut self, f: impl FnOnce(&mut CommandInterpreter, &mut Scene<'_>)) {
        let interpreter = &mut self.interpreter;
        match self.world.local_player {
            Some(id) => {
                self.world.with_entity(id, |player, world| {
                    let player = Some(player);
                    f(interpreter, &mut Scene { player, world });
                });
            }
            None => {
                let world = &mut self.world;
                f(
                    interpreter,
                    &mut Scene {
                        player: None,
                        world,
                    },
                );
            }
        }
    }
}
