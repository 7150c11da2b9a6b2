//! Animation: part frames, root motion and hooks of each frame, 0x03...... Source: `spec/11-dat-files.md, 9.3`.

use bitflags::bitflags;
use serde::{Serialize, Serializer};

use super::anim_frame::{AnimFrame, write_hooks};
use super::frame::StoredFrame;
use super::hook::AnimationHook;
use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

bitflags! {
    /// Flags of an animation.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
    pub struct AnimationFlags: u32 {
        /// Root motion frames follow.
        const ROOT_MOTION = 1;
        /// Some frame has hooks; informative, hook counts are always present.
        const HOOKS = 2;
    }
}

/// An animation. All frames share one list of part frames and one of hooks: a walk has dozens of frames of as many parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Own id.
    pub id: u32,
    /// Flags.
    pub flags: AnimationFlags,
    part_count: u32,
    /// Root motion of each frame; empty if not stored.
    root_frames: Vec<StoredFrame>,
    /// `part_count` frames for each frame.
    part_frames: Vec<StoredFrame>,
    hooks: Vec<AnimationHook>,
    /// End of each frame's hooks.
    hook_ends: Vec<u32>,
}

/// One frame of an animation, a view.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AnimFrameRef<'a> {
    /// Place of each part in the object's space.
    pub parts: &'a [StoredFrame],
    /// Hooks, in order of execution.
    pub hooks: &'a [AnimationHook],
}

impl Animation {
    /// An animation without frames.
    #[must_use]
    pub fn new(id: u32, part_count: u32) -> Self {
        Self {
            id,
            flags: AnimationFlags::empty(),
            part_count,
            root_frames: Vec::new(),
            part_frames: Vec::new(),
            hooks: Vec::new(),
            hook_ends: Vec::new(),
        }
    }

    /// Number of parts.
    #[must_use]
    pub fn part_count(&self) -> usize {
        self.part_count as usize
    }

    /// Number of frames; 0 is possible in a damaged file.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.hook_ends.len()
    }

    /// Root motion that belongs to frame `i`; `None` without root motion.
    #[must_use]
    pub fn root_frame(&self, i: usize) -> Option<&StoredFrame> {
        self.root_frames.get(i)
    }

    /// Root motion of every frame; empty if not stored.
    #[must_use]
    pub fn root_frames(&self) -> &[StoredFrame] {
        &self.root_frames
    }

    /// Frame `i`.
    #[must_use]
    pub fn frame(&self, i: usize) -> Option<AnimFrameRef<'_>> {
        let end = *self.hook_ends.get(i)? as usize;
        let begin = if i == 0 {
            0
        } else {
            self.hook_ends[i - 1] as usize
        };
        let p = self.part_count();
        Some(AnimFrameRef {
            parts: self.part_frames.get(i * p..(i + 1) * p)?,
            hooks: self.hooks.get(begin..end)?,
        })
    }

    /// Whether any frame has hooks.
    #[must_use]
    pub fn has_hooks(&self) -> bool {
        !self.hooks.is_empty()
    }

    /// All frames in order.
    pub fn frames(&self) -> impl Iterator<Item = AnimFrameRef<'_>> {
        (0..self.frame_count()).filter_map(|i| self.frame(i))
    }

    /// Adds a frame. Root motion must be given for all frames or for none.
    pub fn push(&mut self, frame: AnimFrame, root: Option<StoredFrame>) {
        self.part_frames.extend(frame.parts);
        self.hooks.extend(frame.hooks);
        self.hook_ends.push(self.hooks.len() as u32);
        if let Some(root) = root {
            self.root_frames.push(root);
            self.flags |= AnimationFlags::ROOT_MOTION;
        }
    }
}

impl Record for Animation {
    const KIND: RecordKind = RecordKind::Animation;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let flags = AnimationFlags::from_bits_retain(r.u32()?);
        let (part_count, f) = (r.u32()?, r.u32()?);
        let f = r.fits(
            "frames",
            u64::from(f),
            AnimFrame::least(part_count as usize),
        )?;
        let mut root_frames = Vec::new();
        if flags.contains(AnimationFlags::ROOT_MOTION) {
            let n = r.fits("root motion frames", f as u64, 28)?;
            root_frames = r.many(n, Reader::frame)?;
        }
        let parts = part_count as usize;
        let f = r.fits("frames", f as u64, AnimFrame::least(parts))?;
        let mut part_frames = Vec::with_capacity(f * parts);
        let (mut hooks, mut hook_ends) = (Vec::new(), Vec::with_capacity(f));
        for _ in 0..f {
            for _ in 0..parts {
                part_frames.push(r.frame()?);
            }
            for _ in 0..r.count_u32("hooks", AnimationHook::LEAST)? {
                hooks.push(AnimationHook::parse(r)?);
            }
            hook_ends.push(hooks.len() as u32);
        }
        Ok(Self {
            id,
            flags,
            part_count,
            root_frames,
            part_frames,
            hooks,
            hook_ends,
        })
    }

    fn write(&self, w: &mut Writer) {
        let f = self.frame_count();
        w.u32(self.id);
        w.u32(self.flags.bits());
        w.u32(self.part_count);
        w.count_u32("frames", f);
        w.same_len(
            "root motion frames",
            self.root_frames.len(),
            if self.flags.contains(AnimationFlags::ROOT_MOTION) {
                f
            } else {
                0
            },
        );
        w.same_len("part frames", self.part_frames.len(), f * self.part_count());
        for frame in &self.root_frames {
            w.frame(frame);
        }
        for frame in self.frames() {
            for part in frame.parts {
                w.frame(part);
            }
            write_hooks(w, frame.hooks);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}

impl Serialize for Animation {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct View<'a> {
            #[serde(serialize_with = "super::json::hex")]
            id: u32,
            flags: AnimationFlags,
            part_count: u32,
            root_frames: &'a [StoredFrame],
            frames: Vec<AnimFrameRef<'a>>,
        }
        View {
            id: self.id,
            flags: self.flags,
            part_count: self.part_count,
            root_frames: &self.root_frames,
            frames: self.frames().collect(),
        }
        .serialize(s)
    }
}
