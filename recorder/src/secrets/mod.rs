//! Removal of secrets before anything is kept (`spec/09-network.md`, 14).
//!
//! A [`Guard`] sees every datagram of one client in both directions and hands back what may be written. Three layers, each behind the
//! other:
//!
//! 1. the [`Redactor`] follows the structure: LoginRequests and the messages that carry an account name;
//! 2. a client's datagram that cannot be followed (malformed, a wrong clear checksum, bytes after its end) could be a damaged LoginRequest:
//!    nothing of its payload is kept;
//! 3. every text that a LoginRequest showed to be secret is overwritten wherever else it turns up, whoever sent it ([`Secrets`]).
//!
//! Lengths, sequences and key words stay; checksums are repaired, and a wrong one stays wrong.

mod known;

use std::sync::{Arc, Mutex, PoisonError};

use ac_client::net::transport::{
    AuthType, HEADER_LENGTH, LoginRequest, OptionalHeaders, Packet, PacketBuilder, PacketFlags,
    PacketHeader, REDACTED, Redactor, Verified,
};

pub use known::{LONG, Searcher, Secrets, is_searchable};

/// What is done with secrets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SecretPolicy {
    /// They are overwritten, same length.
    Redact {
        /// LoginRequests are also replaced by one for account and password "x", so that the lengths are gone too.
        hide_length: bool,
    },
    /// They are kept; the file says so.
    Keep,
}

impl Default for SecretPolicy {
    fn default() -> Self {
        Self::Redact { hide_length: false }
    }
}

impl SecretPolicy {
    /// The word for it in a recording's metadata.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Redact { hide_length: false } => "redacted",
            Self::Redact { hide_length: true } => "redacted, lengths hidden",
            Self::Keep => KEPT,
        }
    }
}

/// The word in the metadata of a recording that holds secrets.
pub const KEPT: &str = "kept";

/// Secrets that all guards of a recording share, and that the self-check searches for.
pub type SharedSecrets = Arc<Mutex<Secrets>>;

/// The secrets, also after a panic elsewhere: they only grow.
pub fn locked(secrets: &SharedSecrets) -> std::sync::MutexGuard<'_, Secrets> {
    secrets.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Lets through what may be written of one client's datagrams.
pub struct Guard {
    policy: SecretPolicy,
    redactor: Redactor,
    secrets: SharedSecrets,
    searcher: Searcher,
}

impl Guard {
    /// A guard for one client of a recording.
    pub fn new(policy: SecretPolicy, secrets: SharedSecrets) -> Self {
        Self {
            policy,
            redactor: Redactor::new(),
            secrets,
            searcher: Searcher::default(),
        }
    }

    /// Writes what may be kept of a datagram into `out`, which is cleared first. Returns the number of secret bytes.
    pub fn clean(&mut self, to_server: bool, datagram: &[u8], out: &mut Vec<u8>) -> usize {
        out.clear();
        out.extend_from_slice(datagram);
        let SecretPolicy::Redact { hide_length } = self.policy else {
            return 0;
        };
        if to_server {
            learn(datagram, &self.secrets);
            if !can_be_followed(datagram) {
                return overwrite_payload(out);
            }
        }
        let mut hidden = self.redactor.redact(out).bytes;
        if to_server && hide_length && hidden > 0 {
            hide_login_length(out);
        }
        locked(&self.secrets).update(&mut self.searcher);
        hidden += self.searcher.scrub(out);
        hidden
    }
}

/// Remembers what a LoginRequest shows to be secret, even when its checksum is wrong.
pub fn learn(datagram: &[u8], secrets: &SharedSecrets) {
    if let Ok(packet) = Packet::parse(datagram)
        && let Some(Ok(login)) = packet.optional.login.map(LoginRequest::parse)
    {
        locked(secrets).learn(&login);
    }
}

/// Whether a client's datagram is a packet whose secrets have a known place. A LoginRequest must be as this library writes it, to the byte:
/// what comes after its last known field could be anything.
fn can_be_followed(datagram: &[u8]) -> bool {
    let Ok(packet) = Packet::parse(datagram) else {
        return false;
    };
    if packet.trailing > 0 || packet.verify() == Verified::Wrong {
        return false;
    }
    let Some(payload) = packet.optional.login else {
        return !packet.header.flags.contains(PacketFlags::LOGIN_REQUEST);
    };
    packet.verify() == Verified::Clear
        && LoginRequest::parse(payload)
            .is_ok_and(|login| login.to_bytes().is_ok_and(|b| b.len() == payload.len()))
}

fn overwrite_payload(datagram: &mut [u8]) -> usize {
    let payload = datagram.get_mut(HEADER_LENGTH..).unwrap_or_default();
    payload.fill(REDACTED);
    payload.len()
}

/// Replaces a LoginRequest by one whose account and password are "x".
fn hide_login_length(datagram: &mut Vec<u8>) {
    let Some(bytes) = canonical_login(datagram) else {
        return;
    };
    *datagram = bytes;
}

fn canonical_login(datagram: &[u8]) -> Option<Vec<u8>> {
    let packet = Packet::parse(datagram).ok()?;
    let login = LoginRequest::parse(packet.optional.login?).ok()?;
    let payload = LoginRequest {
        account: "x".into(),
        account_override: String::new(),
        secret: (login.auth != AuthType::Account).then(|| "x".into()),
        ..login
    }
    .to_bytes()
    .ok()?;
    let optional = OptionalHeaders {
        login: Some(&payload),
        ..OptionalHeaders::default()
    };
    let flags = packet.header.flags.difference(
        PacketFlags::all().difference(PacketFlags::LOGIN_REQUEST | PacketFlags::RETRANSMISSION),
    );
    let header = PacketHeader {
        flags,
        ..packet.header
    };
    Some(
        PacketBuilder::new()
            .start(&optional)
            .finish(header, None)
            .to_vec(),
    )
}

#[cfg(test)]
mod tests;
