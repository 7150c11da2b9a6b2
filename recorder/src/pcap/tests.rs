use std::io::Cursor;

use super::*;
use crate::format::{Recording, read_bytes};

const UDP: u8 = 17;

fn udp_bytes(from: u16, to: u16, payload: &[u8]) -> Vec<u8> {
    let mut u = Vec::new();
    u.extend(from.to_be_bytes());
    u.extend(to.to_be_bytes());
    u.extend(((8 + payload.len()) as u16).to_be_bytes());
    u.extend([0, 0]);
    u.extend(payload);
    u
}

/// An IPv4 packet with a part of an IP payload.
fn ipv4(server_is_receiver: bool, id: u16, offset: usize, more: bool, payload: &[u8]) -> Vec<u8> {
    // The server is 10.0.0.2.
    let (a, b) = if server_is_receiver { (1, 2) } else { (2, 1) };
    let mut p = vec![0x45, 0];
    p.extend(((20 + payload.len()) as u16).to_be_bytes());
    p.extend(id.to_be_bytes());
    p.extend(((offset / 8) as u16 | if more { 0x2000 } else { 0 }).to_be_bytes());
    p.extend([64, UDP, 0, 0, 10, 0, 0, a, 10, 0, 0, b]);
    p.extend(payload);
    p
}

/// An IPv6 packet; with a fragment header where `fragment` says so.
fn ipv6(fragment: Option<(u32, usize, bool)>, payload: &[u8]) -> Vec<u8> {
    let mut extension = Vec::new();
    if let Some((id, offset, more)) = fragment {
        extension.extend([UDP, 0]);
        extension.extend((offset as u16 | u16::from(more)).to_be_bytes());
        extension.extend(id.to_be_bytes());
    }
    let mut p = vec![0x60, 0, 0, 0];
    p.extend(((extension.len() + payload.len()) as u16).to_be_bytes());
    p.extend([if fragment.is_some() { 44 } else { UDP }, 64]);
    for host in [1u8, 2] {
        p.extend([0xFD, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, host]);
    }
    p.extend(extension);
    p.extend(payload);
    p
}

fn ethernet(tags: &[u16], ether_type: u16, ip: &[u8]) -> Vec<u8> {
    let mut f = vec![0; 12];
    for tag in tags {
        f.extend(tag.to_be_bytes());
        f.extend([0, 5]);
    }
    f.extend(ether_type.to_be_bytes());
    f.extend(ip);
    // Ethernet pads short frames.
    f.resize(f.len().max(60), 0);
    f
}

/// An Ethernet frame with a UDP datagram.
fn frame(from: u16, to: u16, payload: &[u8]) -> Vec<u8> {
    let ip = ipv4(to >= 9000, 0, 0, false, &udp_bytes(from, to, payload));
    ethernet(&[], 0x0800, &ip)
}

fn capture_of(link: u32, frames: &[Vec<u8>]) -> Vec<u8> {
    let mut c = Vec::new();
    c.extend(0xA1B2_C3D4u32.to_le_bytes());
    c.extend([2, 0, 4, 0]);
    c.extend([0; 8]);
    c.extend(65_535u32.to_le_bytes());
    c.extend(link.to_le_bytes());
    for (i, f) in frames.iter().enumerate() {
        let n = f.len() as u32;
        for word in [100, i as u32, n, n] {
            c.extend(word.to_le_bytes());
        }
        c.extend(f);
    }
    c
}

fn capture(frames: &[Vec<u8>]) -> Vec<u8> {
    capture_of(1, frames)
}

/// A block of a pcapng file.
fn block(kind: u32, body: &[u8]) -> Vec<u8> {
    let mut body = body.to_vec();
    body.resize(body.len().next_multiple_of(4), 0);
    let length = (12 + body.len()) as u32;
    let mut b = Vec::new();
    b.extend(kind.to_le_bytes());
    b.extend(length.to_le_bytes());
    b.extend(body);
    b.extend(length.to_le_bytes());
    b
}

fn section() -> Vec<u8> {
    let mut body = Vec::new();
    body.extend(0x1A2B_3C4Du32.to_le_bytes());
    body.extend([1, 0, 0, 0]);
    body.extend([0xFF; 8]);
    block(0x0A0D_0D0A, &body)
}

/// An interface whose times are in units of 10^-`digits` s.
fn interface(link: u16, digits: u8) -> Vec<u8> {
    let mut body = Vec::new();
    body.extend(link.to_le_bytes());
    body.extend([0; 2]);
    body.extend(0u32.to_le_bytes());
    body.extend([9, 0, 1, 0, digits, 0, 0, 0, 0, 0, 0, 0]);
    block(1, &body)
}

fn enhanced(interface: u32, ticks: u64, frame: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    let n = frame.len() as u32;
    for word in [interface, (ticks >> 32) as u32, ticks as u32, n, n] {
        body.extend(word.to_le_bytes());
    }
    body.extend(frame);
    block(6, &body)
}

fn simple(frame: &[u8]) -> Vec<u8> {
    let mut body = (frame.len() as u32).to_le_bytes().to_vec();
    body.extend(frame);
    block(3, &body)
}

fn imported(capture: &[u8]) -> (ImportReport, Recording) {
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
    assert_eq!(report.damage, None);
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
fn link_layers() {
    let ip = ipv4(false, 0, 0, false, &udp_bytes(9000, 5000, b"there"));
    let mut cooked = vec![0, 0, 0, 1, 0, 6, 0, 0, 0, 0, 0, 0, 0, 0, 0x08, 0x00];
    cooked.extend(&ip);
    let mut cooked2 = vec![0x08, 0x00];
    cooked2.resize(20, 0);
    cooked2.extend(&ip);
    let mut loopback = 2u32.to_le_bytes().to_vec();
    loopback.extend(&ip);
    let v6 = ipv6(None, &udp_bytes(9000, 5000, b"there"));
    let cases = [
        (1, ethernet(&[], 0x0800, &ip)),
        (1, ethernet(&[0x8100], 0x0800, &ip)),
        (1, ethernet(&[0x88A8, 0x8100], 0x0800, &ip)),
        (1, ethernet(&[0x9100, 0x8100], 0x0800, &ip)),
        (1, ethernet(&[0x8100, 0x8100], 0x86DD, &v6)),
        (0, loopback.clone()),
        (108, loopback),
        (101, ip.clone()),
        (12, ip.clone()),
        (228, ip.clone()),
        (229, v6.clone()),
        (101, v6),
        (113, cooked),
        (276, cooked2),
    ];
    for (link, frame) in cases {
        let (report, recording) = imported(&capture_of(link, &[frame]));
        assert_eq!(report.taken, 1, "link layer {link}: {report:?}");
        assert_eq!(recording.packets[0].bytes, b"there", "link layer {link}");
    }
    let (report, _) = imported(&capture_of(77, &[ip]));
    assert_eq!((report.taken, report.others), (0, 1));
}

#[test]
fn fragments_are_put_together() {
    let payload: Vec<u8> = (0..3000u32).map(|i| i as u8).collect();
    let datagram = udp_bytes(9000, 5000, &payload);
    let (a, b) = datagram.split_at(1480);
    let (b, c) = b.split_at(1000);
    let v4 = [
        ipv4(false, 7, 1480, true, b),
        ipv4(false, 7, 0, true, a),
        // Another datagram with the same ports is not mixed up with it.
        ipv4(false, 8, 0, true, a),
        ipv4(false, 7, 0, true, a),
        ipv4(false, 7, 2480, false, c),
    ];
    let v6 = [
        ipv6(Some((7, 2480, false)), c),
        ipv6(Some((7, 0, true)), a),
        ipv6(Some((7, 1480, true)), b),
    ];
    let frames: Vec<_> = v4.iter().map(|ip| ethernet(&[], 0x0800, ip)).collect();
    let (report, recording) = imported(&capture(&frames));
    assert_eq!(
        (report.taken, report.reassembled, report.incomplete),
        (1, 1, 1)
    );
    assert_eq!(recording.packets[0].bytes, payload);
    let frames: Vec<_> = v6
        .iter()
        .map(|ip| ethernet(&[0x8100], 0x86DD, ip))
        .collect();
    let (report, recording) = imported(&capture(&frames));
    assert_eq!(
        (report.taken, report.reassembled, report.incomplete),
        (1, 1, 0)
    );
    assert_eq!(recording.packets[0].bytes, payload);
}

#[test]
fn pcapng_with_several_sections_and_interfaces() {
    let f = |payload: &[u8]| frame(9000, 5000, payload);
    let ip = ipv4(false, 0, 0, false, &udp_bytes(9001, 5000, b"raw"));
    let mut file = section();
    file.extend(interface(1, 6));
    file.extend(interface(101, 9));
    file.extend(enhanced(0, 5_000_001, &f(b"micro")));
    file.extend(enhanced(1, 5_000_002_000, &ip));
    file.extend(block(5, &[0; 12]));
    file.extend(simple(&f(b"plain")));
    // An interface that was not described.
    file.extend(enhanced(9, 1, &f(b"nobody")));
    // A new section counts its interfaces anew.
    file.extend(section());
    file.extend(interface(101, 6));
    file.extend(enhanced(0, 6_000_000, &ip));
    let (report, recording) = imported(&file);
    assert_eq!((report.taken, report.damage), (4, None));
    let seen: Vec<_> = recording
        .packets
        .iter()
        .map(|p| (p.time, &p.bytes[..]))
        .collect();
    let expected: [(u64, &[u8]); 4] = [
        (5_000_001_000, b"micro"),
        (5_000_002_000, b"raw"),
        (5_000_002_000, b"plain"),
        (6_000_000_000, b"raw"),
    ];
    assert_eq!(seen, expected);
    for n in section().len()..file.len() {
        let (report, _) = imported(&file[..n]);
        assert!(report.taken < 4);
    }
}

#[test]
fn packets_captured_in_part_are_counted() {
    let f = frame(9000, 5000, &[9; 200]);
    let mut c = capture(&[]);
    for word in [100, 0, 100, f.len() as u32] {
        c.extend(word.to_le_bytes());
    }
    c.extend(&f[..100]);
    let (report, _) = imported(&c);
    assert_eq!((report.taken, report.cut), (0, 1));
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
    for link in [1, 0, 108, 101, 113, 276, 77] {
        for n in 0..whole.len() {
            let _ = content_of(link, &whole[..n]);
            let _ = content_of(link, &whole[n..]);
        }
    }
    assert!(matches!(content_of(1, &whole), Content::Udp(_)));
    assert_eq!(content_of(101, &whole[14..]), content_of(1, &whole));
}
