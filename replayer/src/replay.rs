//! Runs a scene, or some of its frames, and writes the states as a trace.

use std::{
    io::{Seek, Write},
    num::NonZeroU32,
    ops::RangeInclusive,
};

use ac_client::frame::FrameStates;
use ac_golden_traces::{
    Scene,
    expect::STAGES_SCHEMA,
    trace::{ChannelHeader, ChannelKind, Compression, TraceInfo, TraceWriter},
};

use crate::{
    Simulation, SimulationError,
    keyframes::{self, Identity, KeyframeError, KeyframeHeader},
};

/// Why a replay failed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The client cannot go on.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The trace cannot be written.
    #[error("the trace cannot be written")]
    Trace(#[from] mcap::McapError),
    /// A keyframe cannot be written.
    #[error(transparent)]
    Keyframe(#[from] KeyframeError),
    /// The trace cannot be written to the end.
    #[error("the trace cannot be written")]
    Io(#[from] std::io::Error),
}

/// What a trace holds beside the states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Detail {
    /// Nothing.
    #[default]
    States,
    /// The checkpoints of every stage, on channel `/stages/PROFILE`.
    Checkpoints,
}

/// Runs `simulation`, which stands before frame -1 of `scene`, and writes a trace with channel `/states` and what `detail`
/// names. Answers the number of frames.
///
/// # Errors
/// When the simulation cannot go on or writing fails.
pub fn replay<W: Write + Seek>(
    simulation: &mut dyn Simulation,
    scene: &Scene,
    scene_text: &[u8],
    info: &TraceInfo,
    detail: Detail,
    out: W,
) -> Result<u32, ReplayError> {
    let what = Replay {
        scene,
        scene_text,
        info,
        detail,
        frames: -1..=last_frame(scene),
        keyframes: None,
    };
    replay_frames(simulation, &what, out)?;
    Ok(scene.frame_count())
}

/// What is replayed, and what of it is written.
#[derive(Debug, Clone)]
pub struct Replay<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Text of its file.
    pub scene_text: &'a [u8],
    /// What the trace says about itself.
    pub info: &'a TraceInfo,
    /// What the trace holds beside the states.
    pub detail: Detail,
    /// Which frames it holds; -1 is the state before the first.
    pub frames: RangeInclusive<i32>,
    /// Keyframes: how many frames lie between two, and what the run is of.
    pub keyframes: Option<(NonZeroU32, &'a Identity)>,
}

/// The last frame of a scene.
pub fn last_frame(scene: &Scene) -> i32 {
    // A scene has fewer than 2^31 frames.
    i32::try_from(scene.frame_count()).unwrap_or(i32::MAX) - 1
}

/// Runs a simulation from the first to the last of the frames in `what`, before the first of which it stands, and writes a trace of them.
/// Answers the number of frames written, -1 left out.
///
/// # Errors
/// When the simulation cannot go on or writing fails.
pub fn replay_frames<W: Write + Seek>(
    simulation: &mut dyn Simulation,
    what: &Replay<'_>,
    out: W,
) -> Result<u32, ReplayError> {
    let Replay {
        scene,
        scene_text,
        info,
        detail,
        frames,
        keyframes,
    } = what;
    let (first, last) = (*frames.start(), *frames.end());
    let mut writer = TraceWriter::new(out, info, scene_text, Compression::Fast)?;
    for kind in [ChannelKind::Clock, ChannelKind::Script, ChannelKind::States] {
        writer.add_channel(kind, None)?;
    }
    if *detail == Detail::Checkpoints {
        let header = checkpoint_header(info);
        writer.add_channel(ChannelKind::Stages(info.profile.clone()), Some(&header))?;
    }
    let (mut states, mut records) = (FrameStates::new(), Vec::new());
    if first < 0 {
        simulation.frame_minus_one(&mut states)?;
        writer.write_states(&ChannelKind::States, -1, scene.start_time, &states)?;
    }
    let times = (0_i32..).zip(scene.times()).take_while(|(f, _)| *f <= last);
    for (number, time) in times.skip_while(|(frame, _)| *frame < first) {
        let frame = number.cast_unsigned();
        if number == first {
            writer.begin_at(scene, frame, time)?;
        }
        writer.write_inputs(scene, frame, time)?;
        states.clear();
        match detail {
            Detail::States => simulation.step(frame, &mut states)?,
            Detail::Checkpoints => {
                records.clear();
                simulation.step_with_checkpoints(frame, &mut states, &mut records)?;
                writer.write_stages(&info.profile, number, time, &records)?;
            }
        }
        writer.write_states(&ChannelKind::States, number, time, &states)?;
        if let Some((every, identity)) = keyframes
            && (frame + 1).is_multiple_of(every.get())
        {
            write_keyframe(&mut writer, simulation, identity, number, time)?;
        }
    }
    writer.finish()?.flush()?;
    Ok(last.max(-1).abs_diff(first.max(0) - 1))
}

fn write_keyframe<W: Write + Seek>(
    writer: &mut TraceWriter<W>,
    simulation: &dyn Simulation,
    identity: &Identity,
    frame: i32,
    time: f64,
) -> Result<(), ReplayError> {
    let Some(snapshot) = simulation.snapshot()? else {
        return Ok(());
    };
    let header = KeyframeHeader::new(frame, identity, &snapshot);
    let bytes = keyframes::encode(&header, &snapshot)?;
    writer.attach(
        &keyframes::name_of(frame),
        keyframes::MEDIA_TYPE,
        time,
        &bytes,
    )?;
    Ok(())
}

fn checkpoint_header(info: &TraceInfo) -> ChannelHeader {
    ChannelHeader {
        schema: STAGES_SCHEMA.into(),
        scene: info.scene.clone(),
        oracle: info.profile.clone(),
        oracle_version: info.producer.clone().into(),
        notes: Vec::new(),
    }
}
