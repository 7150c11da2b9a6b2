//! One pose: a frame for every part, and the hooks that fire with it. Source: `spec/11-dat-files.md, 5.5`.

use serde::Serialize;

use super::frame::StoredFrame;
use super::hook::AnimationHook;
use super::reader::{Read, Reader};
use super::writer::Writer;

/// One pose. Its size depends on the part count of the record around it.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct AnimFrame {
    /// Place of each part in the object's space.
    pub parts: Vec<StoredFrame>,
    /// Hooks, in order of execution.
    pub hooks: Vec<AnimationHook>,
}

impl AnimFrame {
    /// Least bytes with this number of parts.
    #[must_use]
    pub fn least(parts: usize) -> usize {
        parts.saturating_mul(28).saturating_add(4)
    }

    pub(super) fn parse(r: &mut Reader<'_>, parts: usize) -> Read<Self> {
        let n = r.fits("part frames", parts as u64, 28)?;
        let parts = r.many(n, Reader::frame)?;
        let n = r.count_u32("hooks", AnimationHook::LEAST)?;
        Ok(Self {
            parts,
            hooks: r.many(n, AnimationHook::parse)?,
        })
    }

    pub(super) fn write(&self, w: &mut Writer, parts: usize) {
        w.same_len("part frames", self.parts.len(), parts);
        for p in &self.parts {
            w.frame(p);
        }
        write_hooks(w, &self.hooks);
    }
}

pub(super) fn write_hooks(w: &mut Writer, hooks: &[AnimationHook]) {
    w.count_u32("hooks", hooks.len());
    for h in hooks {
        h.write(w);
    }
}
