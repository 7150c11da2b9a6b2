//! Stage checkpoints of a run: what goes into and what comes out of every stage of every entity's tick, as records of
//! `spec/stage-format.md`.
//!
//! [`CheckpointProbe`] looks on while a frame runs and changes nothing. It reads the entity, the world and what passes between the stages;
//! each stage has a file of its own here.

mod adjust;
mod animation;
mod commit;
mod hooks;
mod integrate;
mod motion;
mod shapes;
mod transition;

use ac_client::frame::{Probe, StageView, TickStage};
use serde_json::value::{RawValue, to_raw_value};
use serde_json::{Value, json};

/// Writes a record for every stage that runs.
#[derive(Debug)]
pub struct CheckpointProbe<'a> {
    frame: u32,
    records: &'a mut Vec<Box<RawValue>>,
    /// The stage that is running.
    begun: Option<Begun>,
}

/// What is known of a stage before it runs.
#[derive(Debug)]
struct Begun {
    input: Value,
    /// Place in the list of steps that the quantum will have.
    quantum: usize,
    /// Events that had happened.
    events: usize,
    /// Hooks that were queued.
    hooks: usize,
    /// Id of the cell, 0 for none.
    cell: u32,
    /// Position managers that are going to act.
    acting: Vec<&'static str>,
}

impl<'a> CheckpointProbe<'a> {
    /// A probe for frame `frame` that appends to `records`.
    pub fn new(frame: u32, records: &'a mut Vec<Box<RawValue>>) -> Self {
        Self {
            frame,
            records,
            begun: None,
        }
    }
}

impl Probe for CheckpointProbe<'_> {
    fn before(&mut self, view: StageView<'_>) {
        let entity = view.entity;
        self.begun = Some(Begun {
            input: input(&view),
            quantum: entity.steps.len(),
            events: entity.events.len(),
            hooks: animation::queued(entity),
            cell: commit::cell_of(entity, view.world),
            acting: adjust::acting(entity),
        });
    }

    fn after(&mut self, view: StageView<'_>) {
        let Some(begun) = self.begun.take() else {
            return;
        };
        let record = json!({
            "frame": self.frame,
            "guid": shapes::hex(view.entity.guid()),
            "quantum": begun.quantum,
            "stage": view.stage.name(),
            "in": begun.input,
            "out": output(&view, &begun),
        });
        // A tree of values with text keys always has a text.
        self.records.extend(to_raw_value(&record));
    }
}

fn input(view: &StageView<'_>) -> Value {
    match view.stage {
        TickStage::Animation => animation::input(view),
        TickStage::Adjust => adjust::input(view),
        TickStage::Integrate => integrate::input(view),
        TickStage::Hooks => hooks::input(view),
        TickStage::Transition => transition::input(view),
        TickStage::Commit => commit::input(view),
        TickStage::Motion => motion::input(view),
    }
}

fn output(view: &StageView<'_>, begun: &Begun) -> Value {
    match view.stage {
        TickStage::Animation => animation::output(view, begun.hooks),
        TickStage::Adjust => adjust::output(view, &begun.acting),
        TickStage::Integrate => integrate::output(view),
        TickStage::Hooks => hooks::output(view, begun.events),
        TickStage::Transition => transition::output(view),
        TickStage::Commit => commit::output(view, begun.cell, begun.events),
        TickStage::Motion => motion::output(view, begun.events),
    }
}
