//! Bodies of the fuzz targets (`fuzz/`); a test here runs them on damaged valid input.

use std::io::Cursor;
use std::path::Path;

use crate::format::{RecordingReader, RecordingWriter};
use crate::pcap::{Content, FragmentLimits, Fragments, content_of, import};
use crate::secrets::{Guard, SecretPolicy, SharedSecrets, locked};

/// Any bytes as a capture file.
pub fn capture(data: &[u8]) {
    let Ok(mut writer) = RecordingWriter::new(Cursor::new(Vec::new())) else {
        return;
    };
    if let Ok(report) = import(Path::new("capture"), data, 9000, &mut writer) {
        assert!(report.taken <= data.len());
    }
}

/// Any bytes as captured frames: link layer (one byte), length (one byte, times 8), frame.
pub fn frames(mut data: &[u8]) {
    const LINKS: [i32; 8] = [1, 0, 108, 12, 101, 113, 276, 77];
    let limits = FragmentLimits {
        datagrams: 8,
        bytes: 4096,
        age: 16,
    };
    let mut fragments = Fragments::new(limits);
    let mut time = 0;
    while let [link, length, rest @ ..] = data {
        let (frame, rest) = rest.split_at(rest.len().min(usize::from(*length) * 8));
        time += u64::from(link >> 4);
        match content_of(LINKS[usize::from(link & 7)], frame) {
            Content::Udp(datagram) => assert!(datagram.bytes.len() < frame.len()),
            Content::Fragment {
                key,
                offset,
                more,
                bytes,
            } => {
                let whole = fragments.push(key, offset, more, bytes, time);
                assert!(whole.is_none_or(|w| w.len() <= 65_535));
                assert!(fragments.bytes() <= limits.bytes);
            }
            Content::Other | Content::Unreadable => {}
        }
        data = rest;
    }
}

/// Any bytes as a recording.
pub fn recording(data: &[u8]) {
    if let Ok(mut reader) = RecordingReader::new(Path::new("recording"), data) {
        let mut analysis = crate::stats::Analysis::default();
        let mut messages = Vec::new();
        while let Some(packet) = reader.next_packet() {
            messages.clear();
            analysis.take(&packet, &mut messages);
        }
        assert!(reader.position() <= data.len() as u64);
    }
}

/// Any bytes as datagrams of a client whose secrets are known: direction (one bit) and length (one byte, times 2), datagram. No secret
/// is let through.
pub fn guard(mut data: &[u8]) {
    const SECRET: &str = "secret";
    let secrets = SharedSecrets::default();
    locked(&secrets).add(SECRET);
    let searcher = locked(&secrets).searcher();
    let mut guard = Guard::new(SecretPolicy::default(), secrets);
    let mut out = Vec::new();
    while let [head, length, rest @ ..] = data {
        let (datagram, rest) = rest.split_at(rest.len().min(usize::from(*length) * 2));
        guard.clean(head & 1 == 1, datagram, &mut out);
        assert_eq!(out.len(), datagram.len());
        let payload = out.get(20..).unwrap_or_default();
        assert_eq!(searcher.count(payload), 0);
        data = rest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Stream;

    /// Damages bytes in many ways (xorshift).
    fn damaged(valid: &[u8], rounds: u64, body: fn(&[u8])) {
        let mut state = 0x9E37_79B9_7F4A_7C15u64;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        body(valid);
        for _ in 0..rounds {
            let mut bytes = valid.to_vec();
            for _ in 0..next() % 8 {
                let n = bytes.len().max(1) as u64;
                match next() % 4 {
                    0 => bytes.truncate((next() % n) as usize),
                    1 => bytes.insert((next() % n) as usize % (bytes.len() + 1), next() as u8),
                    _ => {
                        let at = (next() % n) as usize;
                        if let Some(byte) = bytes.get_mut(at) {
                            *byte = next() as u8;
                        }
                    }
                }
            }
            body(&bytes);
        }
    }

    /// An IPv4 packet with a fragment of a UDP datagram.
    fn fragment(offset: u16, more: bool) -> Vec<u8> {
        let field = (offset / 8) | if more { 0x2000 } else { 0 };
        let mut p = vec![0x45, 0, 0, 36, 0, 7];
        p.extend(field.to_be_bytes());
        p.extend([64, 17, 0, 0, 10, 0, 0, 1, 10, 0, 0, 2]);
        p.extend([0x13, 0x88, 0x23, 0x28, 0, 32, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8]);
        p
    }

    #[test]
    fn damaged_input_does_no_harm() {
        let mut input = Vec::new();
        for (offset, more) in [(0, true), (16, false), (16, true)] {
            let packet = fragment(offset, more);
            input.extend([3, packet.len().div_ceil(8) as u8]);
            input.extend(packet);
            input.resize(input.len() + 4, 0);
        }
        damaged(&input, 3000, frames);

        let mut pcap = 0xA1B2_C3D4u32.to_le_bytes().to_vec();
        pcap.extend([
            2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 0, 0, 101, 0, 0, 0,
        ]);
        for packet in [fragment(0, true), fragment(16, false)] {
            let n = packet.len() as u32;
            for word in [1, 2, n, n] {
                pcap.extend(word.to_le_bytes());
            }
            pcap.extend(packet);
        }
        damaged(&pcap, 1000, capture);

        let stream = Stream {
            client: 0,
            to_server: true,
            next_port: false,
        };
        let mut writer = RecordingWriter::new(Cursor::new(Vec::new())).expect("memory");
        writer.write(stream, 1, &[0; 30]).expect("memory");
        let file = writer.finish().expect("memory").into_inner();
        damaged(&file, 1000, recording);

        let mut datagrams = vec![0, 20];
        datagrams.extend([
            4u8, 0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 20, 0, 0, 0,
        ]);
        datagrams.extend(b"the secret and SECRET");
        damaged(&datagrams, 3000, guard);
    }
}
