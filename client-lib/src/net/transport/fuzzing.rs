//! Body of the fuzz target `transport` in `fuzz/`. It is here so that a deterministic smoke of the very same body runs with the tests.

use super::{
    Connection, ConnectionLimits, Incoming, MAX_DATAGRAM, Packet, PacketBuilder, Queue, Redactor,
    Role, Verified,
};

/// Takes the bytes as datagrams, and as damage to the datagrams of two connected sides.
pub fn transport(data: &[u8]) {
    packet(data);
    let mut rest = data;
    let mut redactor = Redactor::new();
    let mut sides = [Role::Client, Role::Server].map(connection);
    let mut out = Vec::new();
    let mut now = 0.0;
    while let Some((&length, tail)) = rest.split_first() {
        let (datagram, tail) = tail.split_at(usize::from(length).min(tail.len()));
        rest = tail;
        now += f64::from(length % 16) * 0.1;
        packet(datagram);
        redact(&mut redactor, datagram);
        for side in &mut sides {
            side.receive(datagram, now, &mut out);
        }
        exchange(&mut sides, datagram, now, &mut out);
        assert!(
            out.len() < 4096,
            "a datagram brings a bounded number of things"
        );
        out.clear();
    }
}

fn connection(role: Role) -> Connection {
    Connection::new(
        role,
        7,
        0x1234_5678,
        0x99E7_7855,
        0.0,
        ConnectionLimits::default(),
    )
}

/// A datagram that can be read can be built again, bit by bit.
fn packet(datagram: &[u8]) {
    let Ok(packet) = Packet::parse(datagram) else {
        return;
    };
    let key = match packet.verify() {
        Verified::Wrong => return,
        Verified::Clear => None,
        Verified::Encrypted(word) => Some(word),
    };
    let mut builder = PacketBuilder::new();
    builder.start(&packet.optional);
    for fragment in packet.fragments() {
        builder.fragment(fragment.header, fragment.data);
    }
    let end = datagram.len() - packet.trailing;
    assert_eq!(builder.finish(packet.header, key), &datagram[..end]);
}

/// Redaction keeps the length, and what was readable and right stays so.
fn redact(redactor: &mut Redactor, datagram: &[u8]) {
    let mut redacted = datagram.to_vec();
    redactor.redact(&mut redacted);
    assert_eq!(redacted.len(), datagram.len());
    if let (Ok(before), Ok(after)) = (Packet::parse(datagram), Packet::parse(&redacted)) {
        assert_eq!(before.verify(), after.verify());
    }
}

/// One side sends the bytes as a message; on the way a datagram may be lost, doubled or damaged.
fn exchange(sides: &mut [Connection; 2], message: &[u8], now: f64, out: &mut Vec<Incoming>) {
    let fate = message.first().copied().unwrap_or(0);
    let from = usize::from(fate & 1);
    sides[from].send(Queue(u16::from(fate >> 4)), message, now);
    sides[from].handle_timeout(now);
    // Answers to answers end: nothing is sent for an acknowledgement.
    for round in 0..64 {
        let sender = (from + round) % 2;
        let Some(mut datagram) = sides[sender].poll_transmit() else {
            if round > 0 {
                break;
            }
            continue;
        };
        assert!(datagram.len() <= MAX_DATAGRAM);
        if fate & 0x0E == 0x02 {
            let at = usize::from(fate) % datagram.len().max(1);
            datagram[at] ^= 1 << (fate >> 5);
        }
        let copies = match fate & 0x0E {
            0x04 => 0,
            0x06 => 2,
            _ => 1,
        };
        for _ in 0..copies {
            sides[1 - sender].receive(&datagram, now, out);
        }
    }
}
