//! Probes: observers of the stages of an entity's tick.
//!
//! The tick is generic over its [`Probe`]. [`NoProbe`] does nothing and compiles to nothing; a probe that records stage checkpoints
//! (`spec/stage-format.md`) sees the entity, the world and what passes between the stages directly before and after each of them.

use crate::entity::Entity;
use crate::math::Frame;
use crate::physics::transition::{Transit, TransitionInput, TransitionResult};
use crate::physics::update::CommitKind;
use crate::world::World;

/// A named stage of an entity's tick, in the order of a quantum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TickStage {
    /// Root motion of the animation.
    Animation,
    /// Interpolation, sticky, constraint.
    Adjust,
    /// Friction, translation, velocity, rotation.
    Integrate,
    /// Hooks of the frames crossed.
    Hooks,
    /// The swept-sphere transition.
    Transition,
    /// Cell, frame, contact, collisions, shadows.
    Commit,
    /// Targets, move-to, completed motions, position managers.
    Motion,
}

impl TickStage {
    /// Every stage, in order.
    pub const ALL: [Self; 7] = [
        Self::Animation,
        Self::Adjust,
        Self::Integrate,
        Self::Hooks,
        Self::Transition,
        Self::Commit,
        Self::Motion,
    ];

    /// The name used in stage files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Animation => "animation",
            Self::Adjust => "adjust",
            Self::Integrate => "integrate",
            Self::Hooks => "hooks",
            Self::Transition => "transition",
            Self::Commit => "commit",
            Self::Motion => "motion",
        }
    }
}

/// What a probe sees of a stage besides the entity and the world.
#[derive(Debug, Clone, Copy)]
pub enum StageData<'a> {
    /// Animation and adjust: the offset (own axes, m), as it is.
    Offset(&'a Frame),
    /// Integrate: the offset, and the frame that is being integrated (landblock coordinates).
    Integrate {
        /// Root motion after adjusting.
        offset: &'a Frame,
        /// Frame before or after.
        frame: &'a Frame,
    },
    /// Hooks and motion: nothing passes through.
    None,
    /// Transition: what goes in and, afterwards, what came out.
    Transition {
        /// Start, goal and mover.
        input: &'a TransitionInput,
        /// The transition that is about to run or has run; see [`World::transition_start`].
        transit: &'a Transit,
        /// The result, after the stage.
        result: Option<&'a TransitionResult>,
    },
    /// Commit: how, and the wanted frame.
    Commit {
        /// What is committed.
        kind: CommitKind,
        /// Wanted frame, after integration, hooks and heading.
        frame: &'a Frame,
    },
}

/// One side of one stage.
#[derive(Debug, Clone, Copy)]
pub struct StageView<'a> {
    /// Which.
    pub stage: TickStage,
    /// Length of the quantum, s.
    pub quantum: f32,
    /// The entity, as it is at this moment. It is taken out of the world.
    pub entity: &'a Entity,
    /// The world without the entity.
    pub world: &'a World,
    /// What passes through the stage.
    pub data: StageData<'a>,
}

/// An observer of the stages of an entity's tick.
pub trait Probe {
    /// Whether it looks at anything. If not, stages that change nothing need not run.
    const OBSERVES: bool = true;

    /// Called directly before a stage.
    #[inline(always)]
    fn before(&mut self, _view: StageView<'_>) {}

    /// Called directly after a stage.
    #[inline(always)]
    fn after(&mut self, _view: StageView<'_>) {}
}

/// Observes nothing, at no cost.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoProbe;

impl Probe for NoProbe {
    const OBSERVES: bool = false;
}
