//! The per-frame pipeline and the record of what a frame left behind.

pub mod state;

pub use state::{FrameState, FrameStates};
