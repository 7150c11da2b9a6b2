//! `ac-conform precision`.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
};

use ac_client::{dat::DatSet, frame::FrameStates, profile::Profile};
use ac_golden_traces::{
    Scene, corpus,
    trace::{ChannelKind, TraceEvent, TraceReader},
};
use ac_replayer::client::{ClientSimulator, planning};
use clap::ValueEnum;
use miette::{IntoDiagnostic, WrapErr, miette};

use super::{emit, run::progress};
use crate::{
    precision::{
        self, Options, SceneLab, Subject, cases, cost, grid,
        lab::{scene_of, seconds},
        output, summary, track,
    },
    report_html::precision_page,
    run::{Case, cases as found_cases},
};

/// Measures error against run time: every scene under a grid of fidelity settings.
///
/// Without SCENES: the bundled traces and the scenes whose solution is known. Errors are those of the first 10 seconds.
#[derive(clap::Args)]
pub struct Args {
    /// Traces (`*.mcap`), scenes (`*.scene.json`), folders of them, or the word `analytic` for the scenes whose solution is known.
    pub(super) scenes: Vec<PathBuf>,
    /// Folder of the worlds. Default: the bundled worlds.
    #[arg(long)]
    pub(super) worlds: Option<PathBuf>,
    /// Compare with this oracle; its profile and constants are the own setting.
    #[arg(long, default_value = "gdle-repaired", value_parser = ["ace", "gdle", "gdle-repaired"])]
    oracle: String,
    /// A few settings, one timed run, the first scene of every class.
    #[arg(long)]
    quick: bool,
    /// Timed runs of each setting; the median counts. 0: no times, so that the output is the same every time.
    #[arg(long, value_name = "N")]
    repeats: Option<u32>,
    /// Errors are looked at up to so many seconds.
    #[arg(long, default_value_t = 10.0)]
    horizon: f64,
    /// Count instructions too (the first scene of every class; needs valgrind, takes minutes).
    #[arg(long)]
    instructions: bool,
    /// How to write the results.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write plots for a browser into this folder: DIR/precision.html.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write the JSON document to this file as well; `ac-conform status` reads target/precision.json.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Only run every setting once, for valgrind.
    #[arg(long, hide = true)]
    counted: bool,
}

/// How results are written to standard output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Tables for people: recommendations and orders; settings too where few scenes are named.
    #[default]
    Human,
    /// One JSON document.
    Json,
    /// One line per scene and setting.
    Csv,
}

/// Measures and prints.
///
/// # Errors
/// When a scene cannot be read or run.
pub fn run(args: &Args, simulator: &ClientSimulator) -> miette::Result<ExitCode> {
    let profile = grid::PROFILES
        .into_iter()
        .find(|name| *name == args.oracle)
        .ok_or_else(|| miette!("no profile is called `{}`", args.oracle))?;
    let mut subjects = subjects(args, simulator)?;
    if args.quick && args.scenes.is_empty() {
        let mut seen = BTreeSet::new();
        subjects.retain(|s| s.analytic.is_some() || seen.insert(s.scene.area().to_owned()));
    }
    let options = Options {
        profile,
        grid: if args.quick {
            grid::quick(profile)
        } else {
            grid::full(profile)
        },
        repeats: args.repeats.unwrap_or(if args.quick { 1 } else { 3 }),
        horizon: args.horizon,
    };
    if args.counted {
        return counted(&subjects, &options);
    }
    let bar = progress(subjects.len() as u64 * 2);
    let mut labs = precision::run(&subjects, &options, || bar.inc(1)).into_diagnostic()?;
    if args.instructions {
        count(args, &subjects, &mut labs)?;
    }
    bar.finish_and_clear();
    write(args, &labs)?;
    Ok(ExitCode::SUCCESS)
}

fn write(args: &Args, labs: &[SceneLab]) -> miette::Result<()> {
    if let Some(folder) = &args.report {
        let file = precision_page::write(folder, labs).into_diagnostic()?;
        eprintln!("report: {}", file.display());
    }
    let json = || serde_json::to_string_pretty(&output::document(labs)).into_diagnostic();
    if let Some(path) = &args.output {
        std::fs::write(path, json()?)
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot write {}", path.display()))?;
    }
    match args.format {
        Format::Human => emit(&output::human(labs, labs.len() <= 6)),
        Format::Json => emit(&format!("{}\n", json()?)),
        Format::Csv => emit(&output::csv(labs)),
    }
}

/// The scenes that the arguments name.
fn subjects(args: &Args, simulator: &ClientSimulator) -> miette::Result<Vec<Subject>> {
    let analytic = Path::new("analytic");
    let mut paths: Vec<PathBuf> = args
        .scenes
        .iter()
        .filter(|path| *path != analytic)
        .cloned()
        .collect();
    let mut subjects = Vec::new();
    if args.scenes.is_empty() {
        paths.push(corpus::bundled().join("traces"));
    }
    if args.scenes.is_empty() || args.scenes.iter().any(|path| path == analytic) {
        for case in cases::all().into_diagnostic()? {
            let profile = Profile::named(&args.oracle).unwrap_or_default();
            let index = planning::measure_index(&case.source, &profile).into_diagnostic()?;
            subjects.push(Subject {
                scene: case.scene.clone(),
                source: Arc::clone(&case.source),
                index: Some(Arc::new(index)),
                expected: Vec::new(),
                analytic: Some(case),
            });
        }
    }
    for case in found_cases::find(&paths, None, None).into_diagnostic()? {
        subjects.push(subject(&case, &args.oracle, simulator)?);
    }
    Ok(subjects)
}

fn subject(case: &Case, oracle: &str, simulator: &ClientSimulator) -> miette::Result<Subject> {
    let (scene, expected) = match case {
        Case::Files { scene, .. } => (Scene::open(scene).into_diagnostic()?, Vec::new()),
        Case::Trace(path) => expectation(path, oracle)?,
    };
    let source: Arc<DatSet> = simulator.world(&scene.world).into_diagnostic()?;
    let profile = Profile::named(oracle).unwrap_or_default();
    let index = simulator.index(&scene.world, &profile).into_diagnostic()?;
    Ok(Subject {
        scene,
        source,
        index: Some(index),
        expected,
        analytic: None,
    })
}

/// The scene of a trace and what an oracle expects in it.
fn expectation(path: &Path, oracle: &str) -> miette::Result<(Scene, Vec<track::Track>)> {
    let mut reader = TraceReader::open(path).into_diagnostic()?;
    reader.select(|kind| matches!(kind, ChannelKind::Expect(_)));
    let scene = reader.scene().clone();
    let (mut states, mut all) = (FrameStates::new(), Vec::new());
    while let Some(event) = reader.next_event(&mut states).into_diagnostic()? {
        if let TraceEvent::States {
            kind: ChannelKind::Expect(name),
            ..
        } = event
            && name == oracle
        {
            all.extend(states.iter().cloned());
        }
    }
    let tracks = track::expected(&all, &scene);
    Ok((scene, tracks))
}

/// Runs every setting of every scene once, in the order of the rows.
fn counted(subjects: &[Subject], options: &Options) -> miette::Result<ExitCode> {
    for subject in subjects {
        for setting in &options.grid {
            if let Some(scene) = scene_of(&subject.scene, setting) {
                let mut run = track::start(&scene, subject.ground(), setting).into_diagnostic()?;
                cost::counted_frames(&mut run, scene.frame_count());
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Puts instruction counts into the first scene of every class.
fn count(args: &Args, subjects: &[Subject], labs: &mut [SceneLab]) -> miette::Result<()> {
    let valgrind = cost::valgrind().ok_or_else(|| {
        miette!(
            help = "install valgrind, or leave --instructions out",
            "valgrind is not on the path"
        )
    })?;
    let mut seen = BTreeSet::new();
    for (subject, lab) in subjects.iter().zip(labs) {
        if !seen.insert(lab.class.clone()) && subjects.len() > 4 {
            continue;
        }
        let named = named(subject);
        let mut arguments: Vec<String> = vec!["precision".into(), "--counted".into()];
        arguments.extend(args.quick.then(|| "--quick".into()));
        arguments.extend(["--oracle".into(), args.oracle.clone(), named]);
        let Some(counts) = cost::instructions(&valgrind, &arguments) else {
            eprintln!("valgrind could not count {}", lab.scene);
            continue;
        };
        // The analytic scenes are run together.
        let at = subjects
            .iter()
            .filter(|s| s.analytic.is_some())
            .position(|s| s.scene.name == lab.scene)
            .unwrap_or(0);
        let length = seconds(&subject.scene);
        let counts = counts.get(at * lab.rows.len()..).unwrap_or_default();
        for (row, count) in lab.rows.iter_mut().zip(counts) {
            row.instructions_per_second = Some(*count as f64 / length);
        }
        summary::mark_pareto(&mut lab.rows);
    }
    Ok(())
}

/// The argument that names a subject.
fn named(subject: &Subject) -> String {
    if subject.analytic.is_some() {
        return "analytic".into();
    }
    let trace = format!("{}{}", subject.scene.name, corpus::TRACE_SUFFIX);
    corpus::bundled()
        .join("traces")
        .join(trace)
        .display()
        .to_string()
}
