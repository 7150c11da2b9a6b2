//! Sessions through the proxy, over loopback: what is passed on, what is recorded, and what happens when it cannot be.

use std::io;
use std::path::Path;
use std::time::Duration;

use crate::common::{Running, Server, client, free_pair, record};
use ac_client::net::messages::message_name;
use ac_recorder::decode::all_messages;
use ac_recorder::disk::{DiskConfig, Medium, Storage};
use ac_recorder::format::{Item, open, read};
use ac_recorder::proxy::{Proxy, ProxyConfig};
use tokio::net::UdpSocket;

#[tokio::test]
async fn two_clients_are_relayed_and_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("session.mcap");
    let report = record(|listen, server| ProxyConfig::new(listen, server, output.clone())).await;
    let counts = report.counts;
    assert_eq!(counts.recorded, counts.to_server + counts.to_clients);
    assert_eq!(
        (counts.unwritten(), counts.not_sent, counts.refused),
        (0, 0, 0)
    );
    assert!(counts.secret_bytes > 0, "{counts:?}");
    assert!(report.disk.leaks.is_empty() && report.disk.unchecked.is_empty());

    let recording = read(&output).expect("a recording");
    assert_eq!(recording.damage, None);
    assert_eq!(recording.packets.len() as u64, counts.recorded);
    for packet in &recording.packets {
        assert!(packet.forwarded.is_some_and(|f| f >= packet.time - 1));
    }
    for client in [0, 1] {
        let lists = all_messages(&recording.packets)
            .iter()
            .filter(|m| m.stream.client == client)
            .filter(|m| message_name(&m.bytes, m.stream.direction()) == "CharacterList")
            .count();
        assert_eq!(lists, 1, "client {client}");
    }
    index_is_right(&output);
}

/// The index says what the datagrams say, and its numbers lead to them.
fn index_is_right(path: &Path) {
    let messages = all_messages(&read(path).expect("a recording").packets);
    let mut reader = open(path).expect("a recording");
    let mut entries = Vec::new();
    let mut numbers = Vec::new();
    while let Some(item) = reader.next_item() {
        match item {
            Item::Index(_, entry) => {
                assert!(entry.datagrams.iter().all(|d| numbers.contains(d)));
                entries.push(entry);
            }
            Item::Packet(packet) => numbers.push(packet.number),
            Item::Counts(..) => {}
        }
    }
    assert_eq!(entries.len(), messages.len());
    assert!(entries.iter().any(|e| e.datagrams.len() == 2));
    for (entry, message) in entries.iter().zip(&messages) {
        assert_eq!(entry.name, message.name());
        assert_eq!(entry.bytes, message.bytes.len());
        assert_eq!(entry.datagrams, message.datagrams);
    }
    assert!(reader.last_counts().is_some_and(|c| c.recorded > 0));
}

#[tokio::test]
async fn parts_of_a_rotated_recording_make_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("session.mcap");
    let report = record(|listen, server| {
        let mut config = ProxyConfig::new(listen, server, output.clone());
        config.disk.rotation.every = Some(Duration::from_millis(60));
        config.disk.flush = Duration::from_millis(10);
        config
    })
    .await;
    assert!(report.disk.files.len() > 2, "{:?}", report.disk.files);
    let parts = ac_recorder::format::read_all(&report.disk.files).expect("recordings");
    assert_eq!(parts.damage, None);
    let numbers: Vec<_> = parts.packets.iter().map(|p| p.number).collect();
    assert_eq!(
        numbers,
        (0..report.counts.recorded as u32).collect::<Vec<_>>()
    );
    let lists = all_messages(&parts.packets)
        .iter()
        .filter(|m| m.name() == "CharacterList")
        .count();
    assert_eq!(lists, 2);
}

/// A disk with room for a file's start only.
struct Full;

struct FullFile(usize);

impl Medium for FullFile {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0 = self
            .0
            .checked_sub(bytes.len())
            .ok_or(io::ErrorKind::StorageFull)?;
        Ok(())
    }

    fn truncate(&mut self, _length: u64) -> io::Result<()> {
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Storage for Full {
    fn create(&mut self, _path: &Path) -> io::Result<Box<dyn Medium>> {
        Ok(Box::new(FullFile(1500)))
    }

    fn remove(&mut self, _path: &Path) {}
}

#[tokio::test]
async fn a_full_disk_does_not_stop_the_relay() {
    let server = Server::start().await;
    let listen = free_pair().await;
    let config = ProxyConfig {
        disk: DiskConfig {
            flush: Duration::from_millis(5),
            ..DiskConfig::new("nowhere.mcap".into())
        },
        ..ProxyConfig::new(listen, server.address, "nowhere.mcap".into())
    };
    let proxy = Proxy::open_on(&config, Box::new(Full)).expect("room for the start");
    let running = Running::start(proxy);
    client(listen, "FirstAccount").await;
    let report = running.stop().await;
    server.stop().await;
    let counts = report.counts;
    assert!(counts.unwritten_failed > 0, "{counts:?}");
    assert_eq!(
        counts.recorded + counts.unwritten(),
        counts.to_server + counts.to_clients
    );
}

#[tokio::test]
async fn strangers_get_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("session.mcap");
    let server = Server::start().await;
    let listen = free_pair().await;
    let config = ProxyConfig::new(listen, server.address, output.clone());
    let running = Running::start(Proxy::open(&config).expect("free ports"));
    let stranger = UdpSocket::bind("127.0.0.1:0").await.expect("a port");
    for bytes in [&b"junk"[..], &[0; 400], b""] {
        stranger.send_to(bytes, listen).await.expect("sent");
    }
    let mut buffer = [0; 2048];
    let answer = stranger.recv_from(&mut buffer);
    assert!(
        tokio::time::timeout(Duration::from_millis(100), answer)
            .await
            .is_err()
    );
    let report = running.stop().await;
    server.stop().await;
    assert_eq!((report.counts.refused, report.counts.recorded), (3, 0));
    assert!(read(&output).expect("a recording").packets.is_empty());
}
