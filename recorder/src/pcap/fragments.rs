//! Datagrams from IP fragments, in bounded memory.
//!
//! Fragments may come in any order and twice. One that overlaps others in any other way spoils its datagram, as RFC 5722 asks for.

use std::collections::BTreeMap;
use std::net::IpAddr;

/// Largest payload of an IP packet.
const LARGEST: usize = 65_535;

/// Which datagram a fragment belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FragmentKey {
    /// Sender.
    pub from: IpAddr,
    /// Receiver.
    pub to: IpAddr,
    /// Identification.
    pub id: u32,
}

/// Bounds of what is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FragmentLimits {
    /// Datagrams that are not complete, at once; the oldest goes first.
    pub datagrams: usize,
    /// Bytes of them.
    pub bytes: usize,
    /// Age of a datagram, ns.
    pub age: u64,
}

impl Default for FragmentLimits {
    fn default() -> Self {
        Self {
            datagrams: 256,
            bytes: 4 << 20,
            age: 30_000_000_000,
        }
    }
}

struct Partial {
    key: FragmentKey,
    since: u64,
    parts: BTreeMap<usize, Vec<u8>>,
    fragments: usize,
    bytes: usize,
    length: Option<usize>,
}

/// Puts datagrams together.
pub struct Fragments {
    limits: FragmentLimits,
    /// Oldest first.
    partial: Vec<Partial>,
    bytes: usize,
    lost: usize,
}

impl Fragments {
    /// With bounds of its own.
    pub const fn new(limits: FragmentLimits) -> Self {
        Self {
            limits,
            partial: Vec::new(),
            bytes: 0,
            lost: 0,
        }
    }

    /// Fragments that never became part of a whole datagram, those that still wait included.
    pub fn lost(&self) -> usize {
        self.lost + self.partial.iter().map(|p| p.fragments).sum::<usize>()
    }

    /// Bytes that are kept.
    pub const fn bytes(&self) -> usize {
        self.bytes
    }

    /// Takes a fragment that was captured at `time`, ns; hands out the IP payload that it completes.
    pub fn push(
        &mut self,
        key: FragmentKey,
        offset: usize,
        more: bool,
        data: &[u8],
        time: u64,
    ) -> Option<Vec<u8>> {
        self.forget_old(time);
        let end = offset + data.len();
        if data.is_empty() || end > LARGEST || (more && !data.len().is_multiple_of(8)) {
            self.lost += 1;
            return None;
        }
        let at = self.entry(key, time);
        let partial = &mut self.partial[at];
        partial.fragments += 1;
        match partial.add(offset, end, more, data) {
            Added::Spoiled => {
                self.drop_at(at);
                return None;
            }
            Added::Repeated => return None,
            Added::New => self.bytes += data.len(),
        }
        let partial = &self.partial[at];
        if partial.length == Some(partial.bytes) {
            let whole = self.partial.remove(at);
            self.bytes -= whole.bytes;
            return Some(whole.parts.into_values().flatten().collect());
        }
        self.keep_bounds();
        None
    }

    fn entry(&mut self, key: FragmentKey, time: u64) -> usize {
        if let Some(at) = self.partial.iter().position(|p| p.key == key) {
            return at;
        }
        if self.partial.len() >= self.limits.datagrams.max(1) {
            self.drop_at(0);
        }
        self.partial.push(Partial {
            key,
            since: time,
            parts: BTreeMap::new(),
            fragments: 0,
            bytes: 0,
            length: None,
        });
        self.partial.len() - 1
    }

    fn drop_at(&mut self, at: usize) {
        let gone = self.partial.remove(at);
        self.bytes -= gone.bytes;
        self.lost += gone.fragments;
    }

    fn keep_bounds(&mut self) {
        while self.bytes > self.limits.bytes {
            self.drop_at(0);
        }
    }

    fn forget_old(&mut self, time: u64) {
        while self
            .partial
            .first()
            .is_some_and(|p| time.saturating_sub(p.since) > self.limits.age)
        {
            self.drop_at(0);
        }
    }
}

enum Added {
    New,
    Repeated,
    Spoiled,
}

impl Partial {
    fn add(&mut self, offset: usize, end: usize, more: bool, data: &[u8]) -> Added {
        if self.parts.get(&offset).is_some_and(|p| p == data) {
            return Added::Repeated;
        }
        let before = self.parts.range(..=offset).next_back();
        let overlaps = before.is_some_and(|(&at, part)| at + part.len() > offset)
            || self.parts.range(offset..end).next().is_some();
        let last = self.parts.last_key_value();
        let last_end = last.map_or(0, |(&at, part)| at + part.len());
        let beyond = if more {
            self.length.is_some_and(|length| end > length)
        } else {
            self.length.is_some_and(|length| end != length) || last_end > end
        };
        if overlaps || beyond {
            return Added::Spoiled;
        }
        if !more {
            self.length = Some(end);
        }
        self.bytes += data.len();
        self.parts.insert(offset, data.to_vec());
        Added::New
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn key(id: u32) -> FragmentKey {
        FragmentKey {
            from: [10, 0, 0, 1].into(),
            to: [10, 0, 0, 2].into(),
            id,
        }
    }

    /// Offset, whether more follow, and data of each fragment.
    fn split(whole: &[u8], size: usize) -> Vec<(usize, bool, &[u8])> {
        let starts = (0..whole.len()).step_by(size);
        starts
            .map(|at| {
                let end = (at + size).min(whole.len());
                (at, end < whole.len(), &whole[at..end])
            })
            .collect()
    }

    proptest! {
        #[test]
        fn any_order_with_copies_gives_the_datagram(
            whole in proptest::collection::vec(any::<u8>(), 1..4000),
            size in 1usize..100,
            order in proptest::collection::vec(any::<prop::sample::Index>(), 0..200),
        ) {
            let parts = split(&whole, size * 8);
            let mut fragments = Fragments::new(FragmentLimits::default());
            let mut done = None;
            let all = order.iter().map(|i| i.index(parts.len())).chain(0..parts.len());
            for i in all {
                let (offset, more, data) = parts[i];
                done = fragments.push(key(1), offset, more, data, 0);
                if done.is_some() {
                    break;
                }
            }
            prop_assert_eq!(done, Some(whole));
            prop_assert_eq!((fragments.bytes(), fragments.lost()), (0, 0));
        }

        #[test]
        fn anything_stays_within_bounds(
            input in proptest::collection::vec((0u32..6, 0usize..70_000, any::<bool>(), 0usize..3000, 0u64..100), 0..200),
        ) {
            let limits = FragmentLimits { datagrams: 4, bytes: 10_000, age: 50 };
            let mut fragments = Fragments::new(limits);
            let data = vec![7; 3000];
            for (id, offset, more, n, time) in input {
                if let Some(whole) = fragments.push(key(id), offset, more, &data[..n], time) {
                    prop_assert!(whole.len() <= LARGEST);
                }
                prop_assert!(fragments.bytes() <= limits.bytes && fragments.partial.len() <= limits.datagrams);
            }
        }
    }

    #[test]
    fn overlaps_spoil_the_datagram() {
        let mut fragments = Fragments::new(FragmentLimits::default());
        assert_eq!(fragments.push(key(1), 0, true, &[1; 16], 0), None);
        assert_eq!(fragments.push(key(1), 8, true, &[2; 16], 0), None);
        assert_eq!((fragments.lost(), fragments.bytes()), (2, 0));
        // An end before what is there already.
        assert_eq!(fragments.push(key(2), 16, true, &[1; 16], 0), None);
        assert_eq!(fragments.push(key(2), 0, false, &[1; 8], 0), None);
        assert_eq!((fragments.lost(), fragments.bytes()), (4, 0));
    }

    #[test]
    fn old_ones_go() {
        let mut fragments = Fragments::new(FragmentLimits::default());
        assert_eq!(fragments.push(key(1), 0, true, &[1; 8], 0), None);
        assert_eq!(
            fragments.push(key(1), 8, false, &[1; 8], 31_000_000_000),
            None
        );
        assert_eq!(fragments.lost(), 2);
    }
}
