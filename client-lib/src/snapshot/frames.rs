//! Forms of what a frame left behind and of the pipeline.

use super::form::stored;
use crate::frame::state::{FrameEvent, Outcome, Step};
use crate::frame::{Fidelity, Pacing, Pipeline};

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

/// How finely time is cut.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FidelityForm {
    min_quantum: Option<f64>,
    max_quantum: Option<f64>,
    frame_rate: Option<f64>,
    remote_update_every: u32,
    remote_distance: f32,
}

#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PipelineForm {
    pacing: PacingForm,
    fidelity: FidelityForm,
    last_tick: Option<f64>,
    ticks: u64,
    last_update: f64,
}

/// Nothing here can fail, so that a pipeline is restored without a world.
pub(super) fn restore(form: PipelineForm) -> Pipeline {
    let PipelineForm {
        pacing,
        fidelity,
        last_tick,
        ticks,
        last_update,
    } = form;
    let FidelityForm {
        min_quantum,
        max_quantum,
        frame_rate,
        remote_update_every,
        remote_distance,
    } = fidelity;
    Pipeline {
        pacing: match pacing {
            PacingForm::EveryFrame => Pacing::EveryFrame,
            PacingForm::EngineGate => Pacing::EngineGate,
        },
        fidelity: Fidelity {
            min_quantum,
            max_quantum,
            frame_rate,
            remote_update_every,
            remote_distance,
        },
        last_tick,
        ticks,
        last_update,
        order: Vec::new(),
    }
}

pub(super) fn store(pipeline: &Pipeline) -> PipelineForm {
    let Pipeline {
        pacing,
        fidelity,
        last_tick,
        ticks,
        last_update,
        // Filled anew in every frame.
        order: _,
    } = pipeline;
    let Fidelity {
        min_quantum,
        max_quantum,
        frame_rate,
        remote_update_every,
        remote_distance,
    } = *fidelity;
    PipelineForm {
        pacing: match pacing {
            Pacing::EveryFrame => PacingForm::EveryFrame,
            Pacing::EngineGate => PacingForm::EngineGate,
        },
        fidelity: FidelityForm {
            min_quantum,
            max_quantum,
            frame_rate,
            remote_update_every,
            remote_distance,
        },
        last_tick: *last_tick,
        ticks: *ticks,
        last_update: *last_update,
    }
}

/// What a pipeline is stored as.
#[cfg(test)]
pub(super) fn describe(forms: &mut super::form::Forms) {
    super::form::define(forms, "PipelineForm", |_| {
        "\n  pacing: EveryFrame | EngineGate\n  fidelity: FidelityForm\n  last_tick: optional f64\n  ticks: u64\n  \
         last_update: f64"
            .into()
    });
    super::form::define(forms, "FidelityForm", |_| {
        "\n  min_quantum: optional f64\n  max_quantum: optional f64\n  frame_rate: optional f64\n  \
         remote_update_every: u32\n  remote_distance: f32"
            .into()
    });
}
