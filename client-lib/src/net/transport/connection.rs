//! One side of a connection after the handshake: numbers, acknowledgements, retransmission, key streams, fragments (`spec/09`, 6 to 10, 12).
//!
//! Sans-IO: datagrams and times go in, datagrams and messages come out. Memory is bounded whatever the peer sends.

use std::collections::{BTreeMap, VecDeque};

use super::cipher::KeySearch;
use super::fragment::{FRAGMENT_DATA, FRAGMENT_HEADER, FragmentHeader, Queue, fragment_count};
use super::isaac::Isaac;
use super::optional::{EchoResponse, OptionalHeaders, SequenceList};
use super::packet::{
    Packet, PacketBuilder, PacketError, PacketFlags, PacketHeader, Verified, as_retransmission,
};
use super::reassembly::{Message, Reassembler, ReassemblyLimits, ReassemblyNote};

/// Which side of the connection this is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Sends to a server.
    Client,
    /// Sends to a client.
    Server,
}

/// Bounds and intervals; times in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConnectionLimits {
    /// Packets held because an earlier one is missing.
    pub held: usize,
    /// Entries of a NAK.
    pub nak_entries: usize,
    /// Shortest time between two NAKs (exclusive).
    pub nak_interval: f64,
    /// Longest time without telling the peer what was received, if anything was.
    pub ack_interval: f64,
    /// How long a sent packet is kept for retransmission.
    pub store_age: f64,
    /// Largest payload of a sent packet, bytes.
    pub payload: usize,
    /// Reassembly.
    pub reassembly: ReassemblyLimits,
}

impl Default for ConnectionLimits {
    fn default() -> Self {
        Self {
            held: 256,
            nak_entries: 115,
            nak_interval: 1.0,
            ack_interval: 2.0,
            store_age: 120.0,
            payload: 464,
            reassembly: ReassemblyLimits::default(),
        }
    }
}

/// Something odd in what the peer sent. Nothing of it ends the connection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Anomaly {
    /// Not a packet.
    Malformed(PacketError),
    /// The checksum is wrong, or its key word is not the stream's.
    Checksum,
    /// A packet that was received before.
    Duplicate(u32),
    /// So far ahead that it cannot be held.
    TooFarAhead(u32),
    /// Bytes after the announced size.
    Trailing(usize),
    /// A fragment that completes nothing.
    Fragment(ReassemblyNote),
    /// The peer cannot send this packet again: what it carried is lost.
    Lost(u32),
    /// The peer asks for a packet that is not kept any more.
    NotKept(u32),
}

/// What a received datagram brought.
#[derive(Debug, Clone, PartialEq)]
pub enum Incoming {
    /// A complete message.
    Message(Message),
    /// The peer's game time, s.
    TimeSync(f64),
    /// An answer to an echo request.
    Echo(EchoResponse),
    /// The peer ended the connection.
    Disconnected,
    /// Something odd.
    Anomaly(Anomaly),
}

/// Counters of one connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "the names say it")]
pub struct ConnectionStats {
    pub packets_received: u64,
    pub packets_sent: u64,
    pub retransmissions_received: u64,
    pub retransmissions_sent: u64,
    pub checksum_failures: u64,
    pub duplicates: u64,
    pub naks_sent: u64,
    pub naks_received: u64,
    pub messages_received: u64,
    pub messages_sent: u64,
    pub packets_lost: u64,
}

/// A number further ahead than this is not waited for: it is forged or damaged.
const MAX_GAP: u32 = 4096;

struct Sent {
    at: f64,
    bytes: Vec<u8>,
}

/// Numbers, keys and buffers of one side of a connection.
pub struct Connection {
    role: Role,
    limits: ConnectionLimits,
    /// NetID for a client, server id for a server.
    id: u16,
    started: f64,
    outgoing_key: Isaac,
    incoming_key: KeySearch,
    /// Highest number up to which everything was processed.
    last: u32,
    /// Packets beyond a gap; `None` where the peer refused to send one again.
    held: BTreeMap<u32, Option<Vec<u8>>>,
    last_nak: Option<f64>,
    acked: u32,
    last_ack: f64,
    next_sequence: u32,
    next_blob: u32,
    store: VecDeque<(u32, Sent)>,
    reassembler: Reassembler,
    builder: PacketBuilder,
    /// Flags of the optional headers of the packet being built.
    building: PacketFlags,
    transmits: VecDeque<Vec<u8>>,
    last_received: f64,
    last_numbered: f64,
    echo_owed: Option<(f32, f64)>,
    closed: bool,
    stats: ConnectionStats,
}

/// Numbers of the first packet and first message after the handshake.
struct Start {
    sequence: u32,
    blob: u32,
}

impl Connection {
    /// A connection whose handshake is done at time `now` (s).
    ///
    /// `id` is the NetID for a client and the server id for a server; the seeds are those of the ConnectRequest.
    pub fn new(
        role: Role,
        id: u16,
        seed_from_server: u32,
        seed_from_client: u32,
        now: f64,
        limits: ConnectionLimits,
    ) -> Self {
        let (outgoing, incoming, start) = match role {
            Role::Client => (
                seed_from_client,
                seed_from_server,
                Start {
                    sequence: 2,
                    blob: 1,
                },
            ),
            Role::Server => (
                seed_from_server,
                seed_from_client,
                Start {
                    sequence: 2,
                    blob: 0,
                },
            ),
        };
        Self {
            role,
            limits,
            id,
            started: now,
            outgoing_key: Isaac::new(outgoing),
            incoming_key: KeySearch::new(incoming),
            last: 1,
            held: BTreeMap::new(),
            last_nak: None,
            acked: 1,
            last_ack: now,
            next_sequence: start.sequence,
            next_blob: start.blob,
            store: VecDeque::new(),
            reassembler: Reassembler::new(limits.reassembly),
            builder: PacketBuilder::new(),
            building: PacketFlags::empty(),
            transmits: VecDeque::new(),
            last_received: now,
            last_numbered: now,
            echo_owed: None,
            closed: false,
            stats: ConnectionStats::default(),
        }
    }

    /// Counters.
    pub const fn stats(&self) -> &ConnectionStats {
        &self.stats
    }

    /// Highest number up to which everything was received.
    pub const fn received_up_to(&self) -> u32 {
        self.last
    }

    /// Whether either side ended the connection.
    pub const fn is_closed(&self) -> bool {
        self.closed
    }

    /// When the last packet with a good checksum arrived, s.
    pub const fn last_received(&self) -> f64 {
        self.last_received
    }

    /// When the last numbered packet was sent, s; servers end a session that sends none for long.
    pub const fn last_numbered_sent(&self) -> f64 {
        self.last_numbered
    }

    /// The next datagram to send.
    pub fn poll_transmit(&mut self) -> Option<Vec<u8>> {
        self.transmits.pop_front()
    }

    /// Takes a datagram that arrived at `now` (s); what it brought is appended to `out`, in order.
    pub fn receive(&mut self, datagram: &[u8], now: f64, out: &mut Vec<Incoming>) {
        self.stats.packets_received += 1;
        let packet = match Packet::parse(datagram) {
            Ok(packet) => packet,
            Err(error) => return out.push(Incoming::Anomaly(Anomaly::Malformed(error))),
        };
        let good = match packet.verify() {
            Verified::Clear => true,
            Verified::Wrong => false,
            Verified::Encrypted(word) => {
                self.incoming_key.accept(word) || self.is_known_copy(&packet)
            }
        };
        if !good {
            self.stats.checksum_failures += 1;
            return out.push(Incoming::Anomaly(Anomaly::Checksum));
        }
        self.last_received = now;
        if packet.trailing > 0 {
            out.push(Incoming::Anomaly(Anomaly::Trailing(packet.trailing)));
        }
        if packet.header.flags.contains(PacketFlags::RETRANSMISSION) {
            self.stats.retransmissions_received += 1;
        }
        if packet
            .header
            .flags
            .intersects(PacketFlags::DISCONNECT | PacketFlags::NET_ERROR_DISCONNECT)
        {
            self.closed = true;
            return out.push(Incoming::Disconnected);
        }
        self.order(&packet, datagram, now, out);
    }

    /// A copy of a packet that was processed or is held: its key word was used already.
    fn is_known_copy(&self, packet: &Packet<'_>) -> bool {
        let n = packet.header.sequence;
        packet.header.flags.contains(PacketFlags::RETRANSMISSION)
            && packet.is_numbered()
            && (n <= self.last || self.held.contains_key(&n))
    }

    /// Processes packets in the order of their numbers (9.3).
    fn order(&mut self, packet: &Packet<'_>, datagram: &[u8], now: f64, out: &mut Vec<Incoming>) {
        let n = packet.header.sequence;
        if !packet.is_numbered() {
            self.control(packet, now, out);
            return self.advance(now, out);
        }
        if n <= self.last || self.held.get(&n).is_some_and(Option::is_some) {
            self.stats.duplicates += 1;
            return out.push(Incoming::Anomaly(Anomaly::Duplicate(n)));
        }
        if n == self.last + 1 {
            self.process(packet, now, out);
            self.last = n;
            return self.advance(now, out);
        }
        if self.held.len() >= self.limits.held {
            out.push(Incoming::Anomaly(Anomaly::TooFarAhead(n)));
        } else {
            self.held.insert(n, Some(datagram.to_vec()));
        }
        // One packet in between may only be late.
        if n >= self.last + 3 {
            self.request_missing(n, now);
        }
    }

    /// Goes on with held packets that have become the next ones.
    fn advance(&mut self, now: f64, out: &mut Vec<Incoming>) {
        while let Some(next) = self.held.remove(&(self.last + 1)) {
            self.last += 1;
            match next {
                Some(bytes) => {
                    if let Ok(packet) = Packet::parse(&bytes) {
                        self.process(&packet, now, out);
                    }
                }
                None => {
                    self.stats.packets_lost += 1;
                    out.push(Incoming::Anomaly(Anomaly::Lost(self.last)));
                }
            }
        }
    }

    /// Whether packets are held because an earlier one is missing.
    pub fn is_waiting(&self) -> bool {
        !self.held.is_empty()
    }

    /// Gives up the packets that are missing before the first held one, and goes on with that: for a reader of recordings, which cannot ask
    /// for them. Does nothing when none is held.
    pub fn give_up(&mut self, now: f64, out: &mut Vec<Incoming>) {
        let Some((&first, _)) = self.held.first_key_value() else {
            return;
        };
        if first - self.last > MAX_GAP {
            self.held.remove(&first);
            return out.push(Incoming::Anomaly(Anomaly::TooFarAhead(first)));
        }
        for missing in self.last + 1..first {
            self.stats.packets_lost += 1;
            out.push(Incoming::Anomaly(Anomaly::Lost(missing)));
        }
        self.last = first - 1;
        self.advance(now, out);
    }

    fn process(&mut self, packet: &Packet<'_>, now: f64, out: &mut Vec<Incoming>) {
        self.control(packet, now, out);
        for fragment in packet.fragments() {
            match self.reassembler.push(&fragment, now) {
                Ok(None) => {}
                Ok(Some(message)) => {
                    self.stats.messages_received += 1;
                    out.push(Incoming::Message(message));
                }
                Err(note) => out.push(Incoming::Anomaly(Anomaly::Fragment(note))),
            }
        }
    }

    /// Optional headers.
    fn control(&mut self, packet: &Packet<'_>, now: f64, out: &mut Vec<Incoming>) {
        let h = &packet.optional;
        if let Some(ack) = h.ack {
            while self.store.front().is_some_and(|(n, _)| *n <= ack) {
                self.store.pop_front();
            }
        }
        if let Some(list) = h.request_retransmit {
            self.stats.naks_received += 1;
            self.resend(list, out);
        }
        if let Some(list) = h.reject_retransmit {
            for n in list.iter().take(self.limits.held) {
                if n > self.last && self.held.len() < self.limits.held {
                    self.held.entry(n).or_insert(None);
                }
            }
        }
        h.time_sync
            .into_iter()
            .for_each(|t| out.push(Incoming::TimeSync(t)));
        h.echo_response
            .into_iter()
            .for_each(|e| out.push(Incoming::Echo(e)));
        if let Some(time) = h.echo_request {
            self.echo_owed = Some((time, now));
        }
    }

    fn resend(&mut self, list: SequenceList<'_>, out: &mut Vec<Incoming>) {
        let mut refused = Vec::new();
        for n in list.iter().take(self.limits.nak_entries) {
            match self.store.binary_search_by_key(&n, |(k, _)| *k) {
                Ok(at) => {
                    let mut copy = self.store[at].1.bytes.clone();
                    as_retransmission(&mut copy);
                    self.stats.retransmissions_sent += 1;
                    self.transmits.push_back(copy);
                }
                Err(_) => {
                    refused.extend_from_slice(&n.to_le_bytes());
                    out.push(Incoming::Anomaly(Anomaly::NotKept(n)));
                }
            }
        }
        if !refused.is_empty() {
            let reject = OptionalHeaders {
                reject_retransmit: Some(SequenceList(&refused)),
                ..OptionalHeaders::default()
            };
            self.send_clear(&reject);
        }
    }

    /// Asks for what is missing before `received`, not more often than allowed (9.4).
    fn request_missing(&mut self, received: u32, now: f64) {
        if self
            .last_nak
            .is_some_and(|at| now - at <= self.limits.nak_interval)
        {
            return;
        }
        let missing: Vec<u8> = (self.last + 1..received)
            .filter(|n| !self.held.contains_key(n))
            .take(self.limits.nak_entries)
            .flat_map(u32::to_le_bytes)
            .collect();
        if missing.is_empty() {
            return;
        }
        self.last_nak = Some(now);
        self.stats.naks_sent += 1;
        self.send_clear(&OptionalHeaders {
            request_retransmit: Some(SequenceList(&missing)),
            ..OptionalHeaders::default()
        });
    }

    /// A packet without a number, a key word or a place in the store.
    fn send_clear(&mut self, optional: &OptionalHeaders<'_>) {
        let header = PacketHeader {
            flags: optional.flags(),
            ..self.header(0, self.started)
        };
        let bytes = self.builder.start(optional).finish(header, None).to_vec();
        self.stats.packets_sent += 1;
        self.transmits.push_back(bytes);
    }

    fn header(&self, sequence: u32, now: f64) -> PacketHeader {
        // Half seconds since the start, wrapping; nobody interprets it.
        let time = ((now - self.started).max(0.0) * 2.0) as u64 as u16;
        PacketHeader {
            sequence,
            id: self.id,
            time,
            iteration: u16::from(self.role == Role::Server),
            ..PacketHeader::default()
        }
    }

    /// Sends a message: splits it, and packs fragments and a due acknowledgement into numbered packets.
    pub fn send(&mut self, queue: Queue, message: &[u8], now: f64) {
        self.send_all(&[(queue, message)], now);
    }

    /// Sends several messages; small ones share packets.
    pub fn send_all(&mut self, messages: &[(Queue, &[u8])], now: f64) {
        let mut open = false;
        for (queue, message) in messages {
            let count = fragment_count(message.len()).max(1);
            let blob = self.next_blob;
            self.next_blob += 1;
            self.stats.messages_sent += 1;
            for index in 0..count {
                let start = index * FRAGMENT_DATA;
                let data = &message[start..message.len().min(start + FRAGMENT_DATA)];
                let needed = FRAGMENT_HEADER + data.len();
                if open && self.builder.payload_length() + needed > self.limits.payload {
                    self.finish_numbered(PacketFlags::BLOB_FRAGMENTS, now);
                    open = false;
                }
                if !open {
                    // A full fragment leaves no room for an acknowledgement.
                    let optional = self.piggy_backed(needed + 4 <= self.limits.payload, now);
                    self.building = optional.flags();
                    self.builder.start(&optional);
                    open = true;
                }
                let id = if self.role == Role::Server {
                    0x8000_0000
                } else {
                    0
                };
                let header = FragmentHeader {
                    sequence: blob,
                    id,
                    count: count as u16,
                    size: 0,
                    index: index as u16,
                    queue: *queue,
                };
                self.builder.fragment(header, data);
            }
        }
        if open {
            self.finish_numbered(PacketFlags::BLOB_FRAGMENTS, now);
        }
    }

    /// Optional headers that travel with the next numbered packet.
    fn piggy_backed(&mut self, room: bool, now: f64) -> OptionalHeaders<'static> {
        let mut optional = OptionalHeaders::default();
        if room && self.acked != self.last {
            optional.ack = Some(self.last);
            self.acked = self.last;
            self.last_ack = now;
        }
        optional
    }

    /// Finishes a packet with a number and a key word of its own, and keeps it for retransmission.
    fn finish_numbered(&mut self, more: PacketFlags, now: f64) {
        let sequence = self.next_sequence;
        self.next_sequence += 1;
        let flags = self.building | more | PacketFlags::ENCRYPTED_CHECKSUM;
        let key = self.outgoing_key.next_word();
        let header = PacketHeader {
            flags,
            ..self.header(sequence, now)
        };
        let bytes = self.builder.finish(header, Some(key)).to_vec();
        self.stats.packets_sent += 1;
        self.last_numbered = now;
        self.store.push_back((
            sequence,
            Sent {
                at: now,
                bytes: bytes.clone(),
            },
        ));
        self.transmits.push_back(bytes);
    }

    /// Sends optional headers in a numbered packet of their own (a time sync, an echo request).
    pub fn send_headers(&mut self, headers: &OptionalHeaders<'_>, now: f64) {
        let mut headers = *headers;
        headers.ack = self.piggy_backed(true, now).ack;
        self.building = headers.flags();
        self.builder.start(&headers);
        self.finish_numbered(PacketFlags::empty(), now);
    }

    /// Work that is due at `now` (s): acknowledgements, answers to echo requests, forgetting old packets.
    pub fn handle_timeout(&mut self, now: f64) {
        while self
            .store
            .front()
            .is_some_and(|(_, sent)| now - sent.at > self.limits.store_age)
        {
            self.store.pop_front();
        }
        if let Some((time, since)) = self.echo_owed.take() {
            let echo_response = Some(EchoResponse {
                time,
                holding: (now - since) as f32,
            });
            // In a packet without fragments: a server that cannot read this header would take it for one.
            self.send_headers(
                &OptionalHeaders {
                    echo_response,
                    ..OptionalHeaders::default()
                },
                now,
            );
        }
        if self.acked != self.last && now - self.last_ack >= self.limits.ack_interval {
            self.acked = self.last;
            self.last_ack = now;
            self.send_clear(&OptionalHeaders {
                ack: Some(self.last),
                ..OptionalHeaders::default()
            });
        }
        if let Some((&first, _)) = self.held.first_key_value()
            && first > self.last + 1
            && self
                .last_nak
                .is_none_or(|at| now - at > self.limits.nak_interval)
        {
            self.request_missing(first, now);
        }
    }

    /// When [`Connection::handle_timeout`] is due next, s; `None` if nothing waits.
    pub fn next_timeout(&self) -> Option<f64> {
        let ack = (self.acked != self.last).then_some(self.last_ack + self.limits.ack_interval);
        let nak = (!self.held.is_empty()).then(|| {
            self.last_nak
                .map_or(self.last_received, |at| at + self.limits.nak_interval)
        });
        let echo = self.echo_owed.map(|(_, since)| since);
        [ack, nak, echo]
            .into_iter()
            .flatten()
            .min_by(f64::total_cmp)
    }

    /// Ends the connection: one packet, to be sent twice because it may get lost.
    pub fn disconnect(&mut self) {
        self.closed = true;
        let header = PacketHeader {
            flags: PacketFlags::DISCONNECT,
            ..self.header(0, self.started)
        };
        let bytes = self
            .builder
            .start(&OptionalHeaders::default())
            .finish(header, None)
            .to_vec();
        self.stats.packets_sent += 2;
        self.transmits.extend([bytes.clone(), bytes]);
    }
}

impl core::fmt::Debug for Connection {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Connection")
            .field("role", &self.role)
            .field("last", &self.last)
            .field("next_sequence", &self.next_sequence)
            .field("held", &self.held.len())
            .finish_non_exhaustive()
    }
}
