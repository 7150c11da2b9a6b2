//! What the commands say, on a recording that is always the same.

use std::fs::File;
use std::path::Path;
use std::process::Command;

use ac_client::net::transport::{
    AuthType, ConnectRequest, FragmentHeader, Isaac, LoginRequest, OptionalHeaders, PacketBuilder,
    PacketFlags, PacketHeader, Queue, SequenceList,
};
use ac_recorder::counters::Counts;
use ac_recorder::format::{RecordingWriter, Stream};

use crate::common::character_list;

const SEED: u32 = 0x1234_5678;

struct Session {
    builder: PacketBuilder,
    keys: Isaac,
}

impl Session {
    fn clear(&mut self, flags: PacketFlags, optional: &OptionalHeaders<'_>) -> Vec<u8> {
        let header = PacketHeader {
            flags,
            ..PacketHeader::default()
        };
        self.builder.start(optional).finish(header, None).to_vec()
    }

    fn login(&mut self) -> Vec<u8> {
        let payload = LoginRequest {
            version: "1802".into(),
            auth: AuthType::Password,
            auth_flags: 1,
            timestamp: 0,
            account: "FirstAccount".into(),
            account_override: String::new(),
            secret: Some("hush-hush".into()),
        }
        .to_bytes()
        .expect("a valid login");
        let optional = OptionalHeaders {
            login: Some(&payload),
            ..OptionalHeaders::default()
        };
        self.clear(PacketFlags::LOGIN_REQUEST, &optional)
    }

    fn connect_request(&mut self) -> Vec<u8> {
        let connect_request = Some(ConnectRequest {
            server_time: 1.0,
            cookie: 5,
            net_id: 7,
            seed_from_server: SEED,
            seed_from_client: 2,
            unused: 0,
        });
        self.clear(
            PacketFlags::CONNECT_REQUEST,
            &OptionalHeaders {
                connect_request,
                ..OptionalHeaders::default()
            },
        )
    }

    /// A packet of the server with one fragment.
    fn fragment(&mut self, sequence: u32, count: u16, index: u16, data: &[u8]) -> Vec<u8> {
        let fragment = FragmentHeader {
            sequence: 1,
            id: 0x8000_0000,
            count,
            size: 0,
            index,
            queue: Queue::UI,
        };
        let header = PacketHeader {
            sequence,
            flags: PacketFlags::BLOB_FRAGMENTS | PacketFlags::ENCRYPTED_CHECKSUM,
            ..PacketHeader::default()
        };
        let key = self.keys.next_word();
        self.builder
            .start(&OptionalHeaders::default())
            .fragment(fragment, data)
            .finish(header, Some(key))
            .to_vec()
    }
}

const fn stream(to_server: bool, next_port: bool) -> Stream {
    Stream {
        client: 0,
        to_server,
        next_port,
    }
}

/// A session with a message of two fragments, a copy, a gap, and three damaged datagrams.
fn write(path: &Path) {
    let mut writer = RecordingWriter::new(File::create_new(path).expect("a folder")).expect("room");
    let mut s = Session {
        builder: PacketBuilder::new(),
        keys: Isaac::new(SEED),
    };
    let mut list = character_list("FirstAccount");
    list.extend([0; 440]);
    let (first, second) = list.split_at(448);
    let (first, second) = (s.fragment(2, 2, 0, first), s.fragment(3, 2, 1, second));
    let ready = s.fragment(6, 1, 0, &0xF7DFu32.to_le_bytes());
    let mut wrong_key = s.fragment(7, 1, 0, &0xF7DFu32.to_le_bytes());
    wrong_key[9] ^= 1;
    let wanted = [4u8, 0, 0, 0, 5, 0, 0, 0];
    let nak = s.clear(
        PacketFlags::REQUEST_RETRANSMIT,
        &OptionalHeaders {
            request_retransmit: SequenceList::new(&wanted),
            ..OptionalHeaders::default()
        },
    );
    let mut wrong = s.connect_request();
    wrong[8] ^= 1;
    let datagrams = [
        (true, false, s.login()),
        (false, false, s.connect_request()),
        (false, true, first),
        (false, true, second.clone()),
        (false, true, second),
        (false, true, ready),
        (true, false, nak),
        (false, true, wrong_key),
        (false, false, wrong),
        (false, true, b"no packet".to_vec()),
    ];
    for (i, (to_server, next_port, bytes)) in datagrams.iter().enumerate() {
        // One is missing: it was not written in time.
        if i == 6 {
            writer.continuation().set_number(7);
        }
        let time = 1_700_000_000_000_000_000 + 250_000_000 * i as u64;
        writer
            .write_forwarded(stream(*to_server, *next_port), time, Some(time), bytes)
            .expect("room");
    }
    let counts = Counts {
        unwritten_slow: 1,
        ..Counts::default()
    };
    writer.write_counts(0, &counts).expect("room");
    writer.finish().expect("room");
}

/// Standard output and the exit code, or what went wrong.
fn said(arguments: &[&str], folder: &Path) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_ac-record"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .expect("built");
    let code = output.status.code().expect("an exit code");
    let text = String::from_utf8(output.stdout).expect("text");
    let error = String::from_utf8(output.stderr).expect("text");
    format!("{text}{error}exit code {code}\n")
}

#[test]
fn commands_on_a_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder.path().join("session.mcap"));
    for command in ["info", "ls", "verify"] {
        insta::assert_snapshot!(command, said(&[command, "session.mcap"], folder.path()));
    }
    let export = said(
        &[
            "export",
            "session.mcap",
            "-o",
            "out.jsonl",
            "--foxglove",
            "pictures.mcap",
        ],
        folder.path(),
    );
    insta::assert_snapshot!("export", export);
    let lines = std::fs::read_to_string(folder.path().join("out.jsonl")).expect("written");
    insta::assert_snapshot!("export_lines", lines);
    let redact = said(
        &["redact", "session.mcap", "-o", "redacted.mcap"],
        folder.path(),
    );
    insta::assert_snapshot!("redact", redact);
}

#[test]
fn commands_on_damaged_and_other_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = folder.path().join("session.mcap");
    write(&whole);
    let bytes = std::fs::read(&whole).expect("written");
    std::fs::write(folder.path().join("cut.mcap"), &bytes[..bytes.len() / 2]).expect("a folder");
    std::fs::write(folder.path().join("empty.mcap"), b"").expect("a folder");
    std::fs::write(folder.path().join("text.mcap"), b"hello, this is a text").expect("a folder");
    let mut all = String::new();
    for arguments in [
        &["info", "cut.mcap"][..],
        &["verify", "empty.mcap"],
        &["recover", "empty.mcap", "-o", "nothing.mcap"],
        &["verify", "nothing.mcap"],
        &["info", "text.mcap"],
        &["import", "text.mcap", "-o", "imported.mcap"],
        &["ls", "missing.mcap"],
        &["export", "session.mcap"],
    ] {
        all += &format!("$ ac-record {}\n", arguments.join(" "));
        all += &said(arguments, folder.path());
    }
    insta::assert_snapshot!(all);
}

#[test]
fn help_texts() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut all = String::new();
    for arguments in [&["--help"][..], &["proxy", "--help"], &["redact", "--help"]] {
        all += &said(arguments, folder.path());
    }
    insta::assert_snapshot!(all);
}
