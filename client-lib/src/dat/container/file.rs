//! A container: opening, lookup, enumeration, reading records.
//!
//! A lookup reads only the nodes on its way and keeps them; nothing is read at opening but the header. All reading is by positioned reads,
//! so a [`DatFile`] can be shared between threads. Source: `spec/11-dat-files.md, 3, 12.1, 12.2`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use flate2::read::ZlibDecoder;

use super::super::any::AnyRecord;
use super::super::error::{DatError, Problem};
use super::super::kind::{DataSet, RecordKind};
use super::super::reader::{Note, Strictness};
use super::super::record::Record;
use super::header::{HEADER_AT, HEADER_END, Header};
use super::node::{ALL_IDS, Entry, IdRange, NODE_SIZE, Node};
use super::source::ReadAt;

/// Most levels of a directory: a tree of least fill with 2^32 records has seven.
pub const MAX_LEVELS: usize = 8;
/// Largest record that is read, bytes.
pub const MAX_RECORD: u64 = 256 << 20;
/// Largest record that is expanded, bytes.
pub const MAX_EXPANDED: u64 = 64 << 20;
/// Nodes that are kept; the directory of the largest retail file has about 20 000.
const KEPT_NODES: usize = 32 << 10;

/// Work done by a [`DatFile`] since it was opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct ReadCounts {
    /// Directory nodes read.
    pub nodes: u64,
    /// Records read.
    pub records: u64,
    /// Bytes of records handed out.
    pub record_bytes: u64,
    /// Bytes read from the file, links and directory included.
    pub file_bytes: u64,
}

#[derive(Debug, Default)]
struct Counters {
    nodes: AtomicU64,
    records: AtomicU64,
    record_bytes: AtomicU64,
    file_bytes: AtomicU64,
}

type Source = Box<dyn ReadAt + Send + Sync>;

/// An open dat file.
pub struct DatFile {
    name: String,
    source: Source,
    header: Header,
    strictness: Strictness,
    notes: Vec<Note>,
    nodes: Mutex<BTreeMap<u32, Arc<Node>>>,
    counters: Counters,
}

impl std::fmt::Debug for DatFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DatFile")
            .field("name", &self.name)
            .field("header", &self.header)
            .finish_non_exhaustive()
    }
}

impl DatFile {
    /// Opens a file. `expected` is the data set that the caller needs, if any.
    ///
    /// # Errors
    /// What `spec/11-dat-files.md, 12.1` lists, and [`Problem::Io`].
    pub fn open(
        path: impl AsRef<Path>,
        expected: Option<DataSet>,
        strictness: Strictness,
    ) -> Result<Self, DatError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let file = File::open(path)
            .map_err(|e| DatError::in_file(&name, 0, io_problem("open the file", &e)))?;
        Self::from_source(&name, Box::new(file), expected, strictness)
    }

    /// Opens a container that is in memory; `name` stands for the path in errors.
    ///
    /// # Errors
    /// As [`DatFile::open`].
    pub fn from_bytes(
        name: &str,
        bytes: impl Into<Arc<[u8]>>,
        expected: Option<DataSet>,
        strictness: Strictness,
    ) -> Result<Self, DatError> {
        Self::from_source(name, Box::new(bytes.into()), expected, strictness)
    }

    /// Opens a container behind positioned reads.
    ///
    /// # Errors
    /// As [`DatFile::open`].
    pub fn from_source(
        name: &str,
        source: Source,
        expected: Option<DataSet>,
        strictness: Strictness,
    ) -> Result<Self, DatError> {
        let error = |offset: usize, problem| DatError::in_file(name, offset as u64, problem);
        let size = source
            .size()
            .map_err(|e| error(0, io_problem("ask for the size", &e)))?;
        if size < HEADER_END as u64 {
            return Err(error(0, Problem::NotADatFile { size }));
        }
        let mut start = [0; HEADER_END];
        source
            .read_exact_at(&mut start, 0)
            .map_err(|e| error(0, io_problem("read the header", &e)))?;
        let (header, deviation) = Header::parse(&start, size).map_err(|(at, p)| error(at, p))?;
        if let Some(expected) = expected
            .map(DataSet::value)
            .filter(|&e| e != header.data_set)
        {
            return Err(error(
                HEADER_AT + 0xC,
                Problem::WrongDataSet {
                    expected,
                    found: header.data_set,
                },
            ));
        }
        let mut notes = Vec::new();
        if let Some(problem) = deviation {
            if strictness == Strictness::Strict {
                return Err(error(HEADER_AT + 8, problem));
            }
            notes.push(Note {
                offset: HEADER_AT + 8,
                problem,
            });
        }
        let counters = Counters::default();
        counters
            .file_bytes
            .store(HEADER_END as u64, Ordering::Relaxed);
        let name = name.to_owned();
        Ok(Self {
            name,
            source,
            header,
            strictness,
            notes,
            nodes: Mutex::default(),
            counters,
        })
    }

    /// Path or name given at opening.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The header.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// How much is tolerated.
    #[must_use]
    pub fn strictness(&self) -> Strictness {
        self.strictness
    }

    /// Deviations that were passed over at opening.
    #[must_use]
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// Data set of the header; a file with an unknown one is taken as a portal file.
    #[must_use]
    pub fn data_set(&self) -> DataSet {
        DataSet::from_value(self.header.data_set).unwrap_or(DataSet::Portal)
    }

    /// Work done since opening.
    #[must_use]
    pub fn counts(&self) -> ReadCounts {
        let c = &self.counters;
        ReadCounts {
            nodes: c.nodes.load(Ordering::Relaxed),
            records: c.records.load(Ordering::Relaxed),
            record_bytes: c.record_bytes.load(Ordering::Relaxed),
            file_bytes: c.file_bytes.load(Ordering::Relaxed),
        }
    }

    /// Directory entry of a record; `None` if it is not in the file.
    ///
    /// # Errors
    /// A damaged directory on the way to the id.
    pub fn entry(&self, id: u32) -> Result<Option<Entry>, DatError> {
        let (mut offset, mut range) = (self.header.root, ALL_IDS);
        if offset == 0 {
            return Ok(None);
        }
        for _ in 0..MAX_LEVELS {
            let node = self.node(offset, range)?;
            let i = node.entries.partition_point(|e| e.id < id);
            if let Some(entry) = node.entries.get(i).filter(|e| e.id == id) {
                return Ok(Some(*entry));
            }
            if node.is_leaf() {
                return Ok(None);
            }
            range = node.child_range(i, range);
            offset = node.branch(i).map_err(|p| self.error(offset, p))?;
        }
        Err(self.error(offset, Problem::DirectoryDepth { limit: MAX_LEVELS }))
    }

    /// True if the record is in the file.
    ///
    /// # Errors
    /// As [`DatFile::entry`].
    pub fn contains(&self, id: u32) -> Result<bool, DatError> {
        Ok(self.entry(id)?.is_some())
    }

    /// Bytes of a record, expanded if compressed; `None` if it is not in the file.
    ///
    /// # Errors
    /// A damaged directory, chain or compressed stream.
    pub fn get(&self, id: u32) -> Result<Option<Vec<u8>>, DatError> {
        match self.entry(id)? {
            Some(entry) => self.read(&entry).map(Some),
            None => Ok(None),
        }
    }

    /// A parsed record; `None` if it is not in the file.
    ///
    /// # Errors
    /// As [`DatFile::get`] and [`Record::from_bytes`].
    pub fn record<T: Record>(&self, id: u32) -> Result<Option<T>, DatError> {
        match self.get(id)? {
            Some(bytes) => T::from_bytes(&self.name, id, &bytes, self.strictness).map(Some),
            None => Ok(None),
        }
    }

    /// A parsed record of any kind; `None` if it is not in the file or its layout is not known.
    ///
    /// # Errors
    /// As [`DatFile::record`].
    pub fn any_record(&self, id: u32) -> Result<Option<AnyRecord>, DatError> {
        let Some(bytes) = self.get(id)? else {
            return Ok(None);
        };
        let kind = RecordKind::of(self.data_set(), id);
        AnyRecord::parse(kind, &self.name, id, &bytes, self.strictness)
            .map(|r| r.map(|(record, _)| record))
            .transpose()
    }

    /// All entries in ascending order of id. Reads the whole directory.
    ///
    /// # Errors
    /// A damaged directory.
    pub fn entries(&self) -> Result<Vec<Entry>, DatError> {
        let mut list = Vec::new();
        self.walk(|_, _, _| {}, |entry| list.push(*entry))?;
        Ok(list)
    }

    /// All ids in ascending order. Reads the whole directory.
    ///
    /// # Errors
    /// As [`DatFile::entries`].
    pub fn ids(&self) -> Result<Vec<u32>, DatError> {
        Ok(self.entries()?.iter().map(|e| e.id).collect())
    }

    /// Walks the directory in ascending order of id; `on_node` gets offset, node and depth (root 0) before the node's entries.
    pub(super) fn walk(
        &self,
        mut on_node: impl FnMut(u32, &Node, usize),
        mut on_entry: impl FnMut(&Entry),
    ) -> Result<(), DatError> {
        struct Open {
            offset: u32,
            node: Arc<Node>,
            range: IdRange,
            next: usize,
        }
        if self.header.root == 0 {
            return Ok(());
        }
        let mut visited = BTreeSet::from([self.header.root]);
        let node = self.node(self.header.root, ALL_IDS)?;
        on_node(self.header.root, &node, 0);
        let mut open = vec![Open {
            offset: self.header.root,
            node,
            range: ALL_IDS,
            next: 0,
        }];
        while let Some(top) = open.last_mut() {
            let i = top.next;
            top.next += 1;
            // Branch i comes after entry i - 1.
            if let Some(entry) = i.checked_sub(1).and_then(|i| top.node.entries.get(i)) {
                on_entry(entry);
            }
            if i > top.node.entries.len() {
                open.pop();
                continue;
            }
            if top.node.is_leaf() {
                continue;
            }
            let parent = top.offset;
            let offset = top.node.branch(i).map_err(|p| self.error(parent, p))?;
            let range = top.node.child_range(i, top.range);
            if !visited.insert(offset) {
                return Err(self.error(parent, Problem::DirectoryCycle { node: offset }));
            }
            if open.len() >= MAX_LEVELS {
                return Err(self.error(parent, Problem::DirectoryDepth { limit: MAX_LEVELS }));
            }
            let node = self.node(offset, range)?;
            on_node(offset, &node, open.len());
            open.push(Open {
                offset,
                node,
                range,
                next: 0,
            });
        }
        Ok(())
    }

    /// Bytes of the record of an entry, expanded if compressed.
    ///
    /// # Errors
    /// As [`DatFile::get`].
    pub fn read(&self, entry: &Entry) -> Result<Vec<u8>, DatError> {
        let in_record = |e: Problem| DatError::in_record(&self.name, entry.id, 0, e);
        let stored = self
            .chain(entry.offset, u64::from(entry.size), |_| {})
            .map_err(|e| in_record(e.1))?;
        let bytes = if entry.is_compressed() {
            expand(&stored).map_err(in_record)?
        } else {
            stored
        };
        self.counters.records.fetch_add(1, Ordering::Relaxed);
        self.counters
            .record_bytes
            .fetch_add(bytes.len() as u64, Ordering::Relaxed);
        Ok(bytes)
    }

    fn node(&self, offset: u32, range: IdRange) -> Result<Arc<Node>, DatError> {
        // The range is the same whenever a node is reached by the same way; a node that is reached by two ways is an error in the walk,
        // and in a lookup the ids decide.
        let mut nodes = self.nodes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(node) = nodes.get(&offset) {
            let inside = |e: Option<&Entry>| {
                e.is_none_or(|e| i64::from(e.id) > range.0 && i64::from(e.id) < range.1)
            };
            if inside(node.entries.first()) && inside(node.entries.last()) {
                return Ok(Arc::clone(node));
            }
        }
        let bytes = self
            .chain(offset, NODE_SIZE as u64, |_| {})
            .map_err(|(at, p)| self.error(at, p))?;
        let node = Arc::new(Node::parse(&bytes, range).map_err(|p| self.error(offset, p))?);
        self.counters.nodes.fetch_add(1, Ordering::Relaxed);
        if nodes.len() >= KEPT_NODES {
            nodes.clear();
        }
        nodes.insert(offset, Arc::clone(&node));
        Ok(node)
    }

    /// Reads `size` bytes along a chain (3.3). `on_block` gets the offset of every block of it.
    pub(super) fn chain(
        &self,
        start: u32,
        size: u64,
        mut on_block: impl FnMut(u32),
    ) -> Result<Vec<u8>, (u32, Problem)> {
        let limit = u64::from(self.header.file_size).min(MAX_RECORD);
        let blocks = self.header.blocks_for(size);
        if size > limit || blocks > self.header.block_count() {
            return Err((start, Problem::TooLarge { size, limit }));
        }
        // Each block is read with its link in front. The link of a later block falls on the last four bytes of the block before it, which
        // are put back afterwards: one read and no copy per block.
        let size = size as usize;
        let mut buffer = vec![0; size + 4];
        let (mut block, mut done, mut first) = (start, 0, true);
        while done < size || first {
            first = false;
            let part = (size - done).min(self.header.payload());
            if !self.header.is_block(block) {
                return Err((block, Problem::BlockOffset { found: block }));
            }
            on_block(block);
            let window = &mut buffer[done..done + part + 4];
            let mut link = [0; 4];
            link.copy_from_slice(&window[..4]);
            let kept = link;
            self.source
                .read_exact_at(window, u64::from(block))
                .map_err(|e| (block, io_problem("read a block", &e)))?;
            self.counters
                .file_bytes
                .fetch_add(window.len() as u64, Ordering::Relaxed);
            link.copy_from_slice(&window[..4]);
            window[..4].copy_from_slice(&kept);
            done += part;
            block = self.next_block(block, u32::from_le_bytes(link), size - done)?;
        }
        buffer.drain(..4);
        Ok(buffer)
    }

    /// Follows a link; `left` bytes are still to come.
    fn next_block(&self, block: u32, link: u32, left: usize) -> Result<u32, (u32, Problem)> {
        if link >> 31 != 0 {
            return Err((block, Problem::FreeBlock { block }));
        }
        match (left, link) {
            (0, 0) => Ok(0),
            (0, link) if self.strictness == Strictness::Strict => {
                Err((block, Problem::ChainTooLong { link }))
            }
            (0, _) => Ok(0),
            (left, 0) => Err((
                block,
                Problem::ChainEnds {
                    missing: left as u64,
                },
            )),
            (_, link) => Ok(link),
        }
    }

    /// Link of a block.
    pub(super) fn link(&self, block: u32) -> Result<u32, (u32, Problem)> {
        let mut link = [0; 4];
        self.source
            .read_exact_at(&mut link, u64::from(block))
            .map_err(|e| (block, io_problem("read a block", &e)))?;
        Ok(u32::from_le_bytes(link))
    }

    pub(super) fn error(&self, offset: u32, problem: Problem) -> DatError {
        DatError::in_file(&self.name, u64::from(offset), problem)
    }
}

fn io_problem(operation: &'static str, e: &io::Error) -> Problem {
    Problem::Io {
        operation,
        message: e.to_string(),
    }
}

/// Expands a compressed record: its size, then a zlib stream (3.8).
pub(super) fn expand(stored: &[u8]) -> Result<Vec<u8>, Problem> {
    let Some((head, stream)) = stored.split_first_chunk::<4>() else {
        return Err(Problem::Compressed {
            what: "no room for the size",
            stated: 0,
        });
    };
    let stated = u64::from(u32::from_le_bytes(*head));
    if stated > MAX_EXPANDED || stated > 1100 * stored.len() as u64 {
        return Err(Problem::Compressed {
            what: "size is out of proportion",
            stated,
        });
    }
    let mut decoder = ZlibDecoder::new(stream);
    let mut out = Vec::with_capacity(stated as usize);
    let read = decoder.by_ref().take(stated).read_to_end(&mut out);
    if read.is_err() || (out.len() as u64) < stated {
        return Err(Problem::Compressed {
            what: "the stream is damaged or shorter than stated",
            stated,
        });
    }
    match decoder.read(&mut [0]) {
        Ok(0) => Ok(out),
        Ok(_) => Err(Problem::Compressed {
            what: "the stream is longer than stated",
            stated,
        }),
        Err(_) => Err(Problem::Compressed {
            what: "the stream's end is damaged",
            stated,
        }),
    }
}
