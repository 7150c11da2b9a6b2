//! Messages from fragments (`spec/09`, 8.3 and 15).

use super::fragment::{FRAGMENT_DATA, Fragment, Queue};

/// A complete game message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Sequence and id of its fragments.
    pub blob_id: u64,
    /// Queue of its first fragment.
    pub queue: Queue,
    /// Opcode and body.
    pub bytes: Vec<u8>,
}

impl Message {
    /// The opcode; `None` for fewer than four bytes.
    pub fn opcode(&self) -> Option<u32> {
        self.bytes.first_chunk().map(|b| u32::from_le_bytes(*b))
    }
}

/// Bounds of what a reassembler keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReassemblyLimits {
    /// Fragments of one message.
    pub fragments: u16,
    /// Partial messages at once.
    pub partial: usize,
    /// Bytes of all partial messages.
    pub bytes: usize,
    /// Age of a partial message, s.
    pub age: f64,
}

impl Default for ReassemblyLimits {
    fn default() -> Self {
        Self {
            fragments: 2048,
            partial: 64,
            bytes: 4 << 20,
            age: 60.0,
        }
    }
}

/// Something odd about a fragment; the message it belongs to is not complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReassemblyNote {
    /// Count 0, index beyond the count, or a wrong amount of data: dropped.
    Malformed,
    /// More fragments than allowed: dropped.
    TooMany,
    /// This index is there already: dropped, the first copy stays.
    Repeated,
    /// Another count than before under the same key: the old entry was dropped.
    CountChanged,
}

struct Partial {
    blob_id: u64,
    queue: Option<Queue>,
    since: f64,
    parts: Vec<Option<Box<[u8]>>>,
    missing: usize,
    bytes: usize,
}

/// Collects fragments until messages are complete. Memory is bounded; the oldest partial message goes first.
#[derive(Default)]
pub struct Reassembler {
    limits: ReassemblyLimits,
    /// Oldest first.
    partial: Vec<Partial>,
    bytes: usize,
    dropped: u64,
}

impl Reassembler {
    /// A reassembler with its own bounds.
    pub fn new(limits: ReassemblyLimits) -> Self {
        Self {
            limits,
            ..Self::default()
        }
    }

    /// Partial messages that were dropped: too old, or too many.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Partial messages that are kept now.
    pub fn pending(&self) -> usize {
        self.partial.len()
    }

    /// Takes a fragment at time `now` (s) and answers with the message that it completes.
    ///
    /// # Errors
    /// A note about a fragment that completes nothing because something is wrong with it.
    pub fn push(
        &mut self,
        fragment: &Fragment<'_>,
        now: f64,
    ) -> Result<Option<Message>, ReassemblyNote> {
        let h = &fragment.header;
        let last = h.index.checked_add(1) == Some(h.count);
        let whole = if last {
            fragment.data.len() <= FRAGMENT_DATA
        } else {
            fragment.data.len() == FRAGMENT_DATA
        };
        if h.count == 0 || h.index >= h.count || !whole {
            return Err(ReassemblyNote::Malformed);
        }
        if h.count > self.limits.fragments {
            return Err(ReassemblyNote::TooMany);
        }
        if h.count == 1 {
            return Ok(Some(Message {
                blob_id: h.blob_id(),
                queue: h.queue,
                bytes: fragment.data.to_vec(),
            }));
        }
        self.push_part(fragment, now)
    }

    fn push_part(
        &mut self,
        fragment: &Fragment<'_>,
        now: f64,
    ) -> Result<Option<Message>, ReassemblyNote> {
        let h = &fragment.header;
        let age = self.limits.age;
        self.drop_where(|p| now - p.since > age);
        let mut note = None;
        let found = self.partial.iter().position(|p| p.blob_id == h.blob_id());
        let found = found.filter(|&at| {
            let same = self.partial[at].parts.len() == usize::from(h.count);
            note = (!same).then_some(ReassemblyNote::CountChanged);
            same
        });
        if note.is_some() {
            self.drop_where(|p| p.blob_id == h.blob_id());
        }
        let at = found.unwrap_or_else(|| {
            let count = usize::from(h.count);
            let parts = core::iter::repeat_with(|| None).take(count).collect();
            self.partial.push(Partial {
                blob_id: h.blob_id(),
                queue: None,
                since: now,
                parts,
                missing: count,
                bytes: 0,
            });
            self.partial.len() - 1
        });
        let entry = &mut self.partial[at];
        let part = &mut entry.parts[usize::from(h.index)];
        if part.is_some() {
            return Err(ReassemblyNote::Repeated);
        }
        *part = Some(fragment.data.into());
        entry.missing -= 1;
        entry.bytes += fragment.data.len();
        self.bytes += fragment.data.len();
        if h.index == 0 {
            entry.queue = Some(h.queue);
        }
        if entry.missing == 0 {
            return Ok(Some(self.complete(at)));
        }
        self.keep_bounds(h.blob_id());
        note.map_or(Ok(None), Err)
    }

    fn complete(&mut self, at: usize) -> Message {
        let entry = self.partial.remove(at);
        self.bytes -= entry.bytes;
        let mut bytes = Vec::with_capacity(entry.bytes);
        entry
            .parts
            .iter()
            .flatten()
            .for_each(|part| bytes.extend_from_slice(part));
        Message {
            blob_id: entry.blob_id,
            queue: entry.queue.unwrap_or(Queue::INVALID),
            bytes,
        }
    }

    /// Drops the oldest other partial messages until the bounds hold.
    fn keep_bounds(&mut self, newest: u64) {
        while self.partial.len() > self.limits.partial || self.bytes > self.limits.bytes {
            let Some(oldest) = self
                .partial
                .iter()
                .map(|p| p.blob_id)
                .find(|&id| id != newest)
            else {
                break;
            };
            self.drop_where(|p| p.blob_id == oldest);
        }
    }

    fn drop_where(&mut self, gone: impl Fn(&Partial) -> bool) {
        let before = self.partial.len();
        self.partial.retain(|p| !gone(p));
        self.dropped += (before - self.partial.len()) as u64;
        self.bytes = self.partial.iter().map(|p| p.bytes).sum();
    }
}

impl core::fmt::Debug for Reassembler {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Reassembler")
            .field("pending", &self.partial.len())
            .field("bytes", &self.bytes)
            .finish()
    }
}
