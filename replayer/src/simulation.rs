//! What the harness asks of a client.
//!
//! The seam is narrow on purpose: a client is started on a scene, advanced frame by frame, and hands out one record per
//! tracked entity and frame. Two more questions serve the other ways to compare: setting an entity to a recorded state, and
//! running one stage alone from recorded inputs.

use ac_client::{
    frame::{FrameState, FrameStates},
    profile::Profile,
};
use ac_golden_traces::Scene;
use serde_json::{Value, value::RawValue};

/// Starts simulations. Shared between threads: what is expensive to make (parsed worlds) is kept here.
pub trait Simulator: Sync {
    /// Sets up the scene's world, creates its entities, and stands before frame 0.
    ///
    /// # Errors
    /// When the world cannot be loaded or the scene cannot be set up.
    fn start(
        &self,
        scene: &Scene,
        profile: &Profile,
    ) -> Result<Box<dyn Simulation>, SimulationError>;

    /// Goes on from a [snapshot](Simulation::snapshot) that a run of the same scene under the same profile has taken. What
    /// follows is bit for bit what that run did.
    ///
    /// # Errors
    /// When the world cannot be loaded, or the snapshot cannot be read or does not fit to scene and world.
    fn resume(
        &self,
        scene: &Scene,
        profile: &Profile,
        snapshot: &[u8],
    ) -> Result<Box<dyn Simulation>, SimulationError> {
        let _ = (scene, profile, snapshot);
        Err(SimulationError::Snapshot {
            reason: "this client takes no snapshots".into(),
        })
    }
}

/// A running scene.
pub trait Simulation {
    /// Writes the records of frame -1: the state after the creation of the first entities, in the order of the scene's
    /// `track`. Called once, before the first [`Simulation::step`].
    ///
    /// # Errors
    /// When the simulation cannot go on.
    fn frame_minus_one(&mut self, out: &mut FrameStates) -> Result<(), SimulationError>;

    /// Runs frame `frame` (0, 1, 2, … in turn) and writes its records in the order of the scene's `track`.
    ///
    /// # Errors
    /// When the simulation cannot go on.
    fn step(&mut self, frame: u32, out: &mut FrameStates) -> Result<(), SimulationError>;

    /// As [`Simulation::step`], and appends a record of each stage that ran (`spec/stage-format.md`) to `checkpoints`. A client
    /// that has no named stages appends none.
    ///
    /// # Errors
    /// When the simulation cannot go on.
    fn step_with_checkpoints(
        &mut self,
        frame: u32,
        out: &mut FrameStates,
        checkpoints: &mut Vec<Box<RawValue>>,
    ) -> Result<(), SimulationError> {
        let _ = checkpoints;
        self.step(frame, out)
    }

    /// Writes the records of `frame`, which has just been run, once more; a run that was [resumed](Simulator::resume) after that
    /// frame has not written them yet.
    ///
    /// # Errors
    /// When the client cannot go on from snapshots.
    fn records(&self, frame: i32, out: &mut FrameStates) -> Result<(), SimulationError> {
        let _ = (frame, out);
        Err(SimulationError::Snapshot {
            reason: "this client takes no snapshots".into(),
        })
    }

    /// Everything that changes, between two frames, as bytes for [`Simulator::resume`]; `None` from a client that takes none.
    /// Equal states give equal bytes.
    ///
    /// # Errors
    /// When the state cannot be written.
    fn snapshot(&self) -> Result<Option<Vec<u8>>, SimulationError> {
        Ok(None)
    }

    /// Sets every field that `expected` carries into the entity `expected.guid`; what the record does not carry stays. Does
    /// nothing for an entity that is not there.
    ///
    /// # Errors
    /// When the simulation cannot go on.
    fn load_state(&mut self, expected: &FrameState) -> Result<(), SimulationError>;

    /// Runs the stage of `records[index]` from its `in` and answers its `out`; `None` if the client cannot run this stage
    /// alone. `records` are all checkpoints of the frame in order: some stages read the `out` of one before.
    ///
    /// # Errors
    /// When the record cannot be understood.
    fn run_stage(
        &mut self,
        records: &[Value],
        index: usize,
    ) -> Result<Option<Value>, SimulationError>;
}

/// Why a simulation cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// The world's files cannot be loaded.
    #[error("world `{world}`: {reason}")]
    World {
        /// Name of the world.
        world: String,
        /// What is wrong.
        reason: String,
    },
    /// The scene cannot be set up.
    #[error("scene `{scene}`: {reason}")]
    Scene {
        /// Name of the scene.
        scene: String,
        /// What is wrong.
        reason: String,
    },
    /// A snapshot cannot be taken, read or restored.
    #[error("snapshot: {reason}")]
    Snapshot {
        /// What is wrong.
        reason: String,
    },
    /// The plan leaves out what may change results.
    #[error("scene `{scene}`: the plan cannot be used: {reason}")]
    Plan {
        /// Name of the scene.
        scene: String,
        /// The entry that is wrong.
        reason: ac_client::frame::plan::PlanError,
    },
    /// A stage record cannot be understood.
    #[error("stage record: {reason}")]
    Stage {
        /// What is wrong.
        reason: String,
    },
}
