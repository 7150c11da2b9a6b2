//! The proxy: sockets, clock and file around the [`Relay`].
//!
//! Passing datagrams on comes first: a datagram is sent before it is recorded, and a refused send does not end the proxy.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use ac_client::net::messages::Direction;
use ac_client::net::session::Port;
use tokio::net::UdpSocket;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;

use crate::error::RecordError;
use crate::format::{RecordingWriter, Stream};
use crate::relay::{ClientNumber, Relay, RelayLimits, next_port};

/// What a proxy is started with.
#[derive(Debug, Clone)]
pub struct ProxyConfig {
    /// Login port of the relay; the next one is used too.
    pub listen: SocketAddr,
    /// Login port of the server.
    pub server: SocketAddr,
    /// The file.
    pub output: PathBuf,
    /// Bounds.
    pub limits: RelayLimits,
}

/// What a proxy did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ProxyReport {
    /// Datagrams recorded.
    pub packets: u32,
    /// Secret bytes overwritten.
    pub redacted: usize,
}

/// Longest time between a datagram's arrival and its being on the disk.
const FLUSH: Duration = Duration::from_millis(500);
/// Datagrams of the server that wait to be passed on.
const BACKLOG: usize = 1024;
/// Largest datagram of UDP.
const LARGEST: usize = 65_535;

struct Clock {
    start: Instant,
    epoch: u64,
}

impl Clock {
    fn new() -> Self {
        let epoch = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        Self {
            start: Instant::now(),
            epoch: epoch.as_nanos() as u64,
        }
    }

    /// Seconds since the start.
    fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// ns since 1970; steps of the system's clock do not show.
    fn stamp(&self) -> u64 {
        self.epoch + self.start.elapsed().as_nanos() as u64
    }
}

struct Upstream {
    socket: Arc<UdpSocket>,
    reader: JoinHandle<()>,
}

/// A datagram of the server: whose, from where, and its bytes.
type Answer = (ClientNumber, SocketAddr, Vec<u8>);

/// A proxy whose sockets are open.
pub struct Proxy {
    login: UdpSocket,
    next: UdpSocket,
    relay: Relay,
    upstreams: BTreeMap<ClientNumber, Upstream>,
    answers: (mpsc::Sender<Answer>, mpsc::Receiver<Answer>),
    writer: RecordingWriter<BufWriter<File>>,
    server: SocketAddr,
    clock: Clock,
}

async fn bind(address: SocketAddr) -> Result<UdpSocket, RecordError> {
    UdpSocket::bind(address)
        .await
        .map_err(|source| RecordError::Socket { address, source })
}

fn no_next(address: SocketAddr) -> RecordError {
    RecordError::Address {
        text: address.to_string(),
        reason: "there is no port after this one; the protocol uses two in a row".into(),
    }
}

impl Proxy {
    /// Opens the sockets and starts the file.
    ///
    /// # Errors
    /// A socket or the file cannot be opened.
    pub async fn open(config: &ProxyConfig) -> Result<Self, RecordError> {
        let next = next_port(config.listen).ok_or_else(|| no_next(config.listen))?;
        let relay =
            Relay::new(config.server, config.limits).ok_or_else(|| no_next(config.server))?;
        let (login, next) = (bind(config.listen).await?, bind(next).await?);
        let file = File::create_new(&config.output).map_err(|source| RecordError::File {
            path: config.output.clone(),
            source,
        })?;
        Ok(Self {
            login,
            next,
            relay,
            upstreams: BTreeMap::new(),
            answers: mpsc::channel(BACKLOG),
            writer: RecordingWriter::new(BufWriter::new(file))?,
            server: config.server,
            clock: Clock::new(),
        })
    }

    /// Passes datagrams on and records them until `stop` is done; then ends the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub async fn run(mut self, stop: impl Future<Output = ()>) -> Result<ProxyReport, RecordError> {
        tokio::pin!(stop);
        let mut flush = tokio::time::interval(FLUSH);
        let (mut a, mut b) = (vec![0; LARGEST], vec![0; LARGEST]);
        loop {
            tokio::select! {
                () = &mut stop => break,
                _ = flush.tick() => self.tick()?,
                received = self.login.recv_from(&mut a) => {
                    if let Ok((n, from)) = received {
                        self.pass_to_server(Port::Login, from, &a[..n]).await?;
                    }
                }
                received = self.next.recv_from(&mut b) => {
                    if let Ok((n, from)) = received {
                        self.pass_to_server(Port::Next, from, &b[..n]).await?;
                    }
                }
                Some((client, from, bytes)) = self.answers.1.recv() => {
                    self.pass_to_client(client, from, &bytes).await?;
                }
            }
        }
        for upstream in self.upstreams.values() {
            upstream.reader.abort();
        }
        let (packets, redacted) = self.writer.totals();
        self.writer.finish()?;
        Ok(ProxyReport { packets, redacted })
    }

    fn tick(&mut self) -> Result<(), RecordError> {
        for client in self.relay.expire(self.clock.now()) {
            if let Some(upstream) = self.upstreams.remove(&client) {
                upstream.reader.abort();
            }
            tracing::info!(client, "silent for too long, forgotten");
        }
        self.writer.flush()
    }

    async fn pass_to_server(
        &mut self,
        port: Port,
        from: SocketAddr,
        bytes: &[u8],
    ) -> Result<(), RecordError> {
        let Some(route) = self.relay.route_client(from, port, self.clock.now()) else {
            tracing::warn!(%from, "too many clients");
            return Ok(());
        };
        if route.is_new {
            tracing::info!(client = route.client, "new client");
            self.connect(route.client).await?;
        }
        if let Some(upstream) = self.upstreams.get(&route.client)
            && let Err(error) = upstream.socket.send_to(bytes, route.to).await
        {
            tracing::warn!(%error, "not sent to the server");
        }
        let stream = Stream::new(route.client, Direction::ToServer, port);
        self.writer.write(stream, self.clock.stamp(), bytes)
    }

    async fn pass_to_client(
        &mut self,
        client: ClientNumber,
        from: SocketAddr,
        bytes: &[u8],
    ) -> Result<(), RecordError> {
        let Some(route) = self.relay.route_server(client, from, self.clock.now()) else {
            return Ok(());
        };
        let socket = match route.port {
            Port::Login => &self.login,
            Port::Next => &self.next,
        };
        if let Err(error) = socket.send_to(bytes, route.to).await {
            tracing::warn!(%error, "not sent to the client");
        }
        let stream = Stream::new(client, Direction::ToClient, route.port);
        self.writer.write(stream, self.clock.stamp(), bytes)
    }

    /// Opens a client's socket towards the server.
    async fn connect(&mut self, client: ClientNumber) -> Result<(), RecordError> {
        let any: SocketAddr = match self.server {
            SocketAddr::V4(s) if s.ip().is_loopback() => ([127, 0, 0, 1], 0).into(),
            SocketAddr::V4(_) => ([0, 0, 0, 0], 0).into(),
            SocketAddr::V6(_) => ([0u16; 8], 0).into(),
        };
        let socket = Arc::new(bind(any).await?);
        let (answers, own) = (self.answers.0.clone(), Arc::clone(&socket));
        let reader = tokio::spawn(async move {
            let mut buffer = vec![0; LARGEST];
            loop {
                // Some systems report an unreachable port here; the server may come back.
                let Ok((n, from)) = own.recv_from(&mut buffer).await else {
                    tokio::time::sleep(Duration::from_millis(50)).await;
                    continue;
                };
                if answers
                    .send((client, from, buffer[..n].to_vec()))
                    .await
                    .is_err()
                {
                    return;
                }
            }
        });
        self.upstreams.insert(client, Upstream { socket, reader });
        Ok(())
    }
}

/// Done when the process is asked to end: Ctrl-C, or SIGTERM where there is one.
pub async fn asked_to_stop() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut terminate) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = terminate.recv() => {}
                _ = tokio::signal::ctrl_c() => {}
            }
            return;
        }
    }
    let _ = tokio::signal::ctrl_c().await;
}
