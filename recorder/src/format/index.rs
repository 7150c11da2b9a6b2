//! The message index: what complete game messages a recording holds, and in which datagrams.

use serde::{Deserialize, Serialize};

use crate::decode::RecordedMessage;

/// One line of the index, written when the last datagram of a message has come. It holds nothing of the message's content.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct IndexEntry {
    /// Number of the client.
    pub client: u32,
    /// Direction.
    pub to_server: bool,
    /// First word of the message; `None` for messages of fewer than four bytes.
    pub opcode: Option<u32>,
    /// Name of the message, or of the event or action in it.
    pub name: String,
    /// Queue of its first fragment (`spec/09`, 8.4).
    pub queue: u16,
    /// Bytes of the message.
    pub bytes: usize,
    /// Numbers of the datagrams with its fragments, in order of arrival.
    pub datagrams: Vec<u32>,
}

impl IndexEntry {
    /// The entry of a message.
    pub fn of(message: &RecordedMessage) -> Self {
        Self {
            client: message.stream.client,
            to_server: message.stream.to_server,
            opcode: message.bytes.first_chunk().map(|b| u32::from_le_bytes(*b)),
            name: message.name().into_owned(),
            queue: message.queue,
            bytes: message.bytes.len(),
            datagrams: message.datagrams.clone(),
        }
    }
}

/// JSON schema of the index, so that tools show its fields.
pub(super) const INDEX_SCHEMA: &str = r#"{"title":"ac.MessageIndex","type":"object","properties":{"client":{"type":"integer"},"to_server":{"type":"boolean"},"opcode":{"type":["integer","null"]},"name":{"type":"string"},"queue":{"type":"integer"},"bytes":{"type":"integer"},"datagrams":{"type":"array","items":{"type":"integer"}}}}"#;
