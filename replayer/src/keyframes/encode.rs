//! Keyframes as bytes: a line of JSON, then the snapshot compressed with zstd.

use std::io::Read;

use super::{KeyframeError, KeyframeHeader};

/// Longest header.
const MAX_HEADER: usize = 1 << 16;
/// Longest snapshot, bytes. A block with a few hundred static objects takes about 100 kB.
pub const MAX_SNAPSHOT: u64 = 64 << 20;
/// Level of the compression: keyframes are written while something runs.
const LEVEL: i32 = 3;
/// Window of the decompression, as a power of two: what a level that anyone would use needs.
const WINDOW: u32 = 24;

/// The bytes of a keyframe.
///
/// # Errors
/// When the snapshot is longer than [`MAX_SNAPSHOT`].
pub fn encode(header: &KeyframeHeader, snapshot: &[u8]) -> Result<Vec<u8>, KeyframeError> {
    if snapshot.len() as u64 > MAX_SNAPSHOT {
        return Err(KeyframeError::Format(format!(
            "the state of {} bytes is larger than the {MAX_SNAPSHOT} that a keyframe may have",
            snapshot.len()
        )));
    }
    let failed = |error: &dyn std::fmt::Display| KeyframeError::Format(error.to_string());
    let mut bytes = serde_json::to_vec(header).map_err(|error| failed(&error))?;
    bytes.push(b'\n');
    bytes.extend(zstd::bulk::compress(snapshot, LEVEL).map_err(|error| failed(&error))?);
    Ok(bytes)
}

/// The header of a keyframe and its snapshot, still compressed.
///
/// # Errors
/// When the bytes are no keyframe or of a version that this program does not read.
pub(super) fn split(bytes: &[u8]) -> Result<(KeyframeHeader, &[u8]), KeyframeError> {
    let end = bytes.iter().take(MAX_HEADER).position(|b| *b == b'\n');
    let Some((head, rest)) = end.and_then(|end| bytes.split_at_checked(end)) else {
        return Err(KeyframeError::Format("it has no header".into()));
    };
    let header = KeyframeHeader::parse(head)?;
    if header.length > MAX_SNAPSHOT {
        return Err(KeyframeError::Format(format!(
            "its header says {} bytes, more than the {MAX_SNAPSHOT} that a keyframe may have",
            header.length
        )));
    }
    Ok((header, &rest[1..]))
}

/// Reads a keyframe: its header and its snapshot.
///
/// # Errors
/// When the bytes are no keyframe, of a version that this program does not read, or damaged.
pub fn decode(bytes: &[u8]) -> Result<(KeyframeHeader, Vec<u8>), KeyframeError> {
    let (header, compressed) = split(bytes)?;
    let damaged = |error: std::io::Error| KeyframeError::Damaged(error.to_string());
    let mut decoder = zstd::Decoder::with_buffer(compressed).map_err(damaged)?;
    decoder.window_log_max(WINDOW).map_err(damaged)?;
    let mut snapshot = Vec::new();
    // One byte more than announced shows that there is more.
    decoder
        .take(header.length + 1)
        .read_to_end(&mut snapshot)
        .map_err(damaged)?;
    if snapshot.len() as u64 != header.length {
        return Err(KeyframeError::Damaged(format!(
            "its state does not have the {} bytes that its header says",
            header.length
        )));
    }
    if blake3::hash(&snapshot).to_string() != header.hash {
        let reason = "its state does not have the hash that its header says";
        return Err(KeyframeError::Damaged(reason.into()));
    }
    Ok((header, snapshot))
}
