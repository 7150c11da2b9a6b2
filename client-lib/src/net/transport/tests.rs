//! Worked packets of `spec/09` and the invariants of its section 16.

use proptest::prelude::*;

use super::*;

fn bytes(text: &str) -> Vec<u8> {
    text.split_whitespace()
        .map(|b| u8::from_str_radix(b, 16).expect("hexadecimal"))
        .collect()
}

/// Reads a worked packet, builds it again from what was read, and checks its parts.
fn worked(text: &str, h: u32, d: u32, key: Option<u32>) {
    let datagram = bytes(text);
    let packet = Packet::parse(&datagram).expect("a valid packet");
    assert_eq!(packet.header.hash(), h, "header hash");
    assert_eq!(packet.data_hash(), d, "data hash");
    assert_eq!(
        packet.verify(),
        key.map_or(Verified::Clear, Verified::Encrypted)
    );
    assert_eq!(rebuild(&packet, key), datagram);
}

fn rebuild(packet: &Packet<'_>, key: Option<u32>) -> Vec<u8> {
    let mut builder = PacketBuilder::new();
    builder.start(&packet.optional);
    for fragment in packet.fragments() {
        builder.fragment(fragment.header, fragment.data);
    }
    builder.finish(packet.header, key).to_vec()
}

#[test]
fn worked_packets() {
    worked(
        "00 00 00 00 00 40 00 00 EB B0 FA BA 07 00 05 00 04 00 00 00 03 00 00 00",
        0xBAF6B0E8,
        0x00040003,
        None,
    );
    worked(
        "00 00 00 00 00 10 00 00 0A 81 06 BB 07 00 05 00 10 00 00 00
         03 00 00 00 05 00 00 00 06 00 00 00 08 00 00 00",
        0xBAF680F4,
        0x00100016,
        None,
    );
    worked(
        "02 00 00 00 06 00 00 00 39 FB 5E 68 07 00 08 00 14 00 00 00
         01 00 00 00 00 00 00 00 01 00 14 00 00 00 04 00  C8 F7 00 00",
        0xBAF97100,
        0x002CF7CA,
        Some(0xAD497DF3),
    );
    worked(
        "03 00 00 00 06 40 00 0A CD 54 64 D2 07 00 09 00 2A 00 00 00
         05 00 00 00  00 00 48 41  00 10 00 00 3C 00
         02 00 00 00 00 00 00 00 01 00 1C 00 00 00 04 00  B1 F7 00 00 00 00 00 00 E9 01 00 00",
        0xC4FAB117,
        0x7D9309A2,
        Some(0x70FAAA14),
    );
    worked(
        "02 00 00 00 02 00 00 01 57 EA 68 0F 0B 00 88 D6 08 00 01 00  00 00 00 40 88 D6 32 41",
        0x927A70F4,
        0x813AD688,
        Some(0xFDD4AFEB),
    );
    worked(
        "00 00 00 00 00 00 04 00 B9 29 BB 89 0B 00 87 D6 20 00 01 00
         00 00 00 80 87 D6 32 41  EF CD AB 89 67 45 23 01  07 00 00 00  78 56 34 12  55 78 E7 99  00 00 00 00",
        0x917D7108,
        0xF83DB8B1,
        None,
    );
    worked(
        "01 00 00 00 00 00 08 00 43 84 D0 45 07 00 00 00 08 00 00 00  EF CD AB 89 67 45 23 01",
        0xBAF970ED,
        0x8AD71356,
        None,
    );
}

#[test]
fn worked_logins() {
    let ace = "00 00 00 00 00 00 01 00 60 00 65 8E 00 00 00 00 30 00 00 00
        04 00 31 38 30 32 00 00  24 00 00 00  02 00 00 00 01 00 00 00 00 10 5E 5F
        06 00 74 65 73 74 65 72  00 00 00 00  07 00 00 00 06 73 65 63 72 65 74 00";
    let gdle = "00 00 00 00 00 00 01 00 92 00 65 8E 00 00 00 00 30 00 00 00
        04 00 31 38 30 32 00 00  24 00 00 00  01 00 00 00 00 00 00 00 00 10 5E 5F
        0D 00 74 65 73 74 65 72 3A 73 65 63 72 65 74 00  00 00 00 00 00 00 00 00";
    worked(ace, 0xBAF2710D, 0xD3728F53, None);
    worked(gdle, 0xBAF2710D, 0xD3728F85, None);
    for (text, account, secret) in [
        (ace, "tester", Some("secret")),
        (gdle, "tester:secret", None),
    ] {
        let datagram = bytes(text);
        let packet = Packet::parse(&datagram).expect("a valid packet");
        let payload = packet.optional.login.expect("a login");
        let login = LoginRequest::parse(payload).expect("a valid login");
        assert_eq!(
            (login.account.as_str(), login.secret.as_deref()),
            (account, secret)
        );
        assert_eq!(login.to_bytes().expect("writable"), payload);
    }
}

#[test]
fn worked_fragmented_message() {
    let mut message = bytes("E0 F7 00 00 E6 01");
    message.extend([0x41; 486]);
    message.extend(5u32.to_le_bytes());
    assert_eq!(message.len(), 496);
    let mut server = Connection::new(
        Role::Server,
        0x0B,
        0x12345678,
        0x99E77855,
        0.0,
        ConnectionLimits::default(),
    );
    // The first key word and number went to a time sync; message numbers go up to 8 before this one.
    server.send_headers(
        &OptionalHeaders {
            time_sync: Some(1234568.25),
            ..OptionalHeaders::default()
        },
        0.0,
    );
    let mut client = Connection::new(
        Role::Client,
        7,
        0x12345678,
        0x99E77855,
        0.0,
        ConnectionLimits::default(),
    );
    server.send(Queue::UI, &message, 0.0);
    let mut got = Vec::new();
    let sent: Vec<Vec<u8>> = std::iter::from_fn(|| server.poll_transmit()).collect();
    sent.iter().for_each(|d| client.receive(d, 0.1, &mut got));
    assert_eq!(
        sent.iter().map(Vec::len).collect::<Vec<_>>(),
        [28, 20 + 464, 20 + 64]
    );
    assert_eq!(got[0], Incoming::TimeSync(1234568.25));
    let Incoming::Message(received) = &got[1] else {
        panic!("{got:?}")
    };
    assert_eq!(
        (received.bytes.as_slice(), received.queue),
        (message.as_slice(), Queue::UI)
    );
    let second = Packet::parse(&sent[1]).expect("a packet");
    assert_eq!(second.verify(), Verified::Encrypted(0x398311D2));
    assert_eq!(
        hash32(second.fragments().next().expect("a fragment").data),
        0x4D0C03B4
    );
}

fn header_set() -> impl Strategy<Value = OptionalHeaders<'static>> {
    static LIST: [u8; 12] = [5, 0, 0, 0, 6, 0, 0, 0, 200, 1, 0, 0];
    let some = proptest::bool::ANY;
    (
        any::<[bool; 12]>(),
        any::<u32>(),
        any::<u64>(),
        any::<f64>(),
        any::<f32>(),
        some,
    )
        .prop_map(|(on, word, long, time, echo, short)| {
            let list =
                SequenceList::new(if short { &LIST[..4] } else { &LIST }).expect("whole words");
            OptionalHeaders {
                server_switch: on[0].then_some(ServerSwitch {
                    sequence: word,
                    kind: 1,
                }),
                request_retransmit: on[1].then_some(list),
                reject_retransmit: on[2].then_some(list),
                ack: on[3].then_some(word),
                world_login: on[4].then_some(long),
                connect_response: on[5].then_some(long),
                net_error: on[6].then_some(NetError {
                    string: word,
                    table: 2,
                }),
                command: on[7].then_some((word, 3)),
                time_sync: on[8].then_some(time),
                echo_request: on[9].then_some(echo),
                echo_response: on[10].then_some(EchoResponse {
                    time: echo,
                    holding: 0.5,
                }),
                flow: on[11].then_some(Flow {
                    bytes: word,
                    interval: 60,
                }),
                ..OptionalHeaders::default()
            }
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn packets_round_trip(optional in header_set(), data in prop::collection::vec(any::<u8>(), 0..448), key: Option<u32>, sequence: u32) {
        let mut flags = optional.flags();
        flags.set(PacketFlags::ENCRYPTED_CHECKSUM, key.is_some());
        let mut builder = PacketBuilder::new();
        builder.start(&optional);
        if !data.is_empty() {
            flags |= PacketFlags::BLOB_FRAGMENTS;
            let header = FragmentHeader { sequence: 4, id: 0, count: 1, size: 0, index: 0, queue: Queue::WEENIE };
            builder.fragment(header, &data);
        }
        let header = PacketHeader { sequence, flags, ..PacketHeader::default() };
        let built = builder.finish(header, key).to_vec();
        let packet = Packet::parse(&built).expect("what was built is valid");
        prop_assert_eq!(packet.verify(), key.map_or(Verified::Clear, Verified::Encrypted));
        prop_assert_eq!(rebuild(&packet, key), built);
    }

    #[test]
    fn a_flipped_bit_breaks_a_clear_checksum(data in prop::collection::vec(any::<u8>(), 1..60), bit: prop::sample::Index) {
        let header = FragmentHeader { sequence: 4, id: 0, count: 1, size: 0, index: 0, queue: Queue::WEENIE };
        let packet_header = PacketHeader { sequence: 2, flags: PacketFlags::BLOB_FRAGMENTS, ..PacketHeader::default() };
        let mut built =
            PacketBuilder::new().start(&OptionalHeaders::default()).fragment(header, &data).finish(packet_header, None).to_vec();
        let first = HEADER_LENGTH + FRAGMENT_HEADER;
        let at = bit.index((built.len() - first) * 8);
        built[first + at / 8] ^= 1 << (at % 8);
        prop_assert_eq!(Packet::parse(&built).expect("still a packet").verify(), Verified::Wrong);
    }

    #[test]
    fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = Packet::parse(&bytes);
        let _ = LoginRequest::parse(&bytes);
        Redactor::new().redact(&mut bytes.clone());
    }

    #[test]
    fn messages_arrive_in_order_over_a_bad_line(
        lengths in prop::collection::vec(4usize..2000, 1..40),
        fates in prop::collection::vec(0u8..10, 400),
    ) {
        let (mut a, mut b) = pair();
        let messages: Vec<Vec<u8>> = lengths.iter().enumerate().map(|(i, &n)| vec![i as u8; n]).collect();
        let mut fate = fates.into_iter();
        let (mut got, mut notes) = (Vec::new(), Vec::new());
        let mut now = 0.0;
        for m in &messages {
            a.send(Queue::WEENIE, m, now);
        }
        // A last small packet shows the receiver that something is missing before it; repeated until all has come.
        for round in 0..400 {
            now += 1.1;
            let mut late = Vec::new();
            while let Some(d) = a.poll_transmit() {
                match if round < 6 { fate.next().unwrap_or(9) } else { 9 } {
                    0 | 1 => {}
                    2 => { b.receive(&d, now, &mut got); b.receive(&d, now, &mut got); }
                    3 => late.push(d),
                    _ => b.receive(&d, now, &mut got),
                }
            }
            late.into_iter().rev().for_each(|d| b.receive(&d, now, &mut got));
            b.handle_timeout(now);
            while let Some(d) = b.poll_transmit() {
                a.receive(&d, now, &mut notes);
            }
            let arrived = got.iter().filter(|i| matches!(i, Incoming::Message(_))).count();
            if arrived == messages.len() {
                break;
            }
            a.send_headers(&OptionalHeaders { time_sync: Some(now), ..OptionalHeaders::default() }, now);
        }
        let arrived: Vec<Vec<u8>> = got.into_iter().filter_map(|i| match i {
            Incoming::Message(m) => Some(m.bytes),
            _ => None,
        }).collect();
        prop_assert_eq!(arrived, messages);
    }

    #[test]
    fn fragments_in_any_order_give_the_message(length in 449usize..6000, seed in any::<u64>()) {
        let message: Vec<u8> = (0..length).map(|i| (i as u64).wrapping_mul(seed | 1) as u8).collect();
        let count = fragment_count(length);
        let mut order: Vec<usize> = (0..count).chain(0..count).collect();
        order.sort_by_key(|&i| (i as u64 + 1).wrapping_mul(seed | 1).rotate_left(17));
        let mut reassembler = Reassembler::default();
        let mut done = Vec::new();
        for index in order {
            let data = &message[index * FRAGMENT_DATA..length.min((index + 1) * FRAGMENT_DATA)];
            let header = FragmentHeader { sequence: 1, id: 0, count: count as u16, size: 0, index: index as u16, queue: Queue::UI };
            if let Ok(Some(m)) = reassembler.push(&Fragment { header, data }, 0.0) {
                done.push(m.bytes);
            }
        }
        prop_assert!(done.first() == Some(&message));
    }
}

fn pair() -> (Connection, Connection) {
    let limits = ConnectionLimits::default();
    (
        Connection::new(Role::Server, 11, 1, 2, 0.0, limits),
        Connection::new(Role::Client, 7, 1, 2, 0.0, limits),
    )
}

#[test]
fn refused_packets_are_given_up() {
    let limits = ConnectionLimits {
        store_age: 0.5,
        ..ConnectionLimits::default()
    };
    let mut a = Connection::new(Role::Server, 11, 1, 2, 0.0, limits);
    let (_, mut b) = pair();
    for i in 0..4u8 {
        a.send(Queue::UI, &[i; 8], 0.0);
    }
    let sent: Vec<_> = std::iter::from_fn(|| a.poll_transmit()).collect();
    let (mut got, mut notes) = (Vec::new(), Vec::new());
    b.receive(&sent[3], 1.0, &mut got);
    a.handle_timeout(1.0);
    while let Some(d) = b.poll_transmit() {
        a.receive(&d, 1.0, &mut notes);
    }
    assert_eq!(
        notes.len(),
        3,
        "three packets were asked for and are not kept: {notes:?}"
    );
    while let Some(d) = a.poll_transmit() {
        b.receive(&d, 1.0, &mut got);
    }
    assert_eq!(
        got.iter()
            .filter(|i| matches!(i, Incoming::Anomaly(Anomaly::Lost(_))))
            .count(),
        3
    );
    assert!(matches!(got.last(), Some(Incoming::Message(m)) if m.bytes == [3; 8]));
}

#[test]
fn naks_name_only_what_is_missing() {
    let (mut a, mut b) = pair();
    for i in 0..6u8 {
        a.send(Queue::UI, &[i; 8], 0.0);
    }
    let sent: Vec<_> = std::iter::from_fn(|| a.poll_transmit()).collect();
    let mut got = Vec::new();
    b.receive(&sent[2], 5.0, &mut got);
    assert!(b.poll_transmit().is_some(), "two packets are missing");
    b.receive(&sent[5], 5.5, &mut got);
    assert!(b.poll_transmit().is_none(), "a NAK within a second");
    b.handle_timeout(6.2);
    let nak = b.poll_transmit().expect("a NAK");
    let packet = Packet::parse(&nak).expect("a packet");
    assert_eq!(packet.header.flags, PacketFlags::REQUEST_RETRANSMIT);
    let wanted: Vec<u32> = packet
        .optional
        .request_retransmit
        .expect("a list")
        .iter()
        .collect();
    assert_eq!(wanted, [2, 3]);
}

/// A deterministic smoke of the fuzz target `transport`: worked packets, damaged by a small generator.
#[test]
fn damaged_datagrams() {
    let seeds = [
        "00 00 00 00 00 40 00 00 EB B0 FA BA 07 00 05 00 04 00 00 00 03 00 00 00",
        "00 00 00 00 00 10 00 00 0A 81 06 BB 07 00 05 00 10 00 00 00
         03 00 00 00 05 00 00 00 06 00 00 00 08 00 00 00",
        "02 00 00 00 06 00 00 00 39 FB 5E 68 07 00 08 00 14 00 00 00
         01 00 00 00 00 00 00 00 01 00 14 00 00 00 04 00  C8 F7 00 00",
        "00 00 00 00 00 00 01 00 60 00 65 8E 00 00 00 00 30 00 00 00
        04 00 31 38 30 32 00 00  24 00 00 00  02 00 00 00 01 00 00 00 00 10 5E 5F
        06 00 74 65 73 74 65 72  00 00 00 00  07 00 00 00 06 73 65 63 72 65 74 00",
    ]
    .map(bytes);
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as usize % below
    };
    for _ in 0..300 {
        let mut data = Vec::new();
        for _ in 0..=next(6) {
            let mut datagram = seeds[next(seeds.len())].clone();
            for _ in 0..next(4) {
                let at = next(datagram.len());
                datagram[at] ^= 1 << next(8);
            }
            if next(4) == 0 {
                datagram.truncate(next(datagram.len()));
            }
            data.push(datagram.len() as u8);
            data.extend(datagram);
        }
        fuzzing::transport(&data);
    }
}
