//! Reads packet recordings (`docs/recording-format.md`), as far as they can be read.

use std::path::Path;

use mcap::read::{LinearReader, MessageStream, Options};
use mcap::records::Record;

use super::PacketsError;

/// Name of the metadata record.
const METADATA: &str = "ac-packets";
/// Versions of the format that are read: what this reader looks at is the same in both.
const VERSIONS: [&str; 2] = ["1", "2"];

/// A recorded datagram.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Datagram {
    /// Number of the client in the recording.
    pub client: u32,
    /// To the server.
    pub to_server: bool,
    /// Arrival, ns since 1970.
    pub time: u64,
    /// The datagram, redacted.
    pub bytes: Vec<u8>,
}

/// What could be read of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recording {
    /// Datagrams in the order of the file.
    pub datagrams: Vec<Datagram>,
    /// Why reading ended before the end of the file, if it did.
    pub damage: Option<String>,
}

/// The metadata's `format`, if the bytes are an MCAP file with the metadata of a packet recording.
fn format_of(bytes: &[u8]) -> Option<String> {
    let records = LinearReader::new_with_options(bytes, Options::IgnoreEndMagic.into()).ok()?;
    records
        .map_while(Result::ok)
        .find_map(|record| match record {
            Record::Metadata(m) if m.name == METADATA => m.metadata.get("format").cloned(),
            _ => None,
        })
}

/// Whether the bytes are a packet recording.
pub fn is_recording(bytes: &[u8]) -> bool {
    format_of(bytes).is_some()
}

/// The bytes of a file that is a packet recording; `None` for any other file, also for one that cannot be read.
pub fn recording_at(path: &Path) -> Option<Vec<u8>> {
    if path.extension().is_none_or(|ending| ending != "mcap") {
        return None;
    }
    std::fs::read(path).ok().filter(|bytes| is_recording(bytes))
}

/// Client and direction of a channel; `None` for channels of others.
fn stream_of(topic: &str) -> Option<(u32, bool)> {
    let mut parts = topic.strip_prefix("/client/")?.split('/');
    let client = parts.next()?.parse().ok()?;
    let to_server = match parts.next()? {
        "to-server" => true,
        "to-client" => false,
        _ => return None,
    };
    let port = matches!(parts.next()?, "login" | "next");
    (port && parts.next().is_none()).then_some((client, to_server))
}

impl Recording {
    /// Reads the bytes of a recording. `path` is what errors call it.
    ///
    /// # Errors
    /// When the bytes are no recording of a version that is known, or are damaged from the start.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self, PacketsError> {
        let format =
            format_of(bytes).ok_or_else(|| PacketsError::NotARecording { path: path.into() })?;
        if !VERSIONS.contains(&format.as_str()) {
            return Err(PacketsError::Version {
                path: path.into(),
                found: format,
            });
        }
        let messages = MessageStream::new_with_options(bytes, Options::IgnoreEndMagic.into());
        let messages = messages.map_err(|error| PacketsError::Damaged {
            path: path.into(),
            reason: error.to_string(),
        })?;
        let mut recording = Self::default();
        for message in messages {
            match message {
                Ok(message) => {
                    if let Some((client, to_server)) = stream_of(&message.channel.topic) {
                        recording.datagrams.push(Datagram {
                            client,
                            to_server,
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

    /// Reads a file.
    ///
    /// # Errors
    /// When the file cannot be read, and as [`Recording::parse`].
    pub fn open(path: &Path) -> Result<Self, PacketsError> {
        let bytes = std::fs::read(path).map_err(|source| PacketsError::Io {
            path: path.into(),
            source,
        })?;
        Self::parse(&bytes, path)
    }
}
