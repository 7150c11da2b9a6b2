//! The region's height table (`spec/02-terrain.md`, section 4; `spec/01`, 10.2).

use std::sync::Arc;

/// Heights in metres for the 256 height indices of landblock records. Shared; cloning is cheap.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightTable(Arc<[f32; 256]>);

impl HeightTable {
    /// The table of a region record. `None` if the list does not have 256 entries.
    pub fn new(heights: &[f32]) -> Option<Self> {
        Some(Self(Arc::new(heights.try_into().ok()?)))
    }

    /// Twice the index: what is used without a region record.
    pub fn linear() -> Self {
        Self(Arc::new(std::array::from_fn(|i| 2.0 * i as f32)))
    }

    /// Height of an index, m.
    pub fn height(&self, index: u8) -> f32 {
        self.0[usize::from(index)]
    }
}

impl Default for HeightTable {
    fn default() -> Self {
        Self::linear()
    }
}
