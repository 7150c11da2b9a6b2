//! Known secrets: what was learned, and the search for it.

use std::collections::BTreeSet;

use aho_corasick::{AhoCorasick, MatchKind};

use ac_client::net::transport::{
    Fragment, HEADER_LENGTH, LoginRequest, Packet, PacketFlags, PacketHeader, REDACTED,
};

/// From this length on a secret is overwritten and searched for anywhere; a shorter one only behind its length, since it could be any bytes.
pub const LONG: usize = 6;
/// Shortest secret that is searched for at all.
const SHORTEST: usize = 3;
/// At a border between fragments, so much of a secret's start or end counts as the secret.
const PART: usize = 4;
/// Secrets of one recording; logins beyond are redacted by structure only.
const MOST: usize = 1024;

/// What the logins of a recording showed to be secret.
#[derive(Default)]
pub struct Secrets {
    texts: BTreeSet<Vec<u8>>,
    revision: u64,
    overflow: bool,
}

impl core::fmt::Debug for Secrets {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Secrets")
            .field("count", &self.texts.len())
            .finish_non_exhaustive()
    }
}

/// Whether a text is long enough, and not what secrets are overwritten with.
pub fn is_searchable(text: &[u8]) -> bool {
    let printable = text.iter().all(|&b| b >= 0x20);
    let only_x = text.iter().all(|b| b.eq_ignore_ascii_case(&REDACTED));
    text.len() >= SHORTEST && printable && !only_x
}

impl Secrets {
    /// Adds the accounts and the password or ticket of a login. GDLE's `name:password` counts whole and in its parts.
    pub fn learn(&mut self, login: &LoginRequest) {
        let texts = [
            &login.account,
            &login.account_override,
            login.secret.as_ref().unwrap_or(&login.account),
        ];
        for text in texts {
            self.add(text);
            if let Some((name, password)) = text.split_once(':') {
                self.add(name);
                self.add(password);
            }
        }
    }

    /// Adds a text, as code page 1252 and as UTF-8, and in other letter cases.
    pub fn add(&mut self, text: &str) {
        for text in [text.to_owned(), text.to_lowercase(), text.to_uppercase()] {
            let windows: Option<Vec<u8>> = text
                .chars()
                .map(|c| u8::try_from(u32::from(c)).ok())
                .collect();
            for bytes in [Some(text.into_bytes()), windows].into_iter().flatten() {
                self.add_bytes(bytes);
            }
        }
    }

    fn add_bytes(&mut self, mut bytes: Vec<u8>) {
        // The search does not tell ASCII letters of different case apart.
        bytes.make_ascii_lowercase();
        if !is_searchable(&bytes) || self.texts.contains(&bytes) {
            return;
        }
        if self.texts.len() >= MOST {
            self.overflow = true;
            return;
        }
        self.texts.insert(bytes);
        self.revision += 1;
    }

    /// Texts to search for.
    pub fn len(&self) -> usize {
        self.texts.len()
    }

    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.texts.is_empty()
    }

    /// Whether there were more secrets than are remembered.
    pub const fn overflowed(&self) -> bool {
        self.overflow
    }

    /// A search for what is known now.
    pub fn searcher(&self) -> Searcher {
        let mut searcher = Searcher::default();
        self.update(&mut searcher);
        searcher
    }

    /// Brings a search up to date.
    pub fn update(&self, searcher: &mut Searcher) {
        if searcher.revision == self.revision {
            return;
        }
        let (mut patterns, mut starts) = (Vec::new(), Vec::new());
        for text in &self.texts {
            if text.len() >= LONG {
                patterns.push(text.clone());
                starts.push(0);
                continue;
            }
            // A short text counts behind its length: a string16, or the packed length of a password.
            let length = text.len() as u8;
            for prefix in [&[length, 0][..], &[length]] {
                patterns.push([prefix, text].concat());
                starts.push(prefix.len());
            }
        }
        let automaton = AhoCorasick::builder()
            .ascii_case_insensitive(true)
            .match_kind(MatchKind::Standard)
            .build(&patterns)
            .ok();
        *searcher = Searcher {
            automaton,
            starts,
            patterns,
            revision: self.revision,
        };
    }
}

/// A search for known secrets.
#[derive(Default, Clone)]
pub struct Searcher {
    automaton: Option<AhoCorasick>,
    /// Where the secret starts in each pattern.
    starts: Vec<usize>,
    patterns: Vec<Vec<u8>>,
    revision: u64,
}

impl Searcher {
    /// Whether there is nothing to search for.
    pub fn is_empty(&self) -> bool {
        self.patterns.is_empty()
    }

    /// Length of the longest pattern: parts of a stream must overlap by as much less one.
    pub fn longest(&self) -> usize {
        self.patterns.iter().map(Vec::len).max().unwrap_or_default()
    }

    /// Number of places where a secret starts.
    pub fn count(&self, bytes: &[u8]) -> usize {
        self.automaton
            .as_ref()
            .map_or(0, |a| a.find_overlapping_iter(bytes).count())
    }

    /// As [`count`](Self::count), but only secrets long enough to be told from chance in compressed bytes.
    pub fn count_long(&self, bytes: &[u8]) -> usize {
        self.automaton.as_ref().map_or(0, |a| {
            a.find_overlapping_iter(bytes)
                .filter(|m| self.starts[m.pattern()] == 0)
                .count()
        })
    }

    /// Overwrites every secret in a datagram behind its header, and repairs the checksum. Returns the bytes overwritten.
    pub fn scrub(&self, datagram: &mut [u8]) -> usize {
        let Some(automaton) = &self.automaton else {
            return 0;
        };
        let Some((head, payload)) = datagram.split_first_chunk_mut::<HEADER_LENGTH>() else {
            return 0;
        };
        let mut places: Vec<_> = automaton
            .find_overlapping_iter(&*payload)
            .map(|m| m.start() + self.starts[m.pattern()]..m.end())
            .collect();
        let header = PacketHeader::parse(head);
        if header.flags.contains(PacketFlags::BLOB_FRAGMENTS) {
            self.parts_at_borders(datagram, &mut places);
        }
        if places.is_empty() {
            return 0;
        }
        overwrite(datagram, header, &places)
    }

    /// Starts and ends of secrets that go on in another fragment, as places in the payload.
    fn parts_at_borders(&self, datagram: &[u8], places: &mut Vec<core::ops::Range<usize>>) {
        let Ok(packet) = Packet::parse(datagram) else {
            return;
        };
        let mut at = packet.optional_bytes.len();
        for Fragment { header, data } in packet.fragments() {
            at += usize::from(header.size) - data.len();
            let end = at + data.len();
            if header.count > 1 {
                for text in self
                    .patterns
                    .iter()
                    .zip(&self.starts)
                    .map(|(p, &s)| &p[s..])
                {
                    let lengths = || (PART..text.len().min(data.len() + 1)).rev();
                    if header.index + 1 < header.count
                        && let Some(n) = lengths()
                            .find(|&n| data[data.len() - n..].eq_ignore_ascii_case(&text[..n]))
                    {
                        places.push(end - n..end);
                    }
                    if header.index > 0
                        && let Some(n) = lengths()
                            .find(|&n| data[..n].eq_ignore_ascii_case(&text[text.len() - n..]))
                    {
                        places.push(at..at + n);
                    }
                }
            }
            at = end;
        }
    }
}

/// Overwrites places of the payload. The checksum's error, if it has one, and the key word stay.
fn overwrite(
    datagram: &mut [u8],
    header: PacketHeader,
    places: &[core::ops::Range<usize>],
) -> usize {
    let before = Packet::parse(datagram).map(|p| p.data_hash());
    let mut bytes = 0;
    for place in places {
        for byte in &mut datagram[HEADER_LENGTH..][place.clone()] {
            bytes += usize::from(*byte != REDACTED);
            *byte = REDACTED;
        }
    }
    let after = Packet::parse(datagram).map(|p| p.data_hash());
    if let (Ok(before), Ok(after)) = (before, after) {
        let checksum = if header.flags.contains(PacketFlags::ENCRYPTED_CHECKSUM) {
            let key = header.checksum.wrapping_sub(header.hash()) ^ before;
            header.hash().wrapping_add(after ^ key)
        } else {
            header.checksum.wrapping_sub(before).wrapping_add(after)
        };
        datagram[8..12].copy_from_slice(&checksum.to_le_bytes());
    }
    bytes
}
