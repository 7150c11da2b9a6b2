//! The relay's decisions, without sockets: who is a client, and where a datagram goes.
//!
//! Every client gets a socket of its own towards the server, so that the server sees different clients. Datagrams are passed on byte for
//! byte. A client sends to the relay's two ports from one address; the server answers from either of its two ports to the client's socket
//! (ACE from the second, GDLE from the first; `spec/09-network.md`, 2).
//!
//! Addresses of UDP datagrams can be forged, so an unknown address is served in steps:
//!
//! 1. Only a valid LoginRequest (or WorldLoginRequest) makes a client. Everything else from unknown addresses is refused.
//! 2. Until the client has answered a ConnectRequest with its cookie, it gets at most [`AMPLIFICATION`] times the bytes that it sent.
//!    More is held back until then, up to [`HELD`] bytes, and sent in order afterwards. A real client answers after 0.2 s.
//! 3. A client that has not answered is forgotten sooner, and makes room when there are too many.

use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;

use ac_client::net::session::Port;
use ac_client::net::transport::{HEADER_LENGTH, Packet, PacketFlags, PacketHeader, Verified};

/// Number of a client, from 0, never used again.
pub type ClientNumber = u32;

/// An address that has not proved itself gets at most so many times the bytes that came from it.
pub const AMPLIFICATION: usize = 3;
/// Bytes held back for one client.
pub const HELD: usize = 64 << 10;
/// ConnectRequests of one client whose cookies are remembered.
const COOKIES: usize = 4;

/// Bounds of a relay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayLimits {
    /// Clients at once; more are not served.
    pub clients: usize,
    /// A client that was silent for so long, s, and its server too, is forgotten.
    pub idle: f64,
    /// The same for a client that has not proved its address.
    pub unproved_idle: f64,
}

impl Default for RelayLimits {
    fn default() -> Self {
        Self {
            clients: 64,
            idle: 120.0,
            unproved_idle: 20.0,
        }
    }
}

struct Client {
    number: ClientNumber,
    address: SocketAddr,
    last: f64,
    proved: bool,
    cookies: VecDeque<u64>,
    received: usize,
    sent: usize,
    held: Vec<(Port, Vec<u8>)>,
    held_bytes: usize,
}

/// What happens with a client's datagram.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FromClient {
    /// It is passed on.
    Pass(ToServer),
    /// The address is unknown, and the datagram is no login.
    Refused,
    /// A login, but there are too many clients.
    Full,
}

/// Where a client's datagram goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ToServer {
    /// Whose socket sends it.
    pub client: ClientNumber,
    /// The client was not known: it needs a socket.
    pub is_new: bool,
    /// A client that was forgotten to make room; its socket is to be closed.
    pub evicted: Option<ClientNumber>,
    /// Where to.
    pub to: SocketAddr,
    /// What was held back for this client, which has proved its address with this datagram.
    pub released: Vec<(Port, Vec<u8>)>,
}

/// What happens with a server's datagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FromServer {
    /// It is passed on.
    Pass(ToClient),
    /// It waits until the client has proved its address.
    Held(Port),
    /// Too much waits already.
    Dropped(Port),
    /// It is not the server's, or the client is gone.
    Stranger,
}

/// Where a server's datagram goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ToClient {
    /// The relay's port that sends it.
    pub port: Port,
    /// Where to.
    pub to: SocketAddr,
}

/// Clients and the server between whom datagrams are passed on.
pub struct Relay {
    server: SocketAddr,
    limits: RelayLimits,
    clients: BTreeMap<ClientNumber, Client>,
    numbers: BTreeMap<SocketAddr, ClientNumber>,
    next: ClientNumber,
}

/// The second of two ports in a row.
pub fn next_port(address: SocketAddr) -> Option<SocketAddr> {
    let port = address.port().checked_add(1)?;
    Some(SocketAddr::new(address.ip(), port))
}

/// Flags of a datagram's header, if it has one.
fn flags(datagram: &[u8]) -> PacketFlags {
    let head = datagram.first_chunk::<HEADER_LENGTH>();
    head.map_or(PacketFlags::empty(), |head| PacketHeader::parse(head).flags)
}

/// A valid packet that starts a session.
fn is_login(datagram: &[u8]) -> bool {
    let first = PacketFlags::LOGIN_REQUEST | PacketFlags::WORLD_LOGIN_REQUEST;
    flags(datagram).intersects(first)
        && Packet::parse(datagram).is_ok_and(|packet| packet.verify() != Verified::Wrong)
}

/// The cookie that a ConnectRequest gives, or that a ConnectResponse repeats.
fn cookie(datagram: &[u8], flag: PacketFlags) -> Option<u64> {
    if !flags(datagram).contains(flag) {
        return None;
    }
    let optional = Packet::parse(datagram).ok()?.optional;
    if flag == PacketFlags::CONNECT_REQUEST {
        optional.connect_request.map(|request| request.cookie)
    } else {
        optional.connect_response
    }
}

impl Relay {
    /// A relay to a server, named by its login port; `None` when there is no next port.
    pub fn new(server: SocketAddr, limits: RelayLimits) -> Option<Self> {
        next_port(server)?;
        Some(Self {
            server,
            limits,
            clients: BTreeMap::new(),
            numbers: BTreeMap::new(),
            next: 0,
        })
    }

    /// Clients at the moment.
    pub fn clients(&self) -> usize {
        self.clients.len()
    }

    fn server(&self, port: Port) -> SocketAddr {
        match port {
            Port::Login => self.server,
            Port::Next => next_port(self.server).unwrap_or(self.server),
        }
    }

    /// A datagram of a client that arrived at the relay's port at `now`, s.
    pub fn route_client(
        &mut self,
        address: SocketAddr,
        port: Port,
        datagram: &[u8],
        now: f64,
    ) -> FromClient {
        let known = self.numbers.get(&address).copied();
        let mut evicted = None;
        let number = match known {
            Some(number) => number,
            None if !is_login(datagram) => return FromClient::Refused,
            None => {
                if self.clients.len() >= self.limits.clients {
                    evicted = self.make_room();
                    if evicted.is_none() {
                        return FromClient::Full;
                    }
                }
                self.add(address, now)
            }
        };
        let to = self.server(port);
        let mut released = Vec::new();
        if let Some(client) = self.clients.get_mut(&number) {
            client.last = now;
            client.received += datagram.len();
            released = client.prove(datagram);
        }
        FromClient::Pass(ToServer {
            client: number,
            is_new: known.is_none(),
            evicted,
            to,
            released,
        })
    }

    fn add(&mut self, address: SocketAddr, now: f64) -> ClientNumber {
        let number = self.next;
        self.next += 1;
        self.numbers.insert(address, number);
        let client = Client {
            number,
            address,
            last: now,
            proved: false,
            cookies: VecDeque::new(),
            received: 0,
            sent: 0,
            held: Vec::new(),
            held_bytes: 0,
        };
        self.clients.insert(number, client);
        number
    }

    /// Forgets the client that has been silent for longest among those that have not proved their addresses.
    fn make_room(&mut self) -> Option<ClientNumber> {
        let unproved = self.clients.values().filter(|c| !c.proved);
        let number = unproved.min_by(|a, b| a.last.total_cmp(&b.last))?.number;
        self.remove(number);
        Some(number)
    }

    fn remove(&mut self, number: ClientNumber) {
        if let Some(client) = self.clients.remove(&number) {
            self.numbers.remove(&client.address);
        }
    }

    /// A datagram that arrived at a client's socket at `now`, s.
    pub fn route_server(
        &mut self,
        client: ClientNumber,
        from: SocketAddr,
        datagram: &[u8],
        now: f64,
    ) -> FromServer {
        let ports = [Port::Login, Port::Next];
        let port = ports.into_iter().find(|&p| self.server(p) == from);
        let (Some(port), Some(client)) = (port, self.clients.get_mut(&client)) else {
            return FromServer::Stranger;
        };
        client.last = now;
        if client.proved {
            return FromServer::Pass(ToClient {
                port,
                to: client.address,
            });
        }
        client.answer(port, datagram)
    }

    /// Forgets the clients that have been silent for too long, and names them: their sockets are to be closed.
    pub fn expire(&mut self, now: f64) -> Vec<ClientNumber> {
        let limits = self.limits;
        let silent = |c: &&Client| {
            let idle = if c.proved {
                limits.idle
            } else {
                limits.unproved_idle.min(limits.idle)
            };
            now - c.last >= idle
        };
        let gone: Vec<_> = self
            .clients
            .values()
            .filter(silent)
            .map(|c| c.number)
            .collect();
        for &number in &gone {
            self.remove(number);
        }
        gone
    }
}

impl Client {
    /// A datagram of the client: perhaps it repeats a cookie. Hands out what was held back.
    fn prove(&mut self, datagram: &[u8]) -> Vec<(Port, Vec<u8>)> {
        if self.proved {
            return Vec::new();
        }
        let answer = cookie(datagram, PacketFlags::CONNECT_RESPONSE);
        self.proved = answer.is_some_and(|cookie| self.cookies.contains(&cookie));
        if self.proved {
            self.held_bytes = 0;
            std::mem::take(&mut self.held)
        } else {
            Vec::new()
        }
    }

    /// A datagram for the client, which has not proved its address.
    fn answer(&mut self, port: Port, datagram: &[u8]) -> FromServer {
        if let Some(cookie) = cookie(datagram, PacketFlags::CONNECT_REQUEST) {
            if self.cookies.len() >= COOKIES {
                self.cookies.pop_front();
            }
            self.cookies.push_back(cookie);
        }
        let fits = self.sent + datagram.len() <= AMPLIFICATION * self.received;
        if fits && self.held.is_empty() {
            self.sent += datagram.len();
            return FromServer::Pass(ToClient {
                port,
                to: self.address,
            });
        }
        if self.held_bytes + datagram.len() > HELD {
            return FromServer::Dropped(port);
        }
        self.held_bytes += datagram.len();
        self.held.push((port, datagram.to_vec()));
        FromServer::Held(port)
    }
}

#[cfg(test)]
mod tests;
