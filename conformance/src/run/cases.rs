//! Finds what to run.

use std::path::{Path, PathBuf};

use ac_golden_traces::{
    GoldenError, Scene,
    corpus::{self, EXPECT_SUFFIXES, SCENE_SUFFIX, STAGE_SUFFIXES, TRACE_SUFFIX},
};

/// One scene with its expectations.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Case {
    /// A trace file, which holds everything.
    Trace(PathBuf),
    /// A scene file with files of oracles.
    Files {
        /// The scene.
        scene: PathBuf,
        /// Expected-state traces.
        expect: Vec<PathBuf>,
        /// Stage files.
        stages: Vec<PathBuf>,
    },
}

impl Case {
    /// The file that names the case.
    pub fn path(&self) -> &Path {
        match self {
            Self::Trace(path) | Self::Files { scene: path, .. } => path,
        }
    }
}

/// All cases at or under the paths: `*.mcap`, and `*.scene.json` with the expectations beside them or under `expect`
/// (`ORACLE/AREA/NAME.expect.jsonl`, `.gz`), and likewise stage files.
///
/// # Errors
/// When a path does not exist or a scene cannot be read.
pub fn find(
    paths: &[PathBuf],
    expect: Option<&Path>,
    stages: Option<&Path>,
) -> Result<Vec<Case>, GoldenError> {
    let mut cases = Vec::new();
    for path in paths {
        for file in corpus::find(path, &[TRACE_SUFFIX, SCENE_SUFFIX])? {
            cases.push(if file.to_string_lossy().ends_with(TRACE_SUFFIX) {
                Case::Trace(file)
            } else {
                let name = Scene::open(&file)?.name;
                Case::Files {
                    expect: files(&file, &name, expect, &EXPECT_SUFFIXES)?,
                    stages: files(&file, &name, stages, &STAGE_SUFFIXES)?,
                    scene: file,
                }
            });
        }
    }
    cases.sort();
    cases.dedup();
    Ok(cases)
}

/// As [`find`]; without paths the bundled traces, with the library's own expectations.
///
/// # Errors
/// As [`find`].
pub fn find_or_bundled(
    paths: &[PathBuf],
    expect: Option<&Path>,
    stages: Option<&Path>,
) -> Result<Vec<Case>, GoldenError> {
    if !paths.is_empty() {
        return find(paths, expect, stages);
    }
    let mut bundled = vec![corpus::bundled().join("traces")];
    // Not there before anything was blessed.
    bundled.extend(Some(crate::bless::bundled()).filter(|folder| folder.is_dir()));
    find(&bundled, None, None)
}

/// Files with these endings beside the scene file or in the folder of all.
fn files(
    scene: &Path,
    name: &str,
    root: Option<&Path>,
    suffixes: &[&str],
) -> Result<Vec<PathBuf>, GoldenError> {
    let stem = scene
        .to_string_lossy()
        .strip_suffix(SCENE_SUFFIX)
        .map(str::to_owned)
        .unwrap_or_default();
    let beside = suffixes
        .iter()
        .map(|suffix| PathBuf::from(format!("{stem}{suffix}")))
        .find(|file| file.is_file());
    let mut files: Vec<PathBuf> = beside.into_iter().collect();
    if let Some(root) = root {
        files.extend(corpus::of_scene(root, name, suffixes)?);
    }
    Ok(files)
}
