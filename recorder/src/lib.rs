//! Recordings of client/server sessions: format, UDP relay, redaction, recovery (`spec/09-network.md`, 2 and 14).
//!
//! A recording is an MCAP file of raw datagrams: one channel per client, direction and server port. Secrets are overwritten before
//! anything reaches the disk; lengths, sequences and key words stay, so a recording still verifies.

pub mod cli;
pub mod clock;
pub mod counters;
pub mod decode;
pub mod demo_server;
pub mod disk;
pub mod error;
pub mod fault;
pub mod format;
#[doc(hidden)]
pub mod fuzzing;
pub mod measure;
pub mod pcap;
pub mod pictures;
pub mod play;
pub mod progress;
pub mod proxy;
pub mod relay;
pub mod scan;
pub mod secrets;
pub mod signals;
pub mod sockets;
pub mod stats;
