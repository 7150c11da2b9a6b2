//! A server, clients and ports for tests.

use std::net::SocketAddr;
use std::path::Path;
use std::time::{Duration, Instant};

use ac_client::net::session::{
    ClientConfig, ClientEvent, ClientSession, ClientState, Port, ServerConfig, ServerEvent,
    ServerSession,
};
use ac_client::net::transport::{AuthType, LoginRequest, Queue};
use ac_recorder::proxy::{Proxy, ProxyConfig, ProxyReport};
use ac_recorder::relay::next_port;
use tokio::net::UdpSocket;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// The password of every client.
pub const PASSWORD: &str = "hush-hush";

/// Two UDP ports in a row.
pub async fn pair() -> (UdpSocket, UdpSocket) {
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

/// Two ports in a row that were free a moment ago.
pub async fn free_pair() -> SocketAddr {
    let (first, _second) = pair().await;
    first.local_addr().expect("bound")
}

/// A server, and how to stop it.
pub struct Server {
    pub address: SocketAddr,
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Server {
    pub async fn start() -> Self {
        let (login, next) = pair().await;
        let address = login.local_addr().expect("bound");
        let (stop, stopped) = oneshot::channel();
        let task = tokio::spawn(serve(login, next, stopped));
        Self {
            address,
            stop,
            task,
        }
    }

    pub async fn stop(self) {
        drop(self.stop);
        self.task.await.expect("no panic");
    }
}

/// Sends its character list, and a text that gives everything away, to everybody who logs in.
async fn serve(login: UdpSocket, next: UdpSocket, mut stop: oneshot::Receiver<()>) {
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
                session.send(Queue::UI, &chatter(&login.account), now);
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

fn string16(m: &mut Vec<u8>, text: &str) {
    m.extend((text.len() as u16).to_le_bytes());
    m.extend(text.bytes());
    m.resize(m.len().next_multiple_of(4), 0);
}

pub fn character_list(account: &str) -> Vec<u8> {
    let mut m: Vec<u8> = [0xF658u32, 0, 0, 0, 11]
        .iter()
        .flat_map(|w| w.to_le_bytes())
        .collect();
    string16(&mut m, account);
    m.extend([1u32, 1].iter().flat_map(|w| w.to_le_bytes()));
    m
}

/// A chat text of two fragments with account and password in it.
fn chatter(account: &str) -> Vec<u8> {
    let mut m = 0xF7E0u32.to_le_bytes().to_vec();
    let dots = ".".repeat(430);
    string16(
        &mut m,
        &format!("Welcome, {account}! {dots} {account} has password {PASSWORD}"),
    );
    m.extend(5u32.to_le_bytes());
    m
}

/// Logs in and waits for the character list.
pub async fn client(proxy: SocketAddr, account: &str) {
    let request = LoginRequest {
        version: "1802".into(),
        auth: AuthType::Password,
        auth_flags: 1,
        timestamp: 0,
        account: account.into(),
        account_override: String::new(),
        secret: Some(PASSWORD.into()),
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

/// A proxy, and how to stop it.
pub struct Running {
    stop: oneshot::Sender<()>,
    task: JoinHandle<ProxyReport>,
}

impl Running {
    pub fn start(proxy: Proxy) -> Self {
        let (stop, stopped) = oneshot::channel::<()>();
        let task = tokio::spawn(proxy.run(async {
            let _ = stopped.await;
        }));
        Self { stop, task }
    }

    pub async fn stop(self) -> ProxyReport {
        drop(self.stop);
        self.task.await.expect("no panic")
    }
}

/// Records a session of two clients.
pub async fn record(config: impl FnOnce(SocketAddr, SocketAddr) -> ProxyConfig) -> ProxyReport {
    let server = Server::start().await;
    let listen = free_pair().await;
    let config = config(listen, server.address);
    let proxy = Running::start(Proxy::open(&config).expect("free ports"));
    tokio::join!(
        client(listen, "FirstAccount"),
        client(listen, "SecondAccount")
    );
    tokio::time::sleep(Duration::from_millis(50)).await;
    let report = proxy.stop().await;
    server.stop().await;
    report
}

pub fn contains(bytes: &[u8], text: &str) -> bool {
    bytes
        .windows(text.len())
        .any(|w| w.eq_ignore_ascii_case(text.as_bytes()))
}

/// All bytes of a file: as they are, and every record after decompression.
pub fn every_byte(path: &Path) -> Vec<u8> {
    use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader};
    let file = std::fs::read(path).expect("written");
    let mut all = file.clone();
    let (mut reader, mut rest) = (LinearReader::new(), &file[..]);
    while let Some(event) = reader.next_event() {
        match event.expect("a whole file") {
            LinearReadEvent::ReadRequest(n) => {
                let n = n.min(rest.len());
                reader.insert(n).copy_from_slice(&rest[..n]);
                reader.notify_read(n);
                rest = &rest[n..];
            }
            LinearReadEvent::Record { data, .. } => all.extend(data),
        }
    }
    assert!(all.len() > file.len());
    all
}
