//! UDP sockets with large buffers, and what the system drops at them.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use socket2::{Domain, Protocol, Socket, Type};
use tokio::net::UdpSocket;

use crate::error::RecordError;

/// Bytes that are asked for; the system may give less (Linux: `net.core.rmem_max`).
const BUFFER: usize = 8 << 20;

fn open(address: SocketAddr) -> std::io::Result<Socket> {
    let socket = Socket::new(
        Domain::for_address(address),
        Type::DGRAM,
        Some(Protocol::UDP),
    )?;
    // A smaller buffer works too.
    let _ = socket.set_recv_buffer_size(BUFFER);
    let _ = socket.set_send_buffer_size(BUFFER);
    socket.bind(&address.into())?;
    Ok(socket)
}

/// Opens a socket. Must be called on a tokio runtime.
///
/// # Errors
/// It cannot be opened.
pub fn bind(address: SocketAddr) -> Result<UdpSocket, RecordError> {
    open(address)
        .and_then(|socket| {
            socket.set_nonblocking(true)?;
            UdpSocket::from_std(socket.into())
        })
        .map_err(|source| RecordError::Socket { address, source })
}

/// Opens a socket whose calls wait.
///
/// # Errors
/// It cannot be opened.
pub fn bind_blocking(address: SocketAddr) -> Result<std::net::UdpSocket, RecordError> {
    open(address)
        .map(Into::into)
        .map_err(|source| RecordError::Socket { address, source })
}

/// Counts datagrams that the system dropped because a socket's buffer was full. Linux only: elsewhere there are none.
#[derive(Debug, Default)]
pub struct Drops {
    /// Drops so far, by inode.
    sockets: BTreeMap<u64, u64>,
}

impl Drops {
    /// Counts those of this socket from now on.
    pub fn watch(&mut self, socket: &UdpSocket) {
        if let Some(inode) = inode(socket) {
            self.sockets.insert(inode, 0);
        }
    }

    /// Datagrams dropped since the last call. Reads the system's tables.
    pub fn new_ones(&mut self) -> u64 {
        let mut new = 0;
        for table in ["/proc/net/udp", "/proc/net/udp6"] {
            let Ok(text) = std::fs::read_to_string(table) else {
                continue;
            };
            for (inode, drops) in text.lines().filter_map(line) {
                if let Some(before) = self.sockets.get_mut(&inode) {
                    new += drops.saturating_sub(*before);
                    *before = drops;
                }
            }
        }
        new
    }
}

/// Inode and drops of a line of the table: the tenth and the thirteenth field.
fn line(text: &str) -> Option<(u64, u64)> {
    let mut fields = text.split_ascii_whitespace().skip(9);
    let inode = fields.next()?.parse().ok()?;
    let drops = fields.nth(2)?.parse().ok()?;
    Some((inode, drops))
}

#[cfg(target_os = "linux")]
fn inode(socket: &UdpSocket) -> Option<u64> {
    use std::os::fd::AsRawFd;
    let link = std::fs::read_link(format!("/proc/self/fd/{}", socket.as_raw_fd())).ok()?;
    let text = link.to_str()?;
    text.strip_prefix("socket:[")?
        .strip_suffix(']')?
        .parse()
        .ok()
}

#[cfg(not(target_os = "linux"))]
fn inode(_socket: &UdpSocket) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_table() {
        let text = "  123: 0100007F:2328 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 45678 2 0000000000000000 17";
        assert_eq!(line(text), Some((45_678, 17)));
        assert_eq!(line("  sl  local_address rem_address"), None);
    }

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn a_full_buffer_is_noticed() {
        let socket = bind(([127, 0, 0, 1], 0).into()).expect("a port");
        let to = socket.local_addr().expect("bound");
        let mut drops = Drops::default();
        drops.watch(&socket);
        assert_eq!(drops.new_ones(), 0);
        let sender = std::net::UdpSocket::bind("127.0.0.1:0").expect("a port");
        let mut new = 0;
        for _ in 0..100_000 {
            let _ = sender.send_to(&[0; 8000], to);
            new = drops.new_ones();
            if new > 0 {
                break;
            }
        }
        assert!(new > 0, "nothing was dropped");
        assert_eq!(drops.new_ones(), 0);
    }
}
