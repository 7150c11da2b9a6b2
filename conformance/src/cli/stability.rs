//! `ac-conform stability`.

use std::{collections::BTreeSet, path::PathBuf, process::ExitCode};

use ac_client::frame::FrameStates;
use ac_golden_traces::{
    corpus,
    trace::{ChannelKind, TraceEvent, TraceReader},
};
use ac_replayer::client::ClientSimulator;
use miette::{IntoDiagnostic, WrapErr, miette};

use super::{DIFFERS, Format, emit, run::progress};
use crate::{
    report_html::stability_page,
    run::{Case, cases as found_cases},
    stability::{
        ensemble::Change,
        lab::{self, Bundled, Report},
        output,
    },
};

/// Checks numerical stability: the stiff and extreme cases that the specification lists, rules that must hold in every scene, and what
/// small changes at the start grow to.
///
/// Exit code 1 when a rule is violated and no trace or section shows that retail does the same.
#[derive(clap::Args)]
pub struct Args {
    /// Traces (`*.mcap`) or folders of them for rules and ensembles; `05` or `05/14` for listed cases; `cases` for all of these. Default:
    /// all cases and the bundled traces.
    pub(super) scenes: Vec<PathBuf>,
    /// Folder of the worlds. Default: the bundled worlds.
    #[arg(long)]
    pub(super) worlds: Option<PathBuf>,
    /// The oracle whose profile scenes run under, and whose traces show what retail does.
    #[arg(long, default_value = "gdle-repaired", value_parser = ["ace", "gdle", "gdle-repaired"])]
    oracle: String,
    /// The first scene of every area only, and three changes instead of ten.
    #[arg(long)]
    quick: bool,
    /// How to write the results.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write a page for a browser into this folder: DIR/stability.html.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write the JSON document to this file as well; `ac-conform status` reads target/stability.json.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs and prints.
///
/// # Errors
/// When a trace cannot be read or a scene cannot be run.
pub fn run(args: &Args, simulator: &ClientSimulator) -> miette::Result<ExitCode> {
    let report = measure(args, simulator)?;
    if let Some(folder) = &args.report {
        let file = stability_page::write(folder, &report).into_diagnostic()?;
        eprintln!("report: {}", file.display());
    }
    let json = || serde_json::to_string_pretty(&output::document(&report)).into_diagnostic();
    if let Some(path) = &args.output {
        std::fs::write(path, json()?)
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot write {}", path.display()))?;
    }
    match args.format {
        Format::Human => emit(&output::human(&report))?,
        Format::Json => emit(&format!("{}\n", json()?))?,
    }
    Ok(if report.ours() > 0 {
        ExitCode::from(DIFFERS)
    } else {
        ExitCode::SUCCESS
    })
}

fn measure(args: &Args, simulator: &ClientSimulator) -> miette::Result<Report> {
    let all = args.scenes.is_empty();
    let text = |path: &PathBuf| path.to_string_lossy().into_owned();
    let names = args.scenes.iter().map(text);
    let (named, paths): (Vec<String>, Vec<String>) = names.partition(|name| is_case(name));
    let wanted = |id: &str| {
        all || named
            .iter()
            .any(|name| name == "cases" || id == name || id.split('/').next() == Some(name))
    };
    let mut report = Report {
        cases: lab::cases(wanted),
        ..Report::default()
    };
    let scenes = if all {
        bundled(&[corpus::bundled().join("traces")], args, simulator)?
    } else {
        let paths: Vec<PathBuf> = paths.into_iter().map(PathBuf::from).collect();
        bundled(&paths, args, simulator)?
    };
    let changes: &[Change] = if args.quick {
        &[
            Change::PlaceUlps(1),
            Change::Place(1e-4),
            Change::FrameUlps(1),
        ]
    } else {
        &Change::ALL
    };
    let bar = progress(scenes.len() as u64);
    (report.scenes, report.ensembles) =
        lab::bundled(&scenes, changes, || bar.inc(1)).into_diagnostic()?;
    bar.finish_and_clear();
    if all {
        report.scenes.extend(lab::whole_scenes());
    }
    if report.cases.is_empty() && report.scenes.is_empty() {
        return Err(miette!(
            help =
                "cases are called like 05/14 (docs/stability.md lists them), traces end in .mcap",
            "there is nothing to run"
        ));
    }
    Ok(report)
}

/// `cases`, `05` or `05/14`.
fn is_case(name: &str) -> bool {
    let digits = |text: &str| text.len() == 2 && text.bytes().all(|b| b.is_ascii_digit());
    name == "cases" || name.split('/').all(digits)
}

fn bundled(
    paths: &[PathBuf],
    args: &Args,
    simulator: &ClientSimulator,
) -> miette::Result<Vec<Bundled>> {
    let oracle = ["ace", "gdle", "gdle-repaired"]
        .into_iter()
        .find(|name| *name == args.oracle)
        .ok_or_else(|| miette!("no oracle is called `{}`", args.oracle))?;
    let mut scenes = Vec::new();
    let mut seen = BTreeSet::new();
    for case in found_cases::find(paths, None, None).into_diagnostic()? {
        let Case::Trace(path) = case else {
            continue;
        };
        let mut reader = TraceReader::open(&path).into_diagnostic()?;
        let scene = reader.scene().clone();
        if args.quick && !seen.insert(scene.area().to_owned()) {
            continue;
        }
        reader.select(|kind| matches!(kind, ChannelKind::Expect(_)));
        let (mut states, mut expected) = (FrameStates::new(), Vec::new());
        while let Some(event) = reader.next_event(&mut states).into_diagnostic()? {
            if let TraceEvent::States {
                kind: ChannelKind::Expect(name),
                ..
            } = event
                && name == oracle
            {
                expected.extend(states.iter().cloned());
            }
        }
        let source = simulator.world(&scene.world).into_diagnostic()?;
        scenes.push(Bundled {
            scene,
            source,
            oracle,
            expected,
        });
    }
    Ok(scenes)
}
