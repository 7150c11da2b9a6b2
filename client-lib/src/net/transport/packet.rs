//! One datagram: header, optional headers, fragments, checksum (`spec/09`, 3 to 6).

use bitflags::bitflags;
use thiserror::Error;

use super::fragment::{Fragment, FragmentHeader, Fragments};
use super::hash::hash32;
use super::optional::OptionalHeaders;

/// Bytes of a packet header.
pub const HEADER_LENGTH: usize = 20;
/// Largest datagram that a client accepts.
pub const MAX_DATAGRAM: usize = 2048;
/// What stands in the checksum field while the header is hashed.
const CHECKSUM_PLACEHOLDER: u32 = 0xBADD_70DD;

bitflags! {
    /// What a packet is and carries.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct PacketFlags: u32 {
        /// A copy of a packet that was sent before.
        const RETRANSMISSION = 0x0000_0001;
        /// The checksum is mixed with a key word.
        const ENCRYPTED_CHECKSUM = 0x0000_0002;
        /// Fragments fill the rest of the packet.
        const BLOB_FRAGMENTS = 0x0000_0004;
        /// Move to another server.
        const SERVER_SWITCH = 0x0000_0100;
        /// Address of the login service.
        const LOGON_SERVER_ADDR = 0x0000_0200;
        /// No payload; not used.
        const EMPTY_HEADER_1 = 0x0000_0400;
        /// The login service sends the client to a world.
        const REFERRAL = 0x0000_0800;
        /// Asks for packets again (NAK).
        const REQUEST_RETRANSMIT = 0x0000_1000;
        /// Packets that cannot be sent again (empty ack).
        const REJECT_RETRANSMIT = 0x0000_2000;
        /// What was received so far.
        const ACK_SEQUENCE = 0x0000_4000;
        /// The sender ends the connection.
        const DISCONNECT = 0x0000_8000;
        /// First packet of a client.
        const LOGIN_REQUEST = 0x0001_0000;
        /// First packet to a world after a referral.
        const WORLD_LOGIN_REQUEST = 0x0002_0000;
        /// The server's answer to a login.
        const CONNECT_REQUEST = 0x0004_0000;
        /// The client's answer to that.
        const CONNECT_RESPONSE = 0x0008_0000;
        /// An error.
        const NET_ERROR = 0x0010_0000;
        /// An error that ends the connection.
        const NET_ERROR_DISCONNECT = 0x0020_0000;
        /// A command.
        const CICMD_COMMAND = 0x0040_0000;
        /// GDLE's error before the login.
        const LOGIN_ERROR = 0x0080_0000;
        /// Game time.
        const TIME_SYNC = 0x0100_0000;
        /// Asks for an echo.
        const ECHO_REQUEST = 0x0200_0000;
        /// Answers one.
        const ECHO_RESPONSE = 0x0400_0000;
        /// Flow report.
        const FLOW = 0x0800_0000;
    }
}

impl PacketFlags {
    /// Bits without a meaning: the layout of such a packet's payload is not known.
    pub const fn unknown(self) -> u32 {
        self.bits() & !Self::all().bits()
    }
}

/// Why a datagram is not a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PacketError {
    /// Too short for a header.
    #[error("datagram of {length} bytes: a packet header needs {HEADER_LENGTH}")]
    TooShort {
        /// Bytes of the datagram.
        length: usize,
    },
    /// The header announces more than there is.
    #[error("packet header announces {size} bytes of payload, the datagram has {available}")]
    Size {
        /// Announced.
        size: usize,
        /// There.
        available: usize,
    },
    /// Flag bits that nobody knows.
    #[error(
        "unknown packet flags {bits:#010x}: the payload's layout is not known, keep the packet raw"
    )]
    UnknownFlags {
        /// The unknown bits.
        bits: u32,
    },
    /// An optional header does not fit.
    #[error("{what} at payload offset {offset} needs {needed} bytes, {left} are left")]
    Truncated {
        /// The header.
        what: &'static str,
        /// Bytes that it needs.
        needed: usize,
        /// Where.
        offset: usize,
        /// Bytes that are left.
        left: usize,
    },
    /// A list is longer than the packet.
    #[error("{what} lists {count} sequences, at most {fits} fit into the packet")]
    Count {
        /// The header.
        what: &'static str,
        /// Announced entries.
        count: usize,
        /// Entries that fit.
        fits: usize,
    },
    /// A fragment header does not fit.
    #[error("{left} bytes are left where a fragment header of 16 is due")]
    FragmentTruncated {
        /// Bytes that are left.
        left: usize,
    },
    /// A fragment's size is impossible.
    #[error("fragment of {size} bytes where 16 to {left} are possible")]
    FragmentSize {
        /// Announced.
        size: usize,
        /// Bytes that are left.
        left: usize,
    },
    /// Payload without the fragment flag is left over.
    #[error("{left} bytes of payload that no flag announces")]
    Unannounced {
        /// Bytes that are left.
        left: usize,
    },
}

/// Header of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PacketHeader {
    /// Number of the packet; which packets carry a new one is told in `spec/09`, 9.1.
    pub sequence: u32,
    /// What the packet carries; unknown bits are kept.
    pub flags: PacketFlags,
    /// Checksum as received.
    pub checksum: u32,
    /// NetID from the client, server id from the server.
    pub id: u16,
    /// The sender's clock; not to be interpreted.
    pub time: u16,
    /// Bytes after the header.
    pub size: u16,
    /// 1 from servers.
    pub iteration: u16,
}

impl PacketHeader {
    /// Reads a header.
    pub fn parse(b: &[u8; HEADER_LENGTH]) -> Self {
        let half = |i: usize| u16::from_le_bytes([b[i], b[i + 1]]);
        let word = |i: usize| u32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]]);
        Self {
            sequence: word(0),
            flags: PacketFlags::from_bits_retain(word(4)),
            checksum: word(8),
            id: half(12),
            time: half(14),
            size: half(16),
            iteration: half(18),
        }
    }

    /// The header's bytes.
    pub fn to_bytes(&self) -> [u8; HEADER_LENGTH] {
        let mut b = [0; HEADER_LENGTH];
        b[0..4].copy_from_slice(&self.sequence.to_le_bytes());
        b[4..8].copy_from_slice(&self.flags.bits().to_le_bytes());
        b[8..12].copy_from_slice(&self.checksum.to_le_bytes());
        b[12..14].copy_from_slice(&self.id.to_le_bytes());
        b[14..16].copy_from_slice(&self.time.to_le_bytes());
        b[16..18].copy_from_slice(&self.size.to_le_bytes());
        b[18..20].copy_from_slice(&self.iteration.to_le_bytes());
        b
    }

    /// Hash of the header without its checksum (H).
    pub fn hash(&self) -> u32 {
        hash32(
            &Self {
                checksum: CHECKSUM_PLACEHOLDER,
                ..*self
            }
            .to_bytes(),
        )
    }
}

/// What a checksum says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verified {
    /// The clear checksum is right.
    Clear,
    /// The clear checksum is wrong.
    Wrong,
    /// The packet is protected by this key word; a [`KeySearch`](super::KeySearch) tells whether it is the stream's.
    Encrypted(u32),
}

/// A packet as it lies in a datagram.
#[derive(Debug, Clone)]
pub struct Packet<'a> {
    /// Header.
    pub header: PacketHeader,
    /// Optional headers.
    pub optional: OptionalHeaders<'a>,
    /// Bytes of the optional headers.
    pub optional_bytes: &'a [u8],
    /// Bytes of the fragments.
    pub fragment_bytes: &'a [u8],
    /// Bytes after the announced size: an anomaly that is ignored.
    pub trailing: usize,
}

impl<'a> Packet<'a> {
    /// Reads a datagram. Fragments are checked: [`Packet::fragments`] of a packet that was read has no errors.
    ///
    /// # Errors
    /// When the datagram is no packet of a known layout; see [`PacketError`].
    pub fn parse(datagram: &'a [u8]) -> Result<Self, PacketError> {
        let (head, rest) =
            datagram
                .split_first_chunk::<HEADER_LENGTH>()
                .ok_or(PacketError::TooShort {
                    length: datagram.len(),
                })?;
        let header = PacketHeader::parse(head);
        let size = usize::from(header.size);
        let (payload, after) = rest.split_at_checked(size).ok_or(PacketError::Size {
            size,
            available: rest.len(),
        })?;
        match header.flags.unknown() {
            0 => {}
            bits => return Err(PacketError::UnknownFlags { bits }),
        }
        let (optional, length) = OptionalHeaders::parse(header.flags, payload)?;
        let (optional_bytes, fragment_bytes) = payload.split_at(length);
        if !header.flags.contains(PacketFlags::BLOB_FRAGMENTS) && !fragment_bytes.is_empty() {
            return Err(PacketError::Unannounced {
                left: fragment_bytes.len(),
            });
        }
        Fragments::new(fragment_bytes).try_for_each(|f| f.map(drop))?;
        Ok(Self {
            header,
            optional,
            optional_bytes,
            fragment_bytes,
            trailing: after.len(),
        })
    }

    /// The fragments, in packet order.
    pub fn fragments(&self) -> impl Iterator<Item = Fragment<'a>> {
        Fragments::new(self.fragment_bytes).filter_map(Result::ok)
    }

    /// Hash of everything behind the header (D).
    pub fn data_hash(&self) -> u32 {
        self.fragments()
            .fold(hash32(self.optional_bytes), |h, f| h.wrapping_add(f.hash()))
    }

    /// What the checksum says about the bytes as they are.
    pub fn verify(&self) -> Verified {
        let (h, d) = (self.header.hash(), self.data_hash());
        if self.header.flags.contains(PacketFlags::ENCRYPTED_CHECKSUM) {
            Verified::Encrypted(self.header.checksum.wrapping_sub(h) ^ d)
        } else if self.header.checksum == h.wrapping_add(d) {
            Verified::Clear
        } else {
            Verified::Wrong
        }
    }

    /// Whether the packet carries a number of its own in the direction from the server (9.1).
    pub fn is_numbered(&self) -> bool {
        let f = self.header.flags;
        self.header.sequence != 0
            && f != PacketFlags::ACK_SEQUENCE
            && !f.contains(PacketFlags::REQUEST_RETRANSMIT)
            && f.difference(PacketFlags::ENCRYPTED_CHECKSUM) != PacketFlags::ECHO_RESPONSE
    }
}

/// Builds packets into one buffer that is used again.
#[derive(Debug, Default)]
pub struct PacketBuilder {
    bytes: Vec<u8>,
    optional: usize,
    fragments: u32,
}

impl PacketBuilder {
    /// An empty builder.
    pub fn new() -> Self {
        Self::default()
    }

    /// Starts a packet with its optional headers.
    pub fn start(&mut self, optional: &OptionalHeaders<'_>) -> &mut Self {
        self.bytes.clear();
        self.bytes.resize(HEADER_LENGTH, 0);
        optional.write(&mut self.bytes);
        self.optional = self.bytes.len();
        self.fragments = 0;
        self
    }

    /// Adds a fragment; its `size` is set here.
    pub fn fragment(&mut self, header: FragmentHeader, data: &[u8]) -> &mut Self {
        let header = FragmentHeader {
            size: (super::FRAGMENT_HEADER + data.len()) as u16,
            ..header
        };
        self.fragments = self
            .fragments
            .wrapping_add(Fragment { header, data }.hash());
        self.bytes.extend_from_slice(&header.to_bytes());
        self.bytes.extend_from_slice(data);
        self
    }

    /// Bytes behind the header so far.
    pub fn payload_length(&self) -> usize {
        self.bytes.len().saturating_sub(HEADER_LENGTH)
    }

    /// Finishes the packet: writes size and checksum, with `key` where the flags say that it is encrypted. Flags of optional headers and
    /// fragments must be set in `header`.
    pub fn finish(&mut self, header: PacketHeader, key: Option<u32>) -> &[u8] {
        let header = PacketHeader {
            size: self.payload_length() as u16,
            ..header
        };
        let data = hash32(&self.bytes[HEADER_LENGTH..self.optional]).wrapping_add(self.fragments);
        let checksum = header.hash().wrapping_add(key.map_or(data, |k| data ^ k));
        self.bytes[..HEADER_LENGTH]
            .copy_from_slice(&PacketHeader { checksum, ..header }.to_bytes());
        &self.bytes
    }
}

/// The same packet as a retransmission: one flag more, a checksum to match, the same key word (6.4). Anything that is no packet stays.
pub(super) fn as_retransmission(datagram: &mut [u8]) {
    let Some((head, _)) = datagram.split_first_chunk_mut::<HEADER_LENGTH>() else {
        return;
    };
    let before = PacketHeader::parse(head);
    let mut after = PacketHeader {
        flags: before.flags | PacketFlags::RETRANSMISSION,
        ..before
    };
    after.checksum = before
        .checksum
        .wrapping_sub(before.hash())
        .wrapping_add(after.hash());
    *head = after.to_bytes();
}
