//! The recording format, version 1: an MCAP file with profile `ac-packets`.
//!
//! | part | content |
//! |---|---|
//! | metadata `ac-packets` | `format` (1), `producer` |
//! | channel `/client/N/to-server/login`, `.../next`, `/client/N/to-client/login`, `.../next` | client N's datagrams, by direction and server port (P or P + 1); message encoding `ac-datagram` |
//! | message | one datagram, redacted, byte for byte otherwise; log time = arrival, ns since 1970; sequence = its number in the file |
//!
//! Readers ignore channels with other topics. A changed meaning of what is here raises the version.

use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::path::Path;

use ac_client::net::messages::Direction;
use ac_client::net::session::Port;
use ac_client::net::transport::Redactor;
use mcap::read::{LinearReader, MessageStream, Options};
use mcap::records::{MessageHeader, Metadata, Record};

use crate::error::RecordError;

/// Name of the metadata record, and the profile.
pub const METADATA: &str = "ac-packets";
/// Version of the format.
pub const VERSION: &str = "1";
/// Encoding of a channel's messages.
const ENCODING: &str = "ac-datagram";

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
    /// Arrival, ns since 1970.
    pub time: u64,
    /// The datagram, redacted.
    pub bytes: Vec<u8>,
}

/// Writes a recording. There is no way to write a datagram that was not redacted.
pub struct RecordingWriter<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    channels: BTreeMap<Stream, u16>,
    redactors: BTreeMap<u32, Redactor>,
    packets: u32,
    redacted: usize,
    last_time: u64,
}

impl<W: Write + Seek> RecordingWriter<W> {
    /// Starts a recording.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(out: W) -> Result<Self, RecordError> {
        let mut mcap = mcap::WriteOptions::new()
            .profile(METADATA)
            .library(concat!("ac-recorder ", env!("CARGO_PKG_VERSION")))
            .compression(Some(mcap::Compression::Zstd))
            .compression_level(3)
            .compression_threads(0)
            .create(out)?;
        let metadata = BTreeMap::from([
            ("format".to_owned(), VERSION.to_owned()),
            (
                "producer".to_owned(),
                concat!("ac-record ", env!("CARGO_PKG_VERSION")).to_owned(),
            ),
        ]);
        mcap.write_metadata(&Metadata {
            name: METADATA.into(),
            metadata,
        })?;
        Ok(Self {
            mcap,
            channels: BTreeMap::new(),
            redactors: BTreeMap::new(),
            packets: 0,
            redacted: 0,
            last_time: 0,
        })
    }

    /// Redacts and writes a datagram. Times never go backwards: an earlier one is written as the last.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(&mut self, stream: Stream, time: u64, datagram: &[u8]) -> Result<(), RecordError> {
        let mut bytes = datagram.to_vec();
        let redactor = self.redactors.entry(stream.client).or_default();
        self.redacted += redactor.redact(&mut bytes).bytes;
        let channel_id = match self.channels.get(&stream) {
            Some(&id) => id,
            None => {
                let id = self
                    .mcap
                    .add_channel(0, &stream.topic(), ENCODING, &BTreeMap::new())?;
                self.channels.insert(stream, id);
                id
            }
        };
        self.last_time = self.last_time.max(time);
        let header = MessageHeader {
            channel_id,
            sequence: self.packets,
            log_time: self.last_time,
            publish_time: self.last_time,
        };
        self.mcap.write_to_known_channel(&header, &bytes)?;
        self.packets = self.packets.wrapping_add(1);
        Ok(())
    }

    /// Puts everything written so far where a crash leaves it readable.
    ///
    /// # Errors
    /// When writing fails.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        Ok(self.mcap.flush()?)
    }

    /// Datagrams written, and secret bytes overwritten in them.
    pub const fn totals(&self) -> (u32, usize) {
        (self.packets, self.redacted)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(mut self) -> Result<W, RecordError> {
        self.mcap.finish()?;
        Ok(self.mcap.into_inner())
    }
}

/// What could be read of a recording.
#[derive(Debug, Default)]
pub struct Recording {
    /// Datagrams in order of arrival.
    pub packets: Vec<RecordedPacket>,
    /// Why reading ended before the end of the file, if it did.
    pub damage: Option<String>,
}

/// Checks that a file is a recording of a known version.
fn check_metadata(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    let records = LinearReader::new_with_options(bytes, Options::IgnoreEndMagic.into())?;
    // The metadata comes right after the header; damage behind it does not matter here.
    let metadata = records
        .map_while(Result::ok)
        .find_map(|record| match record {
            Record::Metadata(m) if m.name == METADATA => Some(m),
            _ => None,
        });
    let not = || RecordError::NotARecording { path: path.into() };
    let format = metadata.and_then(|m| m.metadata.get("format").cloned());
    match format.ok_or_else(not)? {
        version if version == VERSION => Ok(()),
        found => Err(RecordError::Version {
            path: path.into(),
            found,
        }),
    }
}

/// Reads the bytes of a recording, as far as they can be read.
///
/// # Errors
/// The bytes are no recording.
pub fn read_bytes(path: &Path, bytes: &[u8]) -> Result<Recording, RecordError> {
    check_metadata(path, bytes)?;
    let mut recording = Recording::default();
    for message in MessageStream::new_with_options(bytes, Options::IgnoreEndMagic.into())? {
        match message {
            Ok(message) => {
                if let Some(stream) = Stream::of(&message.channel.topic) {
                    recording.packets.push(RecordedPacket {
                        stream,
                        time: message.log_time,
                        bytes: message.data.into_owned(),
                    });
                }
            }
            Err(error) => {
                recording.damage = Some(error.to_string());
                break;
            }
        }
    }
    if recording.damage.is_none() && !bytes.ends_with(mcap::MAGIC) {
        recording.damage = Some("the file was not finished".into());
    }
    Ok(recording)
}

/// Reads a recording, as far as it can be read.
///
/// # Errors
/// The file cannot be read, or is no recording.
pub fn read(path: &Path) -> Result<Recording, RecordError> {
    let bytes = std::fs::read(path).map_err(|source| RecordError::File {
        path: path.into(),
        source,
    })?;
    read_bytes(path, &bytes)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use ac_client::net::transport::{
        AuthType, LoginRequest, OptionalHeaders, Packet, PacketBuilder, PacketFlags, PacketHeader,
        Verified,
    };

    use super::*;

    fn login() -> Vec<u8> {
        let request = LoginRequest {
            version: "1802".into(),
            auth: AuthType::Password,
            auth_flags: 1,
            timestamp: 1,
            account: "tester".into(),
            account_override: String::new(),
            secret: Some("secret".into()),
        };
        let payload = request.to_bytes().expect("a valid login");
        let optional = OptionalHeaders {
            login: Some(&payload),
            ..OptionalHeaders::default()
        };
        let header = PacketHeader {
            flags: PacketFlags::LOGIN_REQUEST,
            ..PacketHeader::default()
        };
        PacketBuilder::new()
            .start(&optional)
            .finish(header, None)
            .to_vec()
    }

    const STREAM: Stream = Stream {
        client: 3,
        to_server: true,
        next_port: false,
    };

    fn file(packets: u64, finish: bool) -> Vec<u8> {
        let mut writer = RecordingWriter::new(Cursor::new(Vec::new())).expect("memory");
        for i in 0..packets {
            writer.write(STREAM, 1000 + i, &login()).expect("memory");
            writer.flush().expect("memory");
        }
        if finish {
            writer.finish().expect("memory").into_inner()
        } else {
            writer.mcap.into_inner().into_inner()
        }
    }

    #[test]
    fn nothing_secret_is_written() {
        let bytes = file(1, true);
        let recording = read_bytes(Path::new("r"), &bytes).expect("a recording");
        assert_eq!(recording.damage, None);
        let [packet] = &recording.packets[..] else {
            panic!("one packet: {recording:?}");
        };
        assert_eq!((packet.stream, packet.time), (STREAM, 1000));
        for secret in ["tester", "secret"] {
            let found = |b: &[u8]| b.windows(6).any(|w| w == secret.as_bytes());
            assert!(!found(&packet.bytes) && !found(&bytes));
        }
        let packet = Packet::parse(&packet.bytes).expect("still a packet");
        assert_eq!(packet.verify(), Verified::Clear);
    }

    #[test]
    fn a_file_that_was_cut_off_is_read_up_to_there() {
        let whole = file(5, true);
        let unfinished = file(5, false);
        let recording = read_bytes(Path::new("r"), &unfinished).expect("a recording");
        assert_eq!(recording.packets.len(), 5);
        assert!(recording.damage.is_some());
        let mut seen = 5;
        for n in (200..whole.len()).rev() {
            if let Ok(recording) = read_bytes(Path::new("r"), &whole[..n]) {
                assert!(recording.packets.len() <= seen && recording.damage.is_some());
                seen = recording.packets.len();
            }
        }
        assert!(seen < 5);
    }

    #[test]
    fn other_files_are_refused() {
        assert!(read_bytes(Path::new("r"), b"").is_err());
        assert!(read_bytes(Path::new("r"), &[7; 100]).is_err());
        let mut other = Cursor::new(Vec::new());
        mcap::Writer::new(&mut other)
            .and_then(|mut w| w.finish())
            .expect("memory");
        let error = read_bytes(Path::new("r"), other.get_ref()).expect_err("no metadata");
        assert!(matches!(error, RecordError::NotARecording { .. }));
    }

    #[test]
    fn topics_name_streams() {
        for client in [0, 7] {
            for (to_server, next_port) in
                [(false, false), (false, true), (true, false), (true, true)]
            {
                let stream = Stream {
                    client,
                    to_server,
                    next_port,
                };
                assert_eq!(Stream::of(&stream.topic()), Some(stream));
            }
        }
        for topic in [
            "/states",
            "/client/x/to-server/login",
            "/client/1/to-server/login/x",
        ] {
            assert_eq!(Stream::of(topic), None);
        }
    }
}
