//! Advancing the playing list by a quantum (`spec/07-animation.md`, 8.5 to 8.9).
//!
//! Velocities and root motion act in whole animation frames: a frame that is crossed moves the object by what belongs to it, and a quantum
//! that crosses none moves nothing.

use super::error::AnimationError;
use super::hooks::AnimHookQueue;
use super::node::AnimSequenceNode;
use super::sequence::Sequence;
use crate::dat::{HookAction, HookDirection, StoredFrame};
use crate::math::{EPSILON, Frame, Vec3, floor64};
use crate::profile::{Profile, Width};

/// Passes, and frames crossed, of one update. Quanta of 2 s at a rate of 100 000 stay far below.
const STEP_LIMIT: u32 = 1 << 20;
/// Hooks queued by one update; an animation that crosses this many is damaged.
const HOOK_LIMIT: usize = 1 << 16;

/// Which way frames are crossed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Playing {
    /// Root motion is added.
    Up,
    /// Root motion is taken off again.
    Down,
}

/// One update: what it writes to besides the list itself.
struct Update<'a> {
    offset: Option<&'a mut Frame>,
    hooks: &'a mut AnimHookQueue,
    hooks_before: usize,
    profile: &'a Profile,
    velocity: Vec3,
    omega: Vec3,
    steps_left: u32,
}

/// `N-01`: rounds to f32 where the frame number is one. One f64 operation on f32 values, rounded, is the f32 operation.
#[inline]
fn narrow(x: f64, profile: &Profile) -> f64 {
    match profile.frame_number {
        Width::F64 => x,
        Width::F32 => f64::from(x as f32),
    }
}

impl Sequence {
    /// Advances by `t` seconds. Root motion and velocity are added to `offset` (the object's own axes, m), hooks of the frames crossed are
    /// queued behind those in `hooks`. Without an offset frame no movement is computed and everything else happens.
    ///
    /// # Errors
    /// Inputs on which the references hang: infinite rates or times. The list is left as it was at that point.
    pub fn update(
        &mut self,
        t: f64,
        offset: Option<&mut Frame>,
        hooks: &mut AnimHookQueue,
        profile: &Profile,
    ) -> Result<(), AnimationError> {
        if self.advance_within_node(t, offset.is_some(), profile) {
            return Ok(());
        }
        let mut update = Update {
            hooks_before: hooks.len(),
            offset,
            hooks,
            profile,
            velocity: self.velocity,
            omega: self.omega,
            steps_left: STEP_LIMIT,
        };
        let t = update.narrow(t);
        if self.nodes.is_empty() {
            update.apply_physics(t, t);
            return Ok(());
        }
        let result = self.play(t, &mut update);
        self.drop_played();
        result
    }

    /// The plain case of an update, forwards and within the current node: no frame is crossed, or nothing comes of those that are. `false`: it is
    /// not, and nothing was done.
    fn advance_within_node(&mut self, t: f64, moves: bool, profile: &Profile) -> bool {
        /// Frames that may be crossed here.
        const FEW: f64 = 1000.0;
        let Some(node) = self.nodes.front().filter(|_| self.current == Some(0)) else {
            return false;
        };
        let t = narrow(t, profile);
        let advance = narrow(f64::from(node.rate) * t, profile);
        let (before, frame) = (
            self.frame_number,
            narrow(self.frame_number + advance, profile),
        );
        let stays =
            advance > 0.0 && advance < FEW && before >= 0.0 && frame < f64::from(node.high) + 1.0;
        if !stays {
            return false;
        }
        let crosses = before as i64 != frame as i64;
        if crosses && (moves || node.has_hooks()) {
            return false;
        }
        self.frame_number = frame;
        true
    }

    /// Plays nodes until the time is used up (`update_internal`).
    fn play(&mut self, mut t: f64, update: &mut Update<'_>) -> Result<(), AnimationError> {
        while let Some(left) = self.play_node(t, update)? {
            // A node has ended; only ends of links count as an animation done, but the head stays the head until the update is over.
            if self.nodes.len() > 1 {
                update.queue(HookAction::AnimationDone, self.playing_id())?;
            }
            self.advance_to_next(t, update);
            t = left;
        }
        Ok(())
    }

    fn playing_id(&self) -> u32 {
        self.current_node()
            .map_or(0, AnimSequenceNode::animation_id)
    }

    /// One pass: advances within the current node. Answers the time that is left if the node ended.
    fn play_node(
        &mut self,
        t: f64,
        update: &mut Update<'_>,
    ) -> Result<Option<f64>, AnimationError> {
        let Some(node) = self.current.and_then(|i| self.nodes.get(i)) else {
            return Ok(None);
        };
        update.step(node)?;
        let rate = f64::from(node.rate);
        let advance = update.narrow(rate * t);
        let before = self.frame_number;
        let mut frame = update.narrow(before + advance);
        let mut left = None;
        if advance > 0.0 {
            let high = f64::from(node.high);
            if high < floor64(frame) {
                let over = update.narrow(update.narrow(frame - high) - 1.0);
                left = Some(update.time_left(node, if over < 0.0 { 0.0 } else { over }));
                frame = high;
            }
            update.cross(node, Playing::Up, floor64(before), floor64(frame), t)?;
        } else if advance < 0.0 {
            let low = f64::from(node.low);
            if low > floor64(frame) {
                let over = update.narrow(frame - low);
                left = Some(update.time_left(node, if over > 0.0 { 0.0 } else { over }));
                frame = low;
            }
            update.cross(node, Playing::Down, floor64(before), floor64(frame), t)?;
        } else if t.abs() > f64::from(EPSILON) {
            update.apply_physics(t, t);
        }
        self.frame_number = frame;
        Ok(left)
    }

    /// Hands over from a node that ended to the next, which may be the same (`advance_to_next_animation`). No hooks.
    fn advance_to_next(&mut self, t: f64, update: &mut Update<'_>) {
        let (Some(current), Some(tail)) = (self.current, self.first_cyclic_index()) else {
            return;
        };
        // Time never runs backwards on the client path; kept for completeness.
        let forwards = t >= 0.0;
        self.hand_over(
            current,
            t,
            update,
            |rate| {
                if forwards { rate < 0.0 } else { rate >= 0.0 }
            },
            Playing::Down,
        );
        let next = if forwards {
            (current + 1).min(tail)
        } else {
            current.checked_sub(1).unwrap_or(tail)
        };
        self.enter(next);
        if !forwards && let Some(node) = self.nodes.get(next) {
            self.frame_number = node.ending_frame();
        }
        self.hand_over(
            next,
            t,
            update,
            |rate| {
                if forwards { rate > 0.0 } else { rate < 0.0 }
            },
            Playing::Up,
        );
    }

    /// Applies the frame at which a node is entered or left, if it plays in the direction for which this frame is due.
    fn hand_over(
        &self,
        index: usize,
        t: f64,
        update: &mut Update<'_>,
        is_due: impl Fn(f32) -> bool,
        playing: Playing,
    ) {
        if let Some(node) = self.nodes.get(index)
            && is_due(node.rate)
        {
            update.move_by(node, node.pos_frame(self.current_frame()), playing, t);
        }
    }
}

impl Update<'_> {
    fn narrow(&self, x: f64) -> f64 {
        narrow(x, self.profile)
    }

    fn step(&mut self, node: &AnimSequenceNode) -> Result<(), AnimationError> {
        self.steps_left = self
            .steps_left
            .checked_sub(1)
            .ok_or(AnimationError::Endless {
                animation: node.animation_id(),
            })?;
        Ok(())
    }

    fn queue(&mut self, hook: HookAction, animation: u32) -> Result<(), AnimationError> {
        if self.hooks.len() - self.hooks_before >= HOOK_LIMIT {
            return Err(AnimationError::TooManyHooks {
                animation,
                limit: HOOK_LIMIT,
            });
        }
        self.hooks.push(hook);
        Ok(())
    }

    /// Time that is left after a node ended `over` frames ago.
    fn time_left(&self, node: &AnimSequenceNode, over: f64) -> f64 {
        if node.rate_counts() {
            self.narrow(over / f64::from(node.rate))
        } else {
            0.0
        }
    }

    /// Crosses the frames from `last` to `now` (whole numbers).
    fn cross(
        &mut self,
        node: &AnimSequenceNode,
        playing: Playing,
        mut last: f64,
        now: f64,
        t: f64,
    ) -> Result<(), AnimationError> {
        let (step, direction) = match playing {
            Playing::Up => (1.0, HookDirection::FORWARD),
            Playing::Down => (-1.0, HookDirection::BACKWARD),
        };
        while if playing == Playing::Up {
            now > last
        } else {
            now < last
        } {
            self.step(node)?;
            let index = last as i32;
            self.move_by(node, node.pos_frame(index), playing, t);
            self.execute_hooks(node, index, direction)?;
            last += step;
        }
        Ok(())
    }

    /// Queues the hooks of a frame that fire in this direction.
    fn execute_hooks(
        &mut self,
        node: &AnimSequenceNode,
        index: i32,
        direction: HookDirection,
    ) -> Result<(), AnimationError> {
        let Some(frame) = node.part_frame(index) else {
            return Ok(());
        };
        for hook in frame.hooks {
            if hook.direction == HookDirection::BOTH || hook.direction == direction {
                self.queue(hook.action, node.animation_id())?;
            }
        }
        Ok(())
    }

    /// Root motion of one frame, and the velocities for its duration.
    fn move_by(
        &mut self,
        node: &AnimSequenceNode,
        pos_frame: Option<&StoredFrame>,
        playing: Playing,
        t: f64,
    ) {
        let Some(offset) = self.offset.as_deref_mut() else {
            return;
        };
        if let Some(b) = pos_frame {
            *offset = match playing {
                Playing::Up => offset.combine_origin(b.origin, b.rotation, self.profile),
                Playing::Down => {
                    offset.subtract_animation(&Frame::new(b.origin, b.rotation), self.profile)
                }
            };
        }
        if node.rate_counts() {
            self.apply_physics(1.0 / f64::from(node.rate), t);
        }
    }

    /// Velocities for `q` seconds, in the direction of time given by `sign`. The velocity is not turned by the offset frame.
    fn apply_physics(&mut self, q: f64, sign: f64) {
        let Some(offset) = self.offset.as_deref_mut() else {
            return;
        };
        let q = if sign >= 0.0 { q.abs() } else { -q.abs() } as f32;
        offset.origin += self.velocity * q;
        offset.rotate(self.omega * q, self.profile);
    }
}
