//! Sessions: handshake, character selection, staying connected, leaving (`spec/09-network.md`, 11 to 13).
//!
//! Both sides are sans-IO state machines: datagrams and times go in, datagrams, messages and events come out.

mod client;
mod server;

pub use client::{ClientConfig, ClientEvent, ClientSession, ClientState, SessionFailure};
pub use server::{Login, ServerConfig, ServerEvent, ServerSession, ServerState};

/// Which of a server's two ports a datagram goes to or comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Port {
    /// The login port P.
    Login,
    /// The next one, P + 1.
    Next,
}

/// A datagram to send.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transmit {
    /// The server's port: for a client the destination, for a server the port to send from.
    pub port: Port,
    /// The datagram.
    pub bytes: Vec<u8>,
}

/// Opcodes of the messages that move a session from one state to the next (`spec/09`, 11.6).
#[allow(missing_docs, reason = "names of the field")]
pub mod opcode {
    pub const CHARACTER_LIST: u32 = 0xF658;
    pub const SERVER_NAME: u32 = 0xF7E1;
    pub const DDD_INTERROGATION: u32 = 0xF7E5;
    pub const DDD_INTERROGATION_RESPONSE: u32 = 0xF7E6;
    pub const DDD_END: u32 = 0xF7EA;
    pub const ENTER_WORLD_REQUEST: u32 = 0xF7C8;
    pub const SERVER_READY: u32 = 0xF7DF;
    pub const ENTER_WORLD: u32 = 0xF657;
    pub const CHARACTER_ERROR: u32 = 0xF659;
    pub const ACCOUNT_BOOTED: u32 = 0xF7DC;
    pub const ACCOUNT_BANNED: u32 = 0xF7C1;
    pub const CREATE_PLAYER: u32 = 0xF746;
    pub const CREATE_OBJECT: u32 = 0xF745;
    pub const PLAYER_TELEPORT: u32 = 0xF751;
    pub const LOG_OFF: u32 = 0xF653;
    pub const GAME_ACTION: u32 = 0xF7B1;
    pub const ACTION_LOGIN_COMPLETE: u32 = 0x00A1;
    pub const ACTION_PING: u32 = 0x01E9;
}
