//! What the client says, and the answers (`spec/09-network.md`, 11.6; `spec/10-messages.md`, 6 and 9).

use ac_client::net::messages::chat::HearSpeech;
use ac_client::net::messages::common::{List, Text};
use ac_client::net::messages::object::Guid;
use ac_client::net::messages::session::{
    CharacterEntry, CharacterList, DddInterrogation, ServerName,
};
use ac_client::net::messages::{
    ClientMessage, GameAction, GameEvent, PlainClientMessage, PlainServerMessage as P,
};
use ac_client::net::transport::Queue;
use ac_golden_traces::scene::EntitySpec;

use super::describe::player_description;
use super::known::Known;
use super::{DemoNote, DemoServer, Phase, Played};

/// Name of the character.
const NAME: &str = "Demo";

impl DemoServer {
    /// After the handshake: the characters, the server's name, the question for the client's files.
    pub(super) fn greet(&mut self) {
        self.list_characters();
        self.say(
            Queue::UI,
            P::ServerName(ServerName {
                connections: 1,
                maximum: 1,
                name: Text::new("ac-record demo-server"),
            }),
        );
        self.say(
            Queue::DATABASE,
            P::DddInterrogation(DddInterrogation {
                region: 1,
                name_rules: 1,
                product: 1,
                languages: List(vec![0, 1]),
            }),
        );
    }

    fn list_characters(&mut self) {
        let character = CharacterEntry {
            guid: self.player(),
            name: Text::new(NAME),
            deletion: 0,
        };
        let list = CharacterList {
            characters: List(vec![character]),
            slots: 1,
            account: Text::new(&self.account),
            expansion: 1,
            ..CharacterList::default()
        };
        self.say(Queue::UI, P::CharacterList(list));
    }

    pub(super) fn take_message(&mut self, bytes: &[u8], now: f64) {
        self.stats.messages_received += 1;
        match ClientMessage::parse(bytes).map(|parsed| parsed.message) {
            Ok(ClientMessage::Plain(message)) => self.take_plain(message),
            Ok(ClientMessage::Action { action, .. }) => self.take_action(action, now),
            Err(error) => {
                let text = error.to_string();
                self.notes.push_back(DemoNote::Unreadable(text));
            }
        }
    }

    fn take_plain(&mut self, message: PlainClientMessage) {
        match message {
            PlainClientMessage::DddInterrogationResponse(_) => {
                self.say(Queue::DATABASE, P::DddEnd(()));
            }
            PlainClientMessage::EnterWorldRequest(()) if self.phase == Phase::Lobby => {
                self.say(Queue::UI, P::ServerReady(()));
            }
            PlainClientMessage::EnterWorld(enter)
                if self.phase == Phase::Lobby && enter.guid == self.player() =>
            {
                self.enter_world();
            }
            PlainClientMessage::LogOff(_) if self.phase != Phase::Lobby => self.log_off(),
            _ => {}
        }
    }

    /// The player is told who it is, then what it sees.
    fn enter_world(&mut self) {
        if self.next_frame > 0 && self.restart().is_err() {
            // It could be set up once, so this does not happen; the client stays where it is.
            return;
        }
        if self.config.played == Played::Guest {
            let told = self.config.told.unwrap_or(self.config.abilities);
            let about = player_description(told);
            self.say_event(GameEvent::PlayerDescription(Box::new(about)));
        }
        let guid = self.player();
        self.say(Queue::SMARTBOX, P::PlayerCreate(Guid { guid }));
        let avatar = self.avatar.spec;
        self.introduce(&avatar);
        let specs = self.config.scene.entities.clone();
        for spec in specs.iter().filter(|spec| spec.guid != guid) {
            self.introduce(spec);
        }
        self.enter(Phase::Loading);
    }

    /// Tells the client of an object, if there is one.
    pub(super) fn introduce(&mut self, spec: &EntitySpec) {
        let id = if spec.guid == self.player() {
            Some(self.avatar.id)
        } else {
            self.run.object(spec.guid)
        };
        let world = &self.run.world;
        let Some(entity) = id.and_then(|id| world.entity(id)) else {
            return;
        };
        let instance = self.instances.entry(spec.guid).or_insert(0);
        *instance = instance.wrapping_add(1);
        let (known, message) = Known::introduce(entity, spec, *instance, world);
        self.known.push(known);
        self.say(Queue::SMARTBOX, message);
    }

    fn log_off(&mut self) {
        self.known.clear();
        self.next_frame_at = f64::INFINITY;
        self.enter(Phase::Lobby);
        self.say(Queue::UI, P::LogOff(()));
        self.list_characters();
    }

    fn take_action(&mut self, action: GameAction, now: f64) {
        match action {
            GameAction::LoginComplete(()) => match self.phase {
                Phase::Loading => self.begin_scene(now),
                _ => self.avatar.teleporting = false,
            },
            GameAction::Ping(()) => self.say_event(GameEvent::PingResponse(())),
            GameAction::Talk(text) => self.say(
                Queue::UI,
                P::HearSpeech(HearSpeech {
                    text,
                    sender: Text::new(NAME),
                    sender_guid: self.player(),
                    kind: 2,
                }),
            ),
            action if self.phase == Phase::Playing => self.take_movement(&action),
            _ => {}
        }
    }
}
