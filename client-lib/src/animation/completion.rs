//! Reporting finished motions one by one (`spec/07-animation.md`, 12.4 to 12.8).
//!
//! Retail calls the object's `MotionDone` from the middle of these loops: after the counter was raised, before the entry is removed. What the
//! object does then (it may stop everything and queue new entries) is seen by the rest of the loop. A [`CompletionRun`] is such a loop that
//! pauses at each report: the caller deals with it at once and asks for the next.

use super::motion_class::{ACTION, has};
use super::motion_table_manager::MotionTableManager;

/// A motion that is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MotionNotice {
    /// Motion command.
    pub motion: u32,
    /// `false` if it was cut short.
    pub success: bool,
}

/// Why entries are completed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cause {
    /// An animation ended: entries complete as far as the counter reaches.
    AnimationDone { success: bool },
    /// Entries without animations complete.
    Check,
    /// All entries complete, unsuccessfully.
    Flush,
}

/// A loop over entries to complete; see the module. Every run must be carried to its end:
///
/// ```text
/// let mut run = parts.animation_done(true);
/// while let Some(notice) = parts.next_completion(&mut run) { /* MotionDone */ }
/// ```
#[derive(Debug, Clone)]
#[must_use = "a run does nothing until it is asked for its notices"]
pub struct CompletionRun {
    cause: Option<Cause>,
    /// Serial number and animations of the entry whose notice is out.
    reported: Option<(u64, u32)>,
}

impl CompletionRun {
    /// A run that has nothing to do.
    pub const fn nothing() -> Self {
        Self {
            cause: None,
            reported: None,
        }
    }

    const fn new(cause: Cause) -> Self {
        Self {
            cause: Some(cause),
            reported: None,
        }
    }
}

impl MotionTableManager {
    /// An animation ended (12.5). Without pending motions nothing is counted.
    pub fn animation_done(&mut self, success: bool) -> CompletionRun {
        if self.pending.is_empty() {
            return CompletionRun::nothing();
        }
        self.animation_counter = self.animation_counter.wrapping_add(1);
        CompletionRun::new(Cause::AnimationDone { success })
    }

    /// Completes what needs no more animations (12.6; `UseTime` is the same).
    pub fn check_for_completed_motions(&mut self) -> CompletionRun {
        CompletionRun::new(Cause::Check)
    }

    /// Completes everything, unsuccessfully (12.8).
    pub fn handle_exit_world(&mut self) -> CompletionRun {
        if self.pending.is_empty() {
            return CompletionRun::nothing();
        }
        CompletionRun::new(Cause::Flush)
    }

    /// The next motion that is done; `None` when the run is over.
    pub fn next_completion(&mut self, run: &mut CompletionRun) -> Option<MotionNotice> {
        let cause = run.cause?;
        if let Some(reported) = run.reported.take() {
            self.remove_reported(cause, reported);
        }
        let head = self.pending.front().filter(|head| match cause {
            Cause::AnimationDone { .. } => head.animations <= self.animation_counter,
            Cause::Check => head.animations == 0,
            Cause::Flush => true,
        });
        let Some(head) = head.copied() else {
            self.end(cause);
            run.cause = None;
            return None;
        };
        if has(head.motion, ACTION) {
            self.state.remove_action_head();
        }
        run.reported = Some((head.serial, head.animations));
        Some(MotionNotice {
            motion: head.motion,
            success: match cause {
                Cause::AnimationDone { success } => success,
                Cause::Check => true,
                Cause::Flush => false,
            },
        })
    }

    fn remove_reported(&mut self, cause: Cause, (serial, animations): (u64, u32)) {
        let position = self.pending.iter().position(|p| p.serial == serial);
        match cause {
            Cause::AnimationDone { .. } => {
                // What the entry counts now: the object may have cut its animations off meanwhile.
                let now = position.and_then(|i| self.pending.get(i));
                let animations = now.map_or(animations, |entry| entry.animations);
                self.animation_counter = self.animation_counter.wrapping_sub(animations);
                self.pending.pop_front();
            }
            Cause::Check => {
                if let Some(i) = position {
                    self.pending.remove(i);
                }
            }
            Cause::Flush => {
                self.pending.pop_front();
            }
        }
    }

    fn end(&mut self, cause: Cause) {
        let counts = match cause {
            Cause::AnimationDone { .. } => !self.pending.is_empty(),
            Cause::Check => true,
            Cause::Flush => false,
        };
        if !counts {
            self.animation_counter = 0;
        }
    }
}
