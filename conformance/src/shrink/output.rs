//! The shrunk scene as files: the scene, its expectation, its world, and what was done.

use std::{fs, io::Write, path::Path};

use ac_golden_traces::{
    GoldenError, Scene,
    expect::{EXPECT_SCHEMA, Header},
    record,
    trace::rewrite::Frame,
};

use serde::Serialize;

use super::{Judge, Shown, ShrinkError, Shrunk, Size, candidate::Records, judge::keep_only};

fn io(path: &Path) -> impl FnOnce(std::io::Error) -> GoldenError + '_ {
    move |source| GoldenError::Io {
        path: path.into(),
        source,
    }
}

/// Writes a scene file.
///
/// # Errors
/// When that fails.
pub fn write_scene(path: &Path, scene: &Scene) -> Result<(), ShrinkError> {
    let text = serde_json::to_string_pretty(scene).map_err(std::io::Error::from);
    let text = text.map_err(io(path))?;
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(io(folder))?;
    }
    fs::write(path, text + "\n").map_err(io(path))?;
    Ok(())
}

/// Writes the two dat files of a world; answers their size in bytes.
///
/// # Errors
/// When that fails.
pub fn write_world(folder: &Path, records: &Records) -> Result<usize, ShrinkError> {
    fs::create_dir_all(folder).map_err(io(folder))?;
    let mut bytes = 0;
    let names = ["client_portal.dat", "client_cell_1.dat"];
    for (name, file) in names.into_iter().zip(records.files()?) {
        let path = folder.join(name);
        fs::write(&path, &file).map_err(io(&path))?;
        bytes += file.len();
    }
    Ok(bytes)
}

/// Writes an expected-state trace.
///
/// # Errors
/// When that fails.
pub fn write_expectation(
    path: &Path,
    scene: &str,
    oracle: &str,
    notes: Vec<String>,
    frames: &[Frame],
) -> Result<(), ShrinkError> {
    let header = Header {
        schema: EXPECT_SCHEMA.into(),
        scene: scene.into(),
        oracle: oracle.into(),
        oracle_version: env!("CARGO_PKG_VERSION").into(),
        notes,
    };
    let head = serde_json::to_string(&header).map_err(std::io::Error::from);
    let mut text = head.map_err(io(path))?.into_bytes();
    for (_, _, states) in frames {
        for state in states.iter() {
            text.push(b'\n');
            record::write_line(&mut text, state);
        }
    }
    text.push(b'\n');
    let mut file = fs::File::create(path).map_err(io(path))?;
    file.write_all(&text).map_err(io(path))?;
    Ok(())
}

/// What was written.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Schema of this report.
    pub schema: &'static str,
    /// Name of the scene that was shrunk.
    pub from: String,
    /// Who expects.
    pub oracle: String,
    /// Before.
    pub before: Size,
    /// After.
    pub after: Size,
    /// Bytes of all files.
    pub bytes: u64,
    /// Candidates that were run.
    pub runs: usize,
    /// Whether the budget ended it.
    pub budget_spent: bool,
    /// What it shows.
    pub shown: Shown,
}

/// Schema of [`Report`].
pub const SCHEMA: &str = "ac-conform-shrink/1";

/// Writes everything into a folder: `NAME.scene.json`, `NAME.expect.jsonl`, `worlds/WORLD/*.dat`, `README.md`. `oracle` is the name that the
/// expectation gets, `rerun` what `ac-conform run` on the folder needs to show the divergence.
///
/// # Errors
/// When something cannot be written, or the expectation not be computed.
pub fn write(
    folder: &Path,
    from: &str,
    oracle: &str,
    rerun: &str,
    shrunk: &Shrunk,
    judge: &mut dyn Judge,
) -> Result<Report, ShrinkError> {
    let plain = from.replace('/', "-");
    let mut frames = judge.expectation(&shrunk.candidate)?;
    let mut candidate = shrunk.candidate.clone();
    candidate.scene.name = format!("shrunk/{plain}");
    candidate.scene.world = format!("shrunk-{plain}");
    candidate.scene.summary = format!("What is left of {from}: {}", candidate.scene.summary);
    if let Some(field) = judge.field() {
        for (_, _, states) in &mut frames {
            states.iter_mut().for_each(|state| keep_only(state, field));
        }
    }
    let file = |ending: &str| folder.join(format!("{plain}{ending}"));
    let paths = [file(".scene.json"), file(".expect.jsonl")];
    write_scene(&paths[0], &candidate.scene)?;
    let notes = vec![format!("of a scene that was shrunk from {from}")];
    write_expectation(&paths[1], &candidate.scene.name, oracle, notes, &frames)?;
    let world = folder.join("worlds").join(&candidate.scene.world);
    let mut bytes = write_world(&world, &candidate.records)? as u64;
    for path in &paths {
        bytes += fs::metadata(path).map_err(io(path))?.len();
    }
    let report = Report {
        schema: SCHEMA,
        from: from.into(),
        oracle: oracle.into(),
        before: shrunk.before,
        after: shrunk.after,
        bytes,
        runs: shrunk.runs,
        budget_spent: shrunk.budget_spent,
        shown: shrunk.shown.clone(),
    };
    let readme = folder.join("README.md");
    fs::write(&readme, text(&report, rerun)).map_err(io(&readme))?;
    Ok(report)
}

/// What a person who finds the folder wants to know.
fn text(report: &Report, rerun: &str) -> String {
    let Report {
        from,
        oracle,
        before,
        after,
        shown,
        runs,
        ..
    } = report;
    let divergence = &shown.place.divergence;
    format!(
        "# {from}, shrunk\n\n\
        `ac-conform shrink` made this of `{from}`: {} of {} frames, {} of {} entities, {} of {} steps, {} of {} records of the world \
        ({runs} runs).\n\n\
        It shows: frame {}, entity {}, `{}`: expected {}, got {}; first in stage {}.\n\n\
        The expectation is under the name `{oracle}`. Here, `ac-conform run . {rerun}` shows it; the world is found in this folder.\n",
        after.frames,
        before.frames,
        after.entities,
        before.entities,
        after.steps,
        before.steps,
        after.records,
        before.records,
        divergence.frame,
        shown.place.guid,
        divergence.field,
        divergence.expected,
        divergence.actual,
        shown.stage.as_deref().unwrap_or("(not known)"),
    )
}
