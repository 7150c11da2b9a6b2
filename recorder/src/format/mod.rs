//! The recording format, version 2: an MCAP file with profile `ac-packets`. `docs/recording-format.md` describes it.
//!
//! | part | content |
//! |---|---|
//! | metadata `ac-packets` | `format`, `producer`, `secrets`, `part`, `first_datagram` |
//! | channel `/client/N/to-server/login`, `.../next`, `/client/N/to-client/login`, `.../next` | client N's datagrams, by direction and server port (P or P + 1); message encoding `ac-datagram` |
//! | message | one datagram, redacted, byte for byte otherwise; log time = arrival, publish time = when it was passed on or 0, ns since 1970; sequence = its number in the recording |
//! | channel `/messages` | JSON, one [`IndexEntry`] per complete game message |
//! | channel `/counters` | JSON, [`Counts`](crate::counters::Counts) about once a second |
//! | metadata `ac-counters` | the last counts |
//!
//! Readers ignore channels with other topics. A changed meaning of what is here raises the version.

mod index;
mod reader;
mod writer;

use ac_client::net::messages::Direction;
use ac_client::net::session::Port;

pub use index::IndexEntry;
pub use reader::{
    Item, Recording, RecordingInfo, RecordingReader, open, read, read_all, read_bytes,
};
pub use writer::{Continuation, PartInfo, RecordingWriter, WriterOptions};

/// Name of the metadata record, and the profile.
pub const METADATA: &str = "ac-packets";
/// Version of the format.
pub const VERSION: &str = "2";
/// Version before: publish times were arrival times, and there was no index.
const OLD_VERSION: &str = "1";
/// Encoding of a channel's messages.
const ENCODING: &str = "ac-datagram";
/// Topic of the message index.
pub const INDEX_TOPIC: &str = "/messages";
/// Topic of the counters.
pub const COUNTERS_TOPIC: &str = "/counters";
/// Metadata with the last counters.
pub const COUNTERS_METADATA: &str = "ac-counters";

/// Which stream of datagrams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stream {
    /// Number of the client in the recording, from 0.
    pub client: u32,
    /// To the server.
    pub to_server: bool,
    /// Of the server's ports the second one.
    pub next_port: bool,
}

impl Stream {
    /// The stream of a datagram.
    pub const fn new(client: u32, direction: Direction, port: Port) -> Self {
        Self {
            client,
            to_server: matches!(direction, Direction::ToServer),
            next_port: matches!(port, Port::Next),
        }
    }

    /// Which way its datagrams go.
    pub const fn direction(self) -> Direction {
        if self.to_server {
            Direction::ToServer
        } else {
            Direction::ToClient
        }
    }

    /// The channel's topic.
    pub fn topic(self) -> String {
        let way = if self.to_server {
            "to-server"
        } else {
            "to-client"
        };
        let port = if self.next_port { "next" } else { "login" };
        format!("/client/{}/{way}/{port}", self.client)
    }

    /// The stream of a topic; `None` for channels of others.
    pub fn of(topic: &str) -> Option<Self> {
        let mut parts = topic.strip_prefix("/client/")?.split('/');
        let stream = Self {
            client: parts.next()?.parse().ok()?,
            to_server: match parts.next()? {
                "to-server" => true,
                "to-client" => false,
                _ => return None,
            },
            next_port: match parts.next()? {
                "login" => false,
                "next" => true,
                _ => return None,
            },
        };
        parts.next().is_none().then_some(stream)
    }
}

/// A recorded datagram.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedPacket {
    /// Its stream.
    pub stream: Stream,
    /// Its number in the recording, from 0; parts of a recording go on counting.
    pub number: u32,
    /// Arrival, ns since 1970.
    pub time: u64,
    /// When it was passed on, ns since 1970; `None` when it was not, or when that is not known.
    pub forwarded: Option<u64>,
    /// The datagram, redacted unless the recording says otherwise.
    pub bytes: Vec<u8>,
}

#[cfg(test)]
mod tests;
