//! Removal of secrets from packets before anything is kept (`spec/09`, 14).
//!
//! Every secret byte becomes [`REDACTED`]; lengths, sequences and key words stay, and the checksum is repaired, so a redacted recording still
//! verifies. Covered: account names and passwords or tickets of a LoginRequest, and the account name in the messages that carry it, also where it
//! straddles two fragments.

use super::fragment::{FRAGMENT_DATA, FRAGMENT_HEADER, Fragments};
use super::login::LoginLayout;
use super::packet::{HEADER_LENGTH, Packet, PacketFlags, PacketHeader};

/// What a secret byte becomes: "x".
pub const REDACTED: u8 = 0x78;

const CHARACTER_LIST: u32 = 0xF658;
const ENTER_WORLD: u32 = 0xF657;
const DELETE_CHARACTER: u32 = 0xF655;
const CREATE_CHARACTER: u32 = 0xF656;

/// What a redaction did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Redaction {
    /// Bytes that were secret.
    pub bytes: usize,
}

/// Redacts the packets of one client's session, in both directions. It learns the account name from the LoginRequest.
#[derive(Default, Clone)]
pub struct Redactor {
    accounts: Vec<Vec<u8>>,
}

impl core::fmt::Debug for Redactor {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Redactor")
            .field("accounts", &self.accounts.len())
            .finish()
    }
}

fn overwrite(bytes: &mut [u8]) -> usize {
    bytes.fill(REDACTED);
    bytes.len()
}

fn read_u16(b: &[u8], at: usize) -> Option<usize> {
    Some(usize::from(u16::from_le_bytes(
        *b.get(at..)?.first_chunk()?,
    )))
}

fn read_u32(b: &[u8], at: usize) -> Option<usize> {
    Some(u32::from_le_bytes(*b.get(at..)?.first_chunk()?) as usize)
}

/// End of the padded string16 at `at`.
fn string16_end(b: &[u8], at: usize) -> Option<usize> {
    Some((at + 2 + read_u16(b, at)?).next_multiple_of(4))
}

/// Where the account's string16 starts in a message, as far as the message's structure can be followed in these bytes.
fn account_field(message: &[u8]) -> Option<usize> {
    match read_u32(message, 0)? as u32 {
        ENTER_WORLD => Some(8),
        DELETE_CHARACTER | CREATE_CHARACTER => Some(4),
        CHARACTER_LIST => {
            let mut at = 8;
            for _ in 0..2 {
                let n = read_u32(message, at)?;
                at += 4;
                for _ in 0..n {
                    at = string16_end(message, at + 4)? + 4;
                }
            }
            Some(at + 4)
        }
        _ => None,
    }
}

impl Redactor {
    /// A redactor that knows no account yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Lets the redactor look for an account name that it did not see in a LoginRequest.
    pub fn add_account(&mut self, account: &[u8]) {
        let name = account
            .split(|&b| b == b':')
            .next()
            .unwrap_or_default()
            .to_ascii_lowercase();
        if !name.is_empty() && !self.accounts.contains(&name) {
            self.accounts.push(name);
        }
    }

    /// Redacts a datagram in place.
    pub fn redact(&mut self, datagram: &mut [u8]) -> Redaction {
        let Some(head) = datagram.first_chunk::<HEADER_LENGTH>() else {
            return Redaction::default();
        };
        let flags = PacketHeader::parse(head).flags;
        if !flags.intersects(PacketFlags::LOGIN_REQUEST | PacketFlags::BLOB_FRAGMENTS) {
            return Redaction::default();
        }
        let Ok(packet) = Packet::parse(datagram) else {
            return self.redact_unreadable(flags, datagram);
        };
        let (header, old, trailing) = (packet.header, packet.data_hash(), packet.trailing);
        let optional = packet.optional_bytes.len();
        let login = packet.optional.login.map(<[u8]>::len);
        let fragments_at = HEADER_LENGTH + optional;
        let end = datagram.len() - trailing;
        let mut bytes = 0;
        if let Some(length) = login {
            bytes += self.redact_login(&mut datagram[fragments_at - length..fragments_at]);
        }
        bytes += self.redact_fragments(&mut datagram[fragments_at..end]);
        if bytes > 0 {
            repair_checksum(datagram, header, old);
        }
        Redaction { bytes }
    }

    /// A login that is no valid packet may still hold secrets: nothing of its payload is kept.
    fn redact_unreadable(&mut self, flags: PacketFlags, datagram: &mut [u8]) -> Redaction {
        let payload = &mut datagram[HEADER_LENGTH..];
        let bytes = if flags.contains(PacketFlags::LOGIN_REQUEST) {
            overwrite(payload)
        } else {
            self.redact_known(payload)
        };
        Redaction { bytes }
    }

    fn redact_login(&mut self, payload: &mut [u8]) -> usize {
        let Ok(layout) = LoginLayout::of(payload) else {
            return overwrite(payload);
        };
        self.add_account(&payload[layout.account.clone()]);
        self.add_account(&payload[layout.account_override.clone()]);
        [layout.account, layout.account_override, layout.secret]
            .into_iter()
            .map(|r| overwrite(&mut payload[r]))
            .sum()
    }

    fn redact_fragments(&self, bytes: &mut [u8]) -> usize {
        let ranges: Vec<_> = Fragments::new(bytes)
            .filter_map(Result::ok)
            .scan(0, |at, fragment| {
                let start = *at + FRAGMENT_HEADER;
                *at = start + fragment.data.len();
                Some((start..*at, fragment.header))
            })
            .collect();
        let mut redacted = 0;
        for (range, header) in ranges {
            let data = &mut bytes[range];
            if header.index == 0 {
                redacted += redact_field(data);
            }
            redacted += self.redact_known(data);
            if header.count > 1 {
                redacted += self.redact_straddling(data, header.index, header.count);
            }
        }
        redacted
    }

    /// Whole occurrences of a known account as a string16, in any letter case.
    fn redact_known(&self, data: &mut [u8]) -> usize {
        let mut redacted = 0;
        for account in &self.accounts {
            let n = account.len();
            for at in 2..=data.len().saturating_sub(n) {
                if read_u16(data, at - 2) == Some(n)
                    && data[at..at + n].eq_ignore_ascii_case(account)
                {
                    redacted += overwrite(&mut data[at..at + n]);
                }
            }
        }
        redacted
    }

    /// An account that begins at the end of one fragment and ends at the start of the next.
    fn redact_straddling(&self, data: &mut [u8], index: u16, count: u16) -> usize {
        let mut redacted = 0;
        for account in &self.accounts {
            let n = account.len();
            let last = index + 1 == count;
            if !last {
                let head = (1..n).rev().find(|&k| {
                    data.len().checked_sub(k + 2).is_some_and(|at| {
                        read_u16(data, at) == Some(n)
                            && data[at + 2..].eq_ignore_ascii_case(&account[..k])
                    })
                });
                if let Some(k) = head {
                    let at = data.len() - k;
                    redacted += overwrite(&mut data[at..]);
                }
            }
            // The account is the last text of a character list: padding and two words follow it.
            let before = FRAGMENT_DATA * usize::from(index);
            let tail = (1..=n).rev().find(|&k| {
                let end = (before + k).next_multiple_of(4) - before;
                (if last {
                    data.len() == end + 8
                } else {
                    data.len() >= k
                }) && data
                    .get(..k)
                    .is_some_and(|d| d.eq_ignore_ascii_case(&account[n - k..]))
            });
            if let (true, Some(k)) = (index > 0 && last, tail) {
                redacted += overwrite(&mut data[..k]);
            }
        }
        redacted
    }
}

/// The account field of a message that carries one, where its structure can be followed.
fn redact_field(data: &mut [u8]) -> usize {
    let Some(at) = account_field(data) else {
        return 0;
    };
    let Some(n) = read_u16(data, at) else {
        return 0;
    };
    let end = (at + 2 + n).min(data.len());
    overwrite(&mut data[at + 2..end])
}

/// Writes the checksum that belongs to the changed payload; an encrypted one keeps its key word.
fn repair_checksum(datagram: &mut [u8], header: PacketHeader, old_data: u32) {
    let Ok(packet) = Packet::parse(datagram) else {
        return;
    };
    let (h, new_data) = (header.hash(), packet.data_hash());
    let checksum = if header.flags.contains(PacketFlags::ENCRYPTED_CHECKSUM) {
        let key = header.checksum.wrapping_sub(h) ^ old_data;
        h.wrapping_add(new_data ^ key)
    } else {
        // A wrong checksum stays wrong by as much: damage in the recording must not be hidden.
        header
            .checksum
            .wrapping_sub(old_data)
            .wrapping_add(new_data)
    };
    datagram[8..12].copy_from_slice(&checksum.to_le_bytes());
}

#[cfg(test)]
mod tests {
    use super::super::{
        AuthType, FragmentHeader, LoginRequest, OptionalHeaders, PacketBuilder, Queue, Verified,
    };
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

    fn contains(bytes: &[u8], text: &str) -> bool {
        bytes
            .windows(text.len())
            .any(|w| w.eq_ignore_ascii_case(text.as_bytes()))
    }

    #[test]
    fn logins_lose_their_secrets_and_still_verify() {
        for (auth, account, secret) in [
            (AuthType::Password, "tester", Some("secret")),
            (AuthType::Account, "tester:secret", None),
        ] {
            let before = login(auth, account, secret);
            let mut after = before.clone();
            assert!(Redactor::new().redact(&mut after).bytes > 0);
            assert!(!contains(&after, "tester") && !contains(&after, "secret"));
            assert_eq!(after.len(), before.len());
            assert_eq!(
                Packet::parse(&after).expect("still a packet").verify(),
                Verified::Clear
            );
        }
    }

    #[test]
    fn a_damaged_login_keeps_nothing() {
        let mut bytes = login(AuthType::Password, "tester", Some("secret"));
        bytes[20] = 0xFF;
        Redactor::new().redact(&mut bytes);
        assert!(!contains(&bytes, "tester") && !contains(&bytes, "secret"));
    }

    /// A character list with `n` characters, so that the account falls at different places of the fragments.
    fn character_list(n: usize, name: &str, account: &str) -> Vec<u8> {
        fn text(out: &mut Vec<u8>, s: &str) {
            out.extend((s.len() as u16).to_le_bytes());
            out.extend(s.bytes());
            out.resize(out.len().next_multiple_of(4), 0);
        }
        let mut m = Vec::new();
        m.extend(CHARACTER_LIST.to_le_bytes());
        m.extend(0u32.to_le_bytes());
        m.extend((n as u32).to_le_bytes());
        for i in 0..n {
            m.extend((0x5000_0000 + i as u32).to_le_bytes());
            text(&mut m, name);
            m.extend(0u32.to_le_bytes());
        }
        m.extend(0u32.to_le_bytes());
        m.extend(11u32.to_le_bytes());
        text(&mut m, account);
        m.extend(1u32.to_le_bytes());
        m.extend(1u32.to_le_bytes());
        m
    }

    #[test]
    fn accounts_in_character_lists_go_wherever_they_fall() {
        let mut redactor = Redactor::new();
        redactor.redact(&mut login(
            AuthType::Password,
            "longaccountname",
            Some("secret"),
        ));
        for n in 0..60 {
            for name in ["A", "Abcdefg", "Bcdefghijkl"] {
                let message = character_list(n, name, "LongAccountName");
                let count = message.len().div_ceil(FRAGMENT_DATA) as u16;
                let mut shown = Vec::new();
                for (i, data) in message.chunks(FRAGMENT_DATA).enumerate() {
                    let fragment = FragmentHeader {
                        sequence: 9,
                        id: 0x8000_0000,
                        count,
                        size: 0,
                        index: i as u16,
                        queue: Queue::UI,
                    };
                    let flags = PacketFlags::BLOB_FRAGMENTS | PacketFlags::ENCRYPTED_CHECKSUM;
                    let header = PacketHeader {
                        sequence: 3,
                        flags,
                        ..PacketHeader::default()
                    };
                    let mut bytes = PacketBuilder::new()
                        .start(&OptionalHeaders::default())
                        .fragment(fragment, data)
                        .finish(header, Some(0x1234_5678))
                        .to_vec();
                    redactor.redact(&mut bytes);
                    let packet = Packet::parse(&bytes).expect("still a packet");
                    assert_eq!(packet.verify(), Verified::Encrypted(0x1234_5678));
                    shown.extend(packet.fragments().map(|f| f.data.to_vec()));
                }
                let all = shown.concat();
                assert!(
                    !contains(&all, "longaccountname"),
                    "{n} characters named {name}"
                );
                assert_eq!(
                    all.iter().zip(&message).filter(|(a, b)| a != b).count(),
                    "longaccountname".len()
                );
            }
        }
    }
}
