//! One entry of the playing list (`spec/07-animation.md`, 7; retail `AnimSequenceNode`).

use std::sync::Arc;

use super::source::AnimationSource;
use crate::dat::{AnimFrameRef, AnimRange, Animation, AnimationHook, StoredFrame};
use crate::math::EPSILON;
use crate::profile::{AnimationBounds, Profile};

/// An animation with a range of frames and a rate.
#[derive(Debug, Clone)]
pub struct AnimSequenceNode {
    /// `None` only where the profile appends missing animations (`N-12`).
    pub(crate) animation: Option<Arc<Animation>>,
    /// Frames per second; negative plays backwards, zero stands still.
    pub rate: f32,
    /// First frame of the range.
    pub low: i32,
    /// Last frame of the range, inclusive.
    pub high: i32,
}

impl AnimSequenceNode {
    /// A node for a range of an animation, its bounds fitted to the number of frames.
    ///
    /// `None` if the animation is missing and the profile does not append missing animations (`N-11`, `N-12`).
    pub fn new(
        range: &AnimRange,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) -> Option<Self> {
        let animation = source.animation(range.animation);
        if animation.is_none() && profile.animation_bounds == AnimationBounds::LastFrame {
            return None;
        }
        let mut node = Self {
            animation,
            rate: range.framerate,
            low: range.low_frame,
            high: range.high_frame,
        };
        node.fit_bounds(profile);
        Some(node)
    }

    /// A node whose bounds were fitted before: for state that was stored.
    pub fn from_state(animation: Arc<Animation>, low: i32, high: i32, rate: f32) -> Self {
        Self {
            animation: Some(animation),
            rate,
            low,
            high,
        }
    }

    fn fit_bounds(&mut self, profile: &Profile) {
        let count = self
            .animation
            .as_ref()
            .map_or(0, |a| i32::try_from(a.frame_count()).unwrap_or(i32::MAX));
        let last = count - 1;
        if self.high < 0 {
            self.high = last;
        }
        // Retail compares unsigned, so that a negative low frame counts as beyond the end.
        let beyond = |i: i32| match profile.animation_bounds {
            AnimationBounds::LastFrame => i as u32 >= count as u32,
            AnimationBounds::Kept => i >= count,
        };
        if beyond(self.low) {
            self.low = last;
        }
        if beyond(self.high) {
            self.high = last;
        }
        if self.low > self.high {
            self.high = self.low;
        }
    }

    /// The animation; `None` for one that is missing.
    #[inline]
    pub(super) fn animation(&self) -> Option<&Arc<Animation>> {
        self.animation.as_ref()
    }

    /// Id of the animation; 0 for an animation that is missing.
    pub fn animation_id(&self) -> u32 {
        self.animation.as_ref().map_or(0, |a| a.id)
    }

    /// Frame number at which playing begins.
    pub fn starting_frame(&self) -> f64 {
        if self.rate < 0.0 {
            self.end_of_high()
        } else {
            f64::from(self.low as f32)
        }
    }

    /// Frame number at which playing ends.
    pub fn ending_frame(&self) -> f64 {
        if self.rate < 0.0 {
            f64::from(self.low as f32)
        } else {
            self.end_of_high()
        }
    }

    /// A hair below `high + 1`. The subtraction is f32: from 4097 on nothing is left of the hair.
    fn end_of_high(&self) -> f64 {
        f64::from(self.high.wrapping_add(1) as f32 - EPSILON)
    }

    /// Multiplies the rate; a negative factor also exchanges the bounds.
    pub fn multiply_rate(&mut self, factor: f32) {
        if factor < 0.0 {
            core::mem::swap(&mut self.low, &mut self.high);
        }
        self.rate *= factor;
    }

    /// Pose and hooks of a frame; `None` outside the animation.
    pub fn part_frame(&self, index: i32) -> Option<AnimFrameRef<'_>> {
        self.animation.as_ref()?.frame(usize::try_from(index).ok()?)
    }

    /// Root motion of a frame; `None` outside the animation or without root motion.
    pub fn pos_frame(&self, index: i32) -> Option<&StoredFrame> {
        self.animation
            .as_ref()?
            .root_frame(usize::try_from(index).ok()?)
    }

    /// Whether the animation has root motion, be it zero.
    pub fn has_root_motion(&self) -> bool {
        let frames = self.animation.as_ref().map(|a| a.root_frames());
        frames.is_some_and(|frames| !frames.is_empty())
    }

    /// Whether frames of the animation have hooks.
    #[inline]
    pub(super) fn has_hooks(&self) -> bool {
        self.animation.as_ref().is_some_and(|a| a.has_hooks())
    }

    /// All hooks of the animation, of whatever frame and direction.
    pub fn hooks(&self) -> impl Iterator<Item = &AnimationHook> {
        let animation = self.animation.iter();
        animation.flat_map(|a| a.frames().flat_map(|frame| frame.hooks))
    }

    /// Whether velocity acts while this node plays: at a rate within ε of zero one frame would take too long to divide by.
    #[inline]
    pub(super) fn rate_counts(&self) -> bool {
        self.rate.abs() > EPSILON
    }
}
