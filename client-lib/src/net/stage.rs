//! The network stage of a frame: complete messages act on the world, and what was odd is counted (`spec/10-messages.md`, 9.7 and 14).
//!
//! A message that cannot be read, or that holds numbers that are none, changes nothing but a counter.

use super::entities::{Dropped, GameEntities, Verdict};
use super::messages::{MessageError, ServerMessage};
use crate::world::World;

/// Seconds in portal space without a position after which it is reported (9.5).
pub const PORTAL_TIMEOUT: f64 = 30.0;

/// What came of the messages so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs, reason = "the names say it")]
pub struct StageStats {
    pub messages: u64,
    pub applied: u64,
    pub kept: u64,
    pub dropped: u64,
    /// Of these: a counter was not newer, or the echo of the own input.
    pub stale: u64,
    /// Of these: numbers that are none.
    pub invalid: u64,
    pub unreadable: u64,
    /// Messages whose layout is not read.
    pub unread: u64,
    /// Messages with bits that no layout knows.
    pub unknown_bits: u64,
    /// Messages with bytes behind their end.
    pub with_extra_bytes: u64,
    pub event_gaps: u64,
}

/// Something to tell a person.
#[derive(Debug, Clone, PartialEq)]
pub enum StageNote {
    /// A message cannot be read.
    Unreadable(MessageError),
    /// A message had no effect.
    Dropped {
        /// Which.
        name: String,
        /// Why.
        why: Dropped,
    },
    /// Events are missing: the number that was expected, and the one that came.
    EventGap {
        /// Expected.
        expected: u32,
        /// Found.
        found: u32,
    },
    /// The player is in portal space for [`PORTAL_TIMEOUT`], and no position came.
    StuckInPortalSpace,
}

/// Applies messages to a world, in order.
#[derive(Debug)]
pub struct NetworkStage {
    /// The objects that the server has described.
    pub entities: GameEntities,
    /// Counters.
    pub stats: StageStats,
    /// What to tell, in order; the host empties the list.
    pub notes: Vec<StageNote>,
    last_event: Option<u32>,
    portal_since: Option<f64>,
    portal_reported: bool,
}

/// Notes that are kept if nobody takes them.
const MAX_NOTES: usize = 1024;

impl Default for NetworkStage {
    fn default() -> Self {
        Self::new()
    }
}

impl NetworkStage {
    /// Nothing was received yet.
    pub fn new() -> Self {
        Self {
            entities: GameEntities::new(),
            stats: StageStats::default(),
            notes: Vec::new(),
            last_event: None,
            portal_since: None,
            portal_reported: false,
        }
    }

    /// Applies a complete message, opcode first. Answers the message, if it can be read, and what it did.
    pub fn deliver(
        &mut self,
        bytes: &[u8],
        world: &mut World,
    ) -> Result<(ServerMessage, Verdict), MessageError> {
        self.stats.messages += 1;
        let parsed = match ServerMessage::parse(bytes) {
            Ok(parsed) => parsed,
            Err(error) => {
                self.stats.unreadable += 1;
                self.note(StageNote::Unreadable(error.clone()));
                return Err(error);
            }
        };
        let message = parsed.message;
        self.stats.with_extra_bytes += u64::from(!parsed.extra.is_empty());
        self.stats.unknown_bits += u64::from(message.has_unknown_bits());
        self.stats.unread += u64::from(message.is_unread());
        if let ServerMessage::Event { sequence, .. } = &message {
            self.count_event(*sequence);
        }
        let verdict = self.entities.apply(&message, world);
        self.count(&message, verdict);
        Ok((message, verdict))
    }

    fn count(&mut self, message: &ServerMessage, verdict: Verdict) {
        let stats = &mut self.stats;
        match verdict {
            Verdict::Applied => stats.applied += 1,
            Verdict::Kept => stats.kept += 1,
            Verdict::Other => {}
            Verdict::Dropped(why) => {
                stats.dropped += 1;
                match why {
                    Dropped::Old(_) | Dropped::Echo | Dropped::EarlierIncarnation => {
                        stats.stale += 1;
                    }
                    _ => {
                        stats.invalid += u64::from(why == Dropped::Invalid);
                        let name = message.name().into_owned();
                        self.note(StageNote::Dropped { name, why });
                    }
                }
            }
        }
    }

    /// Events are numbered without gaps within a session; a server may begin again at 1.
    fn count_event(&mut self, found: u32) {
        let expected = self.last_event.map(|last| last.wrapping_add(1));
        self.last_event = Some(found);
        let starts = found <= 1;
        if let Some(expected) = expected.filter(|&e| e != found && !starts) {
            self.stats.event_gaps += 1;
            self.note(StageNote::EventGap { expected, found });
        }
    }

    /// Work of every frame, after its messages, at the world's time: objects out of sight for long are forgotten, and a stay in portal space
    /// that does not end is reported once.
    pub fn end_of_frame(&mut self, world: &mut World) {
        self.entities.forget_unseen(world);
        if !self.entities.in_portal_space() {
            self.portal_since = None;
            self.portal_reported = false;
            return;
        }
        let now = world.clock.now;
        let since = *self.portal_since.get_or_insert(now);
        if now - since >= PORTAL_TIMEOUT && !self.portal_reported {
            self.portal_reported = true;
            self.note(StageNote::StuckInPortalSpace);
        }
    }

    /// Whether no message waits for its object.
    pub const fn waiting_is_empty(&self) -> bool {
        self.entities.waiting().is_empty()
    }

    fn note(&mut self, note: StageNote) {
        if self.notes.len() < MAX_NOTES {
            self.notes.push(note);
        }
    }
}

#[cfg(test)]
mod tests;
