//! UDP around the scripted client.

use std::fs::File;
use std::io::BufWriter;
use std::net::{SocketAddr, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use ac_client::dat::{DatSet, Strictness};
use ac_client::net::client::{CharacterChoice, GameClient, Happening};
use ac_client::net::entities::{Dropped, Verdict};
use ac_client::net::messages::{Direction, GameEvent, PlainServerMessage as P, ServerMessage};
use ac_client::net::session::{ClientConfig, ClientState, Port};
use ac_client::net::transport::LoginError;
use ac_client::profile::Profile;
use ac_client::world::World;
use ac_golden_traces::corpus;
use miette::Diagnostic;
use thiserror::Error;
use tokio::net::UdpSocket;

use super::account::{Account, AccountError, AccountSource, ServerKind};
use super::script::{Player, Script, ScriptError};
use crate::format::{RecordingWriter, Stream};
use crate::proxy::asked_to_stop;

/// Arguments of `ac-record play`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// What to do in the world: one command per line (wait, forward, backward, left, right, turn-left, turn-right, face, run, hold, release,
    /// jump, say, logoff).
    #[arg(long)]
    script: PathBuf,
    /// Login port of the server, HOST:PORT; the next port is used too.
    #[arg(long, default_value = "127.0.0.1:9000")]
    server: String,
    /// Where account and password come from. They are never arguments.
    #[arg(long, value_enum)]
    account_from: AccountSource,
    /// How the server wants its login.
    #[arg(long, value_enum, default_value_t)]
    server_kind: ServerKind,
    /// Name of the character. Default: the first of the account.
    #[arg(long)]
    character: Option<String>,
    /// Folder with the dat files of the server's world (client_portal.dat, client_cell_1.dat). Default: the bundled testbed.
    #[arg(long)]
    dats: Option<PathBuf>,
    /// Frames per second.
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=240))]
    rate: u32,
    /// Also write a recording of the session; account and password are overwritten in it.
    #[arg(long)]
    record: Option<PathBuf>,
}

/// Why the client could not play.
#[derive(Debug, Error, Diagnostic)]
pub enum PlayError {
    /// The script cannot be read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The script is none.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Script(#[from] ScriptError),
    /// There is no account.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Account(#[from] AccountError),
    /// Account or password cannot be sent.
    #[error(transparent)]
    Login(#[from] LoginError),
    /// The dat files cannot be opened.
    #[error("dat files in {}: {reason}", path.display())]
    #[diagnostic(help(
        "name their folder with --dats; the client predicts its own movement and needs the map"
    ))]
    World {
        /// Their folder.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The server is not found, or the socket does not work.
    #[error("server {server}: {reason}")]
    #[diagnostic(help("--server HOST:PORT names the login port, 9000 by default"))]
    Server {
        /// As given.
        server: String,
        /// What is wrong.
        reason: String,
    },
    /// The session did not get where it should.
    #[error("the session failed: {0}")]
    Session(String),
}

/// Plays the script and prints what is seen. Answers the last line.
///
/// # Errors
/// When the session cannot begin or fails.
pub fn run(args: &Args) -> Result<String, PlayError> {
    let text = std::fs::read_to_string(&args.script).map_err(|source| PlayError::File {
        path: args.script.clone(),
        source,
    })?;
    let script = Script::parse(&text)?;
    let world = world(args.dats.as_deref())?;
    let server = server(&args.server)?;
    let account = Account::from(args.account_from)?;
    let seconds = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
    let login = account.login(args.server_kind, seconds.as_secs() as u32);
    let choice = args
        .character
        .clone()
        .map_or(CharacterChoice::First, CharacterChoice::Named);
    let client = GameClient::new(&login, ClientConfig::default(), choice, world, 0.0)?;
    let recording = args.record.as_deref().map(create).transpose()?;
    let failed = |error: std::io::Error| PlayError::Server {
        server: args.server.clone(),
        reason: error.to_string(),
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(failed)?;
    runtime.block_on(async {
        let any: SocketAddr = match server {
            SocketAddr::V4(_) => ([0, 0, 0, 0], 0).into(),
            SocketAddr::V6(_) => ([0u16; 8], 0).into(),
        };
        let socket = UdpSocket::bind(any).await.map_err(failed)?;
        let session = Session {
            socket,
            server,
            client,
            player: Player::new(script),
            recording,
            started: Instant::now(),
            left: None,
            last_place: f64::NEG_INFINITY,
        };
        session.run(args.rate).await
    })
}

fn world(dats: Option<&Path>) -> Result<World, PlayError> {
    let path = dats.map_or_else(|| corpus::bundled().join("worlds/testbed"), Into::into);
    match DatSet::open(&path, Strictness::Lenient) {
        Ok(source) => Ok(World::with_source(Profile::retail(), 0.0, Arc::new(source))),
        Err(error) => Err(PlayError::World {
            path,
            reason: error.to_string(),
        }),
    }
}

fn server(text: &str) -> Result<SocketAddr, PlayError> {
    let bad = |reason: String| PlayError::Server {
        server: text.into(),
        reason,
    };
    let mut found = text.to_socket_addrs().map_err(|e| bad(e.to_string()))?;
    found.next().ok_or_else(|| bad("no address".into()))
}

type Writer = RecordingWriter<BufWriter<File>>;

fn create(path: &Path) -> Result<Writer, PlayError> {
    let failed = |source| PlayError::File {
        path: path.into(),
        source,
    };
    let file = File::create_new(path).map_err(failed)?;
    RecordingWriter::new(BufWriter::new(file)).map_err(|e| failed(std::io::Error::other(e)))
}

/// Seconds to wait for the server to let the player go.
const LEAVE: f64 = 15.0;
/// The player's place is printed this often, s.
const PLACE: f64 = 1.0;

struct Session {
    socket: UdpSocket,
    server: SocketAddr,
    client: GameClient,
    player: Player,
    recording: Option<Writer>,
    started: Instant,
    left: Option<f64>,
    last_place: f64,
}

impl Session {
    fn now(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    async fn run(mut self, rate: u32) -> Result<String, PlayError> {
        let mut frames = tokio::time::interval(Duration::from_secs(1) / rate);
        let stop = asked_to_stop();
        tokio::pin!(stop);
        let mut buffer = [0; 2048];
        let mut failure = None;
        while failure.is_none() && self.client.state() != ClientState::Closed {
            tokio::select! {
                () = &mut stop => self.client.disconnect(),
                got = self.socket.recv_from(&mut buffer) => {
                    if let Ok((n, from)) = got {
                        self.receive(from, &buffer[..n]);
                    }
                }
                _ = frames.tick() => failure = self.frame(),
            }
            self.send().await;
        }
        if let Some(recording) = self.recording.take() {
            recording.finish().map_err(|e| {
                PlayError::Session(format!("the recording cannot be finished: {e}"))
            })?;
        }
        match failure {
            Some(reason) => Err(PlayError::Session(reason)),
            None => {
                let s = self.client.stage.stats;
                Ok(format!(
                    "{:.1} s, {} messages, {} applied, {} stale, {} unreadable, {} actions sent\n",
                    self.now(),
                    s.messages,
                    s.applied,
                    s.stale,
                    s.unreadable,
                    self.client.actions.sent()
                ))
            }
        }
    }

    /// Datagrams of the server come from its login port or the next one; others are none of ours.
    fn receive(&mut self, from: SocketAddr, bytes: &[u8]) {
        let port = match from.port().checked_sub(self.server.port()) {
            Some(0) => Port::Login,
            Some(1) => Port::Next,
            _ => return,
        };
        if from.ip() == self.server.ip() {
            self.record(Direction::ToClient, port, bytes);
            self.client.receive(bytes, self.now());
        }
    }

    fn record(&mut self, direction: Direction, port: Port, bytes: &[u8]) {
        let time = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        if let Some(recording) = &mut self.recording
            && let Err(error) = recording.write(
                Stream::new(0, direction, port),
                time.as_nanos() as u64,
                bytes,
            )
        {
            tracing::error!(%error, "the recording ends here");
            self.recording = None;
        }
    }

    async fn send(&mut self) {
        while let Some(t) = self.client.poll_transmit() {
            self.record(Direction::ToServer, t.port, &t.bytes);
            let mut to = self.server;
            if t.port == Port::Next {
                to.set_port(to.port().wrapping_add(1));
            }
            if let Err(error) = self.socket.send_to(&t.bytes, to).await {
                tracing::warn!(%error, "not sent");
            }
        }
    }

    /// Runs a frame; `Some`: why the session failed.
    fn frame(&mut self) -> Option<String> {
        let now = self.now();
        let player = &mut self.player;
        self.client
            .frame(now, |keys, scene| player.frame(now, keys, scene));
        self.player.speak(&mut self.client, now);
        for happening in self.client.take_happenings() {
            match happening {
                Happening::Failed(failure) => return Some(format!("{failure:?}")),
                Happening::NoCharacter => return Some("the account has no such character".into()),
                other => tell(now, &other),
            }
        }
        for note in self.client.stage.notes.drain(..) {
            println!("{now:8.2} ! {note:?}");
        }
        self.tell_place(now);
        self.leave(now);
        None
    }

    fn tell_place(&mut self, now: f64) {
        let player = self
            .client
            .player()
            .and_then(|id| self.client.world.entity(id));
        if let Some(player) = player.filter(|_| now - self.last_place >= PLACE) {
            let place = player.body.position;
            let [x, y, z] = place.frame.origin.to_array();
            println!(
                "{now:8.2}   at 0x{:08X} ({x:.2}, {y:.2}, {z:.2})",
                place.cell.0
            );
            self.last_place = now;
        }
    }

    fn leave(&mut self, now: f64) {
        if !self.player.wants_log_off() {
            return;
        }
        let since = *self.left.get_or_insert_with(|| {
            self.client.log_off(now);
            now
        });
        if self.client.state() == ClientState::CharacterSelect || now - since > LEAVE {
            self.client.disconnect();
        }
    }
}

/// Prints what a person wants to see.
fn tell(now: f64, happening: &Happening) {
    match happening {
        Happening::State(state) => println!("{now:8.2} * {state:?}"),
        Happening::Message(message, verdict) => {
            let name = message.name();
            match (&**message, verdict) {
                (ServerMessage::Plain(P::CreateObject(o)), Verdict::Applied) => {
                    println!("{now:8.2} + 0x{:08X} {}", o.guid, o.weenie.name.to_str());
                }
                (ServerMessage::Plain(P::DeleteObject(d)), Verdict::Applied) => {
                    println!("{now:8.2} - 0x{:08X}", d.guid);
                }
                (ServerMessage::Plain(P::HearSpeech(s)), _) => {
                    println!("{now:8.2} \" {}: {}", s.sender.to_str(), s.text.to_str());
                }
                (ServerMessage::Plain(P::ServerText(s)), _) => {
                    println!("{now:8.2} \" {}", s.text.to_str());
                }
                (
                    ServerMessage::Event {
                        event: GameEvent::PingResponse(()),
                        ..
                    },
                    _,
                ) => {}
                (_, Verdict::Dropped(Dropped::Old(_) | Dropped::Echo)) => {}
                (_, Verdict::Dropped(why)) => println!("{now:8.2} ! {name}: {why:?}"),
                _ => {}
            }
        }
        Happening::Anomaly(anomaly) => tracing::debug!(?anomaly, "packet"),
        Happening::NoCharacter | Happening::Failed(_) => {}
    }
}

impl From<PlayError> for crate::error::RecordError {
    fn from(error: PlayError) -> Self {
        Self::Play(Box::new(error))
    }
}
