//! Consistency of a whole container: what a reader of single records does not see. Source: `spec/11-dat-files.md, 3.4, 12.2, 15`.

use serde::Serialize;

use super::super::error::{DatError, Problem};
use super::file::DatFile;
use super::node::{Entry, NODE_LEAST, NODE_SIZE};

/// What a check found.
#[derive(Debug, Default)]
pub struct ContainerReport {
    /// Entries of the directory, as far as it could be walked.
    pub entries: Vec<Entry>,
    /// What is wrong.
    pub errors: Vec<DatError>,
    /// Numbers.
    pub blocks: BlockCounts,
}

/// What the blocks of a file are used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct BlockCounts {
    /// Blocks after the header.
    pub total: u64,
    /// Blocks of records.
    pub records: u64,
    /// Blocks of directory nodes.
    pub nodes: u64,
    /// Free blocks.
    pub free: u64,
    /// Blocks that nothing refers to.
    pub lost: u64,
    /// Levels of the directory.
    pub levels: u64,
}

/// Which blocks are taken, one bit each.
struct Blocks {
    taken: Vec<u64>,
    first: u32,
    size: u32,
}

impl Blocks {
    /// Marks a block; false if it was taken already.
    fn take(&mut self, offset: u32) -> bool {
        let number = (offset.saturating_sub(self.first) / self.size) as usize;
        let Some(word) = self.taken.get_mut(number / 64) else {
            return false;
        };
        let bit = 1 << (number % 64);
        let free = *word & bit == 0;
        *word |= bit;
        free
    }
}

impl DatFile {
    /// Checks directory, chains and free list of the whole file. Reads every block once; parses no record.
    #[must_use]
    pub fn check(&self) -> ContainerReport {
        let header = self.header();
        let mut report = ContainerReport::default();
        let mut blocks = Blocks {
            taken: vec![0; (header.block_count() as usize).div_ceil(64)],
            first: header.first_block(),
            size: header.block_size,
        };
        report.blocks.total = header.block_count();
        self.check_directory(&mut report, &mut blocks);
        self.check_records(&mut report, &mut blocks);
        self.check_free_list(&mut report, &mut blocks);
        let used = report.blocks.records + report.blocks.nodes + report.blocks.free;
        report.blocks.lost = report.blocks.total.saturating_sub(used);
        report
    }

    fn check_directory(&self, report: &mut ContainerReport, blocks: &mut Blocks) {
        let mut nodes = Vec::new();
        let walked = self.walk(
            |offset, node, depth| nodes.push((offset, node.entries.len(), node.is_leaf(), depth)),
            |entry| report.entries.push(*entry),
        );
        report.errors.extend(walked.err());
        report.blocks.levels = nodes.iter().map(|n| n.3 as u64 + 1).max().unwrap_or(0);
        let leaf_depth = nodes.iter().find(|n| n.2).map(|n| n.3);
        for (offset, entries, leaf, depth) in nodes {
            if depth > 0 && entries < NODE_LEAST {
                let what = "entries of a node below the root, at least 30";
                report.errors.push(self.error(
                    offset,
                    Problem::Unbalanced {
                        what,
                        found: entries as u64,
                    },
                ));
            }
            if leaf && Some(depth) != leaf_depth {
                let what = "depth of a leaf";
                report.errors.push(self.error(
                    offset,
                    Problem::Unbalanced {
                        what,
                        found: depth as u64,
                    },
                ));
            }
            let taken = self.check_chain(offset, NODE_SIZE as u64, blocks);
            match taken {
                Ok(n) => report.blocks.nodes += n,
                Err((at, p)) => report.errors.push(self.error(at, p)),
            }
        }
    }

    fn check_records(&self, report: &mut ContainerReport, blocks: &mut Blocks) {
        for entry in &report.entries {
            match self.check_chain(entry.offset, u64::from(entry.size), blocks) {
                Ok(n) => report.blocks.records += n,
                Err((_, p)) => report
                    .errors
                    .push(DatError::in_record(self.name(), entry.id, 0, p)),
            }
        }
    }

    /// Marks the blocks of a chain and answers their number.
    fn check_chain(
        &self,
        start: u32,
        size: u64,
        blocks: &mut Blocks,
    ) -> Result<u64, (u32, Problem)> {
        let (mut n, mut shared) = (0, None);
        self.chain(start, size, |block| {
            n += 1;
            if !blocks.take(block) {
                shared.get_or_insert(block);
            }
        })?;
        match shared {
            Some(block) => Err((block, Problem::SharedBlock { block })),
            None => Ok(n),
        }
    }

    fn check_free_list(&self, report: &mut ContainerReport, blocks: &mut Blocks) {
        let header = self.header();
        let mut block = header.first_free;
        while block != 0 {
            let problem = if !header.is_block(block) {
                Some(Problem::BlockOffset { found: block })
            } else if !blocks.take(block) {
                // Also ends a free list that runs in a circle.
                Some(Problem::SharedBlock { block })
            } else {
                None
            };
            if let Some(p) = problem {
                report.errors.push(self.error(block, p));
                return;
            }
            report.blocks.free += 1;
            match self.link(block) {
                Ok(link) if link >> 31 != 0 => block = link & 0x7FFF_FFFF,
                // D-41: one writer leaves free blocks in a row without links. They are counted from the header then.
                Ok(_) => {
                    report.blocks.free = u64::from(header.free_count);
                    return;
                }
                Err((at, p)) => {
                    report.errors.push(self.error(at, p));
                    return;
                }
            }
        }
        if report.blocks.free != u64::from(header.free_count) {
            let found = report.blocks.free as i64;
            let expected = "the free block count of the header";
            report.errors.push(self.error(
                0x15C,
                Problem::Value {
                    what: "length of the free list",
                    found,
                    expected,
                },
            ));
        }
    }
}
