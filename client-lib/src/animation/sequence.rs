//! The playing list (`spec/07-animation.md`, 8; retail `CSequence`).

use std::collections::VecDeque;

use super::node::AnimSequenceNode;
use super::source::AnimationSource;
use crate::dat::{AnimRange, StoredFrame};
use crate::math::{Vec3, floor64};
use crate::profile::Profile;

/// The static pose that shows while nothing plays: an entry of the setup's placement frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Placement {
    /// Which entry of the setup's list; `None`: no pose.
    pub entry: Option<usize>,
    /// Its key; 0 also stands for "none".
    pub id: i32,
}

/// Animations that are being played and are about to be, and the velocities that go with them.
///
/// The last node is the cycle, which repeats; all before it are links, which play once. Retail keeps a pointer to the first cyclic node; every
/// operation leaves it at the tail, so it needs no field. Between calls the current node is the head.
#[derive(Debug, Clone, Default)]
pub struct Sequence {
    pub(crate) nodes: VecDeque<AnimSequenceNode>,
    pub(crate) current: Option<usize>,
    /// Frames, f64. Profile `ace` computes in f32 and keeps the f32 value here (`N-01`).
    pub(crate) frame_number: f64,
    /// Metres per second in the object's axes.
    pub velocity: Vec3,
    /// Radians per second in the object's axes.
    pub omega: Vec3,
    /// Pose while nothing plays.
    pub placement: Placement,
}

impl Sequence {
    /// An empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// A sequence in a stored state. A `current` that is no index of `nodes` becomes the head.
    pub fn from_state(
        nodes: impl IntoIterator<Item = AnimSequenceNode>,
        current: Option<usize>,
        frame_number: f64,
        velocity: Vec3,
        omega: Vec3,
    ) -> Self {
        let nodes: VecDeque<_> = nodes.into_iter().collect();
        let head = (!nodes.is_empty()).then_some(0);
        Self {
            current: current.filter(|i| *i < nodes.len()).or(head),
            nodes,
            frame_number,
            velocity,
            omega,
            placement: Placement::default(),
        }
    }

    /// Nodes in playing order.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = &AnimSequenceNode> {
        self.nodes.iter()
    }

    /// Whether anything is in the list (`has_anims`).
    pub fn has_animations(&self) -> bool {
        !self.nodes.is_empty()
    }

    /// Index of the current node.
    pub fn current_index(&self) -> Option<usize> {
        self.current
    }

    /// The node that is being played.
    pub fn current_node(&self) -> Option<&AnimSequenceNode> {
        self.nodes.get(self.current?)
    }

    /// Index of the cycle: the last node.
    pub fn first_cyclic_index(&self) -> Option<usize> {
        self.nodes.len().checked_sub(1)
    }

    /// Whether the current node is the cycle. `false` for an empty list, as in traces (retail's `is_first_cyclic` answers `true` there).
    pub fn plays_cycle(&self) -> bool {
        self.current.is_some() && self.current == self.first_cyclic_index()
    }

    /// Frame number, with its fraction.
    pub fn frame_number(&self) -> f64 {
        self.frame_number
    }

    /// Sets the frame number: for state that was stored.
    pub fn set_frame_number(&mut self, frame_number: f64) {
        self.frame_number = frame_number;
    }

    /// Whole frame number (`get_curr_frame_number`).
    pub fn current_frame(&self) -> i32 {
        floor64(self.frame_number) as i32
    }

    /// Part frames of the current animation frame; `None` if nothing plays or the frame lies outside the animation.
    pub fn current_pose(&self) -> Option<&[StoredFrame]> {
        let frame = self.current_node()?.part_frame(self.current_frame())?;
        Some(frame.parts)
    }

    /// Adds a velocity and a turn rate.
    pub fn combine_physics(&mut self, velocity: Vec3, omega: Vec3) {
        self.velocity += velocity;
        self.omega += omega;
    }

    /// Takes a velocity and a turn rate off.
    pub fn subtract_physics(&mut self, velocity: Vec3, omega: Vec3) {
        self.velocity -= velocity;
        self.omega -= omega;
    }

    /// Velocity and turn rate become zero.
    pub fn clear_physics(&mut self) {
        self.velocity = Vec3::ZERO;
        self.omega = Vec3::ZERO;
    }

    /// Empties the list.
    pub fn clear_animations(&mut self) {
        self.nodes.clear();
        self.current = None;
        self.frame_number = 0.0;
    }

    /// Empties the list, the velocities and the placement.
    pub fn clear(&mut self) {
        self.clear_animations();
        self.clear_physics();
        self.placement = Placement::default();
    }

    /// Appends a range of an animation; it becomes the cycle. A missing animation is left out, or appended empty (`N-12`).
    pub fn append_animation(
        &mut self,
        range: &AnimRange,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) {
        if let Some(node) = AnimSequenceNode::new(range, source, profile) {
            self.append_node(node);
        }
    }

    fn append_node(&mut self, node: AnimSequenceNode) {
        self.nodes.push_back(node);
        if self.current.is_none() {
            self.enter(0);
        }
    }

    /// Makes a node the current one, at its start.
    pub(super) fn enter(&mut self, index: usize) {
        if let Some(node) = self.nodes.get(index) {
            self.frame_number = node.starting_frame();
            self.current = Some(index);
        }
    }

    /// Removes the cycle. A link that is playing stays; if the cycle was playing, the last link's end becomes current.
    pub fn remove_cyclic_animations(&mut self) {
        let Some(cycle) = self.first_cyclic_index() else {
            return;
        };
        if self.current == Some(cycle) {
            self.current = cycle.checked_sub(1);
            let last_link = self.current.and_then(|i| self.nodes.get(i));
            self.frame_number = last_link.map_or(0.0, AnimSequenceNode::ending_frame);
        }
        self.nodes.pop_back();
    }

    /// Removes up to `count` links, the one before the cycle first. If a removed one was playing, the cycle starts.
    pub fn remove_link_animations(&mut self, count: u32) {
        for _ in 0..count {
            let Some(cycle) = self.first_cyclic_index() else {
                return;
            };
            let Some(link) = cycle.checked_sub(1) else {
                return;
            };
            let (was_link, was_cycle) = (self.current == Some(link), self.current == Some(cycle));
            self.nodes.remove(link);
            if was_link {
                self.enter(link);
            } else if was_cycle {
                self.current = Some(link);
            }
        }
    }

    /// Removes all links.
    pub fn remove_all_link_animations(&mut self) {
        self.remove_link_animations(u32::MAX);
    }

    /// Drops the links that were played (`apricot`).
    pub(super) fn drop_played(&mut self) {
        while self.nodes.len() > 1 && self.current != Some(0) {
            self.nodes.pop_front();
            self.current = self.current.map(|i| i - 1);
        }
    }

    /// Multiplies the rate of the cycle; the frame number stays.
    pub fn multiply_cyclic_rate(&mut self, factor: f32) {
        if let Some(cycle) = self.nodes.back_mut() {
            cycle.multiply_rate(factor);
        }
    }
}
