//! The trace format: one MCAP file per scene, holding the scene, its inputs, and per-frame states.
//!
//! `docs/trace-format.md` describes it for people and other programs. In short: every message is JSON with a JSON Schema
//! attached; log times are the scene's clock, never a wall clock, so the same content gives the same bytes; chunks are
//! compressed with zstd, carry checksums and are indexed.
//!
//! | topic | one message per | content |
//! |---|---|---|
//! | `/clock` | run of equal frames | `{frame, dt, count}` |
//! | `/script` | input | a step of the scene's script |
//! | `/states` | frame | what the client library produced |
//! | `/expect/ORACLE` | frame | what an oracle expects |
//! | `/stages/ORACLE` | frame | stage checkpoints |
//!
//! The scene file itself is the attachment `scene.json`. A metadata record `ac-trace` says which version of the format this
//! is ([`version`]), who wrote it, and the hashes of the world's files.

mod reader;
pub mod rewrite;
mod seek;
pub mod version;
mod writer;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::expect::Header;

pub use reader::{ChannelFilter, StageMessage, TraceEvent, TraceReader};
pub use seek::SeekableTrace;
pub use version::FormatVersion;
pub use writer::{Compression, TraceWriter};

/// Name of the metadata record.
pub const METADATA: &str = "ac-trace";
/// Name of the attachment with the scene.
pub const SCENE_ATTACHMENT: &str = "scene.json";

/// What the metadata record says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceInfo {
    /// Version of the format.
    pub version: FormatVersion,
    /// Name of the scene.
    pub scene: String,
    /// Program that wrote the file.
    pub producer: String,
    /// Profile under which `/states` was produced; empty in files without it.
    pub profile: String,
    /// BLAKE3 of each file of the world, by file name.
    pub world: BTreeMap<String, String>,
}

/// What a channel holds.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ChannelKind {
    /// Frame lengths.
    Clock,
    /// Inputs.
    Script,
    /// Produced states.
    States,
    /// Expected states of this oracle.
    Expect(String),
    /// Stage checkpoints of this oracle.
    Stages(String),
}

impl ChannelKind {
    /// The topic.
    pub fn topic(&self) -> String {
        match self {
            Self::Clock => "/clock".into(),
            Self::Script => "/script".into(),
            Self::States => "/states".into(),
            Self::Expect(oracle) => format!("/expect/{oracle}"),
            Self::Stages(oracle) => format!("/stages/{oracle}"),
        }
    }

    /// The kind of a topic; `None` for topics that other programs may have added.
    pub fn of(topic: &str) -> Option<Self> {
        Some(match topic {
            "/clock" => Self::Clock,
            "/script" => Self::Script,
            "/states" => Self::States,
            _ => {
                let (kind, oracle) = topic.strip_prefix('/')?.split_once('/')?;
                match kind {
                    "expect" => Self::Expect(oracle.into()),
                    "stages" => Self::Stages(oracle.into()),
                    _ => return None,
                }
            }
        })
    }
}

/// A message of `/clock`: frames of the same length, from `frame` on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClockRun {
    /// First frame of the run.
    pub frame: u32,
    /// Seconds by which the clock advances before each frame.
    pub dt: f64,
    /// Number of frames.
    pub count: u32,
}

/// What a channel of expectations or stages says about itself, beside its messages.
pub type ChannelHeader = Header;

#[cfg(test)]
mod tests;
