//! Where scenes, expectations, traces and worlds lie on disk, and the index of the bundled ones.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use ac_client::frame::FrameStates;
use serde::{Deserialize, Serialize};

use crate::{
    GoldenError,
    trace::{ChannelKind, TraceEvent, TraceReader},
};

/// Ending of scene files.
pub const SCENE_SUFFIX: &str = ".scene.json";
/// Endings of expected-state traces.
pub const EXPECT_SUFFIXES: [&str; 2] = [".expect.jsonl", ".expect.jsonl.gz"];
/// Endings of stage files.
pub const STAGE_SUFFIXES: [&str; 2] = [".stages.jsonl", ".stages.jsonl.gz"];
/// Ending of trace files.
pub const TRACE_SUFFIX: &str = ".mcap";

/// The folder with the bundled traces and worlds.
///
/// That is `golden-traces` of the source tree this program was built from; where that is gone, `golden-traces` in the
/// current folder.
pub fn bundled() -> PathBuf {
    let built = Path::new(env!("CARGO_MANIFEST_DIR"));
    if built.join("traces").is_dir() || built.join("worlds").is_dir() {
        built.into()
    } else {
        "golden-traces".into()
    }
}

/// All files at or under `path` that end in one of `suffixes`, in the order of their paths.
///
/// # Errors
/// When a folder cannot be read or `path` does not exist.
pub fn find(path: &Path, suffixes: &[&str]) -> Result<Vec<PathBuf>, GoldenError> {
    let mut found = Vec::new();
    walk(path, suffixes, 0, &mut found)?;
    found.sort();
    Ok(found)
}

fn walk(
    path: &Path,
    suffixes: &[&str],
    depth: usize,
    found: &mut Vec<PathBuf>,
) -> Result<(), GoldenError> {
    let io = |source| GoldenError::Io {
        path: path.into(),
        source,
    };
    if fs::metadata(path).map_err(io)?.is_dir() {
        // Links may form circles.
        if depth < 32 {
            for entry in fs::read_dir(path).map_err(io)? {
                walk(&entry.map_err(io)?.path(), suffixes, depth + 1, found)?;
            }
        }
    } else if suffixes
        .iter()
        .any(|suffix| path.to_string_lossy().ends_with(suffix))
    {
        found.push(path.into());
    }
    Ok(())
}

/// The files `ROOT/*/AREA/NAME.SUFFIX` of a scene, one folder per oracle, in the order of the folders' names; and
/// `ROOT/AREA/NAME.SUFFIX` if there is one.
///
/// # Errors
/// When `root` cannot be read.
pub fn of_scene(root: &Path, scene: &str, suffixes: &[&str]) -> Result<Vec<PathBuf>, GoldenError> {
    let io = |source| GoldenError::Io {
        path: root.into(),
        source,
    };
    let mut folders: BTreeSet<PathBuf> = [root.into()].into();
    for entry in fs::read_dir(root).map_err(io)? {
        folders.insert(entry.map_err(io)?.path());
    }
    let mut files = Vec::new();
    for folder in folders {
        files.extend(
            suffixes
                .iter()
                .map(|suffix| folder.join(format!("{scene}{suffix}")))
                .find(|file| file.is_file()),
        );
    }
    Ok(files)
}

/// One trace in the index.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IndexEntry {
    /// Name of the scene.
    pub name: String,
    /// First part of the name.
    pub area: String,
    /// What the scene exercises.
    pub summary: String,
    /// Tags of the scene.
    pub features: Vec<String>,
    /// Folder name of its world.
    pub world: String,
    /// Number of frames.
    pub frames: u32,
    /// Number of tracked entities.
    pub tracked: usize,
    /// Oracles with expectations.
    pub oracles: Vec<String>,
    /// Oracles with stage checkpoints.
    pub stages: Vec<String>,
    /// The file, relative to the index.
    pub file: String,
    /// Its size.
    pub bytes: u64,
    /// Its BLAKE3.
    pub blake3: String,
}

/// The index of a folder of traces.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Index {
    /// `ac-index/1`.
    pub schema: String,
    /// Sum of the sizes.
    pub bytes: u64,
    /// One per trace, by file name.
    pub traces: Vec<IndexEntry>,
}

impl Index {
    /// Reads all traces under `root/traces`.
    ///
    /// # Errors
    /// When one cannot be read.
    pub fn of(root: &Path) -> Result<Self, GoldenError> {
        let files = find(&root.join("traces"), &[TRACE_SUFFIX])?;
        let traces = files
            .iter()
            .map(|file| entry(root, file))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            schema: "ac-index/1".into(),
            bytes: traces.iter().map(|entry| entry.bytes).sum(),
            traces,
        })
    }
}

fn entry(root: &Path, file: &Path) -> Result<IndexEntry, GoldenError> {
    let bytes = fs::read(file).map_err(|source| GoldenError::Io {
        path: file.into(),
        source,
    })?;
    let mut reader = TraceReader::new(&bytes[..], file)?;
    let (mut oracles, mut stages) = (BTreeSet::new(), BTreeSet::new());
    let mut states = FrameStates::new();
    // Reading everything also checks everything.
    while let Some(event) = reader.next_event(&mut states)? {
        match event {
            TraceEvent::States {
                kind: ChannelKind::Expect(oracle),
                ..
            } if !oracles.contains(oracle) => {
                oracles.insert(oracle.clone());
            }
            TraceEvent::Stages { oracle, .. } if !stages.contains(oracle) => {
                stages.insert(oracle.to_owned());
            }
            _ => {}
        }
    }
    let scene = reader.scene();
    Ok(IndexEntry {
        name: scene.name.clone(),
        area: scene.area().into(),
        summary: scene.summary.clone(),
        features: scene.features.clone(),
        world: scene.world.clone(),
        frames: scene.frame_count(),
        tracked: scene.track.len(),
        oracles: oracles.into_iter().collect(),
        stages: stages.into_iter().collect(),
        file: file
            .strip_prefix(root)
            .unwrap_or(file)
            .to_string_lossy()
            .replace('\\', "/"),
        bytes: bytes.len() as u64,
        blake3: blake3::hash(&bytes).to_hex().to_string(),
    })
}
