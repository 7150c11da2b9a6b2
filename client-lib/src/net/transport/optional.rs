//! Optional headers: their layout and order (`spec/09`, 4 and 5).

use super::packet::{PacketError, PacketFlags};

/// A list of packet sequences, as it lies in a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SequenceList<'a>(pub(super) &'a [u8]);

impl<'a> SequenceList<'a> {
    /// A list of little-endian words; `None` unless the length is a multiple of 4.
    pub const fn new(bytes: &'a [u8]) -> Option<Self> {
        if bytes.len().is_multiple_of(4) {
            Some(Self(bytes))
        } else {
            None
        }
    }

    /// The sequences in order.
    pub fn iter(self) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.0
            .chunks_exact(4)
            .map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]))
    }

    /// Number of entries.
    pub const fn len(self) -> usize {
        self.0.len() / 4
    }

    /// Whether there is none.
    pub const fn is_empty(self) -> bool {
        self.0.is_empty()
    }
}

/// Move to another server during play; no known server sends it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ServerSwitch {
    /// Sequence.
    pub sequence: u32,
    /// Type.
    pub kind: u32,
}

/// An IPv4 socket address as retail wrote it: family, port big endian, address, eight more bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SocketAddress {
    /// Address family; 2 is IPv4.
    pub family: u16,
    /// UDP port.
    pub port: u16,
    /// IPv4 address in written order.
    pub address: [u8; 4],
    /// Padding, normally zero.
    pub padding: [u8; 8],
}

/// The login service sends the client to a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Referral {
    /// To be repeated in the WorldLoginRequest.
    pub cookie: u64,
    /// The world's address.
    pub address: SocketAddress,
    /// Server id.
    pub server_id: u16,
    /// Normally zero.
    pub unused: [u8; 6],
}

/// The server's answer to a login: cookie, NetID and the seeds of both key streams.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConnectRequest {
    /// The server's game time, s.
    pub server_time: f64,
    /// To be repeated in the ConnectResponse.
    pub cookie: u64,
    /// Identifies the client in its packet headers; used as 16 bits.
    pub net_id: u32,
    /// Seed of the key stream of packets from the server.
    pub seed_from_server: u32,
    /// Seed of the key stream of packets to the server.
    pub seed_from_client: u32,
    /// 0 (ACE) or 2 (GDLE).
    pub unused: u32,
}

/// An error by its place in the string tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NetError {
    /// String id.
    pub string: u32,
    /// String table id.
    pub table: u32,
}

/// Answer to an echo request.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EchoResponse {
    /// The echoed time, s.
    pub time: f32,
    /// Meant as the time it was held, s; servers write other things.
    pub holding: f32,
}

/// Flow report; ignored by servers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flow {
    /// Bytes received.
    pub bytes: u32,
    /// Interval.
    pub interval: u16,
}

/// The optional headers of one packet, in the order in which they lie in it. Lists and the login stay bytes of the packet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[allow(missing_docs, reason = "the types say it")]
pub struct OptionalHeaders<'a> {
    pub server_switch: Option<ServerSwitch>,
    pub logon_server: Option<SocketAddress>,
    pub referral: Option<Referral>,
    /// Packets asked for again (NAK).
    pub request_retransmit: Option<SequenceList<'a>>,
    /// Packets that cannot be sent again (empty ack).
    pub reject_retransmit: Option<SequenceList<'a>>,
    /// Everything up to this sequence was received.
    pub ack: Option<u32>,
    /// Payload of a LoginRequest, to the end of the packet; see [`LoginRequest`](super::LoginRequest).
    pub login: Option<&'a [u8]>,
    /// Cookie of the Referral.
    pub world_login: Option<u64>,
    pub connect_request: Option<ConnectRequest>,
    /// Cookie of the ConnectRequest.
    pub connect_response: Option<u64>,
    pub net_error: Option<NetError>,
    pub net_error_disconnect: Option<NetError>,
    /// Command and parameter.
    pub command: Option<(u32, u32)>,
    /// GDLE's error before the login: 0 bad login, 5 server full.
    pub login_error: Option<u32>,
    /// Game time, s.
    pub time_sync: Option<f64>,
    /// The sender's local time, s.
    pub echo_request: Option<f32>,
    pub echo_response: Option<EchoResponse>,
    pub flow: Option<Flow>,
}

/// Cursor over the payload; every read is bounded.
struct Cursor<'a> {
    rest: &'a [u8],
    length: usize,
}

impl<'a> Cursor<'a> {
    fn bytes(&mut self, n: usize, what: &'static str) -> Result<&'a [u8], PacketError> {
        let at = self.length - self.rest.len();
        let error = PacketError::Truncated {
            what,
            needed: n,
            offset: at,
            left: self.rest.len(),
        };
        let (taken, rest) = self.rest.split_at_checked(n).ok_or(error)?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], PacketError> {
        let mut out = [0; N];
        out.copy_from_slice(self.bytes(N, what)?);
        Ok(out)
    }

    fn u16(&mut self, what: &'static str) -> Result<u16, PacketError> {
        self.array(what).map(u16::from_le_bytes)
    }

    fn u32(&mut self, what: &'static str) -> Result<u32, PacketError> {
        self.array(what).map(u32::from_le_bytes)
    }

    fn u64(&mut self, what: &'static str) -> Result<u64, PacketError> {
        self.array(what).map(u64::from_le_bytes)
    }

    fn f32(&mut self, what: &'static str) -> Result<f32, PacketError> {
        self.u32(what).map(f32::from_bits)
    }

    fn f64(&mut self, what: &'static str) -> Result<f64, PacketError> {
        self.u64(what).map(f64::from_bits)
    }

    fn list(&mut self, what: &'static str) -> Result<SequenceList<'a>, PacketError> {
        let n = self.u32(what)? as usize;
        let fits = self.rest.len() / 4;
        if n > fits {
            return Err(PacketError::Count {
                what,
                count: n,
                fits,
            });
        }
        self.bytes(n * 4, what).map(SequenceList)
    }

    fn address(&mut self) -> Result<SocketAddress, PacketError> {
        const WHAT: &str = "socket address";
        let family = self.u16(WHAT)?;
        let port = u16::from_be_bytes(self.array(WHAT)?);
        Ok(SocketAddress {
            family,
            port,
            address: self.array(WHAT)?,
            padding: self.array(WHAT)?,
        })
    }

    fn net_error(&mut self) -> Result<NetError, PacketError> {
        Ok(NetError {
            string: self.u32("NetError")?,
            table: self.u32("NetError")?,
        })
    }
}

impl<'a> OptionalHeaders<'a> {
    /// Reads the headers that `flags` announces from a packet's payload and answers with them and their length in bytes.
    pub(super) fn parse(
        flags: PacketFlags,
        payload: &'a [u8],
    ) -> Result<(Self, usize), PacketError> {
        let mut c = Cursor {
            rest: payload,
            length: payload.len(),
        };
        let mut h = Self::default();
        let has = |flag| flags.contains(flag);
        if has(PacketFlags::SERVER_SWITCH) {
            h.server_switch = Some(ServerSwitch {
                sequence: c.u32("ServerSwitch")?,
                kind: c.u32("ServerSwitch")?,
            });
        }
        if has(PacketFlags::LOGON_SERVER_ADDR) {
            h.logon_server = Some(c.address()?);
        }
        if has(PacketFlags::REFERRAL) {
            let cookie = c.u64("Referral")?;
            let address = c.address()?;
            h.referral = Some(Referral {
                cookie,
                address,
                server_id: c.u16("Referral")?,
                unused: c.array("Referral")?,
            });
        }
        if has(PacketFlags::REQUEST_RETRANSMIT) {
            h.request_retransmit = Some(c.list("RequestRetransmit")?);
        }
        if has(PacketFlags::REJECT_RETRANSMIT) {
            h.reject_retransmit = Some(c.list("RejectRetransmit")?);
        }
        if has(PacketFlags::ACK_SEQUENCE) {
            h.ack = Some(c.u32("AckSequence")?);
        }
        if has(PacketFlags::LOGIN_REQUEST) {
            h.login = Some(core::mem::take(&mut c.rest));
        }
        h.parse_session(flags, &mut c)?;
        Ok((h, payload.len() - c.rest.len()))
    }

    fn parse_session(&mut self, flags: PacketFlags, c: &mut Cursor<'a>) -> Result<(), PacketError> {
        let has = |flag| flags.contains(flag);
        if has(PacketFlags::WORLD_LOGIN_REQUEST) {
            self.world_login = Some(c.u64("WorldLoginRequest")?);
        }
        if has(PacketFlags::CONNECT_REQUEST) {
            const WHAT: &str = "ConnectRequest";
            self.connect_request = Some(ConnectRequest {
                server_time: c.f64(WHAT)?,
                cookie: c.u64(WHAT)?,
                net_id: c.u32(WHAT)?,
                seed_from_server: c.u32(WHAT)?,
                seed_from_client: c.u32(WHAT)?,
                unused: c.u32(WHAT)?,
            });
        }
        if has(PacketFlags::CONNECT_RESPONSE) {
            self.connect_response = Some(c.u64("ConnectResponse")?);
        }
        if has(PacketFlags::NET_ERROR) {
            self.net_error = Some(c.net_error()?);
        }
        if has(PacketFlags::NET_ERROR_DISCONNECT) {
            self.net_error_disconnect = Some(c.net_error()?);
        }
        if has(PacketFlags::CICMD_COMMAND) {
            self.command = Some((c.u32("CICMDCommand")?, c.u32("CICMDCommand")?));
        }
        if has(PacketFlags::LOGIN_ERROR) {
            self.login_error = Some(c.u32("login error")?);
        }
        if has(PacketFlags::TIME_SYNC) {
            self.time_sync = Some(c.f64("TimeSync")?);
        }
        if has(PacketFlags::ECHO_REQUEST) {
            self.echo_request = Some(c.f32("EchoRequest")?);
        }
        if has(PacketFlags::ECHO_RESPONSE) {
            self.echo_response = Some(EchoResponse {
                time: c.f32("EchoResponse")?,
                holding: c.f32("EchoResponse")?,
            });
        }
        if has(PacketFlags::FLOW) {
            self.flow = Some(Flow {
                bytes: c.u32("Flow")?,
                interval: c.u16("Flow")?,
            });
        }
        Ok(())
    }

    /// Flags of the headers that are there.
    pub fn flags(&self) -> PacketFlags {
        let rows = [
            (self.server_switch.is_some(), PacketFlags::SERVER_SWITCH),
            (self.logon_server.is_some(), PacketFlags::LOGON_SERVER_ADDR),
            (self.referral.is_some(), PacketFlags::REFERRAL),
            (
                self.request_retransmit.is_some(),
                PacketFlags::REQUEST_RETRANSMIT,
            ),
            (
                self.reject_retransmit.is_some(),
                PacketFlags::REJECT_RETRANSMIT,
            ),
            (self.ack.is_some(), PacketFlags::ACK_SEQUENCE),
            (self.login.is_some(), PacketFlags::LOGIN_REQUEST),
            (self.world_login.is_some(), PacketFlags::WORLD_LOGIN_REQUEST),
            (self.connect_request.is_some(), PacketFlags::CONNECT_REQUEST),
            (
                self.connect_response.is_some(),
                PacketFlags::CONNECT_RESPONSE,
            ),
            (self.net_error.is_some(), PacketFlags::NET_ERROR),
            (
                self.net_error_disconnect.is_some(),
                PacketFlags::NET_ERROR_DISCONNECT,
            ),
            (self.command.is_some(), PacketFlags::CICMD_COMMAND),
            (self.login_error.is_some(), PacketFlags::LOGIN_ERROR),
            (self.time_sync.is_some(), PacketFlags::TIME_SYNC),
            (self.echo_request.is_some(), PacketFlags::ECHO_REQUEST),
            (self.echo_response.is_some(), PacketFlags::ECHO_RESPONSE),
            (self.flow.is_some(), PacketFlags::FLOW),
        ];
        rows.into_iter()
            .filter(|(there, _)| *there)
            .map(|(_, flag)| flag)
            .collect()
    }

    /// Appends the headers to a payload, in order.
    pub fn write(&self, out: &mut Vec<u8>) {
        let word = |out: &mut Vec<u8>, v: u32| out.extend_from_slice(&v.to_le_bytes());
        let long = |out: &mut Vec<u8>, v: u64| out.extend_from_slice(&v.to_le_bytes());
        let list = |out: &mut Vec<u8>, l: SequenceList<'_>| {
            word(out, l.len() as u32);
            out.extend_from_slice(l.0);
        };
        let address = |out: &mut Vec<u8>, a: &SocketAddress| {
            out.extend_from_slice(&a.family.to_le_bytes());
            out.extend_from_slice(&a.port.to_be_bytes());
            out.extend_from_slice(&a.address);
            out.extend_from_slice(&a.padding);
        };
        if let Some(s) = &self.server_switch {
            word(out, s.sequence);
            word(out, s.kind);
        }
        if let Some(a) = &self.logon_server {
            address(out, a);
        }
        if let Some(r) = &self.referral {
            long(out, r.cookie);
            address(out, &r.address);
            out.extend_from_slice(&r.server_id.to_le_bytes());
            out.extend_from_slice(&r.unused);
        }
        self.request_retransmit
            .into_iter()
            .chain(self.reject_retransmit)
            .for_each(|l| list(out, l));
        self.ack.into_iter().for_each(|n| word(out, n));
        self.login
            .into_iter()
            .for_each(|bytes| out.extend_from_slice(bytes));
        self.world_login.into_iter().for_each(|c| long(out, c));
        if let Some(c) = &self.connect_request {
            long(out, c.server_time.to_bits());
            long(out, c.cookie);
            [c.net_id, c.seed_from_server, c.seed_from_client, c.unused]
                .into_iter()
                .for_each(|v| word(out, v));
        }
        self.connect_response.into_iter().for_each(|c| long(out, c));
        for e in self.net_error.iter().chain(&self.net_error_disconnect) {
            word(out, e.string);
            word(out, e.table);
        }
        if let Some((command, parameter)) = self.command {
            word(out, command);
            word(out, parameter);
        }
        self.login_error.into_iter().for_each(|e| word(out, e));
        self.time_sync
            .into_iter()
            .for_each(|t| long(out, t.to_bits()));
        self.echo_request
            .into_iter()
            .for_each(|t| word(out, t.to_bits()));
        if let Some(e) = &self.echo_response {
            word(out, e.time.to_bits());
            word(out, e.holding.to_bits());
        }
        if let Some(f) = &self.flow {
            word(out, f.bytes);
            out.extend_from_slice(&f.interval.to_le_bytes());
        }
    }
}
