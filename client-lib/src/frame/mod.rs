//! The per-frame pipeline and the record of what a frame left behind.
//!
//! [`pipeline`] runs the stages of a frame, [`fidelity`] says how finely time is cut, [`probe`] lets an observer see those of an
//! entity's tick, [`state`] is what remains of a frame, [`plan`] is what of all that can be left out.

pub mod fidelity;
pub mod pipeline;
pub mod plan;
pub mod probe;
pub mod state;

pub use fidelity::Fidelity;
pub use pipeline::{FrameStage, Host, NoHost, Pacing, Pipeline};
pub use plan::{ActivePlan, Plan};
pub use probe::{NoProbe, Probe, StageData, StageView, TickStage};
pub use state::{FrameState, FrameStates};
