//! The golden packet sessions: bundled scenes over the loopback, and the traces that replaying them must give (`docs/packet-sessions.md`).

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ac_client::dat::{DatSet, Strictness};
use ac_client::profile::Profile;
use ac_golden_traces::corpus::{self, Index};
use ac_golden_traces::import::hash_world;
use ac_golden_traces::trace::{FormatVersion, TraceInfo, TraceReader};
use ac_golden_traces::{GoldenError, Scene};
use ac_replayer::packets::{
    FrameClock, PacketRun, PacketsError, Recording, Session, Tracks, scene_of, write_expectation,
};
use ac_replayer::replay::ReplayError;

use super::loopback::{Loopback, LoopbackConfig};
use super::{Abilities, Authority, DemoConfig, DemoError, Played};
use crate::error::RecordError;
use crate::fault::Faults;
use crate::format::RecordingWriter;
use crate::play::script::{Script, ScriptError};

/// A golden session.
#[derive(Debug, Clone, Copy)]
pub struct GoldenSession {
    /// Name, and that of its files.
    pub name: &'static str,
    /// What it exercises.
    pub summary: &'static str,
    /// The bundled scene behind it.
    pub scene: &'static str,
    /// Whom the client plays.
    pub played: Played,
    /// Whose position counts.
    pub authority: Authority,
    /// What the client does.
    pub script: &'static str,
    /// The network.
    pub faults: Faults,
    /// The client is told that it runs faster than it does.
    pub misled: bool,
}

/// A network that takes 50 ms each way.
const GOOD: Faults = Faults::delay(0.05);

/// All of them.
pub const SESSIONS: [GoldenSession; 8] = [
    GoldenSession {
        name: "walk-corrections",
        summary: "A guest that believes itself faster than it is runs, turns and jumps; the server walks it too and puts it right when it is 0.7 m off.",
        scene: "terrain/walk-flat",
        played: Played::Guest,
        authority: Authority::Server(0.7),
        script: "wait 0.3\nforward 1\nrun on\nforward 1.2\nturn-right 50\nhold forward\nwait 0.4\njump 0.3\nwait 0.6\nrelease forward\nwait 1",
        faults: Faults::delay(0.1),
        misled: true,
    },
    GoldenSession {
        name: "teleport",
        summary: "The player is taken from the dungeon to the plain, into the house and back; the server moves it.",
        scene: "dungeon/leave-by-teleport",
        played: Played::Entity(0x5000_0001),
        authority: Authority::Server(1.0),
        script: "wait 4.6",
        faults: GOOD,
        misled: false,
    },
    GoldenSession {
        name: "create-delete",
        summary: "Objects appear and vanish in a runner's way, seen by a guest.",
        scene: "lifecycle/create-destroy",
        played: Played::Guest,
        authority: Authority::Server(1.0),
        script: "wait 4.8",
        faults: GOOD,
        misled: false,
    },
    GoldenSession {
        name: "npc-motions",
        summary: "A creature walks, turns and runs by interpreted motions, seen by a walking guest.",
        scene: "motion/interpreted-creature",
        played: Played::Guest,
        authority: Authority::Server(1.0),
        script: "wait 1\nbackward 1\nwait 1\nturn-left 45\nwait 2",
        faults: GOOD,
        misled: false,
    },
    GoldenSession {
        name: "npc-move-to",
        summary: "Players walk to a standing and to a walking creature by move-to events.",
        scene: "moveto/object",
        played: Played::Guest,
        authority: Authority::Server(1.0),
        script: "wait 5",
        faults: GOOD,
        misled: false,
    },
    GoldenSession {
        name: "wield",
        summary: "A runner takes a small thing into its hand and puts it down again.",
        scene: "lifecycle/parent",
        played: Played::Guest,
        authority: Authority::Server(1.0),
        script: "wait 4.6",
        faults: GOOD,
        misled: false,
    },
    GoldenSession {
        name: "door",
        summary: "A door opens and closes; two players go through it, the first is the client's, moved by the server.",
        scene: "motion/door",
        played: Played::Entity(0x5000_0001),
        authority: Authority::Server(1.0),
        script: "wait 6",
        faults: GOOD,
        misled: false,
    },
    GoldenSession {
        name: "lossy",
        summary: "Creatures and a player run into each other over a network that loses, repeats, reorders and damages packets.",
        scene: "objects/creatures",
        played: Played::Guest,
        authority: Authority::Server(1.0),
        script: "wait 0.5\nforward 1.5\nwait 4",
        faults: Faults {
            loss: 0.08,
            duplicate: 0.05,
            reorder: 0.08,
            corrupt: 0.05,
            delay: 0.05,
            jitter: 0.03,
        },
        misled: false,
    },
];

/// Frames per second of client and replay.
const RATE: u32 = 25;
/// Seed of the faults.
const SEED: u64 = 20;

/// Why a session cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The scene's trace cannot be read.
    #[error(transparent)]
    Golden(#[from] GoldenError),
    /// The world cannot be opened.
    #[error("{}: {reason}", path.display())]
    World {
        /// Its folder.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The script is none.
    #[error(transparent)]
    Script(#[from] ScriptError),
    /// The server cannot show the scene.
    #[error(transparent)]
    Demo(#[from] DemoError),
    /// The recording cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The recording cannot be replayed.
    #[error(transparent)]
    Packets(#[from] PacketsError),
    /// The trace cannot be written.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// A file cannot be written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

/// A bundled scene and the dat files of its world.
///
/// # Errors
/// When they cannot be read.
pub fn bundled_scene(name: &str) -> Result<(Scene, Arc<DatSet>), SessionError> {
    let root = corpus::bundled();
    let trace = root.join(format!("traces/{name}.mcap"));
    let scene = TraceReader::open(&trace)?.scene().clone();
    let path = root.join("worlds").join(&scene.world);
    match DatSet::open(&path, Strictness::Lenient) {
        Ok(source) => Ok((scene, Arc::new(source))),
        Err(error) => Err(SessionError::World {
            path,
            reason: error.to_string(),
        }),
    }
}

impl GoldenSession {
    /// The session before its first datagram.
    ///
    /// # Errors
    /// When scene or script are not there.
    pub fn start(&self) -> Result<Loopback, SessionError> {
        self.start_with(self.script, SEED, 60.0)
    }

    /// The same with another script, another seed of the faults, and an end after `limit` s at the latest.
    ///
    /// # Errors
    /// As [`GoldenSession::start`].
    pub fn start_with(
        &self,
        script: &str,
        seed: u64,
        limit: f64,
    ) -> Result<Loopback, SessionError> {
        let (scene, source) = bundled_scene(self.scene)?;
        let mut server = DemoConfig::new(scene, source);
        server.played = self.played;
        server.authority = self.authority;
        server.told = self.misled.then_some(Abilities {
            run: 2 * Abilities::default().run,
            ..Abilities::default()
        });
        Ok(Loopback::new(&LoopbackConfig {
            server,
            script: Script::parse(script)?,
            rate: RATE,
            faults: self.faults,
            seed,
            limit,
            profile: Profile::retail(),
        })?)
    }

    /// Runs the session and answers its recording.
    ///
    /// # Errors
    /// When it cannot start.
    pub fn record(&self) -> Result<Vec<u8>, SessionError> {
        let mut session = self.start()?;
        let mut writer = RecordingWriter::new(Cursor::new(Vec::new()))?;
        session.record(&mut writer)?;
        Ok(writer.finish()?.into_inner())
    }

    /// The trace that the replay of a recording of this session gives.
    ///
    /// # Errors
    /// When the recording cannot be replayed.
    pub fn expectation(&self, recording: &[u8]) -> Result<Vec<u8>, SessionError> {
        let path = Path::new(self.name);
        let session = Session::find(&Recording::parse(recording, path)?, None, path)?;
        let (behind, source) = bundled_scene(self.scene)?;
        let clock = FrameClock::Fixed(RATE.into());
        let (name, summary, world) = (self.name, self.summary, &behind.world);
        let scene = scene_of(&session, name, summary, world, clock, &Tracks::All, path)?;
        let info = TraceInfo {
            version: FormatVersion::CURRENT,
            scene: scene.name.clone(),
            producer: concat!("ac-record ", env!("CARGO_PKG_VERSION")).into(),
            profile: String::new(),
            world: hash_world(&corpus::bundled().join("worlds").join(world))?,
        };
        let mut run = PacketRun::new(&scene, Arc::new(session), source, &Profile::retail());
        let mut out = Cursor::new(Vec::new());
        write_expectation(&mut run, &scene, &info, &mut out)?;
        Ok(out.into_inner())
    }
}

/// Writes every session and its expectation under a folder like `golden-traces`: `packets/NAME.mcap` and `traces/packets/NAME.mcap`, and
/// the index of all traces there.
/// Answers one line per session.
///
/// # Errors
/// When a session cannot be made or a file cannot be written.
pub fn write_all(root: &Path) -> Result<String, SessionError> {
    let put = |folder: PathBuf, name: &str, bytes: &[u8]| {
        let path = folder.join(format!("{name}.mcap"));
        let written = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, bytes));
        written.map_err(|source| SessionError::Io { path, source })
    };
    let mut text = String::new();
    for golden in SESSIONS {
        let recording = golden.record()?;
        let trace = golden.expectation(&recording)?;
        put(root.join("packets"), golden.name, &recording)?;
        put(root.join("traces/packets"), golden.name, &trace)?;
        text += &format!(
            "{}: {} bytes of packets, {} bytes of trace\n",
            golden.name,
            recording.len(),
            trace.len()
        );
    }
    let index = serde_json::to_string_pretty(&Index::of(root)?).map_err(std::io::Error::from);
    let path = root.join("index.json");
    index
        .and_then(|index| std::fs::write(&path, index + "\n"))
        .map_err(|source| SessionError::Io { path, source })?;
    Ok(text)
}
