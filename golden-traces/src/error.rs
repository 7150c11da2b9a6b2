//! Everything that can go wrong with scenes and traces.

use std::path::PathBuf;

use crate::record::RecordError;

/// What went wrong, in which file, where in it.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A scene file is not what the format says.
    #[error("{}, {place}: {reason}", path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// Where in it, e.g. `script[3].guid`.
        place: String,
        /// What is wrong there.
        reason: String,
    },
    /// A line of a JSON Lines file is not what the format says.
    #[error("{}, line {line}: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// 1-based line number.
        line: u64,
        /// What is wrong there.
        reason: String,
    },
    /// A trace file is damaged or not of the container format.
    #[error("{}: not a readable trace: {reason}", path.display())]
    Container {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A trace file ends too early.
    #[error("{}: the trace is cut off; `mcap recover` can save its whole chunks, or write it again", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
    },
    /// A trace file is of a version that this program does not read.
    #[error("{}: trace format {found} cannot be read by this program, which reads {known}; {advice}", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Version of the file.
        found: String,
        /// Versions that are read.
        known: String,
        /// What to do.
        advice: &'static str,
    },
    /// A message of a trace file is not what its channel says.
    #[error("{}, channel {topic}, message {sequence}: {error}", path.display())]
    Message {
        /// The file.
        path: PathBuf,
        /// The channel.
        topic: String,
        /// Sequence number of the message.
        sequence: u32,
        /// What is wrong.
        error: RecordError,
    },
}
