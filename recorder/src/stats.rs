//! What a recording says about the session: losses, copies, checksums, key words, messages.
//!
//! A gap is a packet number that never came: lost before it reached the recorder, or not recorded. A number that came late or again is a
//! retransmission. Key words of encrypted checksums are compared with the streams of the seeds in the ConnectRequest (`spec/09`, 7).

use std::collections::{BTreeMap, BTreeSet};

use ac_client::net::transport::{KeySearch, Packet, PacketFlags, Verified};

use crate::decode::{Decoder, Finding, RecordedMessage};
use crate::format::{RecordedPacket, Stream};

/// Numbers that are waited for at once; more count as lost.
const MISSING: usize = 1 << 16;

/// Counts of one stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StreamCounts {
    /// Datagrams.
    pub datagrams: usize,
    /// Their bytes.
    pub bytes: usize,
    /// Of these, datagrams that were not passed on; only new recordings know.
    pub not_forwarded: usize,
}

/// Counts of one direction of one client.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LineCounts {
    /// Packets with a number of their own, copies not counted.
    pub numbered: usize,
    /// Numbers that never came.
    pub gaps: usize,
    /// Copies of packets that were there already.
    pub repeated: usize,
    /// Packets that came after a later one.
    pub late: usize,
    /// Packets with the retransmission flag.
    pub retransmissions: usize,
    /// Requests for packets that were lost.
    pub naks: usize,
    /// Wrong checksums.
    pub checksum: usize,
    /// Encrypted checksums whose key word is not of the stream.
    pub key: usize,
    /// Datagrams that are no packets.
    pub malformed: usize,
    /// Messages that cannot be read to their end.
    pub unreadable: usize,
}

#[derive(Default)]
struct Line {
    counts: LineCounts,
    highest: Option<u32>,
    missing: BTreeSet<u32>,
    keys: Option<(u32, KeySearch)>,
}

impl Line {
    fn number(&mut self, sequence: u32) {
        let Some(highest) = self.highest else {
            self.highest = Some(sequence);
            self.counts.numbered += 1;
            return;
        };
        if sequence > highest {
            let between = (sequence - highest - 1) as usize;
            // A jump that far is one damaged number, or a recording that was interrupted.
            if between <= MISSING {
                self.missing.extend(highest + 1..sequence);
            } else {
                self.counts.gaps += 1;
            }
            while self.missing.len() > MISSING {
                self.missing.pop_first();
                self.counts.gaps += 1;
            }
            self.highest = Some(sequence);
            self.counts.numbered += 1;
        } else if self.missing.remove(&sequence) {
            self.counts.late += 1;
            self.counts.numbered += 1;
        } else {
            self.counts.repeated += 1;
        }
    }

    /// A new session begins: what is missing now will not come.
    fn restart(&mut self) {
        self.counts.gaps += self.missing.len();
        self.missing.clear();
        self.highest = None;
        self.keys = None;
    }

    fn seed(&mut self, seed: u32) {
        if self.keys.as_ref().is_none_or(|(s, _)| *s != seed) {
            self.keys = Some((seed, KeySearch::new(seed)));
        }
    }

    /// Whether the key word is known to be wrong.
    fn is_wrong_key(&mut self, word: u32, copy: bool) -> bool {
        let Some((_, keys)) = &mut self.keys else {
            return false;
        };
        // The key word of a copy was accepted with the first one.
        !keys.accept(word) && !copy
    }
}

/// Follows a recording, datagram by datagram.
#[derive(Default)]
pub struct Analysis {
    /// Counts per stream.
    pub streams: BTreeMap<Stream, StreamCounts>,
    /// Messages per direction (to the server?) and name: count and bytes.
    pub messages: BTreeMap<(bool, String), (usize, usize)>,
    /// First and last time, ns since 1970.
    pub span: Option<(u64, u64)>,
    /// Datagrams.
    pub packets: usize,
    /// Numbers of datagrams that are not in the recording.
    pub not_recorded: usize,
    lines: BTreeMap<(u32, bool), Line>,
    decoder: Decoder,
    next: Option<u32>,
}

impl Analysis {
    /// Takes the next datagram. Messages that it completes are appended to `out`; the answer says what is wrong with it.
    pub fn take(
        &mut self,
        packet: &RecordedPacket,
        out: &mut Vec<RecordedMessage>,
    ) -> Option<String> {
        self.count(packet);
        let before = out.len();
        let finding = self.decoder.take(packet, out);
        for message in &out[before..] {
            let key = (message.stream.to_server, message.name().into_owned());
            let (count, bytes) = self.messages.entry(key).or_default();
            *count += 1;
            *bytes += message.bytes.len();
        }
        let wrong_key = self.follow(packet);
        let line = self
            .lines
            .entry((packet.stream.client, packet.stream.to_server))
            .or_default();
        match finding {
            Finding::Checksum => {
                line.counts.checksum += 1;
                Some("wrong checksum".into())
            }
            Finding::Malformed(error) => {
                line.counts.malformed += 1;
                Some(error.to_string())
            }
            Finding::Message(error) => {
                line.counts.unreadable += 1;
                Some(error)
            }
            Finding::Good | Finding::Repeated => {
                wrong_key.then(|| "wrong checksum: the key word is not of this session".into())
            }
        }
    }

    fn count(&mut self, packet: &RecordedPacket) {
        let stream = self.streams.entry(packet.stream).or_default();
        stream.datagrams += 1;
        stream.bytes += packet.bytes.len();
        stream.not_forwarded += usize::from(packet.forwarded.is_none());
        self.packets += 1;
        let first = self.span.map_or(packet.time, |(first, _)| first);
        self.span = Some((first, packet.time));
        if let Some(next) = self.next {
            self.not_recorded += packet.number.saturating_sub(next) as usize;
        }
        self.next = Some(packet.number.wrapping_add(1));
    }

    /// Numbers and key words. Says whether the key word is wrong.
    fn follow(&mut self, recorded: &RecordedPacket) -> bool {
        let Ok(packet) = Packet::parse(&recorded.bytes) else {
            return false;
        };
        let verified = packet.verify();
        if verified == Verified::Wrong {
            return false;
        }
        let Stream {
            client, to_server, ..
        } = recorded.stream;
        if packet.header.flags.contains(PacketFlags::LOGIN_REQUEST) {
            for direction in [true, false] {
                self.lines.entry((client, direction)).or_default().restart();
            }
        }
        if let Some(request) = packet.optional.connect_request {
            for (direction, seed) in [
                (true, request.seed_from_client),
                (false, request.seed_from_server),
            ] {
                self.lines
                    .entry((client, direction))
                    .or_default()
                    .seed(seed);
            }
        }
        let line = self.lines.entry((client, to_server)).or_default();
        let again = packet.header.flags.contains(PacketFlags::RETRANSMISSION);
        line.counts.retransmissions += usize::from(again);
        line.counts.naks += usize::from(packet.optional.request_retransmit.is_some());
        let repeated = line.counts.repeated;
        // The handshake has numbers of its own, which may be repeated.
        if packet.is_numbered() && packet.header.sequence >= 2 {
            line.number(packet.header.sequence);
        }
        let copy = again || line.counts.repeated > repeated;
        let wrong = match verified {
            Verified::Encrypted(word) => line.is_wrong_key(word, copy),
            Verified::Clear | Verified::Wrong => false,
        };
        line.counts.key += usize::from(wrong);
        wrong
    }

    /// Counts of each client's direction (to the server?).
    pub fn lines(&self) -> impl Iterator<Item = ((u32, bool), LineCounts)> {
        self.lines.iter().map(|(&key, line)| {
            let gaps = line.counts.gaps + line.missing.len();
            (
                key,
                LineCounts {
                    gaps,
                    ..line.counts
                },
            )
        })
    }

    /// Duration, s.
    pub fn seconds(&self) -> f64 {
        self.span
            .map_or(0.0, |(a, b)| b.saturating_sub(a) as f64 / 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_copies_and_late_ones_are_told_apart() {
        let mut line = Line::default();
        for sequence in [2, 3, 6, 4, 6, 3, 9] {
            line.number(sequence);
        }
        let c = line.counts;
        assert_eq!((c.numbered, c.late, c.repeated), (5, 1, 2));
        assert_eq!(line.missing.iter().copied().collect::<Vec<_>>(), [5, 7, 8]);
        line.restart();
        assert_eq!(line.counts.gaps, 3);
        line.number(2);
        line.number(u32::MAX);
        assert_eq!((line.counts.gaps, line.missing.len()), (4, 0));
    }

    #[test]
    fn key_words_of_copies_are_not_asked_for_twice() {
        let mut line = Line::default();
        let mut stream = ac_client::net::transport::Isaac::new(7);
        let (first, second) = (stream.next_word(), stream.next_word());
        assert!(!line.is_wrong_key(1, false), "no seed is known");
        line.seed(7);
        assert!(!line.is_wrong_key(second, false));
        line.seed(7);
        assert!(!line.is_wrong_key(first, false));
        assert!(line.is_wrong_key(first, false) && !line.is_wrong_key(first, true));
    }
}
