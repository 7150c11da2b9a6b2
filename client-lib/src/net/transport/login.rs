//! The LoginRequest's payload (`spec/09`, 11.1).

use encoding_rs::WINDOWS_1252;
use thiserror::Error;

/// How a client proves who it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AuthType {
    /// Account only; GDLE: the account string is `name:password`.
    Account,
    /// Account and password (ACE).
    Password,
    /// Ticket of the former login service.
    Ticket,
    /// Anything else.
    Other(u32),
}

impl AuthType {
    const fn from_wire(v: u32) -> Self {
        match v {
            1 => Self::Account,
            2 => Self::Password,
            0x4000_0002 => Self::Ticket,
            other => Self::Other(other),
        }
    }

    const fn to_wire(self) -> u32 {
        match self {
            Self::Account => 1,
            Self::Password => 2,
            Self::Ticket => 0x4000_0002,
            Self::Other(v) => v,
        }
    }
}

/// Why a LoginRequest cannot be read or written.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum LoginError {
    /// A field does not fit.
    #[error("login request: {field} at payload offset {offset} runs past the end ({length} bytes)")]
    Truncated {
        /// The field.
        field: &'static str,
        /// Where it starts.
        offset: usize,
        /// Bytes of the payload.
        length: usize,
    },
    /// A text is too long.
    #[error(
        "login request: {field} of {length} characters; servers read at most {limit}, choose a shorter one"
    )]
    TooLong {
        /// The field.
        field: &'static str,
        /// Its length.
        length: usize,
        /// The limit.
        limit: usize,
    },
    /// A text has characters outside code page 1252.
    #[error(
        "login request: {field} has characters outside code page 1252, which the protocol cannot carry"
    )]
    Characters {
        /// The field.
        field: &'static str,
    },
}

/// A client's login. Texts are code page 1252 on the wire.
#[derive(Clone, PartialEq, Eq)]
pub struct LoginRequest {
    /// "1802".
    pub version: String,
    /// How the client proves who it is.
    pub auth: AuthType,
    /// Bits: 1 enable crypto, 2 admin override, 4 extra data.
    pub auth_flags: u32,
    /// Any number.
    pub timestamp: u32,
    /// Account name.
    pub account: String,
    /// Account to log in as; normally empty.
    pub account_override: String,
    /// Password or ticket; `None` writes a zero word.
    pub secret: Option<String>,
}

/// Where the secrets of a LoginRequest lie in its payload.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct LoginLayout {
    pub account: core::ops::Range<usize>,
    pub account_override: core::ops::Range<usize>,
    pub secret: core::ops::Range<usize>,
}

fn word(b: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*b.get(at..)?.first_chunk()?))
}

/// Range of the characters of a string16 at `at`, and where the padded field ends.
fn string16(b: &[u8], at: usize) -> Option<(core::ops::Range<usize>, usize)> {
    let n = usize::from(u16::from_le_bytes(*b.get(at..)?.first_chunk()?));
    let end = at + 2 + n;
    (end <= b.len()).then(|| (at + 2..end, end.next_multiple_of(4)))
}

struct Parts {
    version: core::ops::Range<usize>,
    header: usize,
    layout: LoginLayout,
    secret_text: core::ops::Range<usize>,
    has_secret: bool,
}

fn parts(b: &[u8]) -> Result<Parts, LoginError> {
    let error = |field, offset| LoginError::Truncated {
        field,
        offset,
        length: b.len(),
    };
    let (version, header) = string16(b, 0).ok_or(error("client version", 0))?;
    if b.len() < header + 16 {
        return Err(error("authentication header", header));
    }
    let at = header + 16;
    let (account, at) = string16(b, at).ok_or(error("account", at))?;
    let (account_override, at) = string16(b, at).ok_or(error("account to log in as", at))?;
    let n = match word(b, at) {
        Some(n) => n as usize,
        // Some clients end after the account strings.
        None if at >= b.len() => 0,
        None => return Err(error("password length", at)),
    };
    let start = (at + 4).min(b.len());
    let secret = start
        ..start
            .checked_add(n)
            .filter(|&end| end <= b.len())
            .ok_or(error("password", start))?;
    // A packed length of one or two bytes precedes the characters.
    let prefix = match b.get(secret.clone()).and_then(|s| s.first()) {
        Some(first) if first & 0x80 != 0 => 2,
        Some(_) => 1,
        None => 0,
    };
    let secret_text = (secret.start + prefix.min(secret.len()))..secret.end;
    Ok(Parts {
        version,
        header,
        layout: LoginLayout {
            account,
            account_override,
            secret: secret.clone(),
        },
        secret_text,
        has_secret: n > 0,
    })
}

impl LoginLayout {
    /// Ranges of the secrets; `None` where the payload cannot be followed.
    pub(super) fn of(payload: &[u8]) -> Result<Self, LoginError> {
        parts(payload).map(|p| p.layout)
    }
}

impl LoginRequest {
    /// Reads a LoginRequest's payload.
    ///
    /// # Errors
    /// [`LoginError::Truncated`] names the field that runs past the end.
    pub fn parse(payload: &[u8]) -> Result<Self, LoginError> {
        let p = parts(payload)?;
        let text = |r: core::ops::Range<usize>| {
            WINDOWS_1252
                .decode_without_bom_handling(&payload[r])
                .0
                .into_owned()
        };
        let field = |i: usize| word(payload, p.header + i).unwrap_or_default();
        Ok(Self {
            version: text(p.version),
            auth: AuthType::from_wire(field(4)),
            auth_flags: field(8),
            timestamp: field(12),
            account: text(p.layout.account),
            account_override: text(p.layout.account_override),
            secret: p.has_secret.then(|| text(p.secret_text)),
        })
    }

    /// The payload's bytes.
    ///
    /// # Errors
    /// When a text is too long for servers to read or cannot be written in code page 1252.
    pub fn to_bytes(&self) -> Result<Vec<u8>, LoginError> {
        fn encode<'t>(
            text: &'t str,
            field: &'static str,
            limit: usize,
        ) -> Result<std::borrow::Cow<'t, [u8]>, LoginError> {
            let (bytes, _, bad) = WINDOWS_1252.encode(text);
            if bad {
                return Err(LoginError::Characters { field });
            }
            if bytes.len() > limit {
                return Err(LoginError::TooLong {
                    field,
                    length: bytes.len(),
                    limit,
                });
            }
            Ok(bytes)
        }
        fn string16(out: &mut Vec<u8>, text: &[u8]) {
            out.extend_from_slice(&(text.len() as u16).to_le_bytes());
            out.extend_from_slice(text);
            out.resize(out.len().next_multiple_of(4), 0);
        }
        let mut out = Vec::new();
        string16(&mut out, &encode(&self.version, "client version", 255)?);
        let length_at = out.len();
        for v in [0, self.auth.to_wire(), self.auth_flags, self.timestamp] {
            out.extend_from_slice(&v.to_le_bytes());
        }
        // GDLE logins carry the password in the account string.
        string16(&mut out, &encode(&self.account, "account", 200)?);
        string16(
            &mut out,
            &encode(&self.account_override, "account to log in as", 200)?,
        );
        match &self.secret {
            None => out.extend_from_slice(&0u32.to_le_bytes()),
            Some(secret) => {
                // ACE misreads the two-byte form of the packed length.
                let text = encode(secret, "password", 127)?;
                out.extend_from_slice(&(text.len() as u32 + 1).to_le_bytes());
                out.push(text.len() as u8);
                out.extend_from_slice(&text);
                out.resize(out.len().next_multiple_of(4), 0);
            }
        }
        let length = (out.len() - length_at - 4) as u32;
        out[length_at..length_at + 4].copy_from_slice(&length.to_le_bytes());
        Ok(out)
    }
}

impl core::fmt::Debug for LoginRequest {
    /// Without account and secret: logs are shared.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("LoginRequest")
            .field("version", &self.version)
            .field("auth", &self.auth)
            .finish_non_exhaustive()
    }
}
