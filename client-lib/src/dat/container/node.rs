//! A node of the directory, 1716 bytes, and its entries. Source: `spec/11-dat-files.md, 3.5, 3.6`.

use arrayvec::ArrayVec;
use serde::Serialize;

use super::super::error::Problem;

/// Bytes of a node.
pub const NODE_SIZE: usize = 1716;
/// Branches of a node.
pub const NODE_BRANCHES: usize = 62;
/// Most entries of a node.
pub const NODE_ENTRIES: usize = 61;
/// Least entries of a node that is not the root.
pub const NODE_LEAST: usize = 30;
/// What some writers leave in branches that are not used.
pub const UNUSED: u32 = 0xCDCD_CDCD;

/// Where one record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// Bit 0: compressed.
    pub flags: u16,
    /// 2 in written files.
    pub version: u16,
    /// Id of the record.
    pub id: u32,
    /// First block.
    pub offset: u32,
    /// Bytes stored.
    pub size: u32,
    /// Unix time, informative.
    pub date: u32,
    /// File version that brought the record, informative.
    pub iteration: u32,
}

impl Entry {
    /// Bytes of an entry.
    pub const SIZE: usize = 24;

    /// The record is compressed.
    #[must_use]
    pub fn is_compressed(&self) -> bool {
        self.flags & 1 != 0
    }

    pub(super) fn to_bytes(self) -> [u8; Self::SIZE] {
        let mut out = [0; Self::SIZE];
        out[0..2].copy_from_slice(&self.flags.to_le_bytes());
        out[2..4].copy_from_slice(&self.version.to_le_bytes());
        for (i, v) in [self.id, self.offset, self.size, self.date, self.iteration]
            .into_iter()
            .enumerate()
        {
            out[4 + 4 * i..8 + 4 * i].copy_from_slice(&v.to_le_bytes());
        }
        out
    }
}

/// A directory node.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Offsets of child nodes; the first `entries + 1` count, unless it is a leaf.
    pub branches: [u32; NODE_BRANCHES],
    /// Entries in ascending order of id.
    pub entries: ArrayVec<Entry, NODE_ENTRIES>,
}

/// Ids that a subtree may hold: greater than the first, less than the second. Wider than u32, so that all ids are inside the widest range.
pub(super) type IdRange = (i64, i64);

/// The range of the root.
pub(super) const ALL_IDS: IdRange = (-1, 1 << 32);

impl Node {
    /// Reads a node and checks that ids ascend and lie in the range that the parent gives.
    pub(super) fn parse(bytes: &[u8], range: IdRange) -> Result<Self, Problem> {
        let at = |offset: usize| match bytes.get(offset..offset + 4) {
            Some(b) => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            None => 0,
        };
        let mut branches = [0; NODE_BRANCHES];
        for (i, b) in branches.iter_mut().enumerate() {
            *b = at(4 * i);
        }
        let count = at(248);
        if count as usize > NODE_ENTRIES {
            return Err(Problem::EntryCount { found: count });
        }
        let mut entries = ArrayVec::new();
        let mut last = range.0;
        for i in 0..count as usize {
            let o = 252 + Entry::SIZE * i;
            let (word, id) = (at(o), at(o + 4));
            if i64::from(id) <= last || i64::from(id) >= range.1 {
                return Err(Problem::DirectoryOrder { id });
            }
            last = i64::from(id);
            entries.push(Entry {
                flags: word as u16,
                version: (word >> 16) as u16,
                id,
                offset: at(o + 8),
                size: at(o + 12),
                date: at(o + 16),
                iteration: at(o + 20),
            });
        }
        Ok(Self { branches, entries })
    }

    /// A node without children (D-01: one writer marks leaves with 0xCDCDCDCD).
    #[must_use]
    pub fn is_leaf(&self) -> bool {
        self.branches[0] == 0 || self.branches[0] == UNUSED
    }

    /// Offset of child `i` of an inner node.
    pub(super) fn branch(&self, index: usize) -> Result<u32, Problem> {
        match self.branches.get(index).copied().unwrap_or(0) {
            found @ (0 | UNUSED) => Err(Problem::MissingBranch { index, found }),
            offset => Ok(offset),
        }
    }

    /// Ids that child `index` may hold.
    pub(super) fn child_range(&self, index: usize, range: IdRange) -> IdRange {
        let id = |i: usize| self.entries.get(i).map(|e| i64::from(e.id));
        let low = index.checked_sub(1).and_then(id).unwrap_or(range.0);
        (low, id(index).unwrap_or(range.1))
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(NODE_SIZE);
        for b in self.branches {
            out.extend(b.to_le_bytes());
        }
        out.extend((self.entries.len() as u32).to_le_bytes());
        for e in &self.entries {
            out.extend(e.to_bytes());
        }
        let filler = if self.is_leaf() { 0 } else { 0xCD };
        out.resize(NODE_SIZE, filler);
        out
    }
}
