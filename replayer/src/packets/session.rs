//! From datagrams to complete messages in order, both ways.
//!
//! Each direction goes through the library's own receiver: numbers, checksums with the session's key streams, duplicates, gaps, fragments.
//! Nothing is sent, so a packet that the recording lacks for good never comes; it is given up after a while, and counted.

use std::path::Path;

use ac_client::net::session::opcode;
use ac_client::net::transport::{
    Anomaly, ConnectRequest, Connection, ConnectionLimits, Incoming, Packet, PacketFlags, Role,
};

use super::{Datagram, PacketsError, Recording};

/// A gap in the numbers that is older than this is given up, s.
const GIVE_UP: f64 = 15.0;

/// A complete message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delivery {
    /// Arrival of the datagram that completed it, ns since the session's first datagram.
    pub time: u64,
    /// To the server.
    pub to_server: bool,
    /// Opcode and body.
    pub bytes: Vec<u8>,
}

/// What the datagrams were.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "the names say it")]
pub struct DatagramStats {
    pub datagrams: u64,
    /// Not packets, or with a wrong checksum.
    pub undecodable: u64,
    pub duplicates: u64,
    /// Packets that never came.
    pub lost: u64,
    /// Fragments that fit nowhere.
    pub fragments: u64,
    pub messages_to_client: u64,
    pub messages_to_server: u64,
}

/// One session of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// Number of the client in the recording.
    pub client: u32,
    /// Messages in the order in which they were complete.
    pub deliveries: Vec<Delivery>,
    /// When its datagrams arrived, ns since its first.
    pub arrivals: Vec<u64>,
    /// What they were.
    pub stats: DatagramStats,
    /// Why reading the file ended early, if it did.
    pub damage: Option<String>,
}

/// One direction.
struct Line {
    connection: Connection,
    /// Since when its next packet is missing, s.
    waits_since: Option<f64>,
}

/// Both directions, once the seeds are known.
struct Lines {
    to_client: Line,
    to_server: Line,
}

impl Lines {
    fn new(connect: &ConnectRequest, now: f64) -> Self {
        let line = |role| Line {
            connection: Connection::new(
                role,
                connect.net_id as u16,
                connect.seed_from_server,
                connect.seed_from_client,
                now,
                ConnectionLimits::default(),
            ),
            waits_since: None,
        };
        Self {
            to_client: line(Role::Client),
            to_server: line(Role::Server),
        }
    }
}

impl Line {
    fn take(&mut self, bytes: &[u8], now: f64, out: &mut Vec<Incoming>) {
        self.connection.receive(bytes, now, out);
        // What the library would answer is not sent: this is the past.
        while self.connection.poll_transmit().is_some() {}
        if !self.connection.is_waiting() {
            self.waits_since = None;
            return;
        }
        let since = *self.waits_since.get_or_insert(now);
        if now - since > GIVE_UP {
            self.connection.give_up(now, out);
            self.waits_since = None;
        }
    }
}

impl Session {
    /// The first session of a client that gets into the world; if none does, the first that gets an answer. Without `client` the first
    /// client that has one. `path` is what errors call the recording.
    ///
    /// # Errors
    /// When there is none: the message says what the recording has instead.
    pub fn find(
        recording: &Recording,
        client: Option<u32>,
        path: &Path,
    ) -> Result<Self, PacketsError> {
        let mut sessions = Vec::new();
        let mut clients: Vec<u32> = recording.datagrams.iter().map(|d| d.client).collect();
        clients.sort_unstable();
        clients.dedup();
        for &number in clients.iter().filter(|n| client.is_none_or(|c| c == **n)) {
            sessions.extend(Self::all_of(recording, number));
        }
        let best = sessions.iter().position(Self::enters_world);
        let answered = sessions.iter().position(|s| !s.deliveries.is_empty());
        best.or(answered)
            .map(|at| sessions.swap_remove(at))
            .ok_or_else(|| PacketsError::NoSession {
                path: path.into(),
                reason: missing(recording, client, &clients),
            })
    }

    fn enters_world(&self) -> bool {
        self.deliveries.iter().any(|delivery| {
            let word = delivery.bytes.first_chunk().map(|b| u32::from_le_bytes(*b));
            !delivery.to_server && word == Some(opcode::CREATE_PLAYER)
        })
    }

    /// Every session of a client: each begins with a login that was answered.
    fn all_of(recording: &Recording, client: u32) -> Vec<Self> {
        let own = recording.datagrams.iter().filter(|d| d.client == client);
        let mut starts: Vec<Vec<&Datagram>> = Vec::new();
        let mut answered = false;
        for datagram in own {
            let login = datagram.to_server && has(datagram, PacketFlags::LOGIN_REQUEST);
            // A login that is repeated before it is answered begins nothing.
            if starts.is_empty() || login && answered {
                starts.push(Vec::new());
                answered = false;
            }
            answered |= !datagram.to_server && has(datagram, PacketFlags::CONNECT_REQUEST);
            if let Some(session) = starts.last_mut() {
                session.push(datagram);
            }
        }
        let damage = &recording.damage;
        starts
            .iter()
            .filter_map(|datagrams| Self::decode(client, datagrams, damage.clone()))
            .collect()
    }

    /// `None` without a ConnectRequest: the key streams are not known.
    fn decode(client: u32, datagrams: &[&Datagram], damage: Option<String>) -> Option<Self> {
        let start = datagrams.first()?.time;
        let mut session = Self {
            client,
            deliveries: Vec::new(),
            arrivals: Vec::with_capacity(datagrams.len()),
            stats: DatagramStats::default(),
            damage,
        };
        let mut lines: Option<Lines> = None;
        let mut incoming = Vec::new();
        for datagram in datagrams {
            let time = datagram.time.saturating_sub(start);
            let now = time as f64 / 1e9;
            session.arrivals.push(time);
            session.stats.datagrams += 1;
            let Some(lines) = &mut lines else {
                lines = session.handshake(datagram, now);
                continue;
            };
            if has(datagram, HANDSHAKE) {
                // Repeats of what is done.
                continue;
            }
            let line = match datagram.to_server {
                true => &mut lines.to_server,
                false => &mut lines.to_client,
            };
            line.take(&datagram.bytes, now, &mut incoming);
            session.collect(&mut incoming, time, datagram.to_server);
        }
        let mut lines = lines?;
        let time = session.arrivals.last().copied().unwrap_or(0);
        for (line, to_server) in [(&mut lines.to_client, false), (&mut lines.to_server, true)] {
            while line.connection.is_waiting() {
                line.connection.give_up(time as f64 / 1e9, &mut incoming);
                session.collect(&mut incoming, time, to_server);
            }
        }
        Some(session)
    }

    /// Before the key streams are known only the answer to the login counts.
    fn handshake(&mut self, datagram: &Datagram, now: f64) -> Option<Lines> {
        let packet = match Packet::parse(&datagram.bytes) {
            Ok(packet) => packet,
            Err(_) => {
                self.stats.undecodable += 1;
                return None;
            }
        };
        if packet.verify() == ac_client::net::transport::Verified::Wrong {
            self.stats.undecodable += 1;
            return None;
        }
        let connect = packet.optional.connect_request?;
        (!datagram.to_server).then(|| Lines::new(&connect, now))
    }

    fn collect(&mut self, incoming: &mut Vec<Incoming>, time: u64, to_server: bool) {
        let stats = &mut self.stats;
        for item in incoming.drain(..) {
            match item {
                Incoming::Message(message) => {
                    match to_server {
                        true => stats.messages_to_server += 1,
                        false => stats.messages_to_client += 1,
                    }
                    self.deliveries.push(Delivery {
                        time,
                        to_server,
                        bytes: message.bytes,
                    });
                }
                Incoming::Anomaly(Anomaly::Malformed(_) | Anomaly::Checksum) => {
                    stats.undecodable += 1;
                }
                Incoming::Anomaly(Anomaly::Duplicate(_)) => stats.duplicates += 1,
                Incoming::Anomaly(Anomaly::Lost(_) | Anomaly::TooFarAhead(_)) => stats.lost += 1,
                Incoming::Anomaly(Anomaly::Fragment(_)) => stats.fragments += 1,
                _ => {}
            }
        }
    }

    /// Length, s.
    pub fn seconds(&self) -> f64 {
        self.arrivals.last().map_or(0.0, |last| *last as f64 / 1e9)
    }
}

/// Packets of the handshake.
const HANDSHAKE: PacketFlags = PacketFlags::LOGIN_REQUEST
    .union(PacketFlags::CONNECT_REQUEST)
    .union(PacketFlags::CONNECT_RESPONSE);

fn has(datagram: &Datagram, flags: PacketFlags) -> bool {
    // The flag word is at a fixed place; a datagram that is no packet is found out later.
    let word = datagram.bytes.get(4..8).and_then(<[u8]>::first_chunk);
    word.is_some_and(|b| PacketFlags::from_bits_retain(u32::from_le_bytes(*b)).intersects(flags))
}

/// Says why there is no session.
fn missing(recording: &Recording, client: Option<u32>, clients: &[u32]) -> String {
    let damage = recording.damage.as_ref().map_or(String::new(), |damage| {
        format!(" (the file is damaged: {damage})")
    });
    if recording.datagrams.is_empty() {
        return format!("holds no datagrams{damage}");
    }
    if let Some(client) = client.filter(|c| !clients.contains(c)) {
        let known: Vec<_> = clients.iter().map(u32::to_string).collect();
        return format!("has no client {client}; it has {}", known.join(", "));
    }
    format!(
        "has no answer to a login (ConnectRequest), so the key streams are not known: start the recording before the client logs in{damage}"
    )
}
