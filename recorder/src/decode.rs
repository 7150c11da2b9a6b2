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
    /// Queue of its first fragment (`spec/09`, 8.4).
    pub queue: u16,
    /// Numbers of the datagrams with its fragments, in order of arrival.
    pub datagrams: Vec<u32>,
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
    /// A copy of a packet that was there already; its fragments are left out.
    Repeated,
    /// Its checksum is wrong.
    Checksum,
    /// It is no packet.
    Malformed(PacketError),
    /// A message in it cannot be read: name, offset and problem.
    Message(String),
}

/// Sequences of packets that are remembered for each direction of a client.
const REMEMBERED: usize = 1 << 16;
/// Partial messages whose datagrams are remembered: as many as a reassembler keeps.
const PARTIAL: usize = 64;

/// One direction between one client and the server.
#[derive(Default)]
struct Line {
    reassembler: Reassembler,
    seen: BTreeSet<u32>,
    /// Datagrams of messages that are not complete, oldest first.
    partial: Vec<(u64, Vec<u32>)>,
}

impl Line {
    /// Whether a sequence is new. The lowest ones are forgotten first.
    fn is_new(&mut self, sequence: u32) -> bool {
        let new = self.seen.insert(sequence);
        if self.seen.len() > REMEMBERED {
            self.seen.pop_first();
        }
        new
    }

    /// Datagrams of a fragment's message so far, this one included; all of them when the message is complete.
    fn datagrams(&mut self, blob: u64, number: u32, complete: bool) -> Vec<u32> {
        let known = self.partial.iter().position(|(b, _)| *b == blob);
        match (known, complete) {
            (Some(at), true) => {
                let mut all = self.partial.remove(at).1;
                all.push(number);
                all.dedup();
                return all;
            }
            (Some(at), false) => self.partial[at].1.push(number),
            (None, true) => return vec![number],
            (None, false) => {
                if self.partial.len() >= PARTIAL {
                    self.partial.remove(0);
                }
                self.partial.push((blob, vec![number]));
            }
        }
        Vec::new()
    }
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

    /// Forgets a client.
    pub fn forget(&mut self, client: u32) {
        self.lines.remove(&(client, true));
        self.lines.remove(&(client, false));
    }

    /// Takes the next datagram; complete messages are appended to `out` and read to the end, to say whether they can be. Fragments of a packet
    /// that was there already are left out.
    pub fn take(&mut self, recorded: &RecordedPacket, out: &mut Vec<RecordedMessage>) -> Finding {
        let before = out.len();
        let finding = self.take_bytes(
            recorded.stream,
            recorded.number,
            recorded.time,
            &recorded.bytes,
            out,
        );
        let checks = out[before..]
            .iter()
            .map(|m| messages::check(&m.bytes, m.stream.direction()));
        match checks.filter_map(Result::err).next_back() {
            Some(error) => Finding::Message(error.to_string()),
            None => finding,
        }
    }

    /// As [`take`](Self::take), without reading the messages.
    pub fn take_bytes(
        &mut self,
        stream: Stream,
        number: u32,
        time: u64,
        bytes: &[u8],
        out: &mut Vec<RecordedMessage>,
    ) -> Finding {
        let packet = match Packet::parse(bytes) {
            Ok(packet) => packet,
            Err(error) => return Finding::Malformed(error),
        };
        if packet.verify() == Verified::Wrong {
            return Finding::Checksum;
        }
        if packet.header.flags.contains(PacketFlags::LOGIN_REQUEST) {
            // A new session of the same client: numbers start again.
            self.forget(stream.client);
        }
        let line = self
            .lines
            .entry((stream.client, stream.to_server))
            .or_default();
        if packet.is_numbered() && !line.is_new(packet.header.sequence) {
            return Finding::Repeated;
        }
        for fragment in packet.fragments() {
            let seconds = time as f64 / 1e9;
            let header = fragment.header;
            let Ok(message) = line.reassembler.push(&fragment, seconds) else {
                continue;
            };
            let datagrams = line.datagrams(header.blob_id(), number, message.is_some());
            if let Some(message) = message {
                out.push(RecordedMessage {
                    stream,
                    time,
                    queue: message.queue.0,
                    datagrams,
                    bytes: message.bytes,
                });
            }
        }
        Finding::Good
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
