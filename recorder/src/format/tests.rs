use std::io::Cursor;
use std::path::Path;

use ac_client::net::transport::{
    AuthType, LoginRequest, OptionalHeaders, Packet, PacketBuilder, PacketFlags, PacketHeader,
    Verified,
};

use super::*;
use crate::error::RecordError;
use crate::secrets::{SecretPolicy, SharedSecrets};

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
        writer.abandon().0.into_inner()
    }
}

fn contains(bytes: &[u8], text: &[u8]) -> bool {
    bytes.windows(text.len()).any(|w| w == text)
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
    for secret in [&b"tester"[..], b"secret"] {
        assert!(!contains(&packet.bytes, secret));
    }
    let packet = Packet::parse(&packet.bytes).expect("still a packet");
    assert_eq!(packet.verify(), Verified::Clear);
}

#[test]
fn secrets_are_kept_only_when_asked_for_and_the_file_says_so() {
    let options = WriterOptions {
        secrets: SecretPolicy::Keep,
        compress: false,
    };
    let state = Continuation::new(SharedSecrets::default());
    let out = Cursor::new(Vec::new());
    let mut writer = RecordingWriter::part(out, options, PartInfo { number: 1 }, state)
        .map_err(|failed| failed.0)
        .expect("memory");
    writer.write(STREAM, 5, &login()).expect("memory");
    let bytes = writer.finish().expect("memory").into_inner();
    let mut reader = RecordingReader::new(Path::new("r"), &bytes[..]).expect("a recording");
    assert!(reader.info().secrets_kept);
    assert_eq!(reader.next_packet().map(|p| p.bytes), Some(login()));
    let bytes = file(1, true);
    let reader = RecordingReader::new(Path::new("r"), &bytes[..]).expect("a recording");
    assert!(!reader.info().secrets_kept);
}

#[test]
fn a_file_that_was_cut_off_is_read_up_to_there() {
    let whole = file(5, true);
    let unfinished = file(5, false);
    let recording = read_bytes(Path::new("r"), &unfinished).expect("a recording");
    assert_eq!(recording.packets.len(), 5);
    assert!(recording.damage.is_some());
    let mut seen = 5;
    for n in (0..whole.len()).rev() {
        match read_bytes(Path::new("r"), &whole[..n]) {
            Ok(recording) => {
                assert!(recording.packets.len() <= seen && recording.damage.is_some());
                seen = recording.packets.len();
            }
            Err(error) => assert!(matches!(error, RecordError::NotStarted { .. }), "{error}"),
        }
    }
    assert_eq!(seen, 0);
}

#[test]
fn a_damaged_chunk_ends_the_reading_before_it() {
    let whole = file(3, true);
    for at in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x55;
        if let Ok(recording) = read_bytes(Path::new("r"), &damaged) {
            assert!(recording.packets.len() <= 3);
        }
    }
}

#[test]
fn numbers_and_times_survive() {
    let mut writer = RecordingWriter::new(Cursor::new(Vec::new())).expect("memory");
    writer
        .write_forwarded(STREAM, 10, Some(12), b"a")
        .expect("memory");
    writer.continuation().set_number(7);
    writer
        .write_forwarded(STREAM, 5, None, b"b")
        .expect("memory");
    let bytes = writer.finish().expect("memory").into_inner();
    let packets = read_bytes(Path::new("r"), &bytes)
        .expect("a recording")
        .packets;
    let seen: Vec<_> = packets
        .iter()
        .map(|p| (p.number, p.time, p.forwarded))
        .collect();
    // Times do not go backwards.
    assert_eq!(seen, [(0, 10, Some(12)), (7, 10, None)]);
}

#[test]
fn other_files_are_refused() {
    for (bytes, started) in [(&b""[..], false), (&[7; 100], true)] {
        let error = read_bytes(Path::new("r"), bytes).expect_err("no recording");
        assert_eq!(
            matches!(error, RecordError::NotARecording { .. }),
            started,
            "{error}"
        );
    }
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
        for (to_server, next_port) in [(false, false), (false, true), (true, false), (true, true)] {
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
