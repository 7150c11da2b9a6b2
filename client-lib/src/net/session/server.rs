//! The server's side of a session, for tests and demonstrations (`spec/09`, 11; habits of ACE).

use std::collections::VecDeque;

use super::{Port, Transmit};
use crate::net::transport::{
    Anomaly, AuthType, ConnectRequest, Connection, ConnectionLimits, Incoming, LoginRequest,
    Message, OptionalHeaders, Packet, PacketBuilder, PacketFlags, PacketHeader, Queue, Role,
    Verified,
};

/// What a server session is made with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServerConfig {
    /// Server id in packet headers.
    pub server_id: u16,
    /// NetID given to the client.
    pub net_id: u16,
    /// Cookie of the handshake.
    pub cookie: u64,
    /// Seed of the key stream to the client.
    pub seed_to_client: u32,
    /// Seed of the key stream from the client.
    pub seed_from_client: u32,
    /// Game time at session time 0, s.
    pub game_time: f64,
    /// Between time syncs, s.
    pub time_sync: f64,
    /// Without a good packet received: the session ends, s.
    pub silence: f64,
    /// Whether packets after the handshake come from port P + 1 (ACE) instead of P (GDLE).
    pub send_from_next: bool,
    /// Bounds of the connection.
    pub limits: ConnectionLimits,
}

impl Default for ServerConfig {
    fn default() -> Self {
        Self {
            server_id: 11,
            net_id: 7,
            cookie: 0x0123_4567_89AB_CDEF,
            seed_to_client: 0x1234_5678,
            seed_from_client: 0x99E7_7855,
            game_time: 1_234_567.5,
            time_sync: 20.0,
            silence: 60.0,
            send_from_next: true,
            limits: ConnectionLimits::default(),
        }
    }
}

/// Where a server session is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServerState {
    /// A LoginRequest is due.
    AwaitLogin,
    /// The ConnectRequest is sent; the answer is due.
    AwaitAnswer,
    /// The handshake is done.
    Connected,
    /// Over.
    Closed,
}

/// Who logged in. The secret is dropped: this server trusts everybody.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Login {
    /// Account name, without the password that GDLE logins carry in it.
    pub account: String,
    /// Client version.
    pub version: String,
}

/// What happened.
#[derive(Debug, Clone, PartialEq)]
pub enum ServerEvent {
    /// The handshake is done.
    Connected(Login),
    /// A message, in order.
    Message(Message),
    /// Something odd was received.
    Anomaly(Anomaly),
    /// The client left, or was silent for too long.
    Closed,
}

/// One client's session on a server.
#[derive(Debug)]
pub struct ServerSession {
    config: ServerConfig,
    state: ServerState,
    login: Option<Login>,
    /// The ConnectRequest: sent again when the login comes again.
    greeting: Vec<u8>,
    connection: Option<Connection>,
    started: f64,
    last_sync: f64,
    transmits: VecDeque<Transmit>,
    events: VecDeque<ServerEvent>,
    incoming: Vec<Incoming>,
}

impl ServerSession {
    /// A session that waits for a login, at time `now` (s).
    pub fn new(config: ServerConfig, now: f64) -> Self {
        Self {
            config,
            state: ServerState::AwaitLogin,
            login: None,
            greeting: Vec::new(),
            connection: None,
            started: now,
            last_sync: now,
            transmits: VecDeque::new(),
            events: VecDeque::new(),
            incoming: Vec::new(),
        }
    }

    /// Where the session is.
    pub const fn state(&self) -> ServerState {
        self.state
    }

    /// The connection, once the login was received.
    pub const fn connection(&self) -> Option<&Connection> {
        self.connection.as_ref()
    }

    /// The next datagram to send, and from which port.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        let port = if self.config.send_from_next {
            Port::Next
        } else {
            Port::Login
        };
        if self.state != ServerState::AwaitAnswer
            && let Some(connection) = &mut self.connection
        {
            while let Some(bytes) = connection.poll_transmit() {
                self.transmits.push_back(Transmit { port, bytes });
            }
        }
        self.transmits.pop_front()
    }

    /// The next thing that happened.
    pub fn poll_event(&mut self) -> Option<ServerEvent> {
        self.events.pop_front()
    }

    /// Takes a datagram that arrived on `port` at `now` (s).
    pub fn receive(&mut self, port: Port, datagram: &[u8], now: f64) {
        match (self.state, port) {
            (ServerState::Closed, _) => {}
            (ServerState::AwaitLogin, Port::Login) => self.receive_login(datagram, now),
            (ServerState::AwaitAnswer, Port::Login) => self.greet_again(datagram),
            (ServerState::AwaitAnswer, Port::Next) => self.receive_answer(datagram, now),
            (ServerState::Connected, Port::Login) => self.receive_packet(datagram, now),
            // Repeats of the handshake, and packets to the wrong port.
            _ => {}
        }
    }

    /// The client has not got the answer to its login. (ACE forgets the session here and waits for the next login; this server is for tests.)
    fn greet_again(&mut self, datagram: &[u8]) {
        if read_login(datagram).is_some() {
            self.transmits.push_back(Transmit {
                port: Port::Login,
                bytes: self.greeting.clone(),
            });
        }
    }

    fn receive_login(&mut self, datagram: &[u8], now: f64) {
        let Some(login) = read_login(datagram) else {
            return;
        };
        let account = match login.auth {
            AuthType::Account => login
                .account
                .split(':')
                .next()
                .unwrap_or_default()
                .to_owned(),
            _ => login.account,
        };
        self.login = Some(Login {
            account,
            version: login.version,
        });
        let c = self.config;
        let connect_request = Some(ConnectRequest {
            server_time: c.game_time + (now - self.started),
            cookie: c.cookie,
            net_id: c.net_id.into(),
            seed_from_server: c.seed_to_client,
            seed_from_client: c.seed_from_client,
            unused: 0,
        });
        let optional = OptionalHeaders {
            connect_request,
            ..OptionalHeaders::default()
        };
        let header = PacketHeader {
            flags: PacketFlags::CONNECT_REQUEST,
            id: c.server_id,
            iteration: 1,
            ..PacketHeader::default()
        };
        let bytes = PacketBuilder::new()
            .start(&optional)
            .finish(header, None)
            .to_vec();
        self.greeting.clone_from(&bytes);
        self.transmits.push_back(Transmit {
            port: Port::Login,
            bytes,
        });
        self.connection = Some(Connection::new(
            Role::Server,
            c.server_id,
            c.seed_to_client,
            c.seed_from_client,
            now,
            c.limits,
        ));
        self.state = ServerState::AwaitAnswer;
    }

    fn receive_answer(&mut self, datagram: &[u8], now: f64) {
        let answer = Packet::parse(datagram)
            .ok()
            .and_then(|p| p.optional.connect_response);
        if answer != Some(self.config.cookie) {
            return;
        }
        self.state = ServerState::Connected;
        self.send_time(now);
        self.events
            .extend(self.login.clone().map(ServerEvent::Connected));
    }

    fn receive_packet(&mut self, datagram: &[u8], now: f64) {
        let Some(connection) = &mut self.connection else {
            return;
        };
        connection.receive(datagram, now, &mut self.incoming);
        for item in self.incoming.drain(..) {
            match item {
                Incoming::Message(m) => self.events.push_back(ServerEvent::Message(m)),
                Incoming::Anomaly(a) => self.events.push_back(ServerEvent::Anomaly(a)),
                Incoming::Disconnected => {
                    self.state = ServerState::Closed;
                    self.events.push_back(ServerEvent::Closed);
                }
                Incoming::TimeSync(_) | Incoming::Echo(_) => {}
            }
        }
    }

    fn send_time(&mut self, now: f64) {
        self.last_sync = now;
        let time_sync = Some(self.config.game_time + (now - self.started));
        if let Some(connection) = &mut self.connection {
            connection.send_headers(
                &OptionalHeaders {
                    time_sync,
                    ..OptionalHeaders::default()
                },
                now,
            );
        }
    }

    /// Sends a message once the handshake is done.
    pub fn send(&mut self, queue: Queue, message: &[u8], now: f64) {
        if let (ServerState::Connected, Some(connection)) = (self.state, &mut self.connection) {
            connection.send(queue, message, now);
        }
    }

    /// Sends messages that share packets where they fit, once the handshake is done.
    pub fn send_all(&mut self, messages: &[(Queue, &[u8])], now: f64) {
        if let (ServerState::Connected, Some(connection)) = (self.state, &mut self.connection) {
            connection.send_all(messages, now);
        }
    }

    /// Ends the session.
    pub fn disconnect(&mut self) {
        if let Some(connection) = &mut self.connection {
            connection.disconnect();
        }
        self.state = ServerState::Closed;
    }

    /// Work that is due at `now` (s).
    pub fn handle_timeout(&mut self, now: f64) {
        if self.state != ServerState::Connected {
            return;
        }
        if now - self.last_sync >= self.config.time_sync {
            self.send_time(now);
        }
        if let Some(connection) = &mut self.connection {
            connection.handle_timeout(now);
            if now - connection.last_received() >= self.config.silence {
                self.state = ServerState::Closed;
                self.events.push_back(ServerEvent::Closed);
            }
        }
    }
}

fn read_login(datagram: &[u8]) -> Option<LoginRequest> {
    let packet = Packet::parse(datagram).ok()?;
    let payload = packet.optional.login?;
    (packet.verify() == Verified::Clear)
        .then(|| LoginRequest::parse(payload).ok())
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::super::{
        ClientConfig, ClientEvent, ClientSession, ClientState, SessionFailure, opcode,
    };
    use super::*;

    fn login() -> LoginRequest {
        LoginRequest {
            version: "1802".into(),
            auth: AuthType::Password,
            auth_flags: 1,
            timestamp: 1,
            account: "tester".into(),
            account_override: String::new(),
            secret: Some("secret".into()),
        }
    }

    /// Runs both sides for a while; `lost` says which client datagram does not arrive.
    fn run(
        client: &mut ClientSession,
        server: &mut ServerSession,
        from: f64,
        to: f64,
        lost: impl Fn(usize) -> bool,
    ) {
        let (mut now, mut n) = (from, 0);
        while now < to {
            client.handle_timeout(now);
            server.handle_timeout(now);
            while let Some(t) = client.poll_transmit() {
                if !lost(n) {
                    server.receive(t.port, &t.bytes, now);
                }
                n += 1;
            }
            while let Some(t) = server.poll_transmit() {
                client.receive(&t.bytes, now);
            }
            while let Some(event) = server.poll_event() {
                if let ServerEvent::Connected(login) = event {
                    assert_eq!(login.account, "tester");
                    server.send(Queue::UI, &opcode::CHARACTER_LIST.to_le_bytes(), now);
                }
            }
            now += 0.05;
        }
    }

    #[test]
    fn a_client_logs_in_and_stays() {
        for lost in [None, Some(0), Some(1), Some(2)] {
            let mut client =
                ClientSession::new(&login(), ClientConfig::default(), 0.0).expect("a valid login");
            let mut server = ServerSession::new(ServerConfig::default(), 0.0);
            run(&mut client, &mut server, 0.0, 8.0, |n| Some(n) == lost);
            assert_eq!(
                (client.state(), server.state()),
                (ClientState::CharacterSelect, ServerState::Connected)
            );
            run(&mut client, &mut server, 8.0, 100.0, |_| false);
            assert_eq!(
                server.state(),
                ServerState::Connected,
                "pings keep the session"
            );
            assert!(client.pings() >= 5);
            client.disconnect();
            run(&mut client, &mut server, 100.0, 100.2, |_| false);
            assert_eq!(server.state(), ServerState::Closed);
        }
    }

    #[test]
    fn a_client_gives_up_on_a_silent_server() {
        let mut client =
            ClientSession::new(&login(), ClientConfig::default(), 0.0).expect("a valid login");
        let mut sent = 0;
        while let Some(at) = client.next_timeout() {
            client.handle_timeout(at);
            sent += std::iter::from_fn(|| client.poll_transmit()).count();
        }
        assert_eq!((client.state(), sent), (ClientState::Failed, 6));
        let failed = std::iter::from_fn(|| client.poll_event())
            .find(|e| matches!(e, ClientEvent::Failed(_)));
        assert_eq!(failed, Some(ClientEvent::Failed(SessionFailure::NoAnswer)));
    }
}
