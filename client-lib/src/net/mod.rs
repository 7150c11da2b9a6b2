//! The client's network: transport, sessions and messages.
//!
//! Everything is sans-IO: bytes and times go in, bytes and events come out. Sockets live at the edge, in the programs.
//!
//! Source: `spec/09-network.md`, `spec/10-messages.md`.

pub mod actions;
pub mod client;
pub mod entities;
pub mod messages;
pub mod session;
pub mod stage;
pub mod transport;
