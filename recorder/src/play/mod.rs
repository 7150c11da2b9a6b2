//! `ac-record play`: a client without a screen that follows a script (`docs/packet-sessions.md`).

pub mod account;
pub mod script;
pub mod shell;
