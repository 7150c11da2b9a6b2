//! Placing parts: where the present pose puts them (`spec/07-animation.md`, 6).
//!
//! Most objects are collided with by their spheres and cylinders, and nobody asks where their parts are until they are drawn. So a pose may
//! be taken down and its parts be placed later, when somebody asks; what is taken down is all that the places depend on.

use std::sync::Arc;

use super::part::PhysicsPart;
use super::part_array::PartArray;
use super::sequence::Sequence;
use crate::dat::{Animation, Setup, StoredFrame};
use crate::math::{Frame, Vec3};
use crate::profile::Profile;

/// A pose that has been taken down.
#[derive(Debug, Clone)]
pub(super) struct PendingPose {
    /// Frame of the object.
    frame: Frame,
    scale: Vec3,
    /// `None`: a placement of the setup.
    animation: Option<Arc<Animation>>,
    /// Frame of the animation, or entry of the setup's placements.
    index: usize,
}

/// Parts that wait for their places, and the memory of those that did.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pending {
    waits: bool,
    pose: Option<Box<PendingPose>>,
}

impl Pending {
    pub(super) const NOTHING: Self = Self {
        waits: false,
        pose: None,
    };

    /// What waits is forgotten.
    pub(super) fn clear(&mut self) {
        self.waits = false;
    }
}

/// Places parts by a pose. Parts without a pose frame stay where they are.
fn place(
    parts: &mut [Option<PhysicsPart>],
    pose: &[StoredFrame],
    frame: &Frame,
    scale: Vec3,
    profile: &Profile,
) {
    for (part, local) in parts.iter_mut().zip(pose) {
        if let Some(part) = part {
            let origin = local.origin * scale;
            part.position.frame = frame.combine_origin(origin, local.rotation, profile);
        }
    }
}

/// Part frames of a pose that was taken down.
fn frames_of<'a>(pose: &'a PendingPose, setup: Option<&'a Setup>) -> Option<&'a [StoredFrame]> {
    match &pose.animation {
        Some(animation) => Some(animation.frame(pose.index)?.parts),
        None => {
            let (_, frame) = setup?.placements.entries().get(pose.index)?;
            Some(&frame.parts)
        }
    }
}

/// Where the present pose comes from: animation and frame, or no animation and entry of the setup's placements; and how many parts it
/// places.
#[inline]
fn pose_source<'a>(
    sequence: &'a Sequence,
    setup: Option<&Setup>,
) -> Option<(Option<&'a Arc<Animation>>, usize, usize)> {
    if sequence.current_index().is_some() {
        let animation = sequence.current_node()?.animation()?;
        let index = usize::try_from(sequence.current_frame()).ok()?;
        return (index < animation.frame_count())
            .then(|| (Some(animation), index, animation.part_count()));
    }
    let entry = sequence.placement.entry?;
    let (_, frame) = setup?.placements.entries().get(entry)?;
    Some((None, entry, frame.parts.len()))
}

impl PartArray {
    /// Places the parts by the present pose (`SetFrame`, `UpdateParts`). `frame` is the object's, in landblock coordinates. Parts without a
    /// pose frame stay where they are.
    pub fn update_parts(&mut self, frame: &Frame, profile: &Profile) {
        self.settle_parts(profile);
        if let Some(pose) = super::part_array::pose_of(&self.sequence, self.setup.as_deref()) {
            place(&mut self.parts, pose, frame, self.scale, profile);
        }
    }

    /// As [`PartArray::update_parts`], but the parts get their places only when [`PartArray::settle_parts`] is called.
    pub fn update_parts_later(&mut self, frame: &Frame, profile: &Profile) {
        let Some((animation, index, count)) = pose_source(&self.sequence, self.setup.as_deref())
        else {
            return;
        };
        if self.has_bsp_part || count < self.parts.len() {
            // Movers ask for them at any time, or some parts keep the places that an earlier pose gives them.
            self.update_parts(frame, profile);
            return;
        }
        let scale = self.scale;
        let pending = &mut self.pending;
        pending.waits = true;
        match &mut pending.pose {
            Some(pose) => {
                pose.frame = *frame;
                pose.scale = scale;
                pose.index = index;
                let same = match (&pose.animation, animation) {
                    (Some(old), Some(new)) => Arc::ptr_eq(old, new),
                    (None, None) => true,
                    _ => false,
                };
                if !same {
                    pose.animation = animation.cloned();
                }
            }
            None => {
                pending.pose = Some(Box::new(PendingPose {
                    frame: *frame,
                    scale,
                    animation: animation.cloned(),
                    index,
                }));
            }
        }
    }

    /// Whether the parts wait for their places.
    pub(crate) const fn waits_for_places(&self) -> bool {
        self.pending.waits
    }

    /// Gives the parts the places that they have been waiting for. Whoever looks at places of parts of an object that others may have moved
    /// calls this first; whatever collides with parts has done so.
    pub fn settle_parts(&mut self, profile: &Profile) {
        if !self.pending.waits {
            return;
        }
        self.pending.waits = false;
        if let Some(pose) = &self.pending.pose
            && let Some(frames) = frames_of(pose, self.setup.as_deref())
        {
            place(&mut self.parts, frames, &pose.frame, pose.scale, profile);
        }
    }
}
