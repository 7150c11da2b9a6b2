//! Import of network captures (pcap and pcapng): UDP datagrams of the server's two ports become a recording.
//!
//! Containers are read by `pcap-parser`, packets by `etherparse`: Ethernet with any VLAN tags, Linux cooked (both versions), BSD loopback,
//! raw IP; IPv4 and IPv6, with fragments put together in bounded memory. Packets that were captured only in part are left out and counted.

mod fragments;
mod link;

use std::io::{Read, Seek, Write};
use std::net::SocketAddr;
use std::path::Path;

use ac_client::net::messages::Direction;
use ac_client::net::session::Port;
use pcap_parser::{Block, PcapBlockOwned, PcapError, create_reader};

use crate::error::RecordError;
use crate::format::{RecordingWriter, Stream};

pub use fragments::{FragmentKey, FragmentLimits, Fragments};
pub use link::{Content, content_of};

/// A UDP datagram of a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Datagram<'a> {
    /// Sender.
    pub from: SocketAddr,
    /// Receiver.
    pub to: SocketAddr,
    /// Content.
    pub bytes: &'a [u8],
}

/// What an import did.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ImportReport {
    /// Datagrams taken.
    pub taken: usize,
    /// Of these, datagrams that came in IP fragments.
    pub reassembled: usize,
    /// Packets that are none of the server's.
    pub others: usize,
    /// Packets that were captured only in part.
    pub cut: usize,
    /// IP fragments of datagrams that did not become complete.
    pub incomplete: usize,
    /// Packets whose headers cannot be followed.
    pub unreadable: usize,
    /// Secret bytes overwritten.
    pub redacted: usize,
    /// Why reading ended before the end of the capture, if it did.
    pub damage: Option<String>,
}

/// Most blocks of a capture fit; larger ones grow the buffer up to [`MAX_BUFFER`].
const BUFFER: usize = 1 << 16;
const MAX_BUFFER: usize = 16 << 20;
/// Clients of one capture.
const MAX_CLIENTS: usize = 4096;

/// Sorts datagrams into the streams of a recording, by the server's port.
struct Sorter {
    server_port: u16,
    clients: Vec<SocketAddr>,
}

impl Sorter {
    fn port(&self, port: u16) -> Option<Port> {
        match port.checked_sub(self.server_port)? {
            0 => Some(Port::Login),
            1 => Some(Port::Next),
            _ => None,
        }
    }

    fn stream(&mut self, datagram: &Datagram<'_>) -> Option<Stream> {
        let (client, direction, port) = match (
            self.port(datagram.to.port()),
            self.port(datagram.from.port()),
        ) {
            (Some(port), None) => (datagram.from, Direction::ToServer, port),
            (None, Some(port)) => (datagram.to, Direction::ToClient, port),
            _ => return None,
        };
        let known = self.clients.iter().position(|&c| c == client);
        let number = match known {
            Some(number) => number,
            None if self.clients.len() < MAX_CLIENTS => {
                self.clients.push(client);
                self.clients.len() - 1
            }
            None => return None,
        };
        Some(Stream::new(number as u32, direction, port))
    }
}

/// What is known of a capture's interfaces.
#[derive(Default)]
struct Interfaces {
    legacy: Option<(i32, u64)>,
    /// Time of the last frame: blocks without a time get it.
    last: u64,
    /// Link layer, offset in s, units per s.
    numbered: Vec<(i32, i64, u64)>,
}

/// A captured frame: link layer, ns since 1970, bytes, and whether it is whole.
struct Frame<'a> {
    link: i32,
    time: u64,
    bytes: &'a [u8],
    whole: bool,
}

impl Interfaces {
    fn frame<'b>(&mut self, block: &'b PcapBlockOwned<'_>) -> Option<Frame<'b>> {
        match block {
            PcapBlockOwned::LegacyHeader(header) => {
                let unit = if header.is_nanosecond_precision() {
                    1
                } else {
                    1000
                };
                self.legacy = Some((header.network.0, unit));
                None
            }
            PcapBlockOwned::Legacy(b) => {
                let (link, unit) = self.legacy?;
                let time = u64::from(b.ts_sec) * 1_000_000_000 + u64::from(b.ts_usec) * unit;
                Some(Frame {
                    link,
                    time,
                    bytes: b.data.get(..b.caplen as usize)?,
                    whole: b.caplen >= b.origlen,
                })
            }
            PcapBlockOwned::NG(Block::SectionHeader(_)) => {
                self.numbered.clear();
                None
            }
            PcapBlockOwned::NG(Block::InterfaceDescription(d)) => {
                let units = d.ts_resolution().unwrap_or(1_000_000).max(1);
                self.numbered.push((d.linktype.0, d.if_tsoffset, units));
                None
            }
            PcapBlockOwned::NG(Block::EnhancedPacket(b)) => {
                let &(link, offset, units) = self.numbered.get(b.if_id as usize)?;
                let ticks = u128::from(b.ts_high) << 32 | u128::from(b.ts_low);
                let time = ticks * 1_000_000_000 / u128::from(units);
                let time = i128::try_from(time).ok()? + i128::from(offset) * 1_000_000_000;
                Some(Frame {
                    link,
                    time: u64::try_from(time).unwrap_or_default(),
                    bytes: b.data.get(..b.caplen as usize)?,
                    whole: b.caplen >= b.origlen,
                })
            }
            // No time, and always the first interface.
            PcapBlockOwned::NG(Block::SimplePacket(b)) => {
                let &(link, ..) = self.numbered.first()?;
                let length = (b.origlen as usize).min(b.data.len());
                Some(Frame {
                    link,
                    time: self.last,
                    bytes: b.data.get(..length)?,
                    whole: b.origlen as usize <= b.data.len(),
                })
            }
            PcapBlockOwned::NG(_) => None,
        }
    }
}

fn reason(error: &PcapError<&[u8]>) -> String {
    match error {
        PcapError::HeaderNotRecognized | PcapError::Eof => "neither pcap nor pcapng".into(),
        PcapError::BufferTooSmall => "a block is larger than 16 MiB".into(),
        PcapError::ReadError => "it cannot be read".into(),
        other => format!("damaged ({other:?})").chars().take(200).collect(),
    }
}

fn bad(path: &Path, error: &PcapError<&[u8]>) -> RecordError {
    RecordError::Capture {
        path: path.into(),
        reason: reason(error),
    }
}

/// What a reader needs before it can go on.
enum More {
    Bytes,
    Room,
}

const CUT: &str = "it ends in the middle of a packet";

/// Writes the datagrams of a capture to and from a server's ports `server_port` and `server_port + 1` into a recording. A capture that
/// was cut off or is damaged is read up to there.
///
/// # Errors
/// The capture cannot be read at all, or the recording cannot be written.
pub fn import<W: Write + Seek>(
    path: &Path,
    capture: impl Read + Send,
    server_port: u16,
    writer: &mut RecordingWriter<W>,
) -> Result<ImportReport, RecordError> {
    let mut reader = create_reader(BUFFER, capture).map_err(|e| bad(path, &e))?;
    let mut interfaces = Interfaces::default();
    let mut importer = Importer {
        sorter: Sorter {
            server_port,
            clients: Vec::new(),
        },
        fragments: Fragments::new(FragmentLimits::default()),
        report: ImportReport::default(),
        writer,
    };
    let (mut size, mut blocks) = (BUFFER, 0usize);
    let damage = loop {
        let more = match reader.next() {
            Ok((used, block)) => {
                blocks += 1;
                if let Some(frame) = interfaces.frame(&block) {
                    interfaces.last = frame.time;
                    importer.take(&frame)?;
                }
                drop(block);
                reader.consume(used);
                continue;
            }
            Err(PcapError::Eof) => break None,
            Err(PcapError::UnexpectedEof) => break Some(CUT.into()),
            Err(PcapError::Incomplete(_)) => More::Bytes,
            Err(PcapError::BufferTooSmall) if size < MAX_BUFFER => More::Room,
            Err(error) if blocks == 0 => return Err(bad(path, &error)),
            Err(error) => break Some(reason(&error)),
        };
        match more {
            More::Bytes if reader.reader_exhausted() => break Some(CUT.into()),
            More::Bytes => reader.refill().map_err(|e| bad(path, &e))?,
            More::Room => {
                size *= 2;
                if !reader.grow(size) {
                    break Some(reason(&PcapError::BufferTooSmall));
                }
            }
        }
    };
    let (fragments, mut report) = (importer.fragments, importer.report);
    report.incomplete = fragments.lost();
    report.redacted = writer.totals().1;
    report.damage = damage;
    Ok(report)
}

/// Takes frames.
struct Importer<'w, W: Write + Seek> {
    sorter: Sorter,
    fragments: Fragments,
    report: ImportReport,
    writer: &'w mut RecordingWriter<W>,
}

impl<W: Write + Seek> Importer<'_, W> {
    fn take(&mut self, frame: &Frame<'_>) -> Result<(), RecordError> {
        match content_of(frame.link, frame.bytes) {
            // What is whole in spite of a cut is taken.
            Content::Udp(datagram) => self.datagram(&datagram, frame.time),
            _ if !frame.whole => {
                self.report.cut += 1;
                Ok(())
            }
            Content::Fragment {
                key,
                offset,
                more,
                bytes,
            } => {
                let whole = self.fragments.push(key, offset, more, bytes, frame.time);
                let Some(whole) = whole else {
                    return Ok(());
                };
                match link::udp(key.from, key.to, &whole) {
                    Some(datagram) => {
                        let before = self.report.taken;
                        self.datagram(&datagram, frame.time)?;
                        self.report.reassembled += self.report.taken - before;
                    }
                    None => self.report.unreadable += 1,
                }
                Ok(())
            }
            Content::Other => {
                self.report.others += 1;
                Ok(())
            }
            Content::Unreadable => {
                self.report.unreadable += 1;
                Ok(())
            }
        }
    }

    fn datagram(&mut self, datagram: &Datagram<'_>, time: u64) -> Result<(), RecordError> {
        let Some(stream) = self.sorter.stream(datagram) else {
            self.report.others += 1;
            return Ok(());
        };
        self.report.taken += 1;
        self.writer.write(stream, time, datagram.bytes)
    }
}

#[cfg(test)]
mod tests;
