//! Pictures of a recording for Foxglove and Rerun: the objects that the server described, where clients said they were, and every message
//! as a line of the log. `ac_golden_traces::pictures` says how they are drawn, `docs/foxglove.md` how to look at them.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use ac_client::net::messages::common::WirePosition;
use ac_client::net::messages::object::ObjectDescription;
use ac_client::net::messages::{ClientMessage, GameAction, PlainServerMessage, ServerMessage};
use ac_golden_traces::pictures::{Level, Look, PictureWriter, Place};

use crate::decode::{Decoder, Finding, RecordedMessage, arrow};
use crate::error::RecordError;
use crate::format::RecordedPacket;

/// Objects as the server places them.
const SERVER: [f64; 4] = [0.2, 0.5, 1.0, 1.0];
/// The player, as its own client reports it.
const CLIENT: [f64; 4] = [1.0, 0.6, 0.1, 0.5];

/// Draws a recording, datagram by datagram.
pub struct Pictures<W: Write + Seek> {
    writer: PictureWriter<W>,
    decoder: Decoder,
    messages: Vec<RecordedMessage>,
    looks: BTreeMap<u32, Look>,
}

fn place(position: &WirePosition) -> Place {
    Place {
        cell: position.cell,
        origin: position.origin,
        rotation: position.rotation,
    }
}

impl<W: Write + Seek> Pictures<W> {
    /// Starts a file.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(out: W) -> Result<Self, RecordError> {
        let library = concat!("ac-record ", env!("CARGO_PKG_VERSION"));
        Ok(Self {
            writer: PictureWriter::new(out, library)?,
            decoder: Decoder::new(),
            messages: Vec::new(),
            looks: BTreeMap::new(),
        })
    }

    /// Draws what a datagram says.
    ///
    /// # Errors
    /// When writing fails.
    pub fn take(&mut self, packet: &RecordedPacket) -> Result<(), RecordError> {
        let mut messages = std::mem::take(&mut self.messages);
        messages.clear();
        let finding = self.decoder.take(packet, &mut messages);
        if let Finding::Checksum | Finding::Malformed(_) = finding {
            let line = format!("datagram {}: {finding:?}", packet.number);
            self.writer.log(
                packet.time,
                Level::Warning,
                &name(packet.stream.client),
                line,
            )?;
        }
        for message in &messages {
            self.message(message)?;
        }
        self.messages = messages;
        Ok(())
    }

    fn message(&mut self, message: &RecordedMessage) -> Result<(), RecordError> {
        let client = message.stream.client;
        // Names only: texts may be personal.
        let line = format!(
            "{} {} {} bytes",
            arrow(message.stream.direction()),
            message.name(),
            message.bytes.len()
        );
        self.writer
            .log(message.time, Level::Debug, &name(client), line)?;
        if message.stream.to_server {
            if let Ok(parsed) = ClientMessage::parse(&message.bytes) {
                self.report(message.time, client, &parsed.message)?;
            }
        } else if let Ok(parsed) = ServerMessage::parse(&message.bytes)
            && let ServerMessage::Plain(plain) = &parsed.message
        {
            self.object(message.time, plain)?;
        }
        Ok(())
    }

    /// Where a client says that its player is.
    fn report(
        &mut self,
        time: u64,
        client: u32,
        message: &ClientMessage,
    ) -> Result<(), RecordError> {
        let ClientMessage::Action { action, .. } = message else {
            return Ok(());
        };
        let position = match action {
            GameAction::MoveToState(m) => &m.position,
            GameAction::AutonomousPosition(m) => &m.position,
            GameAction::Jump(m) => &m.position,
            _ => return Ok(()),
        };
        let id = format!("client{client}");
        let look = Look {
            label: name(client),
            color: CLIENT,
            facts: Vec::new(),
        };
        Ok(self.writer.place(time, &id, &look, &place(position))?)
    }

    fn object(&mut self, time: u64, message: &PlainServerMessage) -> Result<(), RecordError> {
        match message {
            PlainServerMessage::CreateObject(d) | PlainServerMessage::UpdateObject(d) => {
                self.describe(time, d)
            }
            PlainServerMessage::UpdatePosition(m) => self.place(time, m.guid, &m.position.position),
            PlainServerMessage::PositionAndMovement(m) => {
                self.place(time, m.guid, &m.position.position)
            }
            PlainServerMessage::DeleteObject(m) => self.remove(time, m.guid),
            PlainServerMessage::PickupEvent(m) => self.remove(time, m.guid),
            _ => Ok(()),
        }
    }

    fn describe(&mut self, time: u64, object: &ObjectDescription) -> Result<(), RecordError> {
        let fields = &object.physics.fields;
        let hex = |value: Option<u32>| value.map(|v| format!("{v:08X}"));
        let facts = [
            ("guid", Some(format!("{:08X}", object.guid))),
            ("setup", hex(fields.setup)),
            ("motion table", hex(fields.motion_table)),
            ("state", hex(Some(object.physics.state))),
        ];
        let look = Look {
            label: object.weenie.name.to_str().into_owned(),
            color: SERVER,
            facts: facts
                .into_iter()
                .filter_map(|(key, value)| Some((key.to_owned(), value?)))
                .collect(),
        };
        self.looks.insert(object.guid, look);
        match &fields.position {
            Some(position) => self.place(time, object.guid, position),
            None => Ok(()),
        }
    }

    fn place(&mut self, time: u64, guid: u32, position: &WirePosition) -> Result<(), RecordError> {
        let id = format!("{guid:08X}");
        let look = self.looks.entry(guid).or_insert_with(|| Look {
            label: id.clone(),
            color: SERVER,
            facts: Vec::new(),
        });
        Ok(self.writer.place(time, &id, look, &place(position))?)
    }

    fn remove(&mut self, time: u64, guid: u32) -> Result<(), RecordError> {
        Ok(self.writer.remove(time, &format!("{guid:08X}"))?)
    }

    /// Ends the file, and says what is in it.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(self) -> Result<String, RecordError> {
        let (mut out, counts) = self.writer.finish()?;
        out.flush().map_err(mcap::McapError::from)?;
        Ok(format!(
            "{} objects, {} places, {} lines of log",
            counts.objects, counts.places, counts.lines
        ))
    }
}

fn name(client: u32) -> String {
    format!("client {client}")
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use ac_client::net::messages::object::UpdatePosition;
    use ac_client::net::messages::position::{PositionPack, PositionStamps};
    use ac_client::net::transport::{
        FragmentHeader, OptionalHeaders, PacketBuilder, PacketFlags, PacketHeader, Queue,
    };

    use super::*;
    use crate::format::Stream;

    fn packet(sequence: u32, message: &[u8]) -> RecordedPacket {
        let fragment = FragmentHeader {
            sequence,
            id: 0x8000_0000,
            count: 1,
            size: 0,
            index: 0,
            queue: Queue::SMARTBOX,
        };
        let header = PacketHeader {
            sequence,
            flags: PacketFlags::BLOB_FRAGMENTS,
            ..PacketHeader::default()
        };
        let bytes = PacketBuilder::new()
            .start(&OptionalHeaders::default())
            .fragment(fragment, message)
            .finish(header, None)
            .to_vec();
        RecordedPacket {
            stream: Stream {
                client: 0,
                to_server: false,
                next_port: false,
            },
            number: sequence,
            time: 1_700_000_000_000_000_000 + u64::from(sequence),
            forwarded: None,
            bytes,
        }
    }

    #[test]
    fn positions_become_transforms_and_messages_lines() {
        let mut pictures = Pictures::new(Cursor::new(Vec::new())).expect("memory");
        for sequence in 2..6 {
            let position = WirePosition {
                cell: 0xA9B4_0001,
                origin: [sequence as f32, 0.0, 0.0],
                rotation: [1.0, 0.0, 0.0, 0.0],
            };
            let update = UpdatePosition {
                guid: 0x5000_0001,
                position: PositionPack::new(position, true, PositionStamps::default()),
            };
            let message = ServerMessage::Plain(PlainServerMessage::UpdatePosition(update));
            let packet = packet(sequence, &message.to_bytes());
            pictures.take(&packet).expect("memory");
        }
        let mut damaged = packet(9, b"\0\0\0\0");
        damaged.bytes[9] ^= 1;
        pictures.take(&damaged).expect("memory");
        let told = pictures.finish().expect("memory");
        assert_eq!(told, "1 objects, 4 places, 5 lines of log");
    }
}
