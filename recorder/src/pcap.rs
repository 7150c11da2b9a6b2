//! Import of network captures (pcap and pcapng): UDP datagrams of the server's two ports become a recording.
//!
//! Link layers: Ethernet (with VLAN tags), Linux cooked, BSD loopback, raw IP. Fragments of IP packets and packets that were captured
//! only in part are left out and counted.

use std::io::{Read, Seek, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::Path;

use ac_client::net::messages::Direction;
use ac_client::net::session::Port;
use pcap_parser::{Block, PcapBlockOwned, PcapError, create_reader};

use crate::error::RecordError;
use crate::format::{RecordingWriter, Stream};

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ImportReport {
    /// Datagrams taken.
    pub taken: usize,
    /// Packets that are none of the server's.
    pub others: usize,
    /// Packets that were captured only in part.
    pub cut: usize,
    /// Secret bytes overwritten.
    pub redacted: usize,
}

const ETHERNET: i32 = 1;
const NULL: i32 = 0;
const LOOP: i32 = 108;
const RAW: [i32; 4] = [12, 101, 228, 229];
const LINUX_SLL: i32 = 113;
const LINUX_SLL2: i32 = 276;

const UDP: u8 = 17;
/// Most blocks of a capture fit; larger ones grow the buffer up to [`MAX_BUFFER`].
const BUFFER: usize = 1 << 16;
const MAX_BUFFER: usize = 16 << 20;
/// Clients of one capture.
const MAX_CLIENTS: usize = 4096;

fn be16(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// The IP packet in a frame of a link layer; `None` for link layers that are not read, and for frames without IP.
fn ip_of(link: i32, frame: &[u8]) -> Option<&[u8]> {
    match link {
        ETHERNET => {
            let mut at = 12;
            // Up to two VLAN tags come before the type.
            for _ in 0..2 {
                if matches!(be16(frame, at)?, 0x8100 | 0x88A8) {
                    at += 4;
                }
            }
            matches!(be16(frame, at)?, 0x0800 | 0x86DD).then(|| frame.get(at + 2..))?
        }
        NULL | LOOP => frame.get(4..),
        LINUX_SLL => frame.get(16..),
        LINUX_SLL2 => frame.get(20..),
        _ if RAW.contains(&link) => Some(frame),
        _ => None,
    }
}

/// The UDP datagram in a frame; `None` for everything else, and for fragments.
pub fn udp_of(link: i32, frame: &[u8]) -> Option<Datagram<'_>> {
    let ip = ip_of(link, frame)?;
    let (from, to, rest): (IpAddr, IpAddr, &[u8]) = match ip.first()? >> 4 {
        4 => {
            let header = usize::from(ip.first()? & 15) * 4;
            let total = usize::from(be16(ip, 2)?);
            let fragment = be16(ip, 6)? & 0x3FFF != 0;
            if *ip.get(9)? != UDP || fragment || header < 20 {
                return None;
            }
            let from = Ipv4Addr::from(*ip.get(12..)?.first_chunk::<4>()?);
            let to = Ipv4Addr::from(*ip.get(16..)?.first_chunk::<4>()?);
            // Short Ethernet frames are padded: the length is the packet's own.
            (from.into(), to.into(), ip.get(header..total)?)
        }
        6 => {
            if *ip.get(6)? != UDP {
                return None;
            }
            let from = Ipv6Addr::from(*ip.get(8..)?.first_chunk::<16>()?);
            let to = Ipv6Addr::from(*ip.get(24..)?.first_chunk::<16>()?);
            (from.into(), to.into(), ip.get(40..)?)
        }
        _ => return None,
    };
    let length = usize::from(be16(rest, 4)?);
    Some(Datagram {
        from: SocketAddr::new(from, be16(rest, 0)?),
        to: SocketAddr::new(to, be16(rest, 2)?),
        bytes: rest.get(8..length)?,
    })
}

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
            PcapBlockOwned::NG(_) => None,
        }
    }
}

fn bad(path: &Path, error: &PcapError<&[u8]>) -> RecordError {
    RecordError::Capture {
        path: path.into(),
        reason: match error {
            PcapError::HeaderNotRecognized | PcapError::Eof => "neither pcap nor pcapng".into(),
            PcapError::BufferTooSmall => "a block is larger than 16 MiB".into(),
            PcapError::ReadError => "it cannot be read".into(),
            other => format!("damaged ({other:?})").chars().take(200).collect(),
        },
    }
}

/// What a reader needs before it can go on.
enum More {
    Bytes,
    Room,
}

/// Writes the datagrams of a capture to and from a server's ports `server_port` and `server_port + 1` into a recording. A capture that
/// was cut off is read up to there.
///
/// # Errors
/// The capture cannot be read, or the recording cannot be written.
pub fn import<W: Write + Seek>(
    path: &Path,
    capture: impl Read + Send,
    server_port: u16,
    writer: &mut RecordingWriter<W>,
) -> Result<ImportReport, RecordError> {
    let mut reader = create_reader(BUFFER, capture).map_err(|e| bad(path, &e))?;
    let mut interfaces = Interfaces::default();
    let mut sorter = Sorter {
        server_port,
        clients: Vec::new(),
    };
    let (mut report, mut size) = (ImportReport::default(), BUFFER);
    loop {
        let more = match reader.next() {
            Ok((used, block)) => {
                if let Some(frame) = interfaces.frame(&block) {
                    take(&frame, &mut sorter, writer, &mut report)?;
                }
                drop(block);
                reader.consume(used);
                continue;
            }
            Err(PcapError::Eof | PcapError::UnexpectedEof) => break,
            Err(PcapError::Incomplete(_)) => More::Bytes,
            Err(PcapError::BufferTooSmall) => More::Room,
            Err(error) => return Err(bad(path, &error)),
        };
        match more {
            More::Bytes if reader.reader_exhausted() => break,
            More::Bytes => reader.refill().map_err(|e| bad(path, &e))?,
            More::Room => {
                size *= 2;
                if size > MAX_BUFFER || !reader.grow(size) {
                    return Err(bad(path, &PcapError::BufferTooSmall));
                }
            }
        }
    }
    report.redacted = writer.totals().1;
    Ok(report)
}

fn take<W: Write + Seek>(
    frame: &Frame<'_>,
    sorter: &mut Sorter,
    writer: &mut RecordingWriter<W>,
    report: &mut ImportReport,
) -> Result<(), RecordError> {
    if !frame.whole {
        report.cut += 1;
        return Ok(());
    }
    let datagram = udp_of(frame.link, frame.bytes);
    match datagram.and_then(|d| Some((sorter.stream(&d)?, d.bytes))) {
        Some((stream, bytes)) => {
            report.taken += 1;
            writer.write(stream, frame.time, bytes)
        }
        None => {
            report.others += 1;
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::format::read_bytes;

    /// An Ethernet frame with a UDP datagram.
    fn frame(from: u16, to: u16, payload: &[u8]) -> Vec<u8> {
        let udp = 8 + payload.len();
        // The server is 10.0.0.2.
        let (a, b) = if to >= 9000 { (1, 2) } else { (2, 1) };
        let mut f = vec![0; 12];
        f.extend([0x08, 0x00, 0x45, 0]);
        f.extend(((20 + udp) as u16).to_be_bytes());
        f.extend([0, 0, 0, 0, 64, UDP, 0, 0, 10, 0, 0, a, 10, 0, 0, b]);
        f.extend(from.to_be_bytes());
        f.extend(to.to_be_bytes());
        f.extend((udp as u16).to_be_bytes());
        f.extend([0, 0]);
        f.extend(payload);
        // Ethernet pads short frames.
        f.resize(f.len().max(60), 0);
        f
    }

    fn capture(frames: &[Vec<u8>]) -> Vec<u8> {
        let mut c = Vec::new();
        c.extend(0xA1B2_C3D4u32.to_le_bytes());
        c.extend([2, 0, 4, 0]);
        c.extend([0; 8]);
        c.extend(65_535u32.to_le_bytes());
        c.extend(1u32.to_le_bytes());
        for (i, f) in frames.iter().enumerate() {
            let n = f.len() as u32;
            for word in [100, i as u32, n, n] {
                c.extend(word.to_le_bytes());
            }
            c.extend(f);
        }
        c
    }

    fn imported(capture: &[u8]) -> (ImportReport, crate::format::Recording) {
        let mut writer = RecordingWriter::new(Cursor::new(Vec::new())).expect("memory");
        let report = import(Path::new("c"), capture, 9000, &mut writer).expect("a capture");
        let bytes = writer.finish().expect("memory").into_inner();
        (
            report,
            read_bytes(Path::new("r"), &bytes).expect("a recording"),
        )
    }

    #[test]
    fn datagrams_of_the_server_are_taken() {
        let frames = [
            frame(5000, 9000, b"hello"),
            frame(9001, 5000, b"there"),
            frame(5001, 9001, b"other"),
            frame(5000, 53, b"name?"),
        ];
        let (report, recording) = imported(&capture(&frames));
        assert_eq!((report.taken, report.others, report.cut), (3, 1, 0));
        let topics: Vec<_> = recording.packets.iter().map(|p| p.stream.topic()).collect();
        let expected = [
            "/client/0/to-server/login",
            "/client/0/to-client/next",
            "/client/1/to-server/next",
        ];
        assert_eq!(topics, expected);
        assert_eq!(recording.packets[1].bytes, b"there");
        assert_eq!(recording.packets[1].time, 100_000_001_000);
    }

    #[test]
    fn damaged_captures_do_no_harm() {
        let whole = capture(&[frame(5000, 9000, b"hello"), frame(9001, 5000, b"there")]);
        for n in 24..whole.len() {
            let (report, _) = imported(&whole[..n]);
            assert!(report.taken < 2);
        }
        let mut writer = RecordingWriter::new(Cursor::new(Vec::new())).expect("memory");
        let error = import(
            Path::new("c"),
            &b"no capture at all, but text"[..],
            9000,
            &mut writer,
        );
        assert!(matches!(error, Err(RecordError::Capture { .. })));
    }

    #[test]
    fn frames_of_any_bytes() {
        let whole = frame(5000, 9000, b"hello");
        for link in [ETHERNET, NULL, LOOP, 101, LINUX_SLL, LINUX_SLL2, 77] {
            for n in 0..whole.len() {
                let _ = udp_of(link, &whole[..n]);
                let _ = udp_of(link, &whole[n..]);
            }
        }
        assert!(udp_of(ETHERNET, &whole).is_some());
        assert_eq!(udp_of(101, &whole[14..]), udp_of(ETHERNET, &whole));
    }
}
