//! The header of a container, 80 bytes at 0x140. Source: `spec/11-dat-files.md, 3.1, 3.2, 12.1`.

use serde::Serialize;

use super::super::error::Problem;

/// Offset of the header in the file.
pub const HEADER_AT: usize = 0x140;
/// End of the header; no block begins before it.
pub const HEADER_END: usize = 0x190;
/// `BT`.
pub const MAGIC: u32 = 0x5442;

/// What the header says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Header {
    /// Bytes per block, its link included.
    pub block_size: u32,
    /// Bytes of the file.
    pub file_size: u32,
    /// 1 portal, 2 cell, 3 local.
    pub data_set: u32,
    /// 0 portal; region number of a cell file.
    pub data_subset: u32,
    /// First free block, 0 none.
    pub first_free: u32,
    /// Last free block, 0 none.
    pub last_free: u32,
    /// Number of free blocks.
    pub free_count: u32,
    /// First block of the directory's root, 0 for an empty file.
    pub root: u32,
    /// 0: not in use.
    pub youngest_lru: u32,
    /// 0: not in use.
    pub oldest_lru: u32,
    /// Only the first byte is the flag (D-40); always 0.
    pub use_lru: u32,
    /// 0.
    pub master_map: u32,
    /// Informative.
    pub engine_version: u32,
    /// Informative.
    pub game_version: u32,
    /// A GUID, informative.
    pub version_major: [u8; 16],
    /// Informative.
    pub version_minor: u32,
}

impl Header {
    /// Reads the first 0x190 bytes of a file of `actual` bytes. The answer's second part is a deviation that is no obstacle.
    pub(super) fn parse(
        start: &[u8; HEADER_END],
        actual: u64,
    ) -> Result<(Self, Option<Problem>), (usize, Problem)> {
        let at = |offset: usize| {
            u32::from_le_bytes([
                start[offset],
                start[offset + 1],
                start[offset + 2],
                start[offset + 3],
            ])
        };
        let magic = at(HEADER_AT);
        if magic != MAGIC {
            let problem = Problem::WrongMagic {
                found: magic,
                old_format: at(0x12C) == MAGIC,
            };
            return Err((HEADER_AT, problem));
        }
        let mut version_major = [0; 16];
        version_major.copy_from_slice(&start[0x17C..0x18C]);
        let header = Self {
            block_size: at(0x144),
            file_size: at(0x148),
            data_set: at(0x14C),
            data_subset: at(0x150),
            first_free: at(0x154),
            last_free: at(0x158),
            free_count: at(0x15C),
            root: at(0x160),
            youngest_lru: at(0x164),
            oldest_lru: at(0x168),
            use_lru: at(0x16C),
            master_map: at(0x170),
            engine_version: at(0x174),
            game_version: at(0x178),
            version_major,
            version_minor: at(0x18C),
        };
        let b = header.block_size;
        if !b.is_multiple_of(4) || !(16..=1 << 20).contains(&b) {
            return Err((0x144, Problem::BlockSize { found: b }));
        }
        let stated = u64::from(header.file_size);
        match actual.cmp(&stated) {
            std::cmp::Ordering::Less => Err((0x148, Problem::Truncated { stated, actual })),
            std::cmp::Ordering::Equal => Ok((header, None)),
            std::cmp::Ordering::Greater => {
                Ok((header, Some(Problem::TrailingBytes { stated, actual })))
            }
        }
    }

    /// The 80 bytes at 0x140.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; HEADER_END - HEADER_AT] {
        let mut out = [0; HEADER_END - HEADER_AT];
        let words = [
            MAGIC,
            self.block_size,
            self.file_size,
            self.data_set,
            self.data_subset,
            self.first_free,
            self.last_free,
            self.free_count,
            self.root,
            self.youngest_lru,
            self.oldest_lru,
            self.use_lru,
            self.master_map,
            self.engine_version,
            self.game_version,
        ];
        for (i, w) in words.iter().enumerate() {
            out[4 * i..4 * i + 4].copy_from_slice(&w.to_le_bytes());
        }
        out[0x3C..0x4C].copy_from_slice(&self.version_major);
        out[0x4C..].copy_from_slice(&self.version_minor.to_le_bytes());
        out
    }

    /// Payload bytes of a block.
    #[must_use]
    pub fn payload(&self) -> usize {
        self.block_size as usize - 4
    }

    /// True if `offset` is that of a block of this file.
    #[must_use]
    pub fn is_block(&self, offset: u32) -> bool {
        offset >= HEADER_END as u32
            && offset >> 31 == 0
            && u64::from(offset) + u64::from(self.block_size) <= u64::from(self.file_size)
            && offset.is_multiple_of(self.block_size)
    }

    /// Offset of the first block.
    #[must_use]
    pub fn first_block(&self) -> u32 {
        (HEADER_END as u32).next_multiple_of(self.block_size)
    }

    /// Number of blocks after the header.
    #[must_use]
    pub fn block_count(&self) -> u64 {
        u64::from(self.file_size.saturating_sub(self.first_block()) / self.block_size)
    }

    /// Blocks that hold `size` bytes.
    #[must_use]
    pub fn blocks_for(&self, size: u64) -> u64 {
        size.div_ceil(self.payload() as u64).max(1)
    }
}
