//! The scene of a session, and the trace that is expected of it.

use std::io::{Seek, Write};
use std::path::Path;

use ac_client::frame::FrameStates;
use ac_client::net::messages::{PlainServerMessage, ServerMessage};
use ac_golden_traces::Scene;
use ac_golden_traces::expect::EXPECT_SCHEMA;
use ac_golden_traces::scene::SCENE_SCHEMA;
use ac_golden_traces::trace::{ChannelHeader, ChannelKind, Compression, TraceInfo, TraceWriter};

use super::{AREA, FEATURE, FrameClock, PacketsError, Session};
use crate::Simulation;
use crate::replay::ReplayError;

/// The oracle whose expectations this library writes for itself, under the profile `retail`.
pub const SELF: &str = "self";

/// Whom a replay records.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Tracks {
    /// Everybody whom the server describes, in this order, up to [`Tracks::MOST`].
    #[default]
    All,
    /// The player alone.
    Player,
    /// These GUIDs.
    Named(Vec<u32>),
}

impl Tracks {
    /// Most entities that [`Tracks::All`] records.
    pub const MOST: usize = 64;

    fn of(&self, session: &Session) -> Vec<u32> {
        let (mut player, mut all) = (None, Vec::new());
        for delivery in session.deliveries.iter().filter(|d| !d.to_server) {
            match ServerMessage::parse(&delivery.bytes).map(|parsed| parsed.message) {
                Ok(ServerMessage::Plain(PlainServerMessage::PlayerCreate(p))) => {
                    player.get_or_insert(p.guid);
                }
                Ok(ServerMessage::Plain(
                    PlainServerMessage::CreateObject(o) | PlainServerMessage::UpdateObject(o),
                )) if !all.contains(&o.guid) && all.len() < Self::MOST => all.push(o.guid),
                _ => {}
            }
        }
        match self {
            Self::All => all,
            Self::Player => player.into_iter().collect(),
            Self::Named(guids) => guids.clone(),
        }
    }
}

/// The scene that stands for a session: no entities and no script of its own, only frames and whom to record. `name` is the last part of its name.
///
/// # Errors
/// When the frames are too many.
pub fn scene_of(
    session: &Session,
    name: &str,
    summary: &str,
    world: &str,
    clock: FrameClock,
    tracks: &Tracks,
    path: &Path,
) -> Result<Scene, PacketsError> {
    Ok(Scene {
        schema: SCENE_SCHEMA.into(),
        name: format!("{AREA}/{name}"),
        summary: summary.into(),
        world: world.into(),
        features: vec![FEATURE.into()],
        start_time: 0.0,
        frames: clock.frames(session, path)?,
        entities: Vec::new(),
        script: Vec::new(),
        track: tracks.of(session),
    })
}

/// Runs a simulation to its end and writes what it did as the expectation of the oracle `self`. Answers the number of frames.
///
/// # Errors
/// When the simulation cannot go on or writing fails.
pub fn write_expectation<W: Write + Seek>(
    simulation: &mut dyn Simulation,
    scene: &Scene,
    info: &TraceInfo,
    out: W,
) -> Result<u32, ReplayError> {
    let text = serde_json::to_vec_pretty(scene).map_err(std::io::Error::from)?;
    let mut writer = TraceWriter::new(out, info, &text, Compression::Archive)?;
    let kind = ChannelKind::Expect(SELF.into());
    let header = ChannelHeader {
        schema: EXPECT_SCHEMA.into(),
        scene: scene.name.clone(),
        oracle: SELF.into(),
        oracle_version: info.producer.clone().into(),
        notes: vec!["written by the library itself, profile retail".into()],
    };
    writer.add_channel(ChannelKind::Clock, None)?;
    writer.add_channel(kind.clone(), Some(&header))?;
    let mut states = FrameStates::new();
    simulation.frame_minus_one(&mut states)?;
    writer.write_states(&kind, -1, scene.start_time, &states)?;
    for (frame, time) in (0u32..).zip(scene.times()) {
        writer.write_inputs(scene, frame, time)?;
        states.clear();
        simulation.step(frame, &mut states)?;
        let number = i32::try_from(frame).unwrap_or(i32::MAX);
        writer.write_states(&kind, number, time, &states)?;
    }
    writer.finish()?.flush()?;
    Ok(scene.frame_count())
}
