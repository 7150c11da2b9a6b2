//! Running one stage of the entity tick alone, from its recorded input (`spec/stage-format.md`).
//!
//! A stage takes a world in which the scene's entities exist (their setups and weenies are what a record leaves out) and the record's `in`;
//! it answers the `out`, in the same form. What the record says of other entities is put into the world first.

mod adjust;
mod animation;
mod json;
mod transition;

pub use adjust::run_adjust_stage;
pub use animation::run_animation_stage;
pub use transition::run_transition_stage;

/// Why a stage record cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    /// The input has not the form of its stage.
    #[error("the input of stage `{stage}` is malformed at `{path}`: {reason}")]
    Malformed {
        /// Name of the stage.
        stage: &'static str,
        /// Place in the input.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// The record names an entity that the scene does not have.
    #[error(
        "there is no entity 0x{guid:08X}, which a record of stage `{stage}` names; is the record of another scene?"
    )]
    NoSuchEntity {
        /// Name of the stage.
        stage: &'static str,
        /// The entity.
        guid: u32,
    },
    /// The record names an animation that the world does not have.
    #[error(
        "there is no animation 0x{animation:08X}, which a record of stage `{stage}` names; is the record of another world?"
    )]
    NoSuchAnimation {
        /// Name of the stage.
        stage: &'static str,
        /// The animation.
        animation: u32,
    },
    /// No more transitions can be nested.
    #[error("no transition is free")]
    NoTransition,
}

impl StageError {
    fn malformed(stage: &'static str, path: &str, reason: &dyn std::fmt::Display) -> Self {
        Self::Malformed {
            stage,
            path: path.into(),
            reason: reason.to_string(),
        }
    }
}

#[cfg(test)]
mod tests;
