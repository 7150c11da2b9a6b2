//! `ac-conform shrink`.

use std::{path::PathBuf, process::ExitCode, time::Duration};

use ac_client::profile::Profile;
use ac_golden_traces::corpus;
use ac_replayer::client::ClientSimulator;
use globset::{Glob, GlobMatcher};
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, miette};
use std::io::IsTerminal;

use super::{Format, emit};
use crate::{
    bisect::verdict::Question,
    hash,
    run::{Case, PROFILES, profile_of},
    shrink::{
        Candidate, Judge, ShrinkError,
        candidate::Records,
        judge::{Recorded, TwoProfiles, TwoPrograms},
        output::{self, Report},
        shrink,
    },
};

/// Arguments of `ac-conform shrink`.
#[derive(clap::Args)]
#[command(
    after_help = "Takes frames, entities, script steps and records of the world out of a scene that diverges, for as long as the same \
    divergence (field and stage) still shows, and writes what is left with a world of its own.\n\n\
    What it diverges from is one of:\n  \
    --against PROFILE    the library under another profile; with --switch only in this point\n  \
    --good-bin FILE      another program (an `ac-replay`); the other side is --bad-bin\n  \
    --oracle NAME        the expectation in the trace (the default: the first that is missed). It cannot be computed again, so that only \
    what has no part in the client's own states goes\n\n\
    Exit codes:\n  0  written\n  2  it does not diverge, or could not be run"
)]
pub struct Args {
    /// The trace (`*.mcap`) or scene (`*.scene.json`).
    trace: PathBuf,
    /// Folder to write to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Behaviour to run under; auto: that of the oracle, else retail.
    #[arg(long, default_value = "auto")]
    profile: String,
    /// Compare with the library under this profile.
    #[arg(long, value_name = "PROFILE", conflicts_with_all = ["oracle", "good_bin"])]
    against: Option<String>,
    /// With --against: the two differ in this switch only (a field of `Profile`, see `ac-conform sensitivity`).
    #[arg(long, value_name = "FIELD", requires = "against")]
    switch: Option<String>,
    /// Compare with the expectation of this oracle.
    #[arg(long, conflicts_with = "good_bin")]
    oracle: Option<String>,
    /// Compare with what this program does.
    #[arg(long, value_name = "FILE", requires = "bad_bin")]
    good_bin: Option<PathBuf>,
    /// The program that is judged.
    #[arg(long, value_name = "FILE", requires = "good_bin")]
    bad_bin: Option<PathBuf>,
    /// Only differences in fields of this name count: a glob, like `origin` or `contact_plane.*`.
    #[arg(long, value_name = "GLOB")]
    field: Option<String>,
    /// Folder of the worlds. Default: the bundled worlds.
    #[arg(long)]
    worlds: Option<PathBuf>,
    /// Candidates to run at most.
    #[arg(long, default_value_t = 5000)]
    max_runs: usize,
    /// How to write the result.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Shrinks and writes.
///
/// # Errors
/// When the scene does not diverge, or cannot be run or written.
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let worlds = args
        .worlds
        .clone()
        .unwrap_or_else(|| corpus::bundled().join("worlds"));
    let case = if args.trace.extension().is_some_and(|of| of == "mcap") {
        Case::Trace(args.trace.clone())
    } else {
        Case::Files {
            scene: args.trace.clone(),
            expect: Vec::new(),
            stages: Vec::new(),
        }
    };
    let scene = hash::scene_of(&case).into_diagnostic()?;
    let name = scene.name.clone();
    if scene.features.iter().any(|feature| feature == "packets") {
        return Err(miette!(
            help = "`ac-conform bisect` works on packet sessions too",
            "{name} is a session of packets: there are no entities, steps or frames to take out of its scene"
        ));
    }
    let world = ClientSimulator::new(&worlds).world(&scene.world);
    let records = Records::of(&*world.into_diagnostic()?).into_diagnostic()?;
    let whole = Candidate::new(scene, records);
    let Side {
        mut judge,
        oracle,
        rerun,
    } = side(args, &whole)?;
    let bar = bar(args.max_runs);
    let progress = |runs: usize, best: &Candidate| {
        bar.set_position(runs as u64);
        let scene = &best.scene;
        bar.set_message(format!(
            "{} frames, {} entities, {} steps, {} records",
            scene.frame_count(),
            scene.entities.len(),
            scene.script.len(),
            best.records.len()
        ));
    };
    let shrunk = shrink(whole, &mut *judge, args.max_runs, &progress);
    bar.finish_and_clear();
    let shrunk = shrunk.map_err(advice)?;
    let report = output::write(&args.output, &name, &oracle, &rerun, &shrunk, &mut *judge);
    let report = report.into_diagnostic()?;
    match args.format {
        Format::Human => emit(&human(
            &report,
            &format!("{} {rerun}", args.output.display()),
        ))?,
        Format::Json => emit(&(serde_json::to_string(&report).into_diagnostic()? + "\n"))?,
    }
    Ok(ExitCode::SUCCESS)
}

fn advice(error: ShrinkError) -> miette::Report {
    match error {
        ShrinkError::Nothing(text) => miette!(
            help = "name what it should differ from: --against PROFILE, --oracle NAME with another --profile, or --good-bin and --bad-bin",
            "{text}"
        ),
        error => miette::Report::msg(error.to_string()),
    }
}

fn bar(max_runs: usize) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(max_runs as u64);
    if let Ok(style) = ProgressStyle::with_template("{pos} of at most {len} runs, {elapsed}: {msg}")
    {
        bar.set_style(style);
    }
    bar
}

/// What a scene is compared with.
struct Side {
    judge: Box<dyn Judge>,
    /// Name of the expectation that is written.
    oracle: String,
    /// Options with which `ac-conform run` shows the divergence again.
    rerun: String,
}

fn profile(name: &str) -> miette::Result<Profile> {
    Profile::named(name).ok_or_else(|| {
        miette!(
            help = format!("profiles: {}", PROFILES.join(", ")),
            "no profile is called `{name}`"
        )
    })
}

fn field(args: &Args) -> miette::Result<Option<GlobMatcher>> {
    let glob = args.field.as_deref().map(Glob::new).transpose();
    Ok(glob.into_diagnostic()?.map(|glob| glob.compile_matcher()))
}

fn side(args: &Args, whole: &Candidate) -> miette::Result<Side> {
    let own = match args.profile.as_str() {
        "auto" => "retail",
        name => name,
    };
    if let (Some(good), Some(bad)) = (&args.good_bin, &args.bad_bin) {
        let mut judge =
            TwoPrograms::new(good, bad, own, Duration::from_secs(60)).into_diagnostic()?;
        judge.field = field(args)?;
        return Ok(Side {
            judge: Box::new(judge),
            oracle: own.into(),
            rerun: "(with the ac-conform of the bad build)".into(),
        });
    }
    if let Some(against) = &args.against {
        let actual = profile(own)?;
        let mut expected = profile(against)?;
        if let Some(name) = &args.switch {
            let from = expected;
            let switch = Profile::SWITCHES.iter().find(|of| of.field == name);
            let switch = switch.ok_or_else(|| {
                miette!(
                    help = "`ac-conform sensitivity` lists them",
                    "no switch is called `{name}`"
                )
            })?;
            expected = actual.clone();
            (switch.copy)(&mut expected, &from);
        }
        return Ok(Side {
            judge: Box::new(TwoProfiles {
                expected,
                actual,
                field: field(args)?,
            }),
            oracle: against.clone(),
            rerun: format!("--profile {own}"),
        });
    }
    recorded(args, whole)
}

/// The named oracle, or the first whose expectation is missed.
fn recorded(args: &Args, whole: &Candidate) -> miette::Result<Side> {
    let mut question = Question {
        trace: args.trace.clone(),
        worlds: PathBuf::new(),
        profile: String::new(),
        field: None,
        expected: Default::default(),
        timeout: Duration::ZERO,
    };
    question
        .read_expectations(args.oracle.as_deref())
        .into_diagnostic()?;
    let mut last = None;
    for (oracle, expected) in question.expected {
        let own = match args.profile.as_str() {
            "auto" => profile_of(&oracle).to_owned(),
            name => name.to_owned(),
        };
        let actual = profile(&own)?;
        let mut judge = Recorded::new(whole, expected, actual.clone()).into_diagnostic()?;
        judge.field = field(args)?;
        let missed = judge.judge(whole, None).into_diagnostic()?.is_some();
        if let Some(theirs) = Profile::named(profile_of(&oracle)).filter(|theirs| *theirs != actual)
        {
            judge.stages = Some(TwoProfiles {
                expected: theirs,
                actual,
                field: None,
            });
        }
        last = Some(Side {
            judge: Box::new(judge),
            oracle,
            rerun: format!("--profile {own}"),
        });
        if missed {
            break;
        }
    }
    last.ok_or_else(|| {
        miette!(
            help =
                "name what it should differ from: --against PROFILE, or --good-bin and --bad-bin",
            "{} has no expectations",
            args.trace.display()
        )
    })
}

fn human(report: &Report, rerun: &str) -> String {
    let Report {
        before,
        after,
        shown,
        ..
    } = report;
    let divergence = &shown.place.divergence;
    let mut text = format!(
        "{} frames (of {}), {} entities (of {}), {} steps (of {}), {} records (of {}), {} bytes in all; {} runs\n",
        after.frames,
        before.frames,
        after.entities,
        before.entities,
        after.steps,
        before.steps,
        after.records,
        before.records,
        report.bytes,
        report.runs
    );
    if report.budget_spent {
        text += "the budget is spent: with a larger --max-runs it may become smaller\n";
    }
    text += &format!(
        "frame {}, entity {}, {}: expected {}, got {}; first in stage {}\n",
        divergence.frame,
        shown.place.guid,
        divergence.field,
        divergence.expected,
        divergence.actual,
        shown.stage.as_deref().unwrap_or("(not known)")
    );
    text + &format!("ac-conform run {rerun}\n")
}
