use ac_client::net::transport::{FRAGMENT_DATA, FragmentHeader, Queue};
use proptest::prelude::*;

use super::*;

fn login(auth: AuthType, account: &str, secret: Option<&str>) -> Vec<u8> {
    let request = LoginRequest {
        version: "1802".into(),
        auth,
        auth_flags: 1,
        timestamp: 0x5F5E_1000,
        account: account.into(),
        account_override: String::new(),
        secret: secret.map(Into::into),
    };
    let payload = request.to_bytes().expect("a valid login");
    let optional = OptionalHeaders {
        login: Some(&payload),
        ..OptionalHeaders::default()
    };
    let header = PacketHeader {
        flags: PacketFlags::LOGIN_REQUEST,
        ..PacketHeader::default()
    };
    PacketBuilder::new()
        .start(&optional)
        .finish(header, None)
        .to_vec()
}

/// A message in packets of one fragment each, with key words.
fn fragments(message: &[u8]) -> Vec<Vec<u8>> {
    let count = message.len().div_ceil(FRAGMENT_DATA) as u16;
    let parts = message.chunks(FRAGMENT_DATA).enumerate();
    parts
        .map(|(i, data)| {
            let fragment = FragmentHeader {
                sequence: 9,
                id: 0x8000_0000,
                count,
                size: 0,
                index: i as u16,
                queue: Queue::UI,
            };
            let header = PacketHeader {
                sequence: 3 + i as u32,
                flags: PacketFlags::BLOB_FRAGMENTS | PacketFlags::ENCRYPTED_CHECKSUM,
                ..PacketHeader::default()
            };
            PacketBuilder::new()
                .start(&OptionalHeaders::default())
                .fragment(fragment, data)
                .finish(header, Some(0x1234_5678))
                .to_vec()
        })
        .collect()
}

fn contains(bytes: &[u8], text: &str) -> bool {
    bytes
        .windows(text.len())
        .any(|w| w.eq_ignore_ascii_case(text.as_bytes()))
}

fn guard(policy: SecretPolicy) -> Guard {
    Guard::new(policy, SharedSecrets::default())
}

fn cleaned(guard: &mut Guard, to_server: bool, datagram: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    guard.clean(to_server, datagram, &mut out);
    out
}

#[test]
fn a_login_keeps_its_form() {
    let mut guard = guard(SecretPolicy::default());
    for (auth, account, secret) in [
        (AuthType::Password, "tester", Some("hush-hush")),
        (AuthType::Ticket, "tester", Some("hush-hush")),
        (AuthType::Account, "tester:hush-hush", None),
    ] {
        let before = login(auth, account, secret);
        let after = cleaned(&mut guard, true, &before);
        assert!(!contains(&after, "tester") && !contains(&after, "hush"));
        assert_eq!(after.len(), before.len());
        let packet = Packet::parse(&after).expect("still a packet");
        assert_eq!(packet.verify(), Verified::Clear);
    }
}

#[test]
fn hidden_lengths_are_all_the_same() {
    let mut guard = guard(SecretPolicy::Redact { hide_length: true });
    let short = login(AuthType::Password, "a", Some("b"));
    let long = login(
        AuthType::Password,
        "long-account-name",
        Some("and a password"),
    );
    let (short, long) = (
        cleaned(&mut guard, true, &short),
        cleaned(&mut guard, true, &long),
    );
    assert_eq!(short, long);
    let packet = Packet::parse(&long).expect("still a packet");
    assert_eq!(packet.verify(), Verified::Clear);
    let parsed = LoginRequest::parse(packet.optional.login.expect("a login")).expect("readable");
    assert_eq!(
        (&*parsed.account, parsed.secret.as_deref()),
        ("x", Some("x"))
    );
}

#[test]
fn kept_secrets_are_not_touched() {
    let mut guard = guard(SecretPolicy::Keep);
    let before = login(AuthType::Password, "tester", Some("hush-hush"));
    assert_eq!(cleaned(&mut guard, true, &before), before);
}

#[test]
fn secrets_go_wherever_they_turn_up() {
    let shared = SharedSecrets::default();
    let mut one = Guard::new(SecretPolicy::default(), shared.clone());
    let mut other = Guard::new(SecretPolicy::default(), shared);
    let login = login(AuthType::Password, "Tester7", Some("hush-hush"));
    cleaned(&mut one, true, &login);
    let text = b"\xE0\xF7\0\0 TESTER7 said Hush-Hush to tester70";
    for guard in [&mut one, &mut other] {
        for packet in fragments(text) {
            let after = cleaned(guard, false, &packet);
            assert!(!contains(&after, "tester7") && !contains(&after, "hush-hush"));
            let packet = Packet::parse(&after).expect("still a packet");
            assert_eq!(packet.verify(), Verified::Encrypted(0x1234_5678));
        }
    }
}

#[test]
fn secrets_across_two_fragments_go_too() {
    let mut guard = guard(SecretPolicy::default());
    cleaned(
        &mut guard,
        true,
        &login(AuthType::Password, "longaccountname", Some("hush-hush")),
    );
    for before in 0..20 {
        let mut message = vec![b'.'; FRAGMENT_DATA - before];
        message[..4].copy_from_slice(&0xF7E0u32.to_le_bytes());
        message.extend(b"LongAccountName and HUSH-HUSH.");
        let shown: Vec<u8> = fragments(&message)
            .iter()
            .map(|p| cleaned(&mut guard, false, p))
            .flat_map(|p| {
                let packet = Packet::parse(&p).expect("still a packet");
                let data: Vec<_> = packet.fragments().map(|f| f.data.to_vec()).collect();
                data.concat()
            })
            .collect();
        assert_eq!(shown.len(), message.len());
        for secret in ["longaccountname", "hush-hush"] {
            assert!(
                !contains(&shown, secret),
                "{secret} with {before} bytes before"
            );
        }
    }
}

#[test]
fn short_secrets_count_behind_their_length() {
    let mut secrets = Secrets::default();
    secrets.add("abc");
    secrets.add("xxxxxxxx");
    secrets.add("ab");
    assert_eq!(secrets.len(), 1);
    let searcher = secrets.searcher();
    assert_eq!(searcher.count(b"the abc is known"), 0);
    assert_eq!(searcher.count(b"\x03\0ABC"), 1);
    assert_eq!(searcher.count(b"\x03aBc"), 1);
    assert_eq!(searcher.count_long(b"\x03\0abc"), 0);
}

#[test]
fn other_letters_and_encodings() {
    let mut secrets = Secrets::default();
    secrets.add("M\u{fc}ller");
    let searcher = secrets.searcher();
    assert_eq!(searcher.count(b"m\xFCLLER"), 1);
    assert_eq!(searcher.count(b"M\xDCLLER"), 1);
    assert_eq!(searcher.count("m\u{fc}ller".as_bytes()), 1);
}

proptest! {
    /// However a login is damaged, cut or extended: nothing of it is kept that could be told from chance.
    #[test]
    fn damaged_logins_keep_nothing(
        at in 0usize..120,
        bit in 0u8..8,
        cut in 20usize..140,
        more in proptest::collection::vec(any::<u8>(), 0..8),
    ) {
        let whole = login(AuthType::Password, "SomeAccount", Some("hush-hush-hush"));
        let mut damaged = whole.clone();
        damaged.truncate(cut);
        damaged.extend(&more);
        let n = damaged.len();
        damaged[at % n] ^= 1 << bit;
        let after = cleaned(&mut guard(SecretPolicy::default()), true, &damaged);
        prop_assert_eq!(after.len(), damaged.len());
        for part in ["count", "hush", "somea"] {
            prop_assert!(!contains(&after[HEADER_LENGTH..], part), "{}", part);
        }
    }

    /// What is no secret stays, and what was right or wrong stays so.
    #[test]
    fn checksums_keep_their_word(key in any::<u32>(), text in "[ -~]{4,600}", wrong in any::<bool>()) {
        let mut guard = guard(SecretPolicy::default());
        cleaned(&mut guard, true, &login(AuthType::Password, "SomeAccount", Some("hush-hush-hush")));
        let message = [text.as_bytes(), b"SomeAccount"].concat();
        for mut packet in fragments(&message) {
            if wrong {
                packet[8] ^= key as u8 | 1;
            }
            let after = cleaned(&mut guard, false, &packet);
            prop_assert_eq!(after.len(), packet.len());
            prop_assert_eq!(
                Packet::parse(&after).map(|p| p.verify()),
                Packet::parse(&packet).map(|p| p.verify())
            );
        }
    }

    #[test]
    fn any_bytes(datagram in proptest::collection::vec(any::<u8>(), 0..300), to_server in any::<bool>()) {
        let mut guard = guard(SecretPolicy::Redact { hide_length: true });
        cleaned(&mut guard, true, &login(AuthType::Password, "SomeAccount", Some("hush-hush-hush")));
        cleaned(&mut guard, to_server, &datagram);
    }
}
