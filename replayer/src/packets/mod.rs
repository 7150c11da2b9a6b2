//! Replays of packet recordings: recorded datagrams drive the client library (`docs/packet-sessions.md`).
//!
//! A recording ([`recording`]) is one client's session with a server. [`session`] turns its datagrams into complete messages in order, both
//! ways; [`clock`] says at which times the frames are; [`run`] delivers to each frame what had arrived by then: the server's messages to the
//! network stage, the client's own movement messages to the input stage. Everything else is the library's frame. The same file gives the
//! same bits.

pub mod clock;
pub mod command;
pub mod recording;
pub mod run;
pub mod session;
#[cfg(test)]
mod tests;
pub mod trace;

use std::path::PathBuf;

use ac_golden_traces::Scene;

pub use clock::FrameClock;
pub use recording::{Datagram, Recording, is_recording, recording_at};
pub use run::{PacketRun, ReplayStats, Reports};
pub use session::{DatagramStats, Session};
pub use trace::{Tracks, scene_of, write_expectation};

/// Tag of scenes that a packet recording drives.
pub const FEATURE: &str = "packets";
/// First part of their names.
pub const AREA: &str = "packets";

/// Whether a packet recording drives a scene.
pub fn drive(scene: &Scene) -> bool {
    scene.features.iter().any(|tag| tag == FEATURE)
}

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum PacketsError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is no packet recording.
    #[error("{}: no packet recording (it has no `ac-packets` metadata)", path.display())]
    NotARecording {
        /// The file.
        path: PathBuf,
    },
    /// The recording's format is not known.
    #[error("{}: packet format {found}, this program reads formats up to 2; use a newer one", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// The format.
        found: String,
    },
    /// The file is damaged from its start on.
    #[error("{}: {reason}; `ac-record recover` saves what can be read", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// There is nothing to replay.
    #[error("{}: {reason}", path.display())]
    NoSession {
        /// The file.
        path: PathBuf,
        /// What is missing, and what to do.
        reason: String,
    },
    /// The frames would be too many.
    #[error("{}: the session lasts {seconds:.0} s, that is more than {limit} frames; choose a lower rate with --clock fixed:HZ", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Length.
        seconds: f64,
        /// Most frames.
        limit: u32,
    },
}
