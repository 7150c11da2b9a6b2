//! The container: header, blocks, chains, directory. Source: `spec/11-dat-files.md, 3`.

mod check;
mod file;
mod header;
mod node;
mod source;
mod write;

pub use check::{BlockCounts, ContainerReport};
pub use file::{DatFile, MAX_EXPANDED, MAX_LEVELS, MAX_RECORD, ReadCounts};
pub use header::{HEADER_AT, HEADER_END, Header, MAGIC};
pub use node::{Entry, NODE_BRANCHES, NODE_ENTRIES, NODE_LEAST, NODE_SIZE};
pub use source::ReadAt;
pub use write::{DatBuilder, Placement};
