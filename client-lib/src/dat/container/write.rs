//! Writing a container: the same records and settings always give the same bytes. Source: `spec/11-dat-files.md, 13`.

use std::collections::BTreeMap;

use arrayvec::ArrayVec;

use super::super::error::{DatError, Problem};
use super::super::iteration::Iteration;
use super::super::kind::{DataSet, ITERATION_ID};
use super::super::record::Record;
use super::header::{HEADER_AT, HEADER_END, Header};
use super::node::{Entry, NODE_BRANCHES, NODE_ENTRIES, NODE_SIZE, Node, UNUSED};

/// Date of all entries: the output must not depend on the clock.
const ENTRY_DATE: u32 = 1_000_000_000;

/// Where the blocks of a chain lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placement {
    /// In order.
    Sequential,
    /// Scattered over the file, by this seed: a reader must follow the links.
    Scattered(u64),
}

/// Collects records, then writes one dat file.
#[derive(Debug, Clone)]
pub struct DatBuilder {
    data_set: DataSet,
    subset: u32,
    block_size: u32,
    iteration: i32,
    label: String,
    placement: Placement,
    free_blocks: u32,
    records: BTreeMap<u32, Vec<u8>>,
}

impl DatBuilder {
    /// An empty file with the block size and subset that are usual for its data set.
    #[must_use]
    pub fn new(data_set: DataSet) -> Self {
        let (block_size, subset) = if data_set == DataSet::Cell {
            (256, 1)
        } else {
            (1024, 0)
        };
        Self {
            data_set,
            subset,
            block_size,
            iteration: 1,
            label: "synthetic world".to_owned(),
            placement: Placement::Sequential,
            free_blocks: 0,
            records: BTreeMap::new(),
        }
    }

    /// Sets the block size, bytes: a multiple of 4 from 16 to 1 MiB.
    #[must_use]
    pub fn block_size(mut self, bytes: u32) -> Self {
        self.block_size = bytes;
        self
    }

    /// Sets where blocks lie.
    #[must_use]
    pub fn placement(mut self, placement: Placement) -> Self {
        self.placement = placement;
        self
    }

    /// Sets the number of free blocks at the end.
    #[must_use]
    pub fn free_blocks(mut self, n: u32) -> Self {
        self.free_blocks = n;
        self
    }

    /// Adds or replaces a record as bytes.
    pub fn insert(&mut self, id: u32, bytes: Vec<u8>) -> &mut Self {
        self.records.insert(id, bytes);
        self
    }

    /// Adds or replaces a record.
    ///
    /// # Errors
    /// As [`Record::to_bytes`].
    pub fn add<T: Record>(&mut self, record: &T) -> Result<&mut Self, DatError> {
        let bytes = record.to_bytes()?;
        Ok(self.insert(record.id(), bytes))
    }

    /// Records so far, by id; without the iteration record, which [`DatBuilder::write`] adds.
    #[must_use]
    pub fn records(&self) -> &BTreeMap<u32, Vec<u8>> {
        &self.records
    }

    /// The bytes of the file. An iteration record is added if none was given.
    ///
    /// # Errors
    /// [`Problem::BlockSize`]; [`Problem::CannotEncode`] if the file would not fit in 2 GiB.
    pub fn write(&self) -> Result<Vec<u8>, DatError> {
        let error = |problem| DatError::in_file("(new file)", 0, problem);
        if !self.block_size.is_multiple_of(4) || !(16..=1 << 20).contains(&self.block_size) {
            return Err(error(Problem::BlockSize {
                found: self.block_size,
            }));
        }
        let mut records = self.records.clone();
        let iteration = Iteration::complete(self.iteration).to_bytes()?;
        records.entry(ITERATION_ID).or_insert(iteration);
        let ids: Vec<u32> = records.keys().copied().collect();
        let mut nodes = Vec::new();
        let root = plan_tree(&ids, height_for(ids.len()), &mut nodes);
        let layout = Layout::new(self, records.values(), nodes.len()).map_err(error)?;
        let mut out = vec![0; layout.file_size as usize];
        self.put_header(&mut out, &layout, layout.nodes[root][0]);
        for (data, chain) in records.values().zip(&layout.records) {
            put_chain(&mut out, chain, self.block_size, data);
        }
        let entry = |id: u32| {
            let at = ids.binary_search(&id).unwrap_or(0);
            Entry {
                flags: 0,
                version: 2,
                id,
                offset: layout.records[at][0],
                size: records[&id].len() as u32,
                date: ENTRY_DATE,
                iteration: self.iteration as u32,
            }
        };
        for (plan, chain) in nodes.iter().zip(&layout.nodes) {
            put_chain(
                &mut out,
                chain,
                self.block_size,
                &plan.encode(&layout, entry),
            );
        }
        for k in 0..self.free_blocks {
            let at = layout.first_free + k * self.block_size;
            let next = if k + 1 < self.free_blocks {
                at + self.block_size
            } else {
                0
            };
            put_u32(&mut out, at, next | 0x8000_0000);
        }
        Ok(out)
    }

    fn put_header(&self, out: &mut [u8], layout: &Layout, root: u32) {
        let some_free = self.free_blocks > 0;
        let header = Header {
            block_size: self.block_size,
            file_size: layout.file_size,
            data_set: self.data_set.value(),
            data_subset: self.subset,
            first_free: if some_free { layout.first_free } else { 0 },
            last_free: if some_free {
                layout.first_free + (self.free_blocks - 1) * self.block_size
            } else {
                0
            },
            free_count: self.free_blocks,
            root,
            youngest_lru: 0,
            oldest_lru: 0,
            use_lru: 0,
            master_map: 0,
            engine_version: 22,
            game_version: 0,
            version_major: std::array::from_fn(|i| i as u8),
            version_minor: self.iteration as u32,
        };
        let label = &self.label.as_bytes()[..self.label.len().min(255)];
        out[..label.len()].copy_from_slice(label);
        out[0x100..0x104].copy_from_slice(&[0x00, 0x50, 0x4C, 0x00]);
        out[HEADER_AT..HEADER_END].copy_from_slice(&header.to_bytes());
    }
}

/// A node of the directory to be: ids and child nodes by number.
struct PlannedNode {
    ids: Vec<u32>,
    children: Vec<usize>,
}

impl PlannedNode {
    fn encode(&self, layout: &Layout, entry: impl Fn(u32) -> Entry) -> Vec<u8> {
        // Leaves end with zeros: two of the references take a leaf by its first branch (D-01).
        let mut branches = [if self.children.is_empty() { 0 } else { UNUSED }; NODE_BRANCHES];
        for (b, &child) in branches.iter_mut().zip(&self.children) {
            *b = layout.nodes[child][0];
        }
        let entries: ArrayVec<Entry, NODE_ENTRIES> = self
            .ids
            .iter()
            .map(|&id| entry(id))
            .take(NODE_ENTRIES)
            .collect();
        Node { branches, entries }.to_bytes()
    }
}

fn capacity(height: u32) -> usize {
    (0..height).fold(NODE_ENTRIES, |below, _| {
        NODE_ENTRIES + NODE_BRANCHES * below
    })
}

fn height_for(ids: usize) -> u32 {
    (0..).find(|&h| capacity(h) >= ids).unwrap_or(0)
}

/// Plans a balanced tree over sorted ids; answers the number of its root. The smallest height that can hold all, children filled evenly:
/// then every node but the root has at least 30 entries.
fn plan_tree(ids: &[u32], height: u32, nodes: &mut Vec<PlannedNode>) -> usize {
    let number = nodes.len();
    if height == 0 {
        nodes.push(PlannedNode {
            ids: ids.to_vec(),
            children: Vec::new(),
        });
        return number;
    }
    let below = capacity(height - 1);
    let children = (2..)
        .find(|k| k * below + k > ids.len())
        .unwrap_or(NODE_BRANCHES);
    let (base, extra) = (
        (ids.len() - (children - 1)) / children,
        (ids.len() - (children - 1)) % children,
    );
    nodes.push(PlannedNode {
        ids: Vec::new(),
        children: Vec::new(),
    });
    let mut at = 0;
    for c in 0..children {
        let n = base + usize::from(c < extra);
        let child = plan_tree(&ids[at..at + n], height - 1, nodes);
        nodes[number].children.push(child);
        at += n;
        if c + 1 < children {
            nodes[number].ids.push(ids[at]);
            at += 1;
        }
    }
    number
}

/// Offsets of the blocks of every chain.
struct Layout {
    records: Vec<Vec<u32>>,
    nodes: Vec<Vec<u32>>,
    first_free: u32,
    file_size: u32,
}

impl Layout {
    fn new<'a>(
        dat: &DatBuilder,
        records: impl Iterator<Item = &'a Vec<u8>>,
        nodes: usize,
    ) -> Result<Self, Problem> {
        let payload = dat.block_size as usize - 4;
        let lengths: Vec<usize> = records.map(|r| r.len().div_ceil(payload).max(1)).collect();
        let node_blocks = NODE_SIZE.div_ceil(payload);
        let used = lengths.iter().sum::<usize>() + node_blocks * nodes;
        let first = (HEADER_END as u32).div_ceil(dat.block_size);
        let size = (u64::from(first) + used as u64 + u64::from(dat.free_blocks))
            * u64::from(dat.block_size);
        if size >= 1 << 31 {
            return Err(Problem::CannotEncode {
                what: "file size",
                found: size,
                limit: (1 << 31) - 1,
            });
        }
        let mut order: Vec<u32> = (0..used as u32)
            .map(|i| (first + i) * dat.block_size)
            .collect();
        if let Placement::Scattered(seed) = dat.placement {
            shuffle(&mut order, seed);
        }
        let mut order = order.into_iter();
        let mut take = |n: usize| order.by_ref().take(n).collect::<Vec<u32>>();
        Ok(Self {
            records: lengths.into_iter().map(&mut take).collect(),
            nodes: (0..nodes).map(|_| take(node_blocks)).collect(),
            first_free: (first + used as u32) * dat.block_size,
            file_size: size as u32,
        })
    }
}

fn shuffle(list: &mut [u32], seed: u64) {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    for i in (1..list.len()).rev() {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        list.swap(i, (state % (i as u64 + 1)) as usize);
    }
}

fn put_u32(out: &mut [u8], at: u32, v: u32) {
    out[at as usize..at as usize + 4].copy_from_slice(&v.to_le_bytes());
}

fn put_chain(out: &mut [u8], chain: &[u32], block_size: u32, data: &[u8]) {
    let mut parts = data.chunks(block_size as usize - 4);
    for (i, &at) in chain.iter().enumerate() {
        put_u32(out, at, chain.get(i + 1).copied().unwrap_or(0));
        let part = parts.next().unwrap_or(&[]);
        let at = at as usize + 4;
        out[at..at + part.len()].copy_from_slice(part);
    }
}
