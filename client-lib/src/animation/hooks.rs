//! Hooks: events of animation frames, and values that change over time (`spec/07-animation.md`, 9).

use crate::dat::HookAction;
use crate::profile::{HooksExecuted, Profile};

/// Animation hooks of an object that wait for `process_hooks`, in order. Kept by the object and reused.
pub type AnimHookQueue = Vec<HookAction>;

/// Whether a tick runs the effect of this hook (`N-23`). Hooks that are not executed leave no trace.
pub fn is_executed(hook: &HookAction, profile: &Profile) -> bool {
    match profile.hooks_executed {
        HooksExecuted::All => true,
        HooksExecuted::AnimationDone => matches!(hook, HookAction::AnimationDone),
        HooksExecuted::DoneNoDrawEtherealOmega => matches!(
            hook,
            HookAction::AnimationDone
                | HookAction::NoDraw { .. }
                | HookAction::Ethereal { .. }
                | HookAction::SetOmega { .. }
        ),
    }
}

/// What a timed hook changes. Only the scale has an effect on physics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimedHookKind {
    /// Scale of the object and its parts.
    Scale,
    /// Translucency.
    Translucency,
    /// Translucency of a part.
    PartTranslucency(u32),
    /// Luminosity.
    Luminosity,
    /// Diffuse factor.
    Diffusion,
    /// Luminosity of a part.
    PartLuminosity(u32),
    /// Diffuse factor of a part.
    PartDiffusion(u32),
    /// Runs a physics script when the value reaches 1.
    CallScript(u32),
}

/// A value that changes over time (retail `FPHook`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedHook {
    /// What it changes.
    pub kind: TimedHookKind,
    /// Physics time of its creation, s.
    pub created: f64,
    /// Duration, s.
    pub duration: f64,
    /// First value.
    pub start: f32,
    /// Last value.
    pub end: f32,
}

/// Value of a timed hook at some time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedValue {
    /// The value to apply.
    pub value: f32,
    /// Whether it is the last one.
    pub finished: bool,
}

impl TimedHook {
    /// The value at physics time `now`, s.
    pub fn at(&self, now: f64) -> TimedValue {
        let elapsed = now - self.created;
        let share = if elapsed <= 0.0 {
            0.0
        } else if elapsed < self.duration {
            elapsed / self.duration
        } else {
            1.0
        };
        let value = f64::from(self.end - self.start) * share + f64::from(self.start);
        TimedValue {
            value: value as f32,
            finished: share == 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timed_hook_runs_from_start_to_end() {
        let hook = TimedHook {
            kind: TimedHookKind::Scale,
            created: 10.0,
            duration: 2.0,
            start: 1.0,
            end: 3.0,
        };
        let at = |now| {
            let TimedValue { value, finished } = hook.at(now);
            (value, finished)
        };
        assert_eq!(at(9.0), (1.0, false));
        assert_eq!(at(11.0), (2.0, false));
        assert_eq!(at(12.0), (3.0, true));
        assert_eq!(at(f64::INFINITY), (3.0, true));
    }

    #[test]
    fn profiles_execute_different_hooks() {
        let done = HookAction::AnimationDone;
        let ethereal = HookAction::Ethereal { value: 1 };
        let scale = HookAction::Scale {
            end: 2.0,
            time: 1.0,
        };
        let executed = |p: &Profile| [done, ethereal, scale].map(|h| is_executed(&h, p));
        assert_eq!(executed(&Profile::retail()), [true, true, true]);
        assert_eq!(executed(&Profile::ace()), [true, false, false]);
        assert_eq!(executed(&Profile::gdle()), [true, true, false]);
    }
}
