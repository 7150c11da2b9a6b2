//! Messages out of recorded datagrams, and a check of every datagram.

use std::collections::{BTreeMap, BTreeSet};

use ac_client::net::messages::{self, Direction};
use ac_client::net::transport::{Packet, PacketError, PacketFlags, Reassembler, Verified};

use crate::format::{RecordedPacket, Stream};

/// A complete message of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedMessage {
    /// Stream of the datagram that completed it.
    pub stream: Stream,
    /// Arrival of that datagram, ns since 1970.
    pub time: u64,
    /// Opcode and body, redacted.
    pub bytes: Vec<u8>,
}

impl RecordedMessage {
    /// Name of the message, or of the event or action in it.
    pub fn name(&self) -> std::borrow::Cow<'static, str> {
        messages::message_name(&self.bytes, self.stream.direction())
    }
}

/// What a datagram turned out to be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finding {
    /// Its checksum is right, or depends on a key.
    Good,
    /// Its checksum is wrong.
    Checksum,
    /// It is no packet.
    Malformed(PacketError),
    /// A message in it cannot be read: name, offset and problem.
    Message(String),
}

/// One direction between one client and the server.
#[derive(Default)]
struct Line {
    reassembler: Reassembler,
    seen: BTreeSet<u32>,
}

/// Follows all lines of a recording, datagram by datagram.
#[derive(Default)]
pub struct Decoder {
    lines: BTreeMap<(u32, bool), Line>,
}

impl Decoder {
    /// A decoder at the start of a recording.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next datagram; complete messages are appended to `out`. Fragments of a packet that was there already are left out.
    pub fn take(&mut self, recorded: &RecordedPacket, out: &mut Vec<RecordedMessage>) -> Finding {
        let packet = match Packet::parse(&recorded.bytes) {
            Ok(packet) => packet,
            Err(error) => return Finding::Malformed(error),
        };
        if packet.verify() == Verified::Wrong {
            return Finding::Checksum;
        }
        let stream = recorded.stream;
        if packet.header.flags.contains(PacketFlags::LOGIN_REQUEST) {
            // A new session of the same client: numbers start again.
            self.lines.remove(&(stream.client, true));
            self.lines.remove(&(stream.client, false));
        }
        let line = self
            .lines
            .entry((stream.client, stream.to_server))
            .or_default();
        let repeated = packet.is_numbered() && !line.seen.insert(packet.header.sequence);
        if repeated {
            return Finding::Good;
        }
        let mut finding = Finding::Good;
        for fragment in packet.fragments() {
            let seconds = recorded.time as f64 / 1e9;
            let Ok(Some(message)) = line.reassembler.push(&fragment, seconds) else {
                continue;
            };
            if let Err(error) = messages::check(&message.bytes, stream.direction()) {
                finding = Finding::Message(error.to_string());
            }
            out.push(RecordedMessage {
                stream,
                time: recorded.time,
                bytes: message.bytes,
            });
        }
        finding
    }
}

/// All complete messages of a recording, in order of completion.
pub fn all_messages(packets: &[RecordedPacket]) -> Vec<RecordedMessage> {
    let (mut decoder, mut out) = (Decoder::new(), Vec::new());
    for packet in packets {
        decoder.take(packet, &mut out);
    }
    out
}

/// Arrow of a direction, for people.
pub const fn arrow(direction: Direction) -> &'static str {
    match direction {
        Direction::ToServer => "->",
        Direction::ToClient => "<-",
    }
}
