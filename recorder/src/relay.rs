//! The relay's decisions, without sockets: who is a client, and where a datagram goes.
//!
//! Every client gets a socket of its own towards the server, so that the server sees different clients. Datagrams are passed on byte for
//! byte. A client sends to the relay's two ports from one address; the server answers from either of its two ports to the client's socket.

use std::net::SocketAddr;

use ac_client::net::session::Port;

/// Number of a client, from 0, never used again.
pub type ClientNumber = u32;

/// Bounds of a relay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayLimits {
    /// Clients at once; more are not served.
    pub clients: usize,
    /// A client that was silent for so long, s, and its server too, is forgotten.
    pub idle: f64,
}

impl Default for RelayLimits {
    fn default() -> Self {
        Self {
            clients: 64,
            idle: 120.0,
        }
    }
}

struct Client {
    number: ClientNumber,
    address: SocketAddr,
    last: f64,
}

/// Where a client's datagram goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ToServer {
    /// Whose socket sends it.
    pub client: ClientNumber,
    /// The client was not known: it needs a socket.
    pub is_new: bool,
    /// Where to.
    pub to: SocketAddr,
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
    clients: Vec<Client>,
    next: ClientNumber,
}

/// The second of two ports in a row.
pub fn next_port(address: SocketAddr) -> Option<SocketAddr> {
    let port = address.port().checked_add(1)?;
    Some(SocketAddr::new(address.ip(), port))
}

impl Relay {
    /// A relay to a server, named by its login port; `None` when there is no next port.
    pub fn new(server: SocketAddr, limits: RelayLimits) -> Option<Self> {
        next_port(server)?;
        Some(Self {
            server,
            limits,
            clients: Vec::new(),
            next: 0,
        })
    }

    /// Clients at the moment.
    pub const fn clients(&self) -> usize {
        self.clients.len()
    }

    fn server(&self, port: Port) -> SocketAddr {
        match port {
            Port::Login => self.server,
            Port::Next => next_port(self.server).unwrap_or(self.server),
        }
    }

    /// A datagram of a client that arrived at the relay's port at `now`, s; `None` when there are too many clients.
    pub fn route_client(&mut self, address: SocketAddr, port: Port, now: f64) -> Option<ToServer> {
        let to = self.server(port);
        if let Some(client) = self.clients.iter_mut().find(|c| c.address == address) {
            client.last = now;
            let client = client.number;
            return Some(ToServer {
                client,
                is_new: false,
                to,
            });
        }
        if self.clients.len() >= self.limits.clients {
            return None;
        }
        let number = self.next;
        self.next += 1;
        self.clients.push(Client {
            number,
            address,
            last: now,
        });
        Some(ToServer {
            client: number,
            is_new: true,
            to,
        })
    }

    /// A datagram that arrived at a client's socket at `now`, s; `None` when it is not the server's, or the client is gone.
    pub fn route_server(
        &mut self,
        client: ClientNumber,
        from: SocketAddr,
        now: f64,
    ) -> Option<ToClient> {
        let port = [Port::Login, Port::Next]
            .into_iter()
            .find(|&port| self.server(port) == from)?;
        let client = self.clients.iter_mut().find(|c| c.number == client)?;
        client.last = now;
        Some(ToClient {
            port,
            to: client.address,
        })
    }

    /// Forgets the clients that have been silent for too long, and names them: their sockets are to be closed.
    pub fn expire(&mut self, now: f64) -> Vec<ClientNumber> {
        let idle = self.limits.idle;
        self.clients
            .extract_if(.., |c| now - c.last >= idle)
            .map(|c| c.number)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(port: u16) -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], port))
    }

    #[test]
    fn datagrams_find_their_way() {
        let mut relay = Relay::new(at(9000), RelayLimits::default()).expect("two ports");
        let first = relay.route_client(at(1), Port::Login, 0.0);
        let expected = ToServer {
            client: 0,
            is_new: true,
            to: at(9000),
        };
        assert_eq!(first, Some(expected));
        let again = relay.route_client(at(1), Port::Next, 0.0).expect("known");
        assert_eq!((again.client, again.is_new, again.to), (0, false, at(9001)));
        let second = relay.route_client(at(2), Port::Login, 0.0).expect("room");
        assert_eq!(second.client, 1);
        let back = relay.route_server(1, at(9001), 0.0);
        let expected = ToClient {
            port: Port::Next,
            to: at(2),
        };
        assert_eq!(back, Some(expected));
        assert_eq!(relay.route_server(1, at(9002), 0.0), None);
        assert_eq!(relay.route_server(7, at(9000), 0.0), None);
    }

    #[test]
    fn clients_are_bounded_and_expire() {
        let limits = RelayLimits {
            clients: 1,
            idle: 10.0,
        };
        let mut relay = Relay::new(at(9000), limits).expect("two ports");
        assert!(relay.route_client(at(1), Port::Login, 0.0).is_some());
        assert!(relay.route_client(at(2), Port::Login, 1.0).is_none());
        assert!(relay.route_server(0, at(9000), 5.0).is_some());
        assert!(relay.expire(14.0).is_empty());
        assert_eq!(relay.expire(15.0), [0]);
        assert_eq!(relay.clients(), 0);
        let next = relay.route_client(at(2), Port::Login, 16.0).expect("room");
        assert_eq!((next.client, next.is_new), (1, true));
        assert!(Relay::new(at(65535), limits).is_none());
    }
}
