//! A small server for development and tests: it shows a scene of the harness to one client (`docs/packet-sessions.md`).
//!
//! Sans-IO: datagrams and times go in, datagrams come out, and the same input gives the same bytes. The scene runs in the server's own
//! simulation, frame by frame as in the harness; what changes is told to the client in the messages of the game. The client plays a guest
//! that the scene does not know, or one of the scene's own entities. It trusts every login.

mod avatar;
mod describe;
mod known;
mod lobby;
pub mod loopback;
pub mod sessions;
pub mod shell;
mod steps;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use ac_client::dat::DatSet;
use ac_client::frame::{FrameStates, NoProbe};
use ac_client::net::messages::{GameEvent, PlainServerMessage, ServerMessage};
use ac_client::net::session::{Port, ServerConfig, ServerEvent, ServerSession, Transmit};
use ac_client::net::transport::{Anomaly, LoginError, Queue};
use ac_client::profile::Profile;
use ac_golden_traces::Scene;
use ac_golden_traces::scene::FrameRun;
use ac_replayer::SimulationError;
use ac_replayer::client::SceneRun;

use avatar::Avatar;
pub use avatar::{Authority, Played};
pub use describe::Abilities;
use known::Known;

/// GUID of a guest.
pub const GUEST: u32 = 0x5000_0F00;
/// Length of the frames after the scene's last, s.
const IDLE_FRAME: f64 = 1.0 / 30.0;
/// How many of them: a day.
const IDLE_FRAMES: u32 = 30 * 86_400;

/// What a server shows, and how.
#[derive(Debug, Clone)]
pub struct DemoConfig {
    /// The scene.
    pub scene: Scene,
    /// The dat files of its world.
    pub source: Arc<DatSet>,
    /// Behaviour of the simulation.
    pub profile: Profile,
    /// Whom the client plays.
    pub played: Played,
    /// Whose position of the player counts.
    pub authority: Authority,
    /// A moving object's position is sent this often, s.
    pub position_interval: f64,
    /// What a guest can do.
    pub abilities: Abilities,
    /// What it is told that it can do, if that is something else: it will have to be put right.
    pub told: Option<Abilities>,
    /// The transport.
    pub session: ServerConfig,
}

impl DemoConfig {
    /// A guest in a scene, with the defaults of everything else.
    pub fn new(scene: Scene, source: Arc<DatSet>) -> Self {
        Self {
            scene,
            source,
            profile: Profile::retail(),
            played: Played::Guest,
            authority: Authority::default(),
            position_interval: 0.5,
            abilities: Abilities::default(),
            told: None,
            session: ServerConfig::default(),
        }
    }
}

/// Why a server cannot show a scene.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// The scene cannot be set up.
    #[error(transparent)]
    Scene(#[from] SimulationError),
    /// The login cannot be sent.
    #[error(transparent)]
    Login(LoginError),
    /// The player is not in the scene.
    #[error("the scene `{scene}` has no entity 0x{guid:X} at its start")]
    NoPlayer {
        /// The scene.
        scene: String,
        /// Who was asked for.
        guid: u32,
    },
    /// The guest finds no room.
    #[error(
        "there is no room for a guest near the first entity of `{scene}`; play one of the scene's entities instead (--player)"
    )]
    NoRoom {
        /// The scene.
        scene: String,
    },
}

/// Where the client is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Not in the world.
    Lobby,
    /// In the world, but it has not said that it has loaded it: the scene waits before its first frame.
    Loading,
    /// The scene runs.
    Playing,
}

/// Something to tell a person.
#[derive(Debug, Clone, PartialEq)]
pub enum DemoNote {
    /// Who logged in.
    Login(String),
    /// The client is somewhere else.
    Phase(Phase),
    /// The player was where the server does not want it, by this many metres: it was put back.
    Corrected(f32),
    /// A message of the client cannot be read.
    Unreadable(String),
    /// Something odd was received.
    Anomaly(Anomaly),
    /// The session is over.
    Closed,
}

/// What a server has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "the names say it")]
pub struct DemoStats {
    pub frames: u32,
    pub messages_sent: u64,
    pub messages_received: u64,
    pub reports: u64,
    pub corrections: u64,
}

/// One client and the scene that it sees.
#[derive(Debug)]
pub struct DemoServer {
    config: DemoConfig,
    session: ServerSession,
    run: SceneRun,
    avatar: Avatar,
    phase: Phase,
    known: Vec<Known>,
    instances: BTreeMap<u32, u16>,
    account: String,
    next_event: u32,
    next_frame: u32,
    /// Session time of the scene's start, s.
    scene_began: f64,
    /// Session time of the next frame, s.
    next_frame_at: f64,
    next_step: usize,
    outbox: Vec<(Queue, ServerMessage)>,
    notes: VecDeque<DemoNote>,
    stats: DemoStats,
    /// States of the scene's tracked entities after each frame, if they are kept.
    states: Option<Vec<FrameStates>>,
}

impl DemoServer {
    /// A server that waits for a login, at time `now` (s).
    ///
    /// # Errors
    /// When the scene cannot be set up, or has no place for the player.
    pub fn new(mut config: DemoConfig, now: f64) -> Result<Self, DemoError> {
        config.scene.frames.push(FrameRun {
            dt: IDLE_FRAME,
            count: IDLE_FRAMES,
        });
        let mut run = SceneRun::new(&config.scene, Arc::clone(&config.source), &config.profile)?;
        let avatar = Avatar::new(&config, &mut run)?;
        Ok(Self {
            session: ServerSession::new(config.session, now),
            run,
            avatar,
            phase: Phase::Lobby,
            known: Vec::new(),
            instances: BTreeMap::new(),
            account: String::new(),
            next_event: 1,
            next_frame: 0,
            scene_began: now,
            next_frame_at: f64::INFINITY,
            next_step: 0,
            outbox: Vec::new(),
            notes: VecDeque::new(),
            stats: DemoStats::default(),
            states: None,
            config,
        })
    }

    /// Keeps the states of the scene's tracked entities from now on: record -1, then one per frame.
    pub fn keep_states(&mut self) {
        let mut first = FrameStates::new();
        self.run.write_records(-1, &mut first);
        self.states = Some(vec![first]);
    }

    /// The kept states.
    pub fn states(&self) -> &[FrameStates] {
        self.states.as_deref().unwrap_or_default()
    }

    /// The simulation.
    pub const fn scene(&self) -> &SceneRun {
        &self.run
    }

    /// The session.
    pub const fn session(&self) -> &ServerSession {
        &self.session
    }

    /// What was done so far.
    pub const fn stats(&self) -> &DemoStats {
        &self.stats
    }

    /// Where the client is.
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// Session time at which the scene began, s.
    pub const fn scene_began(&self) -> f64 {
        self.scene_began
    }

    /// GUIDs and counters of the objects that the client was told of.
    pub fn told(&self) -> impl Iterator<Item = (u32, &[u16; 9])> {
        self.known.iter().map(|known| (known.guid(), &known.stamps))
    }

    /// GUID of the player.
    pub const fn player(&self) -> u32 {
        self.avatar.spec.guid
    }

    /// The next thing to tell a person.
    pub fn poll_note(&mut self) -> Option<DemoNote> {
        self.notes.pop_front()
    }

    /// The next datagram to send, and from which port.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        self.session.poll_transmit()
    }

    /// Takes a datagram that arrived on `port` at `now` (s).
    pub fn receive(&mut self, port: Port, datagram: &[u8], now: f64) {
        self.session.receive(port, datagram, now);
        self.take_events(now);
        self.flush(now);
    }

    /// Runs what is due at `now` (s): timers, and the scene's frames.
    pub fn advance(&mut self, now: f64) {
        self.session.handle_timeout(now);
        self.take_events(now);
        while self.phase == Phase::Playing && self.next_frame_at <= now {
            self.run_frame();
            // Each frame's messages leave at once, as they would from a server that keeps up.
            self.flush(now);
        }
        self.flush(now);
    }

    fn take_events(&mut self, now: f64) {
        while let Some(event) = self.session.poll_event() {
            match event {
                ServerEvent::Connected(login) => {
                    self.account = login.account.clone();
                    self.notes.push_back(DemoNote::Login(login.account));
                    self.greet();
                }
                ServerEvent::Message(message) => self.take_message(&message.bytes, now),
                ServerEvent::Anomaly(anomaly) => self.notes.push_back(DemoNote::Anomaly(anomaly)),
                ServerEvent::Closed => {
                    self.enter(Phase::Lobby);
                    self.notes.push_back(DemoNote::Closed);
                }
            }
        }
    }

    fn enter(&mut self, phase: Phase) {
        if self.phase != phase {
            self.phase = phase;
            self.notes.push_back(DemoNote::Phase(phase));
        }
    }

    fn say(&mut self, queue: Queue, message: PlainServerMessage) {
        self.outbox.push((queue, ServerMessage::Plain(message)));
    }

    fn say_event(&mut self, event: GameEvent) {
        let message = ServerMessage::Event {
            guid: self.player(),
            sequence: self.next_event,
            event,
        };
        self.next_event += 1;
        self.outbox.push((Queue::UI, message));
    }

    /// Sends what has collected; small messages share packets.
    fn flush(&mut self, now: f64) {
        if self.outbox.is_empty() {
            return;
        }
        let messages: Vec<_> = self
            .outbox
            .drain(..)
            .map(|(queue, message)| (queue, message.to_bytes()))
            .collect();
        self.stats.messages_sent += messages.len() as u64;
        let bundle: Vec<_> = messages.iter().map(|(q, m)| (*q, &m[..])).collect();
        self.session.send_all(&bundle, now);
    }

    /// Runs the next frame of the simulation and tells what it changed.
    fn run_frame(&mut self) {
        let frame = self.next_frame;
        self.avatar.begin_frame(&mut self.run.world);
        self.run.run_frame(frame, &mut NoProbe);
        self.stats.frames += 1;
        if let Some(states) = &mut self.states {
            let mut now = FrameStates::new();
            let number = i32::try_from(frame).unwrap_or(i32::MAX);
            self.run.write_records(number, &mut now);
            states.push(now);
        }
        self.tell(frame);
        self.next_frame += 1;
        self.next_frame_at = self.scene_began + self.time_of(self.next_frame);
    }

    /// Seconds from the scene's start to a frame.
    fn time_of(&self, frame: u32) -> f64 {
        let (mut first, mut time) = (0u32, 0.0);
        for run in &self.config.scene.frames {
            let count = (frame + 1).saturating_sub(first).min(run.count);
            time += run.dt * f64::from(count);
            first = first.saturating_add(run.count);
        }
        time
    }

    /// The scene from its start, for a player that comes again.
    pub(super) fn restart(&mut self) -> Result<(), DemoError> {
        let source = Arc::clone(&self.config.source);
        self.run = SceneRun::new(&self.config.scene, source, &self.config.profile)?;
        self.avatar = Avatar::new(&self.config, &mut self.run)?;
        self.known.clear();
        (self.next_frame, self.next_step) = (0, 0);
        if self.states.is_some() {
            self.keep_states();
        }
        Ok(())
    }

    fn begin_scene(&mut self, now: f64) {
        self.scene_began = now;
        self.next_frame_at = now + self.time_of(0);
        self.enter(Phase::Playing);
    }
}
