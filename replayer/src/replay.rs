//! Runs a scene from its first to its last frame and writes the states as a trace.

use std::io::{Seek, Write};

use ac_client::frame::FrameStates;
use ac_golden_traces::{
    Scene,
    trace::{ChannelKind, Compression, TraceInfo, TraceWriter},
};

use crate::{Simulation, SimulationError};

/// Why a replay failed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The client cannot go on.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The trace cannot be written.
    #[error("the trace cannot be written")]
    Trace(#[from] mcap::McapError),
    /// The trace cannot be written to the end.
    #[error("the trace cannot be written")]
    Io(#[from] std::io::Error),
}

/// Runs `simulation`, which stands before frame -1 of `scene`, and writes a trace with channel `/states`. Answers the number
/// of frames.
///
/// # Errors
/// When the simulation cannot go on or writing fails.
pub fn replay<W: Write + Seek>(
    simulation: &mut dyn Simulation,
    scene: &Scene,
    scene_text: &[u8],
    info: &TraceInfo,
    out: W,
) -> Result<u32, ReplayError> {
    let mut writer = TraceWriter::new(out, info, scene_text, Compression::Fast)?;
    for kind in [ChannelKind::Clock, ChannelKind::Script, ChannelKind::States] {
        writer.add_channel(kind, None)?;
    }
    let mut states = FrameStates::new();
    simulation.frame_minus_one(&mut states)?;
    writer.write_states(&ChannelKind::States, -1, scene.start_time, &states)?;
    for (frame, time) in (0u32..).zip(scene.times()) {
        writer.write_inputs(scene, frame, time)?;
        states.clear();
        simulation.step(frame, &mut states)?;
        // A scene has fewer than 2^31 frames.
        writer.write_states(
            &ChannelKind::States,
            i32::try_from(frame).unwrap_or(i32::MAX),
            time,
            &states,
        )?;
    }
    writer.finish()?.flush()?;
    Ok(scene.frame_count())
}
