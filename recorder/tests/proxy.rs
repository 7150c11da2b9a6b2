//! Two sessions through the proxy, over loopback: what is passed on, what is recorded, and that no secret is.

use std::net::SocketAddr;
use std::path::Path;
use std::time::{Duration, Instant};

use ac_client::net::messages::message_name;
use ac_client::net::session::{
    ClientConfig, ClientEvent, ClientSession, ClientState, Port, ServerConfig, ServerEvent,
    ServerSession,
};
use ac_client::net::transport::{AuthType, LoginRequest, Queue};
use ac_recorder::decode::all_messages;
use ac_recorder::format::read;
use ac_recorder::proxy::{Proxy, ProxyConfig};
use ac_recorder::relay::{RelayLimits, next_port};
use tokio::net::UdpSocket;
use tokio::sync::oneshot;

/// Two UDP ports in a row.
async fn pair() -> (UdpSocket, UdpSocket) {
    for _ in 0..100 {
        let first = UdpSocket::bind("127.0.0.1:0").await.expect("a port");
        let address = first.local_addr().expect("bound");
        if let Some(next) = next_port(address)
            && let Ok(second) = UdpSocket::bind(next).await
        {
            return (first, second);
        }
    }
    panic!("no two free ports in a row");
}

/// A server that sends its character list to everybody who logs in, until it is told to stop.
async fn server(login: UdpSocket, next: UdpSocket, mut stop: oneshot::Receiver<()>) {
    let start = Instant::now();
    let mut sessions: Vec<(SocketAddr, ServerSession)> = Vec::new();
    let (mut a, mut b) = ([0; 2048], [0; 2048]);
    loop {
        let (port, n, from) = tokio::select! {
            _ = &mut stop => return,
            r = login.recv_from(&mut a) => { let (n, from) = r.expect("received"); (Port::Login, n, from) }
            r = next.recv_from(&mut b) => { let (n, from) = r.expect("received"); (Port::Next, n, from) }
        };
        let bytes = if port == Port::Login {
            &a[..n]
        } else {
            &b[..n]
        };
        let now = start.elapsed().as_secs_f64();
        if !sessions.iter().any(|s| s.0 == from) {
            sessions.push((from, ServerSession::new(ServerConfig::default(), now)));
        }
        let Some((_, session)) = sessions.iter_mut().find(|s| s.0 == from) else {
            continue;
        };
        session.receive(port, bytes, now);
        while let Some(event) = session.poll_event() {
            if let ServerEvent::Connected(login) = event {
                session.send(Queue::UI, &character_list(&login.account), now);
            }
        }
        while let Some(out) = session.poll_transmit() {
            let socket = if out.port == Port::Login {
                &login
            } else {
                &next
            };
            socket.send_to(&out.bytes, from).await.expect("sent");
        }
    }
}

fn character_list(account: &str) -> Vec<u8> {
    let mut m: Vec<u8> = [0xF658u32, 0, 0, 0, 11]
        .iter()
        .flat_map(|w| w.to_le_bytes())
        .collect();
    m.extend((account.len() as u16).to_le_bytes());
    m.extend(account.bytes());
    m.resize(m.len().next_multiple_of(4), 0);
    m.extend([1u32, 1].iter().flat_map(|w| w.to_le_bytes()));
    m
}

/// Logs in and waits for the character list.
async fn client(proxy: SocketAddr, account: &str) {
    let request = LoginRequest {
        version: "1802".into(),
        auth: AuthType::Password,
        auth_flags: 1,
        timestamp: 0,
        account: account.into(),
        account_override: String::new(),
        secret: Some("hush-hush".into()),
    };
    let start = Instant::now();
    let now = || start.elapsed().as_secs_f64();
    let socket = UdpSocket::bind("127.0.0.1:0").await.expect("a port");
    let mut session =
        ClientSession::new(&request, ClientConfig::default(), now()).expect("a valid login");
    let mut buffer = [0; 2048];
    while session.state() != ClientState::CharacterSelect {
        assert!(now() < 20.0, "{account}: no character list");
        while let Some(out) = session.poll_transmit() {
            let to = if out.port == Port::Login {
                proxy
            } else {
                next_port(proxy).expect("next")
            };
            socket.send_to(&out.bytes, to).await.expect("sent");
        }
        let received =
            tokio::time::timeout(Duration::from_millis(20), socket.recv_from(&mut buffer)).await;
        if let Ok(Ok((n, _))) = received {
            session.receive(&buffer[..n], now());
        }
        session.handle_timeout(now());
        while let Some(event) = session.poll_event() {
            assert!(
                !matches!(event, ClientEvent::Failed(_)),
                "{account}: {event:?}"
            );
        }
    }
}

fn contains(bytes: &[u8], text: &str) -> bool {
    bytes
        .windows(text.len())
        .any(|w| w.eq_ignore_ascii_case(text.as_bytes()))
}

fn check(path: &Path) {
    let bytes = std::fs::read(path).expect("written");
    let recording = read(path).expect("a recording");
    assert_eq!(recording.damage, None);
    for secret in ["firstaccount", "secondaccount", "hush-hush"] {
        assert!(!contains(&bytes, secret));
        assert!(
            !recording.packets.iter().any(|p| contains(&p.bytes, secret)),
            "{secret}"
        );
    }
    for client in [0, 1] {
        let lists = all_messages(&recording.packets)
            .iter()
            .filter(|m| m.stream.client == client)
            .filter(|m| message_name(&m.bytes, m.stream.direction()) == "CharacterList")
            .count();
        assert_eq!(lists, 1, "client {client}");
    }
}

#[tokio::test]
async fn two_clients_are_relayed_and_recorded_without_secrets() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("session.mcap");
    let (login, next) = pair().await;
    let server_address = login.local_addr().expect("bound");
    let (stop_server, server_stopped) = oneshot::channel();
    let server = tokio::spawn(server(login, next, server_stopped));
    // The proxy takes over two ports that were free a moment ago.
    let listen = {
        let (first, _second) = pair().await;
        first.local_addr().expect("bound")
    };
    let config = ProxyConfig {
        listen,
        server: server_address,
        output: output.clone(),
        limits: RelayLimits::default(),
    };
    let proxy = Proxy::open(&config).await.expect("free ports");
    let (stop_proxy, stopped) = oneshot::channel::<()>();
    let proxy = tokio::spawn(proxy.run(async {
        let _ = stopped.await;
    }));
    tokio::join!(
        client(listen, "FirstAccount"),
        client(listen, "SecondAccount")
    );
    tokio::time::sleep(Duration::from_millis(50)).await;
    drop(stop_proxy);
    let report = proxy.await.expect("no panic").expect("written");
    drop(stop_server);
    server.await.expect("no panic");
    assert!(report.packets >= 8 && report.redacted > 0, "{report:?}");
    check(&output);
}
