//! Forms of what a frame left behind and of the pipeline.

use super::form::{Stored, stored};
use super::{Restorer, SnapshotError};
use crate::frame::state::{FrameEvent, Outcome, Step};
use crate::frame::{Pacing, Pipeline};

#[cfg(test)]
use super::form::{Forms, define};

stored!(
    enum OutcomeForm of Outcome { None, Failed, Ok, Collided, Adjusted, Slid }
);
stored!(
    struct StepForm of Step { dt: f32, outcome: Outcome }
);
stored!(
    enum FrameEventForm of FrameEvent { HitGround, LeaveGround, MotionDone(motion: u32), AnimHook(kind: u32) }
);

/// How the entity tick is paced.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
pub(super) enum PacingForm {
    EveryFrame,
    EngineGate,
}

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PipelineForm {
    pacing: PacingForm,
    last_update: f64,
}

/// Nothing here can fail, so that a pipeline is restored without a world.
pub(super) fn restore_pipeline(form: PipelineForm) -> Pipeline {
    let PipelineForm {
        pacing,
        last_update,
    } = form;
    Pipeline {
        pacing: match pacing {
            PacingForm::EveryFrame => Pacing::EveryFrame,
            PacingForm::EngineGate => Pacing::EngineGate,
        },
        last_update,
        order: Vec::new(),
    }
}

impl Stored for Pipeline {
    type Form = PipelineForm;

    fn store(&self) -> PipelineForm {
        let Self {
            pacing,
            last_update,
            // Filled anew in every frame.
            order: _,
        } = self;
        PipelineForm {
            pacing: match pacing {
                Pacing::EveryFrame => PacingForm::EveryFrame,
                Pacing::EngineGate => PacingForm::EngineGate,
            },
            last_update: *last_update,
        }
    }

    fn restore(form: PipelineForm, _: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        Ok(restore_pipeline(form))
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        define(forms, "PipelineForm", |_| {
            "\n  pacing: EveryFrame | EngineGate\n  last_update: f64".into()
        })
    }
}
