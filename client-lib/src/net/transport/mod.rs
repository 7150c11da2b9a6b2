//! Packets between the UDP socket and a complete game message (`spec/09-network.md`).
//!
//! One datagram is one packet: a 20-byte header, optional headers in ascending order of their flag bit, and fragments of messages. A checksum
//! protects it; most packets mix a word of an ISAAC key stream into the checksum, while the payload travels in the clear. All integers are
//! little endian unless a field says otherwise.

mod cipher;
mod connection;
mod fragment;
#[doc(hidden)]
pub mod fuzzing;
mod hash;
mod isaac;
mod login;
mod optional;
mod packet;
mod reassembly;
mod redact;
#[cfg(test)]
mod tests;

pub use cipher::{KEY_WINDOW, KeySearch};
pub use connection::{Anomaly, Connection, ConnectionLimits, ConnectionStats, Incoming, Role};
pub use fragment::{
    FRAGMENT_DATA, FRAGMENT_HEADER, Fragment, FragmentHeader, Fragments, MAX_FRAGMENT, Queue,
    fragment_count,
};
pub use hash::hash32;
pub use isaac::Isaac;
pub use login::{AuthType, LoginError, LoginRequest};
pub use optional::{
    ConnectRequest, EchoResponse, Flow, NetError, OptionalHeaders, Referral, SequenceList,
    ServerSwitch, SocketAddress,
};
pub use packet::{
    HEADER_LENGTH, MAX_DATAGRAM, Packet, PacketBuilder, PacketError, PacketFlags, PacketHeader,
    Verified,
};
pub use reassembly::{Message, Reassembler, ReassemblyLimits, ReassemblyNote};
pub use redact::{REDACTED, Redaction, Redactor};
