//! Writes a trace again with other states in one of its channels; everything else in it is copied.

use std::{
    collections::{BTreeMap, HashMap},
    io::Cursor,
    path::Path,
};

use ac_client::frame::FrameStates;
use mcap::{McapResult, MessageStream, Summary, WriteOptions, records::MessageHeader};

use super::{
    ChannelHeader, ChannelKind,
    writer::{self, Compression},
};
use crate::{GoldenError, record};

/// States of one frame: its number, its time, the records.
pub type Frame = (i32, f64, FrameStates);

/// The bytes of a trace like `bytes`, in which the channel `kind` has exactly `frames`, in the places of the old ones.
/// `path` is what errors call the trace.
///
/// # Errors
/// When the trace cannot be read or has no such channel.
pub fn replace_states(
    bytes: &[u8],
    path: &Path,
    kind: &ChannelKind,
    header: &ChannelHeader,
    frames: &[Frame],
) -> Result<Vec<u8>, GoldenError> {
    let fail = |reason: String| GoldenError::Container {
        path: path.into(),
        reason,
    };
    let topic = kind.topic();
    let summary = Summary::read(bytes).map_err(|error| fail(error.to_string()))?;
    let summary = summary.ok_or_else(|| fail("it has no summary".into()))?;
    if !summary.channels.values().any(|of| of.topic == topic) {
        return Err(fail(format!("it has no channel {topic}")));
    }
    copy(bytes, &summary, &topic, header, frames).map_err(|error| fail(error.to_string()))
}

fn copy(
    bytes: &[u8],
    summary: &Summary,
    topic: &str,
    header: &ChannelHeader,
    frames: &[Frame],
) -> McapResult<Vec<u8>> {
    let mut out = options().create(Cursor::new(Vec::new()))?;
    for index in &summary.metadata_indexes {
        out.write_metadata(&mcap::read::metadata(bytes, index)?)?;
    }
    for index in &summary.attachment_indexes {
        out.attach(&mcap::read::attachment(bytes, index)?)?;
    }
    let mut channels: Vec<_> = summary.channels.iter().collect();
    channels.sort_by_key(|(id, _)| **id);
    let mut ids = HashMap::new();
    for (id, channel) in channels {
        let schema = match &channel.schema {
            Some(schema) => out.add_schema(&schema.name, &schema.encoding, &schema.data)?,
            None => 0,
        };
        let metadata = if channel.topic == topic {
            writer::header_metadata(header)
        } else {
            channel.metadata.clone()
        };
        let new = out.add_channel(schema, &channel.topic, &channel.message_encoding, &metadata)?;
        ids.insert(*id, new);
    }
    let by_sequence: BTreeMap<u32, &Frame> = frames
        .iter()
        .map(|frame| (writer::sequence(frame.0.into()), frame))
        .collect();
    let mut text = Vec::new();
    for message in MessageStream::new(bytes)? {
        let message = message?;
        let data = if message.channel.topic == topic {
            // A frame that is not there any more has no message.
            let Some((frame, time, states)) = by_sequence.get(&message.sequence) else {
                continue;
            };
            text.clear();
            record::write_message(&mut text, *frame, *time, states);
            &text[..]
        } else {
            &message.data[..]
        };
        let head = MessageHeader {
            channel_id: ids.get(&message.channel.id).copied().unwrap_or_default(),
            sequence: message.sequence,
            log_time: message.log_time,
            publish_time: message.publish_time,
        };
        out.write_to_known_channel(&head, data)?;
    }
    out.finish()?;
    Ok(out.into_inner().into_inner())
}

/// As every archived trace is written.
fn options() -> WriteOptions {
    writer::options(Compression::Archive)
}
