//! A server that knows the handshake and otherwise sends everything back, and its client.

use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ac_client::net::transport::{
    AuthType, ConnectRequest, FragmentHeader, HEADER_LENGTH, LoginRequest, OptionalHeaders,
    PacketBuilder, PacketFlags, PacketHeader, Queue,
};

use crate::error::RecordError;
use crate::relay::next_port;
use crate::sockets;

/// The server's cookie.
const COOKIE: u64 = 0x0123_4567_89AB_CDEF;
const WAIT: Duration = Duration::from_millis(50);

/// Two blocking sockets on ports in a row.
pub(super) fn pair() -> Result<(UdpSocket, UdpSocket), RecordError> {
    let any: SocketAddr = ([127, 0, 0, 1], 0).into();
    for _ in 0..100 {
        let first = sockets::bind_blocking(any)?;
        if let Some(next) = first.local_addr().ok().and_then(next_port)
            && let Ok(second) = sockets::bind_blocking(next)
        {
            return Ok((first, second));
        }
    }
    Err(RecordError::Address {
        text: any.to_string(),
        reason: "no two free ports in a row".into(),
    })
}

/// Sends everything back until it is dropped.
pub(super) struct EchoServer {
    pub(super) address: SocketAddr,
    stop: Arc<AtomicBool>,
}

impl EchoServer {
    pub(super) fn start() -> Result<Self, RecordError> {
        let (login, next) = pair()?;
        let any = SocketAddr::from(([0, 0, 0, 0], 0));
        let address = login.local_addr().unwrap_or(any);
        let stop = Arc::<AtomicBool>::default();
        for socket in [login, next] {
            let stop = stop.clone();
            std::thread::spawn(move || echo(&socket, &stop));
        }
        Ok(Self { address, stop })
    }
}

impl Drop for EchoServer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

fn flags(datagram: &[u8]) -> PacketFlags {
    let head = datagram.first_chunk::<HEADER_LENGTH>();
    head.map_or(PacketFlags::empty(), |h| PacketHeader::parse(h).flags)
}

fn echo(socket: &UdpSocket, stop: &AtomicBool) {
    let _ = socket.set_read_timeout(Some(WAIT));
    let mut buffer = [0; 2048];
    while !stop.load(Ordering::Relaxed) {
        let Ok((n, from)) = socket.recv_from(&mut buffer) else {
            continue;
        };
        let flags = flags(&buffer[..n]);
        if flags.contains(PacketFlags::LOGIN_REQUEST) {
            let _ = socket.send_to(&connect_request(), from);
        } else if !flags.contains(PacketFlags::CONNECT_RESPONSE) {
            let _ = socket.send_to(&buffer[..n], from);
        }
    }
}

fn clear(flags: PacketFlags, optional: &OptionalHeaders<'_>) -> Vec<u8> {
    let header = PacketHeader {
        flags,
        ..PacketHeader::default()
    };
    PacketBuilder::new()
        .start(optional)
        .finish(header, None)
        .to_vec()
}

fn connect_request() -> Vec<u8> {
    let request = ConnectRequest {
        server_time: 0.0,
        cookie: COOKIE,
        net_id: 1,
        seed_from_server: 1,
        seed_from_client: 2,
        unused: 0,
    };
    clear(
        PacketFlags::CONNECT_REQUEST,
        &OptionalHeaders {
            connect_request: Some(request),
            ..OptionalHeaders::default()
        },
    )
}

fn login() -> Vec<u8> {
    let request = LoginRequest {
        version: "1802".into(),
        auth: AuthType::Password,
        auth_flags: 1,
        timestamp: 0,
        account: "measure".into(),
        account_override: String::new(),
        secret: Some("not-a-secret".into()),
    };
    // Cannot fail: short texts.
    let payload = request.to_bytes().unwrap_or_default();
    clear(
        PacketFlags::LOGIN_REQUEST,
        &OptionalHeaders {
            login: Some(&payload),
            ..OptionalHeaders::default()
        },
    )
}

/// Logs in, so that a relay serves the socket. Says whether there was an answer in time.
pub(super) fn log_in(socket: &UdpSocket, server: SocketAddr, until: Instant) -> bool {
    let Some(next) = next_port(server) else {
        return false;
    };
    let _ = socket.set_read_timeout(Some(Duration::from_millis(20)));
    let mut buffer = [0; 2048];
    while Instant::now() < until {
        let _ = socket.send_to(&login(), server);
        let answered = socket
            .recv_from(&mut buffer)
            .is_ok_and(|(n, _)| flags(&buffer[..n]).contains(PacketFlags::CONNECT_REQUEST));
        if answered {
            let response = OptionalHeaders {
                connect_response: Some(COOKIE),
                ..OptionalHeaders::default()
            };
            let _ = socket.send_to(&clear(PacketFlags::CONNECT_RESPONSE, &response), next);
            // The relay has to see it before it passes much on.
            std::thread::sleep(Duration::from_millis(20));
            return true;
        }
    }
    false
}

/// Makes packets as a client sends them in play: one short action each.
#[derive(Default)]
pub(super) struct Packets {
    builder: PacketBuilder,
}

impl Packets {
    /// The packet with a sequence.
    pub(super) fn packet(&mut self, sequence: u32) -> &[u8] {
        let mut action = [0; 60];
        action[..4].copy_from_slice(&0xF7B1u32.to_le_bytes());
        action[8..12].copy_from_slice(&0x01E9u32.to_le_bytes());
        let fragment = FragmentHeader {
            sequence,
            id: 0,
            count: 1,
            size: 0,
            index: 0,
            queue: Queue(3),
        };
        let header = PacketHeader {
            sequence,
            flags: PacketFlags::BLOB_FRAGMENTS | PacketFlags::ENCRYPTED_CHECKSUM,
            id: 1,
            ..PacketHeader::default()
        };
        self.builder
            .start(&OptionalHeaders::default())
            .fragment(fragment, &action)
            .finish(header, Some(sequence))
    }
}

/// The sequence of a packet.
pub(super) fn sequence(datagram: &[u8]) -> Option<u32> {
    let head = datagram.first_chunk::<HEADER_LENGTH>()?;
    let header = PacketHeader::parse(head);
    header
        .flags
        .contains(PacketFlags::BLOB_FRAGMENTS)
        .then_some(header.sequence)
}
