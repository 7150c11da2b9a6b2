use ac_client::net::transport::{
    AuthType, ConnectRequest, LoginRequest, OptionalHeaders, PacketBuilder,
};

use super::*;

fn at(port: u16) -> SocketAddr {
    SocketAddr::from(([127, 0, 0, 1], port))
}

fn packet(flags: PacketFlags, optional: &OptionalHeaders<'_>) -> Vec<u8> {
    let header = PacketHeader {
        flags,
        ..PacketHeader::default()
    };
    PacketBuilder::new()
        .start(optional)
        .finish(header, None)
        .to_vec()
}

fn login() -> Vec<u8> {
    let payload = LoginRequest {
        version: "1802".into(),
        auth: AuthType::Password,
        auth_flags: 1,
        timestamp: 1,
        account: "tester".into(),
        account_override: String::new(),
        secret: Some("secret".into()),
    }
    .to_bytes()
    .expect("a valid login");
    packet(
        PacketFlags::LOGIN_REQUEST,
        &OptionalHeaders {
            login: Some(&payload),
            ..OptionalHeaders::default()
        },
    )
}

fn connect_request(cookie: u64) -> Vec<u8> {
    let connect_request = Some(ConnectRequest {
        server_time: 0.0,
        cookie,
        net_id: 1,
        seed_from_server: 1,
        seed_from_client: 2,
        unused: 0,
    });
    packet(
        PacketFlags::CONNECT_REQUEST,
        &OptionalHeaders {
            connect_request,
            ..OptionalHeaders::default()
        },
    )
}

fn connect_response(cookie: u64) -> Vec<u8> {
    packet(
        PacketFlags::CONNECT_RESPONSE,
        &OptionalHeaders {
            connect_response: Some(cookie),
            ..OptionalHeaders::default()
        },
    )
}

fn pass(answer: FromClient) -> ToServer {
    match answer {
        FromClient::Pass(route) => route,
        other => panic!("{other:?}"),
    }
}

#[test]
fn datagrams_find_their_way() {
    let mut relay = Relay::new(at(9000), RelayLimits::default()).expect("two ports");
    let first = pass(relay.route_client(at(1), Port::Login, &login(), 0.0));
    assert_eq!((first.client, first.is_new, first.to), (0, true, at(9000)));
    let again = pass(relay.route_client(at(1), Port::Next, b"any", 0.0));
    assert_eq!((again.client, again.is_new, again.to), (0, false, at(9001)));
    let second = pass(relay.route_client(at(2), Port::Login, &login(), 0.0));
    assert_eq!(second.client, 1);
    let back = relay.route_server(1, at(9001), b"any", 0.0);
    let expected = ToClient {
        port: Port::Next,
        to: at(2),
    };
    assert_eq!(back, FromServer::Pass(expected));
    for (client, from) in [(1, at(9002)), (7, at(9000))] {
        assert_eq!(
            relay.route_server(client, from, b"any", 0.0),
            FromServer::Stranger
        );
    }
}

#[test]
fn only_a_login_makes_a_client() {
    let mut relay = Relay::new(at(9000), RelayLimits::default()).expect("two ports");
    let mut damaged = login();
    damaged[30] ^= 1;
    for datagram in [
        &b""[..],
        b"hello",
        &connect_response(1),
        &damaged,
        &login()[..40],
    ] {
        let answer = relay.route_client(at(1), Port::Login, datagram, 0.0);
        assert_eq!(answer, FromClient::Refused);
    }
    assert_eq!(relay.clients(), 0);
}

#[test]
fn nothing_is_amplified_before_the_client_has_answered() {
    let mut relay = Relay::new(at(9000), RelayLimits::default()).expect("two ports");
    let login = login();
    pass(relay.route_client(at(1), Port::Login, &login, 0.0));
    let (mut passed, mut held, mut dropped) = (0, 0, 0);
    for datagram in [connect_request(77), vec![1; 100]]
        .into_iter()
        .chain((0..200).map(|_| vec![2; 484]))
    {
        match relay.route_server(0, at(9000), &datagram, 0.0) {
            FromServer::Pass(_) => passed += datagram.len(),
            FromServer::Held(_) => held += 1,
            FromServer::Dropped(_) => dropped += 1,
            FromServer::Stranger => panic!("the server's port"),
        }
    }
    assert!(passed >= 152 && passed <= AMPLIFICATION * login.len());
    assert!(held > 100 && held * 484 <= HELD && dropped > 0);
    let wrong = pass(relay.route_client(at(1), Port::Next, &connect_response(78), 0.1));
    assert!(wrong.released.is_empty());
    let right = pass(relay.route_client(at(1), Port::Next, &connect_response(77), 0.2));
    assert_eq!(right.released.len(), held);
    for _ in 0..1000 {
        let answer = relay.route_server(0, at(9000), &[3; 484], 0.3);
        assert!(matches!(answer, FromServer::Pass(_)));
    }
}

#[test]
fn clients_are_bounded_and_expire() {
    let limits = RelayLimits {
        clients: 1,
        idle: 10.0,
        unproved_idle: 5.0,
    };
    let mut relay = Relay::new(at(9000), limits).expect("two ports");
    pass(relay.route_client(at(1), Port::Login, &login(), 0.0));
    // One that has not answered makes room.
    let second = pass(relay.route_client(at(2), Port::Login, &login(), 1.0));
    assert_eq!((second.client, second.evicted), (1, Some(0)));
    relay.route_server(1, at(9000), &connect_request(5), 1.0);
    pass(relay.route_client(at(2), Port::Next, &connect_response(5), 1.0));
    // One that has answered does not.
    let third = relay.route_client(at(3), Port::Login, &login(), 2.0);
    assert_eq!(third, FromClient::Full);
    relay.route_server(1, at(9001), b"any", 5.0);
    assert!(relay.expire(14.0).is_empty());
    assert_eq!(relay.expire(15.0), [1]);
    assert_eq!(relay.clients(), 0);
    let next = pass(relay.route_client(at(2), Port::Login, &login(), 16.0));
    assert_eq!((next.client, next.is_new), (2, true));
    assert!(relay.expire(20.0).is_empty());
    assert_eq!(relay.expire(21.0), [2]);
    assert!(Relay::new(at(65535), limits).is_none());
}
