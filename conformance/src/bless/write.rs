//! Writes what was blessed.

use std::{fs, io::Cursor, path::Path};

use ac_client::profile::Profile;
use ac_golden_traces::{
    GoldenError, Scene, corpus,
    expect::{EXPECT_SCHEMA, Header},
    import::hash_world,
    trace::{
        ChannelKind, Compression, FormatVersion, TraceInfo, TraceReader, TraceWriter,
        rewrite::{Frame, replace_states},
    },
};
use ac_replayer::Simulator;

use super::{Change, produce};
use crate::{
    hash::{self, HashFile},
    run::{Case, RunError, SELF, profile_of},
};

/// Runs the scene again and writes its own expectation. `worlds` is the folder of the worlds, whose hashes go into new traces.
///
/// # Errors
/// When the scene cannot be run, or the trace not be read or written.
pub fn write(simulator: &dyn Simulator, worlds: &Path, change: &Change) -> Result<(), RunError> {
    let frames = produce(simulator, &change.case)?;
    let path = &change.target;
    let io = |source| GoldenError::Io {
        path: path.clone(),
        source,
    };
    let kind = ChannelKind::Expect(SELF.into());
    let bytes = if change.new || change.other_scene {
        new_trace(change, worlds, &frames)?
    } else {
        let old = fs::read(path).map_err(io)?;
        replace_states(&old, path, &kind, &header(&change.scene), &frames)?
    };
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(io)?;
    }
    // Whoever reads meanwhile has the old trace or the new one, never half of it.
    let draft = path.with_extension("mcap.new");
    fs::write(&draft, bytes).map_err(io)?;
    fs::rename(&draft, path).map_err(io)?;
    Ok(())
}

fn header(scene: &str) -> Header {
    Header {
        schema: EXPECT_SCHEMA.into(),
        scene: scene.into(),
        oracle: SELF.into(),
        oracle_version: env!("CARGO_PKG_VERSION").into(),
        notes: vec![format!(
            "what this library did under profile {}; blessed, not computed by an oracle",
            profile_of(SELF)
        )],
    }
}

/// A trace with the scene, its inputs and the expectation.
fn new_trace(change: &Change, worlds: &Path, frames: &[Frame]) -> Result<Vec<u8>, GoldenError> {
    let (scene, text) = scene_and_text(&change.case)?;
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: scene.name.clone(),
        producer: concat!("ac-conform ", env!("CARGO_PKG_VERSION")).into(),
        profile: String::new(),
        world: hash_world(&worlds.join(&scene.world))?,
    };
    trace(&scene, &text, &info, &change.scene, frames).map_err(|error| GoldenError::Container {
        path: change.target.clone(),
        reason: error.to_string(),
    })
}

fn trace(
    scene: &Scene,
    text: &[u8],
    info: &TraceInfo,
    name: &str,
    frames: &[Frame],
) -> Result<Vec<u8>, mcap::McapError> {
    let out = Cursor::new(Vec::new());
    let mut writer = TraceWriter::new(out, info, text, Compression::Archive)?;
    let kind = ChannelKind::Expect(SELF.into());
    writer.add_channel(ChannelKind::Clock, None)?;
    writer.add_channel(ChannelKind::Script, None)?;
    writer.add_channel(kind.clone(), Some(&header(name)))?;
    for (frame, time, states) in frames {
        if let Ok(frame) = u32::try_from(*frame) {
            writer.write_inputs(scene, frame, *time)?;
        }
        writer.write_states(&kind, *frame, *time, states)?;
    }
    Ok(writer.finish()?.into_inner())
}

fn scene_and_text(case: &Case) -> Result<(Scene, Vec<u8>), GoldenError> {
    match case {
        Case::Trace(path) => {
            let reader = TraceReader::open(path)?;
            Ok((reader.scene().clone(), reader.scene_text().to_vec()))
        }
        Case::Files { scene: path, .. } => {
            let text = fs::read(path).map_err(|source| GoldenError::Io {
                path: path.clone(),
                source,
            })?;
            Ok((Scene::parse(&text, path)?, text))
        }
    }
}

/// Brings the bundled file of state hashes up to date for scenes that were blessed. Nothing happens where there is no such file,
/// it is of another profile, or it does not have the scene.
///
/// # Errors
/// When a scene cannot be run, or the file not be read or written.
pub fn update_hashes(simulator: &dyn Simulator, blessed: &[&Change]) -> Result<usize, RunError> {
    let path = corpus::bundled().join("hashes.txt");
    let io = |source| GoldenError::Io {
        path: path.clone(),
        source,
    };
    if blessed.is_empty() || !path.is_file() {
        return Ok(0);
    }
    let text = fs::read_to_string(&path).map_err(io)?;
    let mut file = HashFile::parse(&text).map_err(|error| RunError::Expectation {
        path: path.clone(),
        reason: error.to_string(),
    })?;
    let profile = Profile::retail();
    if file.profile != profile.name {
        return Ok(0);
    }
    let with_frames = file.scenes.values().any(|scene| !scene.frames.is_empty());
    let mut updated = 0;
    for change in blessed {
        if let Some(entry) = file.scenes.get_mut(&change.scene) {
            let fresh = hash::hash_case(simulator, &change.case, &profile)?;
            updated += usize::from(entry.hash != fresh.hash);
            *entry = fresh;
        }
    }
    let scenes: Vec<_> = file.scenes.into_values().collect();
    fs::write(&path, hash::text(&file.profile, &scenes, with_frames)).map_err(io)?;
    Ok(updated)
}
