//! Chat outside game events (`spec/10-messages.md`, 8.2).

use super::common::{Text, WideText};
use super::wire::{ReadError, Reader, Wire, Writer, wire_struct};

wire_struct! {
    /// HearSpeech.
    pub struct HearSpeech {
        /// What is said.
        text: Text,
        /// Who says it.
        sender: Text,
        /// Their GUID.
        sender_guid: u32,
        /// Chat type.
        kind: u32,
    }

    /// HearRangedSpeech.
    pub struct HearRangedSpeech {
        /// What is said.
        text: Text,
        /// Who says it.
        sender: Text,
        /// Their GUID.
        sender_guid: u32,
        /// How far it is heard, m.
        range: f32,
        /// Chat type.
        kind: u32,
    }

    /// EmoteText, SoulEmote.
    pub struct EmoteText {
        /// GUID of who does it.
        guid: u32,
        /// Who does it.
        sender: Text,
        /// What is done.
        text: Text,
    }

    /// ServerMessage.
    pub struct ServerText {
        /// Text.
        text: Text,
        /// Chat type.
        kind: u32,
    }

    /// PlayerKilled.
    pub struct PlayerKilled {
        /// Text.
        text: Text,
        /// Who died.
        victim: u32,
        /// Who did it.
        killer: u32,
    }

    /// A line of a turbine chat room.
    pub struct ChatEvent {
        /// Room.
        room: u32,
        /// Who says it.
        sender: WideText,
        /// What is said.
        text: WideText,
        /// 12.
        size: u32,
        /// GUID of who says it.
        guid: u32,
        /// 0.
        zero: u32,
        /// Chat kind.
        kind: u32,
    }

    /// A line to a turbine chat room.
    pub struct ChatRequest {
        /// Which request.
        context: u32,
        /// 2, 2.
        twos: [u32; 2],
        /// Room.
        room: u32,
        /// What is said.
        text: WideText,
        /// 12.
        size: u32,
        /// Own GUID.
        guid: u32,
        /// 0.
        zero: u32,
        /// Chat kind.
        kind: u32,
    }

    /// The answer to a line.
    #[derive(Copy, Eq)]
    pub struct ChatResponse {
        /// Which request.
        context: u32,
        /// 2, 2.
        twos: [u32; 2],
        /// 0.
        zero: u32,
    }
}

/// What a turbine chat message says.
#[derive(Debug, Clone, PartialEq)]
pub enum ChatBlob {
    /// Blob type 1.
    Event(ChatEvent),
    /// Blob type 3.
    Request(ChatRequest),
    /// Blob type 5.
    Response(ChatResponse),
    /// Any other type, unread.
    Other(Vec<u8>),
}

/// TurbineChat. The byte counts are kept and not believed: one server writes both 8 too large.
#[derive(Debug, Clone, PartialEq)]
pub struct TurbineChat {
    /// Byte count, blob type, dispatch, 1, x, 1, x, 0, byte count.
    pub header: [u32; 9],
    /// Content by blob type.
    pub blob: ChatBlob,
}

impl TurbineChat {
    /// A message with true byte counts.
    pub fn new(dispatch: u32, blob: ChatBlob) -> Self {
        let mut w = Writer::default();
        write_blob(&blob, &mut w);
        let n = w.bytes.len() as u32;
        let kind = match &blob {
            ChatBlob::Event(_) => 1,
            ChatBlob::Request(_) => 3,
            ChatBlob::Response(_) => 5,
            ChatBlob::Other(_) => 0,
        };
        Self {
            header: [n + 32, kind, dispatch, 1, 0, 1, 0, 0, n],
            blob,
        }
    }
}

fn write_blob(blob: &ChatBlob, w: &mut Writer) {
    match blob {
        ChatBlob::Event(e) => e.write(w),
        ChatBlob::Request(q) => q.write(w),
        ChatBlob::Response(a) => a.write(w),
        ChatBlob::Other(bytes) => w.put(bytes),
    }
}

impl Wire for TurbineChat {
    const MIN: usize = 36;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let header = r.get::<[u32; 9]>()?;
        let blob = match header[1] {
            1 => ChatBlob::Event(r.get()?),
            3 => ChatBlob::Request(r.get()?),
            5 => ChatBlob::Response(r.get()?),
            _ => ChatBlob::Other(r.rest().to_vec()),
        };
        Ok(Self { header, blob })
    }
    fn write(&self, w: &mut Writer) {
        self.header.write(w);
        write_blob(&self.blob, w);
    }
}
