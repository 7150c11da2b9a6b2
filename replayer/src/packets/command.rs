//! `ac-replay run` of a packet recording.

use std::fmt::Write as _;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use ac_client::profile::Profile;
use ac_golden_traces::Scene;
use ac_golden_traces::trace::TraceInfo;
use miette::{IntoDiagnostic, WrapErr, miette};

use super::{FrameClock, PacketRun, Recording, ReplayStats, Session, Tracks, scene_of};
use crate::client::ClientSimulator;
use crate::replay::{Detail, replay};

/// Arguments of a run that only packet recordings have.
#[derive(Debug, Clone, clap::Args)]
pub struct PacketArgs {
    /// Packet recordings: frames at `fixed:HZ` per second, or `recorded`: at the times of the datagrams.
    #[arg(long, default_value = "fixed:30")]
    clock: FrameClock,
    /// Packet recordings: the world that the session was in, a folder under --worlds.
    #[arg(long, default_value = "testbed")]
    world: String,
    /// Packet recordings: whom to record: `all` (the first 64), `player`, or GUIDs with commas between.
    #[arg(long, default_value = "all", value_parser = tracks)]
    track: Tracks,
    /// Packet recordings: number of the client. Default: the first that gets into the world.
    #[arg(long)]
    client: Option<u32>,
}

fn tracks(text: &str) -> Result<Tracks, String> {
    let guid = |text: &str| {
        let digits = text
            .trim()
            .trim_start_matches("0x")
            .trim_start_matches("0X");
        u32::from_str_radix(digits, 16).map_err(|_| format!("`{text}` is no GUID in hexadecimal"))
    };
    Ok(match text {
        "all" => Tracks::All,
        "player" => Tracks::Player,
        list => Tracks::Named(list.split(',').map(guid).collect::<Result<_, _>>()?),
    })
}

impl PacketArgs {
    /// Folder name of the world.
    pub fn world(&self) -> &str {
        &self.world
    }

    /// The session of a recording and the scene that stands for it.
    ///
    /// # Errors
    /// When the bytes are no recording, or hold no session.
    pub fn open(&self, bytes: &[u8], path: &Path) -> miette::Result<(Session, Scene)> {
        let recording = Recording::parse(bytes, path).into_diagnostic()?;
        let session = Session::find(&recording, self.client, path).into_diagnostic()?;
        let name: String = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .chars()
            .map(|c| {
                if c.is_ascii_alphanumeric() || "-_.+".contains(c) {
                    c
                } else {
                    '_'
                }
            })
            .collect();
        let summary = format!("Recorded session of client {}.", session.client);
        let scene = scene_of(
            &session,
            &name,
            &summary,
            &self.world,
            self.clock,
            &self.track,
            path,
        )
        .into_diagnostic()?;
        Ok((session, scene))
    }
}

/// Replays a session and writes the trace. Answers what a person wants to know.
///
/// # Errors
/// When the world cannot be opened or the trace cannot be written.
pub fn run(
    session: Session,
    scene: &Scene,
    simulator: &ClientSimulator,
    profile: &Profile,
    info: &TraceInfo,
    output: &Path,
) -> miette::Result<String> {
    let source = simulator.world(&scene.world).into_diagnostic()?;
    let damage = session.damage.clone();
    let mut run = PacketRun::new(scene, Arc::new(session), source, profile);
    let context = || format!("cannot write {}", output.display());
    let text = serde_json::to_vec_pretty(scene).into_diagnostic()?;
    let out = File::create(output)
        .into_diagnostic()
        .wrap_err_with(context)?;
    let frames = replay(
        &mut run,
        scene,
        &text,
        info,
        Detail::States,
        BufWriter::new(out),
    )
    .into_diagnostic()
    .wrap_err_with(context)?;
    if run.player().is_none() {
        return Err(miette!(
            help = "the trace was written; it has no player",
            "the session ends before the player enters the world"
        ));
    }
    let mut text = format!(
        "{}: {frames} frames of {} entities in {}\n",
        scene.name,
        scene.track.len(),
        output.display()
    );
    text += &report(&run.stats());
    if let Some(damage) = damage {
        let _ = writeln!(
            text,
            "the recording is damaged ({damage}): replayed up to there"
        );
    }
    Ok(text)
}

fn report(stats: &ReplayStats) -> String {
    let (d, s, r) = (&stats.datagrams, &stats.stage, &stats.reports);
    let mut text = format!(
        "{} datagrams: {} undecodable, {} repeated, {} never came, {} fragments without a message\n",
        d.datagrams, d.undecodable, d.duplicates, d.lost, d.fragments
    );
    let unreadable = s.unreadable + stats.unreadable_from_client;
    let _ = writeln!(
        text,
        "{} messages: {} applied, {} stale, {} dropped otherwise, {unreadable} unreadable, {} events missing",
        s.messages,
        s.applied,
        s.stale,
        s.dropped - s.stale,
        s.event_gaps
    );
    let _ = write!(
        text,
        "{} positions reported by the recorded client: {} predicted exactly",
        r.count, r.exact
    );
    if let Some(frame) = r.first_other {
        let _ = write!(
            text,
            ", the others within {} m (first in frame {frame})",
            r.largest
        );
    }
    text.push('\n');
    text
}
