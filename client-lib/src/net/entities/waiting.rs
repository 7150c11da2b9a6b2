//! Messages that came before their object (`spec/10-messages.md`, 3, instance check).
//!
//! A server sends a description first, but on another queue, or after a lost packet, a message may overtake it. It waits here, bounded, and is
//! applied right after the description.

use std::collections::BTreeMap;

use crate::net::messages::PlainServerMessage;

/// How many messages may wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WaitingLimits {
    /// For one object.
    pub per_object: usize,
    /// In all.
    pub total: usize,
}

impl Default for WaitingLimits {
    fn default() -> Self {
        Self {
            per_object: 16,
            total: 256,
        }
    }
}

/// Messages by the GUID that they wait for, in order of arrival.
#[derive(Debug, Default)]
pub struct Waiting {
    limits: WaitingLimits,
    messages: BTreeMap<u32, Vec<PlainServerMessage>>,
    count: usize,
    refused: u64,
}

impl Waiting {
    /// Messages that wait.
    pub const fn len(&self) -> usize {
        self.count
    }

    /// Whether none waits.
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Messages for which there was no room.
    pub const fn refused(&self) -> u64 {
        self.refused
    }

    /// Keeps a message; `false` if there is no room.
    pub(super) fn keep(&mut self, guid: u32, message: &PlainServerMessage) -> bool {
        let waiting = self.messages.get(&guid).map_or(0, Vec::len);
        if self.count >= self.limits.total || waiting >= self.limits.per_object {
            self.refused += 1;
            return false;
        }
        self.count += 1;
        self.messages.entry(guid).or_default().push(message.clone());
        true
    }

    /// The messages that waited for an object.
    pub(super) fn take(&mut self, guid: u32) -> Vec<PlainServerMessage> {
        let messages = self.messages.remove(&guid).unwrap_or_default();
        self.count -= messages.len();
        messages
    }
}

/// The object that a message describes.
pub(super) const fn describes(message: &PlainServerMessage) -> Option<u32> {
    match message {
        PlainServerMessage::CreateObject(o) | PlainServerMessage::UpdateObject(o) => Some(o.guid),
        _ => None,
    }
}

/// The object that a message has to wait for: its own, and of an attachment the parent, if that is not known either. Deletions do not wait.
pub(super) fn waits_for(
    message: &PlainServerMessage,
    is_known: impl Fn(u32) -> bool,
) -> Option<u32> {
    use PlainServerMessage as P;
    Some(match message {
        P::UpdatePosition(p) => p.guid,
        P::PositionAndMovement(p) => p.guid,
        P::ParentEvent(p) if is_known(p.child) => p.parent,
        P::ParentEvent(p) => p.child,
        P::PickupEvent(p) => p.guid,
        P::SetState(s) => s.guid,
        P::UpdateMotion(u) => u.guid,
        P::VectorUpdate(v) => v.guid,
        P::ObjDescEvent(o) => o.guid,
        _ => return None,
    })
}
