//! `ac-record demo-server`: UDP around the server.

use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ac_client::dat::{DatSet, Strictness};
use ac_client::net::session::Port;
use ac_client::net::transport::PacketFlags;
use ac_golden_traces::trace::TraceReader;
use ac_golden_traces::{GoldenError, Scene, corpus};
use miette::Diagnostic;
use tokio::net::UdpSocket;

use super::sessions::SessionError;
use super::{Authority, DemoConfig, DemoError, DemoNote, DemoServer, Played};
use crate::fault::{FaultLink, Faults};
use crate::proxy::asked_to_stop;

/// Arguments of `ac-record demo-server`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The scene to show: a bundled one by name (`terrain/walk-flat`), a scene file, or a trace.
    #[arg(long, default_value = "objects/creatures")]
    scene: String,
    /// Folder of the worlds. Default: the bundled worlds.
    #[arg(long)]
    worlds: Option<PathBuf>,
    /// Login port, IP:PORT; the next port is used too. Other machines reach the server only if this says so: it trusts every login.
    #[arg(long, default_value = "127.0.0.1:9000")]
    listen: SocketAddr,
    /// Whom the client plays: `guest`, or the GUID of one of the scene's entities, which its script then moves.
    #[arg(long, default_value = "guest", value_parser = played)]
    player: Played,
    /// Whose position of the player counts: `client`, or the server's, which puts the client right when it is this many metres off.
    #[arg(long, default_value = "1", value_parser = authority)]
    authority: Authority,
    #[command(flatten)]
    faults: FaultArgs,
}

/// A network as bad as wanted, each way.
#[derive(Debug, Clone, clap::Args)]
pub struct FaultArgs {
    /// Share of datagrams that vanish, 0 to 1.
    #[arg(long, default_value_t = 0.0)]
    loss: f64,
    /// Share of datagrams that arrive twice.
    #[arg(long, default_value_t = 0.0)]
    duplicate: f64,
    /// Share of datagrams that later ones overtake.
    #[arg(long, default_value_t = 0.0)]
    reorder: f64,
    /// Share of datagrams that are damaged.
    #[arg(long, default_value_t = 0.0)]
    corrupt: f64,
    /// Time that every datagram takes, s.
    #[arg(long, default_value_t = 0.0)]
    delay: f64,
    /// Random time on top, up to this, s.
    #[arg(long, default_value_t = 0.0)]
    jitter: f64,
    /// Decides which datagrams suffer.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Arguments of `ac-record demo-sessions`.
#[derive(Debug, Clone, clap::Args)]
pub struct SessionArgs {
    /// Folder to write into: `packets/NAME.mcap` and `traces/packets/NAME.mcap`. Default: the bundled golden traces.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

/// Makes the golden sessions again.
///
/// # Errors
/// When one cannot be made or written.
pub fn write_sessions(args: &SessionArgs) -> Result<String, ShellError> {
    let root = args.output.clone().unwrap_or_else(corpus::bundled);
    Ok(super::sessions::write_all(&root)?)
}

fn played(text: &str) -> Result<Played, String> {
    if text == "guest" {
        return Ok(Played::Guest);
    }
    let digits = text.trim_start_matches("0x").trim_start_matches("0X");
    u32::from_str_radix(digits, 16)
        .map(Played::Entity)
        .map_err(|_| format!("`{text}` is neither `guest` nor a GUID in hexadecimal"))
}

fn authority(text: &str) -> Result<Authority, String> {
    if text == "client" {
        return Ok(Authority::Client);
    }
    match text.parse::<f32>() {
        Ok(over) if over >= 0.0 && over.is_finite() => Ok(Authority::Server(over)),
        _ => Err(format!(
            "`{text}` is neither `client` nor a distance in metres"
        )),
    }
}

/// Why the server cannot run.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum ShellError {
    /// The scene cannot be read.
    #[error("scene: {0}")]
    #[diagnostic(help(
        "--scene takes the name of a bundled scene (golden-traces/index.json lists them), a `*.scene.json`, or a trace"
    ))]
    Golden(#[from] GoldenError),
    /// The world cannot be opened.
    #[error("world {}: {reason}", path.display())]
    #[diagnostic(help("name the folder above it with --worlds"))]
    World {
        /// Its folder.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The scene cannot be shown.
    #[error(transparent)]
    Demo(#[from] DemoError),
    /// A golden session cannot be made.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A fault is none.
    #[error("--{0} is out of range")]
    #[diagnostic(help("shares are from 0 to 1, times from 0 to 60 s"))]
    Fault(&'static str),
    /// A socket does not work.
    #[error("UDP {address}: {source}")]
    #[diagnostic(help(
        "two ports in a row are used, the named one and the next; another program may have one of them"
    ))]
    Socket {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
}

impl FaultArgs {
    fn faults(&self) -> Result<Faults, ShellError> {
        let faults = Faults {
            loss: self.loss,
            duplicate: self.duplicate,
            reorder: self.reorder,
            corrupt: self.corrupt,
            delay: self.delay,
            jitter: self.jitter,
        };
        faults
            .invalid()
            .map_or(Ok(faults), |name| Err(ShellError::Fault(name)))
    }
}

fn scene(args: &Args) -> Result<Scene, ShellError> {
    let bundled = corpus::bundled().join(format!("traces/{}.mcap", args.scene));
    let file = PathBuf::from(&args.scene);
    Ok(if args.scene.ends_with(corpus::SCENE_SUFFIX) {
        Scene::open(&file)?
    } else if file.is_file() {
        TraceReader::open(&file)?.scene().clone()
    } else {
        TraceReader::open(&bundled)?.scene().clone()
    })
}

fn config(args: &Args) -> Result<DemoConfig, ShellError> {
    let scene = scene(args)?;
    let worlds = args.worlds.clone();
    let worlds = worlds.unwrap_or_else(|| corpus::bundled().join("worlds"));
    let path = worlds.join(&scene.world);
    let source = match DatSet::open(&path, Strictness::Lenient) {
        Ok(source) => Arc::new(source),
        Err(error) => {
            let reason = error.to_string();
            return Err(ShellError::World { path, reason });
        }
    };
    let mut config = DemoConfig::new(scene, source);
    config.played = args.player;
    config.authority = args.authority;
    Ok(config)
}

/// Runs the server until the process is asked to end. Answers what was done.
///
/// # Errors
/// When the scene cannot be shown or the sockets cannot be opened.
pub fn run(args: &Args) -> Result<String, ShellError> {
    let (config, faults) = (config(args)?, args.faults.faults()?);
    // A scene that cannot be shown is found out before a client comes.
    DemoServer::new(config.clone(), 0.0)?;
    let failed = |source| ShellError::Socket {
        address: args.listen,
        source,
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(failed)?;
    runtime.block_on(async {
        let mut shell = Shell::open(args.listen, config, faults, args.faults.seed).await?;
        tracing::info!(listen = %args.listen, scene = args.scene, "demonstration server; Ctrl-C ends it");
        shell.serve().await;
        Ok(shell.summary())
    })
}

/// The longest datagram that is looked at.
const LARGEST: usize = 2048;
/// How often timers and frames are looked at.
const TICK: Duration = Duration::from_millis(5);

/// Sockets, the bad network, and the server of the present client.
pub(crate) struct Shell {
    login: UdpSocket,
    next: UdpSocket,
    config: DemoConfig,
    up: FaultLink<(Port, SocketAddr)>,
    down: FaultLink<(Port, SocketAddr)>,
    started: Instant,
    server: Option<(DemoServer, SocketAddr)>,
    sessions: u64,
    closed: bool,
}

impl Shell {
    pub(crate) async fn open(
        listen: SocketAddr,
        config: DemoConfig,
        faults: Faults,
        seed: u64,
    ) -> Result<Self, ShellError> {
        let bind = |address: SocketAddr| async move {
            let socket = UdpSocket::bind(address).await;
            socket.map_err(|source| ShellError::Socket { address, source })
        };
        let login = bind(listen).await?;
        let mut after = listen;
        after.set_port(
            login
                .local_addr()
                .map_or(listen.port(), |a| a.port())
                .wrapping_add(1),
        );
        Ok(Self {
            next: bind(after).await?,
            login,
            config,
            up: FaultLink::new(faults, seed),
            down: FaultLink::new(faults, seed ^ 0x5851_F42D_4C95_7F2D),
            started: Instant::now(),
            server: None,
            sessions: 0,
            closed: false,
        })
    }

    fn now(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    async fn serve(&mut self) {
        let stop = asked_to_stop();
        tokio::pin!(stop);
        loop {
            tokio::select! {
                () = &mut stop => return,
                () = self.turn() => {}
            }
        }
    }

    /// Waits for a datagram or the next tick, and does what is due.
    pub(crate) async fn turn(&mut self) {
        let (mut a, mut b) = ([0; LARGEST], [0; LARGEST]);
        let now = self.now();
        tokio::select! {
            // Some systems report an unreachable client here; it may come back.
            got = self.login.recv_from(&mut a) => if let Ok((n, from)) = got {
                self.up.send((Port::Login, from), &a[..n], now);
            },
            got = self.next.recv_from(&mut b) => if let Ok((n, from)) = got {
                self.up.send((Port::Next, from), &b[..n], now);
            },
            () = tokio::time::sleep(TICK) => {}
        }
        let now = self.now();
        while let Some((_, (port, from), bytes)) = self.up.arrive(now) {
            self.receive(port, from, &bytes, now);
        }
        if let Some((server, client)) = &mut self.server {
            server.advance(now);
            while let Some(t) = server.poll_transmit() {
                self.down.send((t.port, *client), &t.bytes, now);
            }
            while let Some(note) = server.poll_note() {
                self.closed |= note == DemoNote::Closed;
                tell(&note);
            }
        }
        if core::mem::take(&mut self.closed) {
            self.server = None;
        }
        while let Some((_, (port, to), bytes)) = self.down.arrive(now) {
            let socket = match port {
                Port::Login => &self.login,
                Port::Next => &self.next,
            };
            if let Err(error) = socket.send_to(&bytes, to).await {
                tracing::warn!(%error, %to, "not sent");
            }
        }
    }

    /// One client at a time: a login begins a session when there is none.
    fn receive(&mut self, port: Port, from: SocketAddr, bytes: &[u8], now: f64) {
        if self.server.is_none() && port == Port::Login && is_login(bytes) {
            match DemoServer::new(self.config.clone(), now) {
                Ok(server) => {
                    self.sessions += 1;
                    tracing::info!(%from, "login");
                    self.server = Some((server, from));
                }
                Err(error) => tracing::error!(%error, "the scene cannot be shown"),
            }
        }
        if let Some((server, client)) = &mut self.server
            && same_client(client.ip(), from.ip())
            && (port == Port::Next || *client == from)
        {
            server.receive(port, bytes, now);
        }
    }

    fn summary(&self) -> String {
        let (up, down) = (self.up.counts(), self.down.counts());
        format!(
            "{} sessions; to the server {} datagrams ({} lost, {} damaged), to clients {} ({} lost, {} damaged)\n",
            self.sessions, up.sent, up.lost, up.corrupted, down.sent, down.lost, down.corrupted
        )
    }
}

fn same_client(a: IpAddr, b: IpAddr) -> bool {
    a == b
}

fn is_login(bytes: &[u8]) -> bool {
    let flags = bytes.get(4..8).and_then(<[u8]>::first_chunk);
    flags.is_some_and(|b| u32::from_le_bytes(*b) == PacketFlags::LOGIN_REQUEST.bits())
}

fn tell(note: &DemoNote) {
    match note {
        DemoNote::Login(account) => tracing::info!(account, "logged in"),
        DemoNote::Phase(phase) => tracing::info!(?phase, "client"),
        DemoNote::Corrected(metres) => tracing::info!(metres, "the player was put right"),
        DemoNote::Unreadable(error) => tracing::warn!(error, "message of the client"),
        DemoNote::Anomaly(anomaly) => tracing::debug!(?anomaly, "packet of the client"),
        DemoNote::Closed => tracing::info!("the session is over"),
    }
}

impl From<ShellError> for crate::error::RecordError {
    fn from(error: ShellError) -> Self {
        Self::Demo(Box::new(error))
    }
}
