//! Reads the messages of one channel, one after another.
//!
//! From frame to frame most of a record stays: an entity that walks changes its place and the frame of its animation, one that rests nothing.
//! [`MessageReader`] keeps the text of the message before with the values of its records, and reads only those fields whose text is another
//! one. The result is that of [`read_message`](super::read_message) for each message alone.

use ac_client::frame::state::{Fields, FrameStates};

use super::{
    RecordError, Unknown,
    fast::{Cursor, FIELDS, Part, Parts},
};

/// Reads messages that resemble each other.
#[derive(Debug, Default)]
pub struct MessageReader {
    /// The message before; empty if nothing can be taken from it.
    text: Vec<u8>,
    records: Vec<Known>,
    /// Its records.
    states: FrameStates,
}

/// A record of the message before.
#[derive(Clone, Debug, Default)]
struct Known {
    /// Where it begins in the text.
    start: usize,
    /// Its fields in the text.
    parts: Parts,
}

impl Known {
    /// Length of the text without the closing brace.
    fn length(&self) -> usize {
        self.parts.iter().map(|part| part.length as usize).sum()
    }
}

impl MessageReader {
    /// Reads one message: the frame, its time and its records into `states`, reusing its memory.
    ///
    /// # Errors
    /// As [`read_message`](super::read_message).
    pub fn read(
        &mut self,
        message: &[u8],
        unknown: Unknown,
        states: &mut FrameStates,
    ) -> Result<(i32, f64), RecordError> {
        if let Some(head) = self.fast(message) {
            states.copy_from(&self.states);
            return Ok(head);
        }
        self.text.clear();
        self.records.clear();
        self.states.clear();
        super::read_message(message, unknown, states)
    }

    fn fast(&mut self, message: &[u8]) -> Option<(i32, f64)> {
        let mut cursor = Cursor { text: message };
        let (frame, time) = cursor.message_head()?;
        let mut count = 0;
        if cursor.literal(b"]").is_none() {
            loop {
                self.record(&mut cursor, message.len(), count, frame, time)?;
                count += 1;
                if cursor.literal(b",").is_none() {
                    break;
                }
            }
            cursor.literal(b"]")?;
        }
        cursor.literal(b"}")?;
        if !cursor.text.is_empty() {
            return None;
        }
        self.records.truncate(count);
        self.states.truncate(count);
        self.text.clear();
        self.text.extend_from_slice(message);
        Some((frame, time))
    }

    /// Reads record `index` of a message of `length` bytes.
    fn record(
        &mut self,
        cursor: &mut Cursor<'_>,
        length: usize,
        index: usize,
        frame: i32,
        time: f64,
    ) -> Option<()> {
        let start = length - cursor.text.len();
        if let (Some(known), Some(state)) =
            (self.records.get_mut(index), self.states.get_mut(index))
        {
            let text = self.text.get(known.start..known.start + known.length() + 1);
            let mut ahead = Cursor { text: cursor.text };
            let same = text.and_then(|text| {
                changes(text, &mut known.parts, &mut ahead, |field, cursor| {
                    cursor.value(field, state)
                })
            });
            if let Some(has) = same {
                (state.has, state.frame, state.time) = (has, frame, time);
                known.start = start;
                cursor.text = ahead.text;
                return Some(());
            }
            state.reset(frame, time, 0);
            known.start = start;
            return cursor.record(state, &mut known.parts);
        }
        let state = self.states.push(frame, time, 0);
        self.records.push(Known {
            start,
            parts: [Part::default(); FIELDS.len()],
        });
        cursor.record(state, &mut self.records.last_mut()?.parts)
    }
}

/// Goes over a record whose fields are those of `text`, which ends with the closing brace, and reads the values that are others. `None` if
/// it has other fields, or is not canonical.
fn changes(
    text: &[u8],
    parts: &mut Parts,
    cursor: &mut Cursor<'_>,
    mut read: impl FnMut(usize, &mut Cursor<'_>) -> Option<Fields>,
) -> Option<Fields> {
    let mut old = text;
    let mut has = Fields::empty();
    // Bytes from here on that are known to be the same.
    let mut same = common_prefix(old, cursor.text);
    for (field, part) in parts.iter_mut().enumerate() {
        let length = part.length as usize;
        if length == 0 {
            continue;
        }
        if same > length {
            // Also what follows: the value ends where it did.
            same -= length;
            cursor.text = &cursor.text[length..];
        } else {
            let before = cursor.text.len();
            cursor.literal(FIELDS[field])?;
            part.has = read(field, cursor)?;
            part.length = u32::try_from(before - cursor.text.len()).ok()?;
            same = common_prefix(&old[length..], cursor.text);
        }
        old = &old[length..];
        has |= part.has;
    }
    cursor.literal(b"}")?;
    Some(has)
}

/// How many bytes two texts have in common at their beginning.
#[inline]
fn common_prefix(a: &[u8], b: &[u8]) -> usize {
    const WORD: usize = size_of::<u64>();
    let (words, others) = (a.as_chunks::<WORD>().0, b.as_chunks::<WORD>().0);
    for (index, (a, b)) in words.iter().zip(others).enumerate() {
        let differ = u64::from_le_bytes(*a) ^ u64::from_le_bytes(*b);
        if differ != 0 {
            return index * WORD + differ.trailing_zeros() as usize / 8;
        }
    }
    let start = words.len().min(others.len()) * WORD;
    let rest = a[start..].iter().zip(&b[start..]);
    start + rest.take_while(|(a, b)| a == b).count()
}

#[cfg(test)]
mod tests {
    use ac_client::frame::FrameState;
    use proptest::prelude::*;

    use super::*;
    use crate::record::{read_message, write_message};

    fn same(a: &[FrameState], b: &[FrameState]) -> bool {
        a.len() == b.len()
            && a.iter().zip(b).all(|(a, b)| {
                a.same_bits(b)
                    && a.anim.is_some() == b.anim.is_some()
                    && (&a.steps, &a.collisions, &a.events) == (&b.steps, &b.collisions, &b.events)
            })
    }

    /// Reads messages one after another, and each alone.
    fn check(messages: &[Vec<u8>]) {
        let mut reader = MessageReader::default();
        let (mut states, mut alone) = (FrameStates::new(), FrameStates::new());
        for message in messages {
            let a = reader.read(message, Unknown::Refuse, &mut states);
            let b = read_message(message, Unknown::Refuse, &mut alone);
            let text = String::from_utf8_lossy(message);
            assert_eq!(format!("{a:?}"), format!("{b:?}"), "{text}");
            if a.is_ok() {
                assert!(same(&states, &alone), "{text}\n{states:?}\n{alone:?}");
            }
        }
    }

    const RECORDS: [&str; 8] = [
        r#"{"guid":"0x1","cell":"0x7","origin":[1,2,3],"state":"0x408","steps":[],"events":[]}"#,
        r#"{"guid":"0x1","cell":"0x7","origin":[1,2,3.5],"state":"0x408","steps":[{"dt":0.5,"outcome":"ok"}],"events":[]}"#,
        r#"{"guid":"0x1","cell":"0x7","origin":[1,2,3.55],"state":"0x4080","steps":[],"events":["hit_ground"]}"#,
        r#"{"guid":"0x1","cell":"0x7","origin":[1,2,3],"state":"0x408","contact_plane":null,"steps":[],"events":[]}"#,
        r#"{"guid":"0x1","cell":"0x7","contact_plane":{"n":[0,0,1],"d":-60,"cell":"0x7"},"sliding_normal":null,"anim":{"frame_number":1.25,"id":"0x3","first_cyclic":true,"queue":["0x3"],"velocity":[0,6,0],"omega":[0,0,0]}}"#,
        r#"{"guid":"0x1","cell":"0x7","contact_plane":{"n":[0,0,1],"d":-60,"cell":"0x70"},"sliding_normal":[1,0,0],"anim":null}"#,
        r#"{"guid":"0x2","cell":"0x0","events":[]}"#,
        r#"{"guid":"0x2","cell":"0x0","events":[],"origin":[1,2,3]}"#,
    ];

    proptest! {
        /// Whatever follows whatever, and however it is damaged.
        #[test]
        fn the_message_before_does_not_matter(
            frames in prop::collection::vec(
                (prop::collection::vec(0..RECORDS.len(), 0..4), 0..200_usize, any::<u8>()),
                1..12,
            ),
        ) {
            let mut messages: Vec<Vec<u8>> = Vec::new();
            for (frame, (records, at, byte)) in frames.iter().enumerate() {
                let records: Vec<&str> = records.iter().map(|r| RECORDS[*r]).collect();
                let text = format!(r#"{{"frame":{frame},"time":0.5,"entities":[{}]}}"#, records.join(","));
                let mut message = text.into_bytes();
                // One in four is damaged.
                if byte % 4 == 0 && *at < message.len() {
                    message[*at] = *byte;
                }
                messages.push(message);
            }
            check(&messages);
        }
    }

    #[test]
    fn every_bundled_message_is_read_as_if_alone() {
        use crate::{
            corpus,
            trace::{TraceEvent, TraceReader},
        };

        for name in ["terrain/cliff-jump", "lifecycle/many", "motion/idle"] {
            let path = corpus::bundled().join(format!("traces/{name}.mcap"));
            if !path.is_file() {
                continue;
            }
            let mut reader = TraceReader::open(&path).unwrap();
            let mut states = FrameStates::new();
            let mut messages = Vec::new();
            while let Some(event) = reader.next_event(&mut states).unwrap() {
                if let TraceEvent::States { frame, time, .. } = event {
                    let mut text = Vec::new();
                    write_message(&mut text, frame, time, &states);
                    messages.push(text);
                }
            }
            check(&messages);
        }
    }

    #[test]
    fn prefixes_are_counted() {
        assert_eq!(common_prefix(b"", b"abc"), 0);
        assert_eq!(common_prefix(b"abcdefgh12", b"abcdefgh13"), 9);
        assert_eq!(common_prefix(b"abcdXfgh12", b"abcdefgh12"), 4);
        assert_eq!(common_prefix(b"abcdefgh", b"abcdefghij"), 8);
    }
}
