//! The one error type of the dat layer: which file, which record, which byte, what was wrong and what to do about it.
//!
//! Source: `spec/11-dat-files.md, 12`.

use std::fmt;

/// What was wrong. One variant per check of `spec/11-dat-files.md, 12`, so that a caller can match on it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Problem {
    /// The operating system could not open or read the file.
    Io {
        /// What was attempted.
        operation: &'static str,
        /// The system's answer.
        message: String,
    },
    /// The file is shorter than a header.
    NotADatFile {
        /// Bytes in the file.
        size: u64,
    },
    /// The magic number is not `BT`.
    WrongMagic {
        /// The number found at 0x140.
        found: u32,
        /// The older format, whose header is at 0x12C, was recognised.
        old_format: bool,
    },
    /// The block size cannot be.
    BlockSize {
        /// The stated block size in bytes.
        found: u32,
    },
    /// The file is shorter than its header says.
    Truncated {
        /// Bytes stated in the header.
        stated: u64,
        /// Bytes in the file.
        actual: u64,
    },
    /// The file is longer than its header says (a note unless strict).
    TrailingBytes {
        /// Bytes stated in the header.
        stated: u64,
        /// Bytes in the file.
        actual: u64,
    },
    /// A portal file where a cell file was expected, or the other way round.
    WrongDataSet {
        /// Data set expected by the caller.
        expected: u32,
        /// Data set stated in the header.
        found: u32,
    },
    /// An offset that is no block of this file.
    BlockOffset {
        /// The offset.
        found: u32,
    },
    /// A link leads into a free block.
    FreeBlock {
        /// Offset of the block whose link is marked free.
        block: u32,
    },
    /// A chain is shorter than what it holds.
    ChainEnds {
        /// Bytes that are missing.
        missing: u64,
    },
    /// A chain is longer than what it holds (a note unless strict).
    ChainTooLong {
        /// The link that should have been 0.
        link: u32,
    },
    /// A record is larger than the file or the limit.
    TooLarge {
        /// The stated size in bytes.
        size: u64,
        /// The limit that it breaks.
        limit: u64,
    },
    /// A directory node claims more entries than fit.
    EntryCount {
        /// The stated number of entries.
        found: u32,
    },
    /// The directory is deeper than any file can need.
    DirectoryDepth {
        /// The limit.
        limit: usize,
    },
    /// A directory node is reached twice.
    DirectoryCycle {
        /// Offset of the node.
        node: u32,
    },
    /// Ids are not strictly ascending, or outside the range that the parent gives.
    DirectoryOrder {
        /// The id that is out of place.
        id: u32,
    },
    /// An inner node lacks a branch that it needs.
    MissingBranch {
        /// Number of the branch.
        index: usize,
        /// What stands there.
        found: u32,
    },
    /// A directory node has too few entries, or leaves lie at different depths (consistency check only).
    Unbalanced {
        /// What exactly.
        what: &'static str,
        /// The number found.
        found: u64,
    },
    /// Two chains share a block (consistency check only).
    SharedBlock {
        /// Offset of the block.
        block: u32,
    },
    /// A compressed record cannot be expanded.
    Compressed {
        /// What exactly.
        what: &'static str,
        /// The stated uncompressed size.
        stated: u64,
    },
    /// A record that was asked for is not in the file.
    Missing {
        /// What kind of record it should be.
        kind: &'static str,
        /// The id of the record that refers to it, if any.
        wanted_by: Option<u32>,
    },
    /// Bytes stop in the middle of a field.
    EndOfRecord {
        /// Bytes needed.
        wanted: usize,
        /// Bytes left.
        left: usize,
    },
    /// A count promises more elements than the rest of the record can hold.
    Count {
        /// What is counted.
        what: &'static str,
        /// The stated count.
        count: u64,
        /// Least bytes of one element.
        least: usize,
        /// Bytes left in the record.
        left: usize,
    },
    /// A signed count is below zero.
    NegativeCount {
        /// What is counted.
        what: &'static str,
        /// The stated count.
        count: i32,
    },
    /// The record begins with another id than its own (a note unless strict).
    OwnId {
        /// The id found.
        found: u32,
    },
    /// A tag or kind whose length is unknown: the rest cannot be read.
    Unknown {
        /// What it is.
        what: &'static str,
        /// The number found.
        found: u32,
    },
    /// An index points outside its list.
    Index {
        /// What it indexes.
        what: &'static str,
        /// The index found.
        found: i64,
        /// Elements in the list.
        limit: usize,
    },
    /// Keys do not count up from 0.
    KeyOrder {
        /// Whose key.
        what: &'static str,
        /// The key expected.
        expected: u32,
        /// The key found.
        found: u32,
    },
    /// Two entries of a map have one key (a note unless strict).
    DuplicateKey {
        /// Which map.
        what: &'static str,
        /// The key.
        key: u32,
    },
    /// A number that is not finite (strict only).
    NotFinite {
        /// Which number.
        what: &'static str,
    },
    /// An orientation that is not a unit quaternion (strict only).
    NotUnit {
        /// Its squared length.
        norm_squared: f32,
    },
    /// Alignment bytes that are not zero (strict only).
    Padding,
    /// Bytes left over after the record (a note unless strict).
    LeftOver {
        /// How many.
        bytes: usize,
    },
    /// A tree is deeper than the limit.
    TreeDepth {
        /// The limit.
        limit: usize,
    },
    /// A value that this place does not allow.
    Value {
        /// Which value.
        what: &'static str,
        /// The value found.
        found: i64,
        /// What is allowed.
        expected: &'static str,
    },
    /// A record in memory cannot be written in its format.
    CannotEncode {
        /// What does not fit.
        what: &'static str,
        /// How large it is.
        found: u64,
        /// What is allowed.
        limit: u64,
    },
}

impl Problem {
    /// What a person can do about it; one short sentence.
    #[must_use]
    pub fn help(&self) -> &'static str {
        match self {
            Self::Io { .. } => "check the path and its permissions",
            Self::NotADatFile { .. } => {
                "give a client_portal.dat, client_cell_1.dat or another dat file of the client"
            }
            Self::WrongMagic {
                old_format: true, ..
            } => {
                "this is the format before Throne of Destiny; use the dat files of the last retail client"
            }
            Self::WrongMagic { .. } => "give a dat file of the last retail client",
            Self::Truncated { .. } => "copy the file again: its end is missing",
            Self::TrailingBytes { .. } => "harmless; the bytes after the stated size are not read",
            Self::WrongDataSet { .. } => "check that the portal and the cell file are not swapped",
            Self::BlockSize { .. }
            | Self::BlockOffset { .. }
            | Self::FreeBlock { .. }
            | Self::ChainEnds { .. }
            | Self::ChainTooLong { .. }
            | Self::TooLarge { .. }
            | Self::EntryCount { .. }
            | Self::DirectoryDepth { .. }
            | Self::DirectoryCycle { .. }
            | Self::DirectoryOrder { .. }
            | Self::MissingBranch { .. }
            | Self::Unbalanced { .. }
            | Self::SharedBlock { .. }
            | Self::Compressed { .. } => {
                "the container is damaged: restore the file from a good copy; `ac-replay dat check` lists what else is broken"
            }
            Self::Missing { .. } => "check that the portal and the cell file belong to one world",
            Self::OwnId { .. }
            | Self::DuplicateKey { .. }
            | Self::NotFinite { .. }
            | Self::NotUnit { .. }
            | Self::Padding
            | Self::LeftOver { .. } => {
                "strict reading refuses this; lenient reading keeps the stored value"
            }
            Self::CannotEncode { .. } => "make the record smaller or split it",
            Self::EndOfRecord { .. }
            | Self::Count { .. }
            | Self::NegativeCount { .. }
            | Self::Unknown { .. }
            | Self::Index { .. }
            | Self::KeyOrder { .. }
            | Self::TreeDepth { .. }
            | Self::Value { .. } => {
                "the record is damaged or of another format: restore the file from a good copy"
            }
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { operation, message } => write!(f, "cannot {operation}: {message}"),
            Self::NotADatFile { size } => write!(
                f,
                "not a dat file: {size} bytes are less than a header of 400"
            ),
            Self::WrongMagic {
                found,
                old_format: true,
            } => write!(
                f,
                "old dat format: magic is at 0x12C, and 0x140 holds 0x{found:08X}"
            ),
            Self::WrongMagic { found, .. } => {
                write!(f, "wrong magic 0x{found:08X}, expected 0x00005442")
            }
            Self::BlockSize { found } => write!(
                f,
                "block size {found}, expected a multiple of 4 from 16 to 1048576"
            ),
            Self::Truncated { stated, actual } => write!(
                f,
                "file is truncated: the header says {stated} bytes, there are {actual}"
            ),
            Self::TrailingBytes { stated, actual } => write!(
                f,
                "file is longer than stated: the header says {stated} bytes, there are {actual}"
            ),
            Self::WrongDataSet { expected, found } => {
                write!(
                    f,
                    "wrong kind of file: data set {found} ({}), expected {expected} ({})",
                    data_set_name(*found),
                    data_set_name(*expected)
                )
            }
            Self::BlockOffset { found } => write!(f, "0x{found:08X} is not the offset of a block"),
            Self::FreeBlock { block } => {
                write!(f, "the chain runs through the free block 0x{block:08X}")
            }
            Self::ChainEnds { missing } => write!(f, "the chain ends {missing} bytes early"),
            Self::ChainTooLong { link } => {
                write!(f, "the chain goes on to 0x{link:08X} after its last byte")
            }
            Self::TooLarge { size, limit } => write!(f, "size {size} exceeds {limit} bytes"),
            Self::EntryCount { found } => {
                write!(f, "directory node with {found} entries, at most 61 fit")
            }
            Self::DirectoryDepth { limit } => write!(f, "directory is deeper than {limit} levels"),
            Self::DirectoryCycle { node } => {
                write!(f, "directory cycle: node 0x{node:08X} is reached twice")
            }
            Self::DirectoryOrder { id } => write!(
                f,
                "directory order: id 0x{id:08X} is out of place or double"
            ),
            Self::MissingBranch { index, found } => {
                write!(f, "directory branch {index} is missing (0x{found:08X})")
            }
            Self::Unbalanced { what, found } => {
                write!(f, "directory is not a balanced tree: {what} ({found})")
            }
            Self::SharedBlock { block } => write!(f, "block 0x{block:08X} belongs to two chains"),
            Self::Compressed { what, stated } => {
                write!(f, "compressed record: {what} (stated size {stated})")
            }
            Self::Missing {
                kind,
                wanted_by: None,
            } => write!(f, "no such {kind}"),
            Self::Missing {
                kind,
                wanted_by: Some(by),
            } => write!(f, "no such {kind}, wanted by 0x{by:08X}"),
            Self::EndOfRecord { wanted, left } => {
                write!(f, "record ends early: {wanted} bytes wanted, {left} left")
            }
            Self::Count {
                what,
                count,
                least,
                left,
            } => {
                write!(
                    f,
                    "{count} {what} of at least {least} bytes cannot be in the {left} bytes left"
                )
            }
            Self::NegativeCount { what, count } => write!(f, "negative number of {what}: {count}"),
            Self::OwnId { found } => write!(f, "the record says that it is 0x{found:08X}"),
            Self::Unknown { what, found } => write!(f, "unknown {what} 0x{found:08X}"),
            Self::Index { what, found, limit } => {
                write!(f, "{what} {found} is out of range, there are {limit}")
            }
            Self::KeyOrder {
                what,
                expected,
                found,
            } => write!(
                f,
                "{what} key {found}, expected {expected} (keys count up from 0)"
            ),
            Self::DuplicateKey { what, key } => write!(f, "{what} key 0x{key:08X} occurs twice"),
            Self::NotFinite { what } => write!(f, "{what} is not a finite number"),
            Self::NotUnit { norm_squared } => write!(
                f,
                "orientation is not a unit quaternion: squared length {norm_squared}"
            ),
            Self::Padding => write!(f, "alignment bytes are not zero"),
            Self::LeftOver { bytes } => write!(f, "{bytes} bytes left over after the record"),
            Self::TreeDepth { limit } => write!(f, "tree is deeper than {limit} levels"),
            Self::Value {
                what,
                found,
                expected,
            } => write!(f, "{what} is {found}, expected {expected}"),
            Self::CannotEncode { what, found, limit } => {
                write!(f, "cannot write {what}: {found}, at most {limit}")
            }
        }
    }
}

/// Name of a data set number of the header (`spec/11-dat-files.md, 3.2`).
#[must_use]
pub fn data_set_name(data_set: u32) -> &'static str {
    match data_set {
        1 => "portal",
        2 => "cell",
        3 => "local",
        _ => "unknown",
    }
}

/// Where the problem is and what it is. One pointer wide, so that results stay small.
#[derive(Debug, Clone, PartialEq)]
pub struct DatError(Box<Inner>);

#[derive(Debug, Clone, PartialEq)]
struct Inner {
    file: String,
    record: Option<u32>,
    offset: u64,
    problem: Problem,
}

impl DatError {
    /// A problem at byte `offset` of the container file itself.
    #[must_use]
    pub fn in_file(file: &str, offset: u64, problem: Problem) -> Self {
        Self(Box::new(Inner {
            file: file.to_owned(),
            record: None,
            offset,
            problem,
        }))
    }

    /// A problem at byte `offset` of the bytes of record `id`.
    #[must_use]
    pub fn in_record(file: &str, id: u32, offset: u64, problem: Problem) -> Self {
        Self(Box::new(Inner {
            file: file.to_owned(),
            record: Some(id),
            offset,
            problem,
        }))
    }

    /// Name of the file, as it was given at opening.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// Id of the record, if the problem is in one.
    #[must_use]
    pub fn record(&self) -> Option<u32> {
        self.0.record
    }

    /// Byte offset, in the record if there is one, otherwise in the file.
    #[must_use]
    pub fn offset(&self) -> u64 {
        self.0.offset
    }

    /// What was wrong.
    #[must_use]
    pub fn problem(&self) -> &Problem {
        &self.0.problem
    }

    /// What a person can do about it.
    #[must_use]
    pub fn help(&self) -> &'static str {
        self.0.problem.help()
    }
}

impl fmt::Display for DatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Inner {
            file,
            record,
            offset,
            problem,
        } = &*self.0;
        match record {
            Some(id) => write!(
                f,
                "{file}: record 0x{id:08X}, offset 0x{offset:X}: {problem}"
            ),
            None => write!(f, "{file}: offset 0x{offset:X}: {problem}"),
        }
    }
}

impl std::error::Error for DatError {}
