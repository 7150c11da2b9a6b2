//! Server and client in one process and in virtual time, over a network as bad as wanted.
//!
//! Everything follows from the configuration: a session that is run again is the same, byte for byte. What the client sends and receives
//! can be written as a recording.

use std::io::{Seek, Write};
use std::sync::Arc;

use ac_client::math::Position;
use ac_client::net::client::{CharacterChoice, GameClient, Happening};
use ac_client::net::messages::Direction;
use ac_client::net::session::{ClientConfig, ClientState, Port};
use ac_client::net::transport::{AuthType, LoginRequest};
use ac_client::profile::Profile;
use ac_client::world::World;

use super::{DemoConfig, DemoError, DemoServer};
use crate::error::RecordError;
use crate::fault::{FaultLink, Faults};
use crate::format::{RecordingWriter, Stream};
use crate::play::script::{Player, Script};

/// Start of virtual time, ns since 1970: the year 2000.
const EPOCH: u64 = 946_684_800_000_000_000;

/// A session in virtual time.
#[derive(Debug, Clone)]
pub struct LoopbackConfig {
    /// The server and its scene.
    pub server: DemoConfig,
    /// What the client does once it is in the world.
    pub script: Script,
    /// The client's frames per second.
    pub rate: u32,
    /// The network, each way.
    pub faults: Faults,
    /// Decides the faults.
    pub seed: u64,
    /// The session ends after this time at the latest, s.
    pub limit: f64,
    /// Profile of the client.
    pub profile: Profile,
}

/// Where the player was, as the client predicted it and as the server had it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Virtual time, s.
    pub time: f64,
    /// The client's.
    pub client: Position,
    /// The server's.
    pub server: Position,
}

/// A running session.
#[derive(Debug)]
pub struct Loopback {
    /// The server.
    pub server: DemoServer,
    /// The client.
    pub client: GameClient,
    /// What happened in the client, in order.
    pub happenings: Vec<(f64, Happening)>,
    player: Player,
    up: FaultLink<Port>,
    down: FaultLink<Port>,
    step: u64,
    rate: u64,
    limit: f64,
    left: bool,
}

/// The login of every demonstration.
pub fn demo_login() -> LoginRequest {
    LoginRequest {
        version: "1802".into(),
        auth: AuthType::Password,
        auth_flags: 1,
        timestamp: 1,
        account: "demo".into(),
        account_override: String::new(),
        secret: Some("demo-secret".into()),
    }
}

impl Loopback {
    /// A session before its first datagram.
    ///
    /// # Errors
    /// When the server cannot show the scene.
    pub fn new(config: &LoopbackConfig) -> Result<Self, DemoError> {
        let source = Arc::clone(&config.server.source);
        let world = World::with_source(config.profile.clone(), 0.0, source);
        let client = GameClient::new(
            &demo_login(),
            ClientConfig::default(),
            CharacterChoice::First,
            world,
            0.0,
        );
        Ok(Self {
            server: DemoServer::new(config.server.clone(), 0.0)?,
            client: client.map_err(DemoError::Login)?,
            happenings: Vec::new(),
            player: Player::new(config.script.clone()),
            up: FaultLink::new(config.faults, config.seed),
            down: FaultLink::new(config.faults, config.seed ^ 0x5851_F42D_4C95_7F2D),
            step: 0,
            rate: config.rate.max(1).into(),
            limit: config.limit,
            left: false,
        })
    }

    /// Virtual time in nanoseconds: frame `n` of the client is at n/rate.
    const fn nanoseconds(&self) -> u64 {
        self.step * 1_000_000_000 / self.rate
    }

    /// Virtual time, s.
    pub fn now(&self) -> f64 {
        self.nanoseconds() as f64 / 1e9
    }

    /// Whether the session is over.
    pub fn is_over(&self) -> bool {
        matches!(
            self.client.state(),
            ClientState::Closed | ClientState::Failed
        ) || self.now() >= self.limit
    }

    /// The links, to the server and back.
    pub const fn links(&mut self) -> [&mut FaultLink<Port>; 2] {
        [&mut self.up, &mut self.down]
    }

    /// Whether the client's script is over.
    pub const fn script_is_over(&self) -> bool {
        self.player.is_over()
    }

    /// Runs one frame of the client. `seen` gets every datagram that the client sends or receives: direction, port, ns, bytes.
    ///
    /// # Errors
    /// What `seen` answers.
    pub fn step<E>(
        &mut self,
        mut seen: impl FnMut(Direction, Port, u64, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let now = self.now();
        while let Some((_, port, bytes)) = self.up.arrive(now) {
            self.server.receive(port, &bytes, now);
        }
        self.server.advance(now);
        while let Some(t) = self.server.poll_transmit() {
            self.down.send(t.port, &t.bytes, now);
        }
        while let Some((at, port, bytes)) = self.down.arrive(now) {
            seen(Direction::ToClient, port, EPOCH + at, &bytes)?;
            self.client.receive(&bytes, now);
        }
        let player = &mut self.player;
        self.client
            .frame(now, |keys, scene| player.frame(now, keys, scene));
        self.player.speak(&mut self.client, now);
        self.leave(now);
        let happened = self.client.take_happenings();
        self.happenings
            .extend(happened.into_iter().map(|h| (now, h)));
        let at = EPOCH + self.nanoseconds();
        while let Some(t) = self.client.poll_transmit() {
            seen(Direction::ToServer, t.port, at, &t.bytes)?;
            self.up.send(t.port, &t.bytes, now);
        }
        self.step += 1;
        Ok(())
    }

    /// After the script: log off, and when the server has let the player go, disconnect.
    fn leave(&mut self, now: f64) {
        if self.player.wants_log_off() && !self.left && self.client.state() == ClientState::InWorld
        {
            self.left = true;
            self.client.log_off(now);
        }
        if self.left && self.client.state() == ClientState::CharacterSelect {
            self.client.disconnect();
        }
    }

    /// Where the player is on both sides.
    pub fn sample(&self) -> Option<Sample> {
        let of = |world: &World, guid| {
            let id = world.entity_of_guid(guid)?;
            Some(world.entity(id)?.body.position)
        };
        let guid = self.server.player();
        Some(Sample {
            time: self.now(),
            client: of(&self.client.world, guid)?,
            server: of(&self.server.scene().world, guid)?,
        })
    }

    /// Runs the session to its end and writes what the client sent and received.
    ///
    /// # Errors
    /// When writing fails.
    pub fn record<W: Write + Seek>(
        &mut self,
        writer: &mut RecordingWriter<W>,
    ) -> Result<(), RecordError> {
        while !self.is_over() {
            self.step(|direction, port, time, bytes| {
                writer.write(Stream::new(0, direction, port), time, bytes)
            })?;
        }
        Ok(())
    }

    /// Runs the session to its end.
    pub fn run(&mut self) {
        while !self.is_over() {
            let done: Result<(), core::convert::Infallible> = self.step(|_, _, _, _| Ok(()));
            let Ok(()) = done;
        }
    }
}
