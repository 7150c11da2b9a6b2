//! The JSON form of a [`FrameState`]: one record of a trace.
//!
//! Two shapes exist. A *line* of an expected-state trace (`spec/scene-format.md`) is a record with `frame` and `time`. A
//! *message* of our trace files holds all records of one frame: `{"frame", "time", "entities": [record…]}`, the records
//! without `frame` and `time`.
//!
//! Reading has two paths with one result. `fast` reads the canonical form (fields in the order of the specification, no
//! white space), which is what the writer here and the oracles produce, without an intermediate tree. Whatever it does not
//! recognise goes to `tree`, which takes any valid JSON and says what is wrong in one that is not a record. A test holds
//! the two together.
//!
//! A [`MessageReader`] reads the messages of a channel one after another, only what is not as in the message before.
//!
//! Numbers are exact both ways: an f32 is written as the shortest decimal of its widened f64 and read by narrowing.

mod fast;
mod repeat;
pub mod schema;
mod tree;
mod write;

use ac_client::frame::state::{FrameState, FrameStates};

pub use repeat::MessageReader;
pub use write::{write_line, write_message, write_record};

/// What to do with fields that this version does not know.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unknown {
    /// They are errors: the file claims to be of a version that does not have them.
    #[default]
    Refuse,
    /// They are skipped: the file is of a newer version that may add fields.
    Skip,
}

/// A record that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct RecordError {
    /// Where in the JSON, e.g. `entities[2].contact_plane.n[1]`.
    pub path: String,
    /// What is wrong there.
    pub reason: String,
}

/// Reads one line of an expected-state trace into `state`, reusing its memory.
///
/// # Errors
/// When the line is no JSON object or not a record.
pub fn read_line(line: &[u8], unknown: Unknown, state: &mut FrameState) -> Result<(), RecordError> {
    if fast::line(line, state).is_some() {
        return Ok(());
    }
    tree::line(&parse(line)?, unknown, state)
}

/// Reads one message: the frame, its time and its records into `states`, reusing its memory.
///
/// # Errors
/// When the message is no JSON object or not of the form above.
pub fn read_message(
    message: &[u8],
    unknown: Unknown,
    states: &mut FrameStates,
) -> Result<(i32, f64), RecordError> {
    states.clear();
    if let Some(head) = fast::message(message, states) {
        return Ok(head);
    }
    states.clear();
    tree::message(&parse(message)?, unknown, states)
}

fn parse(text: &[u8]) -> Result<serde_json::Value, RecordError> {
    serde_json::from_slice(text).map_err(|error| RecordError {
        path: "record".into(),
        reason: error.to_string(),
    })
}

#[cfg(test)]
mod tests;
