//! The proxy: sockets and clock around the [`Relay`], and the [`Disk`] behind it.
//!
//! Passing datagrams on comes first: each socket has a task of its own that receives, sends, and only then hands a copy to the writer's
//! queue. Nothing in that path waits for the disk, and a refused send does not end the proxy.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ac_client::net::messages::Direction;
use ac_client::net::session::Port;
use tokio::net::UdpSocket;
use tokio::task::{AbortHandle, JoinSet};

use crate::clock::Clock;
use crate::counters::{self, Counters, Counts, add};
use crate::disk::{Disk, DiskConfig, DiskReport, Files, Storage};
use crate::error::RecordError;
use crate::format::Stream;
use crate::relay::{ClientNumber, FromClient, FromServer, Relay, RelayLimits, ToServer, next_port};
use crate::sockets::{self, Drops};

pub use crate::signals::asked_to_stop;

/// What a proxy is started with.
#[derive(Debug, Clone)]
pub struct ProxyConfig {
    /// Login port of the relay; the next one is used too.
    pub listen: SocketAddr,
    /// Login port of the server.
    pub server: SocketAddr,
    /// Bounds.
    pub limits: RelayLimits,
    /// Where and how it is recorded.
    pub disk: DiskConfig,
}

impl ProxyConfig {
    /// The usual set-up.
    pub fn new(listen: SocketAddr, server: SocketAddr, output: PathBuf) -> Self {
        Self {
            listen,
            server,
            limits: RelayLimits::default(),
            disk: DiskConfig::new(output),
        }
    }
}

/// What a proxy did.
#[derive(Debug, Default)]
pub struct ProxyReport {
    /// Final counters.
    pub counts: Counts,
    /// What was written.
    pub disk: DiskReport,
}

/// Largest datagram of UDP.
const LARGEST: usize = 65_535;
/// Time between looks at clients that are silent and at losses.
const TICK: Duration = Duration::from_secs(1);

struct Link {
    socket: Arc<UdpSocket>,
    reader: AbortHandle,
}

/// What changes with every datagram. Held for lookups only, never while something is sent.
struct Routes {
    relay: Relay,
    links: BTreeMap<ClientNumber, Link>,
    readers: JoinSet<()>,
}

struct Shared {
    login: UdpSocket,
    next: UdpSocket,
    server: SocketAddr,
    routes: Mutex<Routes>,
    disk: Disk,
    counters: Arc<Counters>,
    clock: Clock,
    drops: Mutex<Drops>,
}

/// A proxy whose sockets are open.
pub struct Proxy {
    shared: Arc<Shared>,
}

fn no_next(address: SocketAddr) -> RecordError {
    RecordError::Address {
        text: address.to_string(),
        reason: "there is no port after this one; the protocol uses two in a row".into(),
    }
}

impl Proxy {
    /// Opens the sockets and starts the file. Must be called on a tokio runtime.
    ///
    /// # Errors
    /// A socket or the file cannot be opened.
    pub fn open(config: &ProxyConfig) -> Result<Self, RecordError> {
        Self::open_on(config, Box::new(Files))
    }

    /// As [`open`](Self::open), on a storage other than the file system.
    ///
    /// # Errors
    /// A socket or the file cannot be opened.
    pub fn open_on(config: &ProxyConfig, storage: Box<dyn Storage>) -> Result<Self, RecordError> {
        let next = next_port(config.listen).ok_or_else(|| no_next(config.listen))?;
        let relay =
            Relay::new(config.server, config.limits).ok_or_else(|| no_next(config.server))?;
        let (login, next) = (sockets::bind(config.listen)?, sockets::bind(next)?);
        let (clock, counters) = (Clock::new(), Arc::<Counters>::default());
        let mut drops = Drops::default();
        drops.watch(&login);
        drops.watch(&next);
        let disk = Disk::start(config.disk.clone(), storage, clock, counters.clone())?;
        Ok(Self {
            shared: Arc::new(Shared {
                login,
                next,
                server: config.server,
                routes: Mutex::new(Routes {
                    relay,
                    links: BTreeMap::new(),
                    readers: JoinSet::new(),
                }),
                disk,
                counters,
                clock,
                drops: Mutex::new(drops),
            }),
        })
    }

    /// Counters, to look at while the proxy runs.
    pub fn counters(&self) -> Arc<Counters> {
        self.shared.counters.clone()
    }

    /// Passes datagrams on and records them until `stop` is done; then ends the file.
    pub async fn run(self, stop: impl Future<Output = ()>) -> ProxyReport {
        let mut tasks = JoinSet::new();
        for port in [Port::Login, Port::Next] {
            let shared = self.shared.clone();
            tasks.spawn(async move { shared.serve(port).await });
        }
        let watcher = self.shared.clone();
        tasks.spawn(async move { watcher.watch().await });
        stop.await;
        tasks.shutdown().await;
        let readers = std::mem::take(&mut self.shared.routes().readers);
        { readers }.shutdown().await;
        self.shared.look_for_drops();
        finish(self.shared).await
    }
}

/// Ends the file, on another thread: it may take a while.
async fn finish(shared: Arc<Shared>) -> ProxyReport {
    let ended = tokio::task::spawn_blocking(move || {
        let mut shared = shared;
        // All tasks have ended; only a look at the system's tables may take a moment more.
        let shared = loop {
            match Arc::try_unwrap(shared) {
                Ok(shared) => break shared,
                Err(shared_still) => shared = shared_still,
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        let disk = shared.disk.finish();
        ProxyReport {
            counts: shared.counters.counts(),
            disk,
        }
    });
    ended.await.unwrap_or_default()
}

impl Shared {
    fn routes(&self) -> MutexGuard<'_, Routes> {
        self.routes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    const fn socket(&self, port: Port) -> &UdpSocket {
        match port {
            Port::Login => &self.login,
            Port::Next => &self.next,
        }
    }

    /// Receives what clients send to one of the two ports.
    async fn serve(self: Arc<Self>, port: Port) {
        let mut buffer = vec![0; LARGEST];
        loop {
            match self.socket(port).recv_from(&mut buffer).await {
                Ok((n, from)) => self.client_sent(port, from, &buffer[..n]).await,
                // Some systems report an unreachable client here.
                Err(_) => tokio::time::sleep(Duration::from_millis(1)).await,
            }
        }
    }

    async fn client_sent(self: &Arc<Self>, port: Port, from: SocketAddr, bytes: &[u8]) {
        let received = self.clock.stamp();
        add(&self.counters.from_clients, 1);
        let Some((route, socket)) = self.route_client(port, from, bytes) else {
            return;
        };
        let forwarded = match socket {
            Some(socket) => self.send(&socket, route.to, bytes).await,
            None => None,
        };
        if forwarded.is_some() {
            add(&self.counters.to_server, 1);
        }
        let stream = Stream::new(route.client, Direction::ToServer, port);
        self.disk.record(stream, received, forwarded, bytes);
        for (port, held) in &route.released {
            if self.send(self.socket(*port), from, held).await.is_some() {
                add(&self.counters.to_clients, 1);
            }
        }
    }

    /// Where a client's datagram goes, and through which socket; none when none could be opened.
    fn route_client(
        self: &Arc<Self>,
        port: Port,
        from: SocketAddr,
        bytes: &[u8],
    ) -> Option<(ToServer, Option<Arc<UdpSocket>>)> {
        let mut routes = self.routes();
        let answer = routes
            .relay
            .route_client(from, port, bytes, self.clock.now());
        let route = match answer {
            FromClient::Pass(route) => route,
            FromClient::Refused => {
                add(&self.counters.refused, 1);
                return None;
            }
            FromClient::Full => {
                add(&self.counters.too_many_clients, 1);
                return None;
            }
        };
        if let Some(evicted) = route.evicted {
            self.disconnect(&mut routes, evicted);
        }
        if route.is_new {
            tracing::info!(client = route.client, "new client");
            if let Err(error) = self.connect(&mut routes, route.client) {
                tracing::error!(%error, "no socket for this client");
            }
        }
        let socket = routes.links.get(&route.client).map(|l| l.socket.clone());
        Some((route, socket))
    }

    /// Sends, and says when; `None` when the system refused.
    async fn send(&self, socket: &UdpSocket, to: SocketAddr, bytes: &[u8]) -> Option<u64> {
        match socket.send_to(bytes, to).await {
            Ok(_) => Some(self.clock.stamp()),
            Err(_) => {
                add(&self.counters.not_sent, 1);
                None
            }
        }
    }

    /// Opens a client's socket towards the server, and starts to receive from it.
    fn connect(
        self: &Arc<Self>,
        routes: &mut Routes,
        client: ClientNumber,
    ) -> Result<(), RecordError> {
        let any: SocketAddr = match self.server {
            SocketAddr::V4(s) if s.ip().is_loopback() => ([127, 0, 0, 1], 0).into(),
            SocketAddr::V4(_) => ([0, 0, 0, 0], 0).into(),
            SocketAddr::V6(_) => ([0u16; 8], 0).into(),
        };
        let socket = Arc::new(sockets::bind(any)?);
        self.drops().watch(&socket);
        let (shared, own) = (self.clone(), socket.clone());
        let reader = routes.readers.spawn(async move {
            let mut buffer = vec![0; LARGEST];
            loop {
                match own.recv_from(&mut buffer).await {
                    Ok((n, from)) => shared.server_sent(client, from, &buffer[..n]).await,
                    // Some systems report an unreachable port here; the server may come back.
                    Err(_) => tokio::time::sleep(Duration::from_millis(50)).await,
                }
            }
        });
        routes.links.insert(client, Link { socket, reader });
        Ok(())
    }

    async fn server_sent(&self, client: ClientNumber, from: SocketAddr, bytes: &[u8]) {
        let received = self.clock.stamp();
        add(&self.counters.from_server, 1);
        let answer = {
            let mut routes = self.routes();
            routes
                .relay
                .route_server(client, from, bytes, self.clock.now())
        };
        let (port, forwarded) = match answer {
            FromServer::Pass(route) => {
                let sent = self.send(self.socket(route.port), route.to, bytes).await;
                add(&self.counters.to_clients, u64::from(sent.is_some()));
                (route.port, sent)
            }
            FromServer::Held(port) => {
                add(&self.counters.held, 1);
                (port, None)
            }
            FromServer::Dropped(port) => {
                add(&self.counters.held, 1);
                add(&self.counters.held_dropped, 1);
                (port, None)
            }
            FromServer::Stranger => {
                add(&self.counters.strangers, 1);
                return;
            }
        };
        let stream = Stream::new(client, Direction::ToClient, port);
        self.disk.record(stream, received, forwarded, bytes);
    }

    fn disconnect(&self, routes: &mut Routes, client: ClientNumber) {
        if let Some(link) = routes.links.remove(&client) {
            link.reader.abort();
        }
        self.disk.forget(client);
    }

    fn drops(&self) -> MutexGuard<'_, Drops> {
        self.drops.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Datagrams that the system dropped before this program saw them.
    fn look_for_drops(&self) {
        let new = self.drops().new_ones();
        add(&self.counters.system_dropped, new);
    }

    /// Forgets silent clients, and says loudly what is lost.
    async fn watch(self: Arc<Self>) {
        let mut tick = tokio::time::interval(TICK);
        let mut said = Counts::default();
        loop {
            tick.tick().await;
            self.expire();
            let own = self.clone();
            // Reads a table of the system, which may be long.
            let _ = tokio::task::spawn_blocking(move || own.look_for_drops()).await;
            let now = self.counters.counts();
            counters::complain(&said, &now);
            said = now;
        }
    }

    fn expire(&self) {
        let mut routes = self.routes();
        for client in routes.relay.expire(self.clock.now()) {
            self.disconnect(&mut routes, client);
            tracing::info!(client, "silent for too long, forgotten");
        }
        while routes.readers.try_join_next().is_some() {}
    }
}
