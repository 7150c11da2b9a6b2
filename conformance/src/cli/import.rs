//! `ac-conform import`.

use std::{
    fs::{self, File},
    io::BufWriter,
    path::{Path, PathBuf},
    process::ExitCode,
};

use ac_golden_traces::{
    GoldenError, Scene,
    corpus::{self, EXPECT_SUFFIXES, Index, SCENE_SUFFIX, STAGE_SUFFIXES},
    import::{Sources, import},
};
use miette::{IntoDiagnostic, WrapErr, miette};
use rayon::prelude::*;

/// Arguments of `ac-conform import`.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of scenes (`AREA/NAME.scene.json`).
    #[arg(long)]
    scenes: PathBuf,
    /// Folder of expected-state traces (`ORACLE/AREA/NAME.expect.jsonl`, `.gz`).
    #[arg(long)]
    expect: PathBuf,
    /// Folder of stage checkpoints (`ORACLE/AREA/NAME.stages.jsonl`, `.gz`).
    #[arg(long)]
    stages: Option<PathBuf>,
    /// Folder of the worlds, whose files are hashed into the traces. Default: the bundled worlds.
    #[arg(long)]
    worlds: Option<PathBuf>,
    /// Folder to write to: `traces/AREA/NAME.mcap` and `index.json`.
    #[arg(short, long)]
    output: PathBuf,
}

/// Imports all scenes.
///
/// # Errors
/// When a file cannot be read or written, or does not fit its scene.
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let scenes = corpus::find(&args.scenes, &[SCENE_SUFFIX]).into_diagnostic()?;
    if scenes.is_empty() {
        return Err(miette!(
            help = "scenes end in .scene.json",
            "no scenes under {}",
            args.scenes.display()
        ));
    }
    let worlds = args
        .worlds
        .clone()
        .unwrap_or_else(|| corpus::bundled().join("worlds"));
    scenes
        .par_iter()
        .map(|scene| import_one(args, &worlds, scene))
        .collect::<Result<Vec<()>, _>>()?;
    let index = Index::of(&args.output).into_diagnostic()?;
    let text = serde_json::to_string_pretty(&index).into_diagnostic()?;
    let path = args.output.join("index.json");
    fs::write(&path, text + "\n")
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot write {}", path.display()))?;
    println!("{} traces, {} bytes", index.traces.len(), index.bytes);
    Ok(ExitCode::SUCCESS)
}

fn import_one(args: &Args, worlds: &Path, path: &Path) -> miette::Result<()> {
    let scene = Scene::open(path).into_diagnostic()?;
    let sources = Sources {
        scene: path.into(),
        expect: corpus::of_scene(&args.expect, &scene.name, &EXPECT_SUFFIXES).into_diagnostic()?,
        stages: match &args.stages {
            Some(stages) => {
                corpus::of_scene(stages, &scene.name, &STAGE_SUFFIXES).into_diagnostic()?
            }
            None => Vec::new(),
        },
        world: Some(worlds.join(&scene.world)),
    };
    if sources.expect.is_empty() {
        return Err(miette!(
            "no expectations for {} under {}",
            scene.name,
            args.expect.display()
        ));
    }
    let target = args
        .output
        .join("traces")
        .join(format!("{}.mcap", scene.name));
    let io = |source| GoldenError::Io {
        path: target.clone(),
        source,
    };
    fs::create_dir_all(target.parent().unwrap_or(&args.output))
        .map_err(io)
        .into_diagnostic()?;
    let file = BufWriter::new(File::create(&target).map_err(io).into_diagnostic()?);
    let file = import(&sources, file, &target).into_diagnostic()?;
    file.into_inner()
        .map_err(|error| io(error.into_error()))
        .into_diagnostic()?;
    Ok(())
}
