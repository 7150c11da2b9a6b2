//! Fragments of messages in a packet (`spec/09`, 8.1 and 8.2).

use super::hash::hash32;
use super::packet::PacketError;

/// Bytes of a fragment header.
pub const FRAGMENT_HEADER: usize = 16;
/// Message bytes in every fragment but the last.
pub const FRAGMENT_DATA: usize = 448;
/// Largest fragment, header included.
pub const MAX_FRAGMENT: usize = FRAGMENT_HEADER + FRAGMENT_DATA;

/// What a message is about; servers ignore it from clients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Queue(pub u16);

#[allow(missing_docs, reason = "names of the field")]
impl Queue {
    pub const INVALID: Self = Self(0);
    pub const EVENT: Self = Self(1);
    pub const CONTROL: Self = Self(2);
    pub const WEENIE: Self = Self(3);
    pub const LOGIN: Self = Self(4);
    pub const DATABASE: Self = Self(5);
    pub const SECURE_CONTROL: Self = Self(6);
    pub const SECURE_WEENIE: Self = Self(7);
    pub const SECURE_LOGIN: Self = Self(8);
    pub const UI: Self = Self(9);
    pub const SMARTBOX: Self = Self(10);
    pub const OBSERVER: Self = Self(11);
}

/// Header of one fragment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FragmentHeader {
    /// Number of the message.
    pub sequence: u32,
    /// 0x80000000 from servers, 0 from clients.
    pub id: u32,
    /// Number of fragments of the message.
    pub count: u16,
    /// Header and data, bytes.
    pub size: u16,
    /// Which fragment this is, from 0.
    pub index: u16,
    /// What the message is about.
    pub queue: Queue,
}

impl FragmentHeader {
    /// Sequence and id as one number: what tells messages apart.
    pub const fn blob_id(&self) -> u64 {
        self.sequence as u64 | (self.id as u64) << 32
    }

    fn parse(b: &[u8]) -> Self {
        let half = |i: usize| u16::from_le_bytes([b[i], b[i + 1]]);
        let word = |i: usize| u32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]]);
        Self {
            sequence: word(0),
            id: word(4),
            count: half(8),
            size: half(10),
            index: half(12),
            queue: Queue(half(14)),
        }
    }

    /// The header's bytes.
    pub fn to_bytes(&self) -> [u8; FRAGMENT_HEADER] {
        let mut b = [0; FRAGMENT_HEADER];
        b[0..4].copy_from_slice(&self.sequence.to_le_bytes());
        b[4..8].copy_from_slice(&self.id.to_le_bytes());
        b[8..10].copy_from_slice(&self.count.to_le_bytes());
        b[10..12].copy_from_slice(&self.size.to_le_bytes());
        b[12..14].copy_from_slice(&self.index.to_le_bytes());
        b[14..16].copy_from_slice(&self.queue.0.to_le_bytes());
        b
    }
}

/// One fragment of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fragment<'a> {
    /// Its header.
    pub header: FragmentHeader,
    /// Its share of the message.
    pub data: &'a [u8],
}

impl Fragment<'_> {
    /// The fragment's share of the packet's hash.
    pub fn hash(&self) -> u32 {
        hash32(&self.header.to_bytes()).wrapping_add(hash32(self.data))
    }
}

/// The fragments of a packet, in order. Ends after the first malformed one.
#[derive(Debug, Clone)]
pub struct Fragments<'a> {
    rest: &'a [u8],
}

impl<'a> Fragments<'a> {
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }
}

impl<'a> Iterator for Fragments<'a> {
    type Item = Result<Fragment<'a>, PacketError>;

    fn next(&mut self) -> Option<Self::Item> {
        let bytes = core::mem::take(&mut self.rest);
        if bytes.is_empty() {
            return None;
        }
        if bytes.len() < FRAGMENT_HEADER {
            return Some(Err(PacketError::FragmentTruncated { left: bytes.len() }));
        }
        let header = FragmentHeader::parse(bytes);
        let size = usize::from(header.size);
        if size < FRAGMENT_HEADER || size > bytes.len() {
            return Some(Err(PacketError::FragmentSize {
                size,
                left: bytes.len(),
            }));
        }
        let (own, rest) = bytes.split_at(size);
        self.rest = rest;
        Some(Ok(Fragment {
            header,
            data: &own[FRAGMENT_HEADER..],
        }))
    }
}

/// Number of fragments of a message of `length` bytes.
pub const fn fragment_count(length: usize) -> usize {
    length.div_ceil(FRAGMENT_DATA)
}
