//! Network transport (`spec/09-network.md`, 17): datagrams made by hand, and two sides that talk over a bad line.

use ac_client::net::transport::{
    AuthType, ConnectRequest, Connection, ConnectionLimits, FRAGMENT_DATA, Flow, Fragment,
    FragmentHeader, Incoming, Isaac, KEY_WINDOW, KeySearch, LoginRequest, MAX_DATAGRAM,
    OptionalHeaders, Packet, PacketBuilder, PacketFlags, PacketHeader, Queue, Reassembler,
    ReassemblyLimits, ReassemblyNote, Role, Verified, fragment_count,
};

use super::{super::trial::Trial, cases};

cases! { "09";
    1 "empty payload with flags 0" => empty_payload;
    2 "fragment sizes 16, 15, 0, 464, 465, beyond the packet" => fragment_sizes;
    3 "index and count that do not fit" => fragment_counts;
    4 "message lengths around a fragment" => message_lengths;
    5 "fragments out of order, twice, different" => fragment_order;
    6 "unaligned fragments, hash tails of 1 to 3 bytes" => unaligned;
    7 "retransmission requests of 0 and of endless length" => nak_lengths;
    8 "key words at the edge of the window" => key_window;
    9 "second connect request with other seeds" => second_connect;
    10 "ids, cookies and seeds of 0 and all ones" => extreme_ids;
    11 "acknowledgement of a packet that is still to come" => early_ack;
    12 "rejected retransmission while later packets wait" => rejected;
    13 "clock backwards, game time not a number" => clock_backwards;
    14 "datagram cut off in an optional header, trailing bytes" => cut_off;
    15 "logging off and on again" => again;
    16 "account names and passwords at their limits" => accounts;
}

fn header(flags: PacketFlags) -> PacketHeader {
    PacketHeader {
        flags,
        ..PacketHeader::default()
    }
}

fn packet(headers: &OptionalHeaders<'_>, fragments: &[(FragmentHeader, &[u8])]) -> Vec<u8> {
    let mut builder = PacketBuilder::new();
    builder.start(headers);
    for (header, data) in fragments {
        builder.fragment(*header, data);
    }
    let blobs = if fragments.is_empty() {
        PacketFlags::empty()
    } else {
        PacketFlags::BLOB_FRAGMENTS
    };
    builder
        .finish(header(headers.flags() | blobs), None)
        .to_vec()
}

fn fragment(index: u16, count: u16, length: usize) -> FragmentHeader {
    FragmentHeader {
        sequence: 7,
        id: 0x8000_0000,
        count,
        size: 16 + length as u16,
        index,
        queue: Queue::UI,
    }
}

/// Every prefix, and every byte changed: reading never does more than refuse.
fn damaged(t: &mut Trial, datagram: &[u8]) {
    for length in 0..datagram.len() {
        let _ = Packet::parse(&datagram[..length]);
    }
    let mut copy = datagram.to_vec();
    for at in 0..copy.len() {
        for bit in [1, 0x80] {
            copy[at] ^= bit;
            if let Ok(packet) = Packet::parse(&copy) {
                let _ = (packet.verify(), packet.fragments().count());
            }
            copy[at] ^= bit;
        }
    }
    t.promise(copy == datagram, || "the control is damaged".into());
}

fn empty_payload(t: &mut Trial) {
    let bytes = packet(&OptionalHeaders::default(), &[]);
    let read = Packet::parse(&bytes);
    t.promise(read.is_ok(), || format!("{read:?}"));
    if let Ok(read) = read {
        t.same("hash of nothing", read.data_hash(), 0);
        t.same("verdict", read.verify(), Verified::Clear);
    }
    damaged(t, &bytes);
}

fn fragment_sizes(t: &mut Trial) {
    let data = [0xAB_u8; 460];
    for (length, readable) in [(0_usize, true), (FRAGMENT_DATA, true)] {
        let bytes = packet(
            &OptionalHeaders::default(),
            &[(fragment(0, 1, length), &data[..length])],
        );
        t.same("readable", Packet::parse(&bytes).is_ok(), readable);
        damaged(t, &bytes);
    }
    // The size word says something else than there is.
    let mut bytes = packet(
        &OptionalHeaders::default(),
        &[(fragment(0, 1, 8), &data[..8])],
    );
    let at = bytes.len() - 8 - 16 + 10;
    for size in [15_u16, 0, 465, 0xFFFF, 25] {
        bytes[at..at + 2].copy_from_slice(&size.to_le_bytes());
        let read = Packet::parse(&bytes);
        t.promise(read.is_err(), || {
            format!("a fragment of size {size} is read")
        });
    }
}

fn push(
    reassembler: &mut Reassembler,
    index: u16,
    count: u16,
    data: &[u8],
) -> Result<bool, ReassemblyNote> {
    let header = fragment(index, count, data.len());
    reassembler
        .push(&Fragment { header, data }, 0.0)
        .map(|message| message.is_some())
}

fn fragment_counts(t: &mut Trial) {
    let full = [1_u8; FRAGMENT_DATA];
    let mut r = Reassembler::new(ReassemblyLimits::default());
    t.same(
        "index = count",
        push(&mut r, 2, 2, &full),
        Err(ReassemblyNote::Malformed),
    );
    t.same(
        "count 0",
        push(&mut r, 0, 0, &full),
        Err(ReassemblyNote::Malformed),
    );
    t.same(
        "count 65535",
        push(&mut r, 0, 65_535, &full),
        Err(ReassemblyNote::TooMany),
    );
    t.same("first of three", push(&mut r, 0, 3, &full), Ok(false));
    t.same(
        "the same key with another count",
        push(&mut r, 1, 4, &full),
        Err(ReassemblyNote::CountChanged),
    );
    t.promise(r.pending() <= 1, || {
        format!("{} messages wait", r.pending())
    });
}

fn pair() -> [Connection; 2] {
    [Role::Server, Role::Client]
        .map(|role| Connection::new(role, 11, 1, 2, 0.0, ConnectionLimits::default()))
}

/// Hands everything over until both are silent; answers what the second got.
fn exchange(sides: &mut [Connection; 2], now: f64) -> Vec<Vec<u8>> {
    let (mut got, mut other) = (Vec::new(), Vec::new());
    for _ in 0..200 {
        let mut silent = true;
        while let Some(datagram) = sides[0].poll_transmit() {
            silent = false;
            sides[1].receive(&datagram, now, &mut got);
        }
        while let Some(datagram) = sides[1].poll_transmit() {
            silent = false;
            sides[0].receive(&datagram, now, &mut other);
        }
        if silent {
            break;
        }
    }
    let message = |incoming: Incoming| match incoming {
        Incoming::Message(message) => Some(message.bytes),
        _ => None,
    };
    got.into_iter().filter_map(message).collect()
}

fn message_lengths(t: &mut Trial) {
    for length in [0_usize, 1, 4, 447, 448, 449, 896, 897, 4480, 30_000] {
        let mut sides = pair();
        let bytes: Vec<u8> = (0..length).map(|i| i as u8).collect();
        sides[0].send(Queue::UI, &bytes, 0.0);
        let got = exchange(&mut sides, 0.1);
        t.promise(got == [bytes.clone()], || {
            format!("length {length}: {} messages", got.len())
        });
        t.promise(fragment_count(length) >= length / FRAGMENT_DATA, || {
            format!("{} fragments", fragment_count(length))
        });
    }
}

fn fragment_order(t: &mut Trial) {
    let full = [1_u8; FRAGMENT_DATA];
    let other = [2_u8; FRAGMENT_DATA];
    let mut r = Reassembler::new(ReassemblyLimits::default());
    t.same("tail first", push(&mut r, 2, 3, &full[..9]), Ok(false));
    t.same("first", push(&mut r, 0, 3, &full), Ok(false));
    t.same(
        "first again, different",
        push(&mut r, 0, 3, &other),
        Err(ReassemblyNote::Repeated),
    );
    let header = fragment(1, 3, FRAGMENT_DATA);
    let whole = r.push(
        &Fragment {
            header,
            data: &full,
        },
        0.0,
    );
    let bytes = whole.ok().flatten().map(|message| message.bytes);
    t.same(
        "first copy wins",
        bytes.map(|b| (b.len(), b[0])),
        Some((2 * FRAGMENT_DATA + 9, 1)),
    );
    t.same("messages that wait", r.pending(), 0);
}

fn unaligned(t: &mut Trial) {
    let flow = OptionalHeaders {
        flow: Some(Flow {
            bytes: 0x80FF_FFFE,
            interval: 0xFFFF,
        }),
        ..OptionalHeaders::default()
    };
    for length in 1..=9_usize {
        let data: Vec<u8> = (0..length).map(|i| 0x80 + i as u8).collect();
        let bytes = packet(&flow, &[(fragment(0, 1, length), &data)]);
        let read = Packet::parse(&bytes);
        t.promise(
            read.as_ref().is_ok_and(|p| p.verify() == Verified::Clear),
            || format!("{length} bytes: {read:?}"),
        );
        damaged(t, &bytes);
    }
}

fn nak_lengths(t: &mut Trial) {
    for count in [0_u32, 1, 0xFFFF_FFFF, 0x4000_0000] {
        let mut bytes = header(PacketFlags::REQUEST_RETRANSMIT).to_bytes().to_vec();
        bytes[16..18].copy_from_slice(&8_u16.to_le_bytes());
        bytes.extend(count.to_le_bytes());
        bytes.extend([0; 4]);
        let read = Packet::parse(&bytes);
        t.promise(read.is_err() || count <= 1, || {
            format!("a request for {count} packets is read")
        });
        let mut sides = pair();
        let mut got = Vec::new();
        sides[0].receive(&bytes, 0.0, &mut got);
        t.promise(got.len() < 4, || {
            format!("{} things of one datagram", got.len())
        });
    }
}

fn key_window(t: &mut Trial) {
    let words = |n: usize| {
        let mut isaac = Isaac::new(5);
        (0..n).map(|_| isaac.next_word()).collect::<Vec<u32>>()
    };
    let all = words(KEY_WINDOW + 2);
    let mut search = KeySearch::new(5);
    t.same(
        "one word beyond the window",
        search.accept(all[KEY_WINDOW + 1]),
        false,
    );
    t.same("the last word in it", search.accept(all[KEY_WINDOW]), true);
    // All that were lost, in reverse order, and a forged one between.
    let mut accepted = 0;
    for word in all[..KEY_WINDOW].iter().rev() {
        accepted += usize::from(search.accept(*word));
        t.same("a forged word", search.accept(word ^ 0x5555_5555), false);
    }
    t.same("words accepted late", accepted, KEY_WINDOW);
    t.same("words outstanding", search.outstanding(), 0);
}

fn second_connect(t: &mut Trial) {
    t.same(
        "an accepted word",
        KeySearch::new(9).accept(Isaac::new(9).next_word()),
        true,
    );
    // A connection that runs takes no other seeds: the header only makes it acknowledge, if anything.
    let again = OptionalHeaders {
        connect_request: Some(ConnectRequest {
            server_time: 1.0,
            cookie: 9,
            net_id: 77,
            seed_from_server: 5,
            seed_from_client: 6,
            unused: 0,
        }),
        ..OptionalHeaders::default()
    };
    let mut sides = pair();
    let mut got = Vec::new();
    sides[1].receive(&packet(&again, &[]), 0.0, &mut got);
    sides[0].send(Queue::UI, b"after it", 0.0);
    t.same(
        "messages after it",
        exchange(&mut sides, 0.1),
        vec![b"after it".to_vec()],
    );
}

fn extreme_ids(t: &mut Trial) {
    for id in [0_u16, 0xFFFF] {
        for seed in [0_u32, 1, 0xFFFF_FFFF] {
            let side =
                |role| Connection::new(role, id, seed, !seed, 0.0, ConnectionLimits::default());
            let mut sides = [side(Role::Server), side(Role::Client)];
            sides[0].send(Queue::UI, b"hello", 0.0);
            t.same(
                "a message",
                exchange(&mut sides, 0.1),
                vec![b"hello".to_vec()],
            );
        }
    }
    for cookie in [0, u64::MAX] {
        let bytes = packet(
            &OptionalHeaders {
                connect_response: Some(cookie),
                ..OptionalHeaders::default()
            },
            &[],
        );
        let read = Packet::parse(&bytes)
            .ok()
            .and_then(|p| p.optional.connect_response);
        t.same("cookie", read, Some(cookie));
    }
}

fn early_ack(t: &mut Trial) {
    for sequence in [0_u32, 1, 2, 1000, u32::MAX] {
        let mut sides = pair();
        let ack = packet(
            &OptionalHeaders {
                ack: Some(sequence),
                ..OptionalHeaders::default()
            },
            &[],
        );
        let mut got = Vec::new();
        sides[1].receive(&ack, 0.0, &mut got);
        sides[0].send(Queue::UI, b"then this", 0.0);
        t.same("messages after it", exchange(&mut sides, 0.1).len(), 1);
    }
}

fn rejected(t: &mut Trial) {
    let limits = ConnectionLimits {
        store_age: 0.5,
        ..ConnectionLimits::default()
    };
    let mut sides = pair();
    sides[0] = Connection::new(Role::Server, 11, 1, 2, 0.0, limits);
    for i in 0..4_u8 {
        sides[0].send(Queue::UI, &[i; 8], 0.0);
    }
    let mut sent = Vec::new();
    while let Some(datagram) = sides[0].poll_transmit() {
        sent.push(datagram);
    }
    let mut got = Vec::new();
    if let Some(last) = sent.last() {
        sides[1].receive(last, 1.0, &mut got);
    }
    sides[0].handle_timeout(1.0);
    for step in 1..20 {
        exchange(&mut sides, 1.0 + f64::from(step));
        sides[1].handle_timeout(1.0 + f64::from(step));
    }
    sides[0].send(Queue::UI, b"later", 30.0);
    let later = exchange(&mut sides, 30.0);
    t.promise(later.contains(&b"later".to_vec()), || {
        format!("{} messages after the loss", later.len())
    });
}

fn clock_backwards(t: &mut Trial) {
    let mut sides = pair();
    for now in [0.0, 100.0, 50.0, -1.0, f64::NAN, 1e300, 101.0] {
        for side in &mut sides {
            side.handle_timeout(now);
        }
        exchange(&mut sides, now);
    }
    let mut got = Vec::new();
    for time in [f64::NAN, f64::INFINITY, -1.0, f64::MAX] {
        let sync = packet(
            &OptionalHeaders {
                time_sync: Some(time),
                ..OptionalHeaders::default()
            },
            &[],
        );
        sides[1].receive(&sync, 102.0, &mut got);
    }
    sides[0].send(Queue::UI, b"still here", 103.0);
    let after = exchange(&mut sides, 103.0);
    t.promise(after.len() <= 1, || format!("{} messages", after.len()));
}

fn cut_off(t: &mut Trial) {
    let headers = OptionalHeaders {
        ack: Some(9),
        time_sync: Some(5.0),
        echo_request: Some(1.0),
        flow: Some(Flow {
            bytes: 1,
            interval: 2,
        }),
        ..OptionalHeaders::default()
    };
    let bytes = packet(&headers, &[]);
    t.promise(Packet::parse(&bytes).is_ok(), || {
        "the whole packet is not read".into()
    });
    // The size word says that much less is there.
    for size in 0..bytes.len() - 20 {
        let mut cut = bytes.clone();
        cut[16..18].copy_from_slice(&(size as u16).to_le_bytes());
        t.promise(Packet::parse(&cut).is_err(), || {
            format!("a payload of {size} bytes is read")
        });
    }
    let mut trailing = bytes.clone();
    trailing.extend([1, 2, 3]);
    t.same(
        "trailing bytes",
        Packet::parse(&trailing).ok().map(|p| p.trailing),
        Some(3),
    );
    damaged(t, &bytes);
    t.promise(Packet::parse(&vec![0xFF; MAX_DATAGRAM]).is_err(), || {
        "noise is a packet".into()
    });
}

fn again(t: &mut Trial) {
    // Two lives of a connection: the second starts from nothing.
    for _ in 0..2 {
        let mut sides = pair();
        for i in 0..300_u32 {
            sides[0].send(Queue::UI, &i.to_le_bytes(), f64::from(i));
            let got = exchange(&mut sides, f64::from(i));
            t.same("message", got, vec![i.to_le_bytes().to_vec()]);
        }
        sides[0].disconnect();
        sides[1].disconnect();
        exchange(&mut sides, 400.0);
    }
}

fn accounts(t: &mut Trial) {
    let login = |account: String, secret: String| LoginRequest {
        version: "1802".into(),
        auth: AuthType::Password,
        auth_flags: 0,
        timestamp: 0,
        account,
        account_override: String::new(),
        secret: Some(secret),
    };
    for length in [0_usize, 1, 127, 128, 255, 256] {
        let request = login("A".into(), "x".repeat(length));
        match request.to_bytes() {
            Ok(bytes) => {
                let read = LoginRequest::parse(&bytes);
                let secret = read.ok().and_then(|r| r.secret);
                t.same("password", secret.unwrap_or_default().len(), length);
                for cut in 0..bytes.len() {
                    let _ = LoginRequest::parse(&bytes[..cut]);
                }
            }
            Err(error) => t.promise(length > 127, || format!("{length}: {error}")),
        }
    }
    let two =
        [login("A".into(), "p".into()), login("a".into(), "p".into())].map(|r| r.to_bytes().ok());
    t.promise(two[0] != two[1], || "accounts A and a are the same".into());
    let umlaut = login("Äé".into(), "ß".into())
        .to_bytes()
        .ok()
        .and_then(|b| LoginRequest::parse(&b).ok());
    t.same(
        "code page 1252",
        umlaut.map(|r| r.account),
        Some("Äé".into()),
    );
    t.promise(login("日".into(), "p".into()).to_bytes().is_err(), || {
        "what the code page has not is sent".into()
    });
}
