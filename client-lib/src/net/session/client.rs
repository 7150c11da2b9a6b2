//! The client's side of a session (`spec/09`, 11 and 12).

use std::collections::VecDeque;

use super::{Port, Transmit, opcode};
use crate::net::transport::{
    Anomaly, ConnectRequest, Connection, ConnectionLimits, Incoming, LoginError, LoginRequest,
    Message, OptionalHeaders, Packet, PacketBuilder, PacketFlags, PacketHeader, Queue, Role,
    Verified,
};

/// Intervals of a client session, s, and its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClientConfig {
    /// Between login attempts.
    pub login_retry: f64,
    /// Between the ConnectRequest and the ConnectResponse: the server looks the account up meanwhile.
    pub answer_delay: f64,
    /// Between ConnectResponses.
    pub answer_retry: f64,
    /// Repeats of either.
    pub repeats: u32,
    /// Without a numbered packet sent: send a ping.
    pub keep_alive: f64,
    /// Without a good packet received: give up.
    pub silence: f64,
    /// Whether echo requests are sent; a replay at another speed than the wall clock's must not send any.
    pub echo_interval: Option<f64>,
    /// Bounds of the connection.
    pub limits: ConnectionLimits,
}

impl Default for ClientConfig {
    fn default() -> Self {
        Self {
            login_retry: 3.0,
            answer_delay: 0.2,
            answer_retry: 1.0,
            repeats: 5,
            keep_alive: 10.0,
            silence: 60.0,
            echo_interval: None,
            limits: ConnectionLimits::default(),
        }
    }
}

/// Where a session is (11.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClientState {
    /// The login is sent.
    LoginSent,
    /// The server has answered; the client waits before it answers.
    Answering,
    /// The client has answered; the character list is due.
    AwaitList,
    /// The character list is there.
    CharacterSelect,
    /// The client has asked to enter the world.
    EnterRequested,
    /// The character is named; the own object is due.
    Entering,
    /// The own object is there; the surroundings are loading.
    PortalSpace,
    /// In the world.
    InWorld,
    /// Logging off.
    LoggingOff,
    /// Over.
    Closed,
    /// Never began; see the event.
    Failed,
}

/// Why a session failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SessionFailure {
    /// No answer to the login.
    NoAnswer,
    /// No character list after the handshake.
    NoCharacterList,
    /// The server refused before the login (GDLE: 0 bad login, 5 server full).
    Refused(u32),
    /// A network error by string and table id.
    NetError(u32, u32),
    /// A message says why: its opcode is CharacterError, AccountBooted or AccountBanned.
    Message(Message),
    /// Nothing was received for too long.
    Silence,
}

/// What happened.
#[derive(Debug, Clone, PartialEq)]
pub enum ClientEvent {
    /// The state changed.
    State(ClientState),
    /// A message, in order.
    Message(Message),
    /// The server's game time, s.
    TimeSync(f64),
    /// Something odd was received.
    Anomaly(Anomaly),
    /// The session failed.
    Failed(SessionFailure),
}

/// One login of a client, from the first packet to the last.
#[derive(Debug)]
pub struct ClientSession {
    config: ClientConfig,
    state: ClientState,
    login: Vec<u8>,
    connect: Option<ConnectRequest>,
    answer: Vec<u8>,
    connection: Option<Connection>,
    tries: u32,
    due: f64,
    started: f64,
    last_echo: f64,
    own_guid: Option<u32>,
    ping: u32,
    transmits: VecDeque<Transmit>,
    events: VecDeque<ClientEvent>,
    incoming: Vec<Incoming>,
}

impl ClientSession {
    /// Starts a login at time `now` (s).
    ///
    /// # Errors
    /// When a text of the login cannot be sent.
    pub fn new(login: &LoginRequest, config: ClientConfig, now: f64) -> Result<Self, LoginError> {
        let payload = login.to_bytes()?;
        let optional = OptionalHeaders {
            login: Some(&payload),
            ..OptionalHeaders::default()
        };
        let header = PacketHeader {
            flags: PacketFlags::LOGIN_REQUEST,
            ..PacketHeader::default()
        };
        let login = PacketBuilder::new()
            .start(&optional)
            .finish(header, None)
            .to_vec();
        let first = Transmit {
            port: Port::Login,
            bytes: login.clone(),
        };
        Ok(Self {
            config,
            state: ClientState::LoginSent,
            login,
            connect: None,
            answer: Vec::new(),
            connection: None,
            tries: 0,
            due: now + config.login_retry,
            started: now,
            last_echo: now,
            own_guid: None,
            ping: 0,
            transmits: VecDeque::from([first]),
            events: VecDeque::new(),
            incoming: Vec::new(),
        })
    }

    /// Where the session is.
    pub const fn state(&self) -> ClientState {
        self.state
    }

    /// GUID of the own character, once it is named.
    pub const fn own_guid(&self) -> Option<u32> {
        self.own_guid
    }

    /// The connection, once the server has answered.
    pub const fn connection(&self) -> Option<&Connection> {
        self.connection.as_ref()
    }

    /// The next datagram to send.
    pub fn poll_transmit(&mut self) -> Option<Transmit> {
        if let Some(connection) = &mut self.connection {
            while let Some(bytes) = connection.poll_transmit() {
                self.transmits.push_back(Transmit {
                    port: Port::Login,
                    bytes,
                });
            }
        }
        self.transmits.pop_front()
    }

    /// The next thing that happened.
    pub fn poll_event(&mut self) -> Option<ClientEvent> {
        self.events.pop_front()
    }

    fn enter(&mut self, state: ClientState) {
        if self.state != state {
            self.state = state;
            self.events.push_back(ClientEvent::State(state));
        }
    }

    fn fail(&mut self, failure: SessionFailure) {
        self.events.push_back(ClientEvent::Failed(failure));
        self.enter(ClientState::Failed);
    }

    fn is_over(&self) -> bool {
        matches!(self.state, ClientState::Closed | ClientState::Failed)
    }

    /// Takes a datagram from the server that arrived at `now` (s).
    pub fn receive(&mut self, datagram: &[u8], now: f64) {
        if self.is_over() {
            return;
        }
        match &mut self.connection {
            None => self.receive_first(datagram, now),
            Some(connection) => {
                // A repeated ConnectRequest belongs to the handshake that is done.
                let mut incoming = core::mem::take(&mut self.incoming);
                connection.receive(datagram, now, &mut incoming);
                for item in incoming.drain(..) {
                    self.take(item, now);
                }
                self.incoming = incoming;
            }
        }
    }

    /// Before the connection exists only a ConnectRequest or an error means anything.
    fn receive_first(&mut self, datagram: &[u8], now: f64) {
        let packet = match Packet::parse(datagram) {
            Ok(packet) if packet.verify() == Verified::Clear => packet,
            Ok(_) => {
                return self
                    .events
                    .push_back(ClientEvent::Anomaly(Anomaly::Checksum));
            }
            Err(error) => {
                return self
                    .events
                    .push_back(ClientEvent::Anomaly(Anomaly::Malformed(error)));
            }
        };
        let h = packet.optional;
        if let Some(code) = h.login_error {
            return self.fail(SessionFailure::Refused(code));
        }
        if let Some(e) = h.net_error.or(h.net_error_disconnect) {
            return self.fail(SessionFailure::NetError(e.string, e.table));
        }
        let Some(connect) = h.connect_request else {
            return;
        };
        let id = connect.net_id as u16;
        let limits = self.config.limits;
        let (s, c) = (connect.seed_from_server, connect.seed_from_client);
        self.connection = Some(Connection::new(Role::Client, id, s, c, now, limits));
        self.events
            .push_back(ClientEvent::TimeSync(connect.server_time));
        let optional = OptionalHeaders {
            connect_response: Some(connect.cookie),
            ..OptionalHeaders::default()
        };
        let header = PacketHeader {
            sequence: 1,
            flags: PacketFlags::CONNECT_RESPONSE,
            id,
            ..PacketHeader::default()
        };
        self.answer = PacketBuilder::new()
            .start(&optional)
            .finish(header, None)
            .to_vec();
        self.connect = Some(connect);
        self.tries = 0;
        self.due = now + self.config.answer_delay;
        self.enter(ClientState::Answering);
    }

    fn take(&mut self, item: Incoming, now: f64) {
        match item {
            Incoming::TimeSync(t) => self.events.push_back(ClientEvent::TimeSync(t)),
            Incoming::Echo(_) => {}
            Incoming::Anomaly(a) => self.events.push_back(ClientEvent::Anomaly(a)),
            Incoming::Disconnected => self.enter(ClientState::Closed),
            Incoming::Message(message) => self.take_message(message, now),
        }
    }

    fn take_message(&mut self, message: Message, now: f64) {
        use ClientState as S;
        let refuses = matches!(
            message.opcode(),
            Some(opcode::CHARACTER_ERROR | opcode::ACCOUNT_BOOTED | opcode::ACCOUNT_BANNED)
        );
        match (message.opcode(), self.state) {
            _ if refuses && matches!(self.state, S::Answering | S::AwaitList) => {
                return self.fail(SessionFailure::Message(message));
            }
            (Some(opcode::CHARACTER_LIST), S::Answering | S::AwaitList | S::LoggingOff) => {
                self.enter(S::CharacterSelect)
            }
            (Some(opcode::DDD_INTERROGATION), _) => self.answer_interrogation(now),
            (Some(opcode::CREATE_PLAYER), S::EnterRequested | S::Entering) => {
                self.own_guid = message
                    .bytes
                    .get(4..)
                    .and_then(<[u8]>::first_chunk)
                    .map(|b| u32::from_le_bytes(*b));
            }
            (Some(opcode::CREATE_OBJECT), S::Entering) => {
                let guid = message
                    .bytes
                    .get(4..)
                    .and_then(<[u8]>::first_chunk)
                    .map(|b| u32::from_le_bytes(*b));
                if guid.is_some() && guid == self.own_guid {
                    self.enter(S::PortalSpace);
                }
            }
            (Some(opcode::PLAYER_TELEPORT), S::InWorld) => self.enter(S::PortalSpace),
            (Some(opcode::LOG_OFF), S::LoggingOff) => self.enter(S::CharacterSelect),
            _ => {}
        }
        self.events.push_back(ClientEvent::Message(message));
    }

    /// Language 1 and no files: servers then send no patch.
    fn answer_interrogation(&mut self, now: f64) {
        let mut body = opcode::DDD_INTERROGATION_RESPONSE.to_le_bytes().to_vec();
        body.extend([1u32.to_le_bytes(), 0u32.to_le_bytes()].concat());
        self.send(Queue::DATABASE, &body, now);
        self.send(Queue::DATABASE, &opcode::DDD_END.to_le_bytes(), now);
    }

    /// Sends a message; ignored before the connection exists and after it ended. Messages that move the session on do so.
    pub fn send(&mut self, queue: Queue, message: &[u8], now: f64) {
        if self.is_over() {
            return;
        }
        let Some(connection) = &mut self.connection else {
            return;
        };
        connection.send(queue, message, now);
        let word = |at: usize| {
            message
                .get(at..)
                .and_then(<[u8]>::first_chunk)
                .map(|b| u32::from_le_bytes(*b))
        };
        match word(0) {
            Some(opcode::ENTER_WORLD_REQUEST) => self.enter(ClientState::EnterRequested),
            Some(opcode::ENTER_WORLD) => {
                self.own_guid = word(4);
                self.enter(ClientState::Entering);
            }
            Some(opcode::GAME_ACTION) if word(8) == Some(opcode::ACTION_LOGIN_COMPLETE) => {
                self.enter(ClientState::InWorld)
            }
            Some(opcode::LOG_OFF) => self.enter(ClientState::LoggingOff),
            _ => {}
        }
    }

    /// Ends the session.
    pub fn disconnect(&mut self) {
        if let Some(connection) = &mut self.connection {
            connection.disconnect();
        }
        self.enter(ClientState::Closed);
    }

    /// Number of the next game action: the word after the opcode of a 0xF7B1 message. Servers do not check it.
    fn ping_message(&mut self) -> Vec<u8> {
        self.ping += 1;
        [opcode::GAME_ACTION, 0, opcode::ACTION_PING]
            .iter()
            .flat_map(|w| w.to_le_bytes())
            .collect()
    }

    /// Pings sent so far.
    pub const fn pings(&self) -> u32 {
        self.ping
    }

    /// Work that is due at `now` (s).
    pub fn handle_timeout(&mut self, now: f64) {
        match self.state {
            ClientState::LoginSent if now >= self.due => {
                if self.tries == self.config.repeats {
                    return self.fail(SessionFailure::NoAnswer);
                }
                self.tries += 1;
                self.due = now + self.config.login_retry;
                self.transmits.push_back(Transmit {
                    port: Port::Login,
                    bytes: self.login.clone(),
                });
            }
            ClientState::Answering | ClientState::AwaitList if now >= self.due => {
                if self.tries > self.config.repeats {
                    return self.fail(SessionFailure::NoCharacterList);
                }
                self.tries += 1;
                self.due = now + self.config.answer_retry;
                self.transmits.push_back(Transmit {
                    port: Port::Next,
                    bytes: self.answer.clone(),
                });
                self.enter(ClientState::AwaitList);
            }
            _ => {}
        }
        self.keep_alive(now);
    }

    fn keep_alive(&mut self, now: f64) {
        if self.is_over() {
            return;
        }
        let Some(connection) = &mut self.connection else {
            return;
        };
        connection.handle_timeout(now);
        let (silent, idle) = (
            now - connection.last_received(),
            now - connection.last_numbered_sent(),
        );
        let before_list = matches!(self.state, ClientState::Answering | ClientState::AwaitList);
        if silent >= self.config.silence {
            return self.fail(SessionFailure::Silence);
        }
        if before_list {
            return;
        }
        if self
            .config
            .echo_interval
            .is_some_and(|every| now - self.last_echo >= every)
        {
            self.last_echo = now;
            let echo_request = Some((now - self.started) as f32);
            connection.send_headers(
                &OptionalHeaders {
                    echo_request,
                    ..OptionalHeaders::default()
                },
                now,
            );
        } else if idle >= self.config.keep_alive {
            let ping = self.ping_message();
            self.send(Queue::WEENIE, &ping, now);
        }
    }

    /// When [`ClientSession::handle_timeout`] is due next, s; `None` once the session is over.
    pub fn next_timeout(&self) -> Option<f64> {
        if self.is_over() {
            return None;
        }
        let handshake = matches!(
            self.state,
            ClientState::LoginSent | ClientState::Answering | ClientState::AwaitList
        );
        let connection = self.connection.as_ref();
        let times = [
            handshake.then_some(self.due),
            connection.and_then(Connection::next_timeout),
            connection.map(|c| c.last_received() + self.config.silence),
            connection
                .filter(|_| !handshake)
                .map(|c| c.last_numbered_sent() + self.config.keep_alive),
            self.config
                .echo_interval
                .filter(|_| !handshake)
                .map(|every| self.last_echo + every),
        ];
        times.into_iter().flatten().min_by(f64::total_cmp)
    }
}
