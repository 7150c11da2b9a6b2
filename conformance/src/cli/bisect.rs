//! `ac-conform bisect`.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Duration,
};

use ac_golden_traces::corpus;
use globset::Glob;
use miette::{IntoDiagnostic, miette};

use super::{DIFFERS, Format, emit};
use crate::bisect::{
    BisectError,
    build::{Builder, Built},
    git::{Commit, Git},
    locate::{Location, locate},
    report,
    search::{Found, search},
    state::{Asked, Known, State},
    verdict::{Question, Verdict, produced},
};

/// Arguments of `ac-conform bisect`.
#[derive(clap::Args)]
#[command(
    after_help = "Builds commits between a good and a bad one in a worktree of its own, until the first one is found whose verdict on \
    the trace is not that of the good one; then runs the commit and the one before it with checkpoints and says in which frame, stage and \
    field they part. An interrupted search goes on where it was. Without git, --good-bin and --bad-bin compare two programs.\n\n\
    Exit codes:\n  0  no difference between the two programs (--good-bin, --bad-bin)\n  1  found\n  2  it could not be looked for"
)]
pub struct Args {
    /// The trace or scene.
    #[arg(long, value_name = "FILE")]
    trace: PathBuf,
    /// A commit with the wanted behaviour.
    #[arg(long, value_name = "REV", requires = "bad", conflicts_with_all = ["good_bin", "bad_bin"])]
    good: Option<String>,
    /// A later commit with another.
    #[arg(long, value_name = "REV", requires = "good")]
    bad: Option<String>,
    /// A program with the wanted behaviour: an `ac-replay`.
    #[arg(
        long,
        value_name = "FILE",
        requires = "bad_bin",
        required_unless_present = "good"
    )]
    good_bin: Option<PathBuf>,
    /// A program with another.
    #[arg(long, value_name = "FILE", requires = "good_bin")]
    bad_bin: Option<PathBuf>,
    /// Only differences in fields of this name count: a glob, like `origin` or `contact_plane.*`.
    #[arg(long, value_name = "GLOB")]
    field: Option<String>,
    /// Compare with the expectation of this oracle only. Default: every one in the trace.
    #[arg(long)]
    oracle: Option<String>,
    /// Behaviour to run under where the trace has no expectation, and to look for the stage under.
    #[arg(long)]
    profile: Option<String>,
    /// Folder of the worlds. Default: the bundled worlds of this program, for all builds.
    #[arg(long)]
    worlds: Option<PathBuf>,
    /// Folder in the repository. Default: the current one.
    #[arg(long, value_name = "DIR")]
    repo: Option<PathBuf>,
    /// Folder for the worktree, the builds and what was found out. Default: `target/ac-bisect` in the repository.
    #[arg(long, value_name = "DIR")]
    worktree: Option<PathBuf>,
    /// How to build a commit: a shell command, run in its worktree with CARGO_TARGET_DIR set.
    #[arg(long, default_value = "cargo build --release -p ac-replayer")]
    build_command: String,
    /// What it makes, under CARGO_TARGET_DIR.
    #[arg(long, default_value = "release/ac-replay", value_name = "PATH")]
    program: PathBuf,
    /// CARGO_TARGET_DIR of the builds. Default: a folder beside the worktree, so that yours stays as it is.
    #[arg(long, value_name = "DIR")]
    target_dir: Option<PathBuf>,
    /// A run that takes more seconds has failed.
    #[arg(long, default_value_t = 600)]
    timeout: u64,
    /// How to write the result.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Searches and prints what was found.
///
/// # Errors
/// When it cannot be looked for.
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let question = question(args)?;
    let (found, location) = match (&args.good, &args.bad, &args.good_bin, &args.bad_bin) {
        (Some(good), Some(bad), ..) => {
            let (found, location) = commits(args, &question, good, bad)?;
            (Some(found), location)
        }
        (.., Some(good), Some(bad)) => (None, programs(args, &question, good, bad)?),
        _ => {
            return Err(miette!(
                "name --good and --bad, or --good-bin and --bad-bin"
            ));
        }
    };
    match args.format {
        Format::Human => {
            if let Some(found) = &found {
                emit(&report::found(found))?;
            }
            emit(&report::located(&location))?;
        }
        Format::Json => {
            let trace = args.trace.display().to_string();
            emit(&format!(
                "{}\n",
                report::json(&trace, found.as_ref(), &location)
            ))?;
        }
    }
    let same = found.is_none() && location == Location::default();
    Ok(if same {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(DIFFERS)
    })
}

fn question(args: &Args) -> miette::Result<Question> {
    let absolute = |path: &Path| {
        let found = path.canonicalize();
        found.map_err(|error| miette!("{}: {error}", path.display()))
    };
    let field = args.field.as_deref().map(Glob::new).transpose();
    let worlds = args.worlds.clone();
    let mut question = Question {
        trace: absolute(&args.trace)?,
        worlds: absolute(&worlds.unwrap_or_else(|| corpus::bundled().join("worlds")))?,
        profile: args.profile.clone().unwrap_or_else(|| "retail".into()),
        field: field.into_diagnostic()?.map(|glob| glob.compile_matcher()),
        expected: Default::default(),
        timeout: Duration::from_secs(args.timeout),
    };
    question
        .read_expectations(args.oracle.as_deref())
        .into_diagnostic()?;
    Ok(question)
}

fn said(line: &str) {
    eprintln!("{line}");
}

/// A folder for the traces that builds write.
fn scratch(folder: &Path) -> miette::Result<PathBuf> {
    let scratch = folder.join("runs");
    fs::create_dir_all(&scratch).into_diagnostic()?;
    Ok(scratch)
}

fn commits(
    args: &Args,
    question: &Question,
    good: &str,
    bad: &str,
) -> miette::Result<(Found, Location)> {
    let repo = args.repo.clone().unwrap_or_else(|| ".".into());
    let git = Git::of(&repo).into_diagnostic()?;
    let folder = args.worktree.clone();
    let folder = folder.unwrap_or_else(|| git.folder().join("target/ac-bisect"));
    fs::create_dir_all(&folder).into_diagnostic()?;
    let folder = folder.canonicalize().into_diagnostic()?;
    let builder = Builder {
        git: git.clone(),
        folder: folder.clone(),
        command: args.build_command.clone(),
        program: args.program.clone(),
        target: args.target_dir.clone(),
    };
    let bytes = fs::read(&question.trace).into_diagnostic()?;
    let asked = Asked {
        trace: question.trace.display().to_string(),
        trace_blake3: blake3::hash(&bytes).to_hex().to_string(),
        good: git.commit(good).into_diagnostic()?.id,
        bad: git.commit(bad).into_diagnostic()?.id,
        field: args.field.clone(),
        oracle: args.oracle.clone(),
        profile: question.profile.clone(),
        build: args.build_command.clone(),
    };
    let file = folder.join("state.json");
    let mut state = State::open(&file, asked).into_diagnostic()?;
    if !state.commits.is_empty() {
        said(&format!(
            "{} commits are known from before ({})",
            state.commits.len(),
            file.display()
        ));
    }
    let scratch = scratch(&folder)?;
    let mut judge = Judge {
        builder: &builder,
        question,
        scratch: &scratch,
        good: git.commit(good).into_diagnostic()?,
    };
    let found = search(
        &git,
        &mut state,
        &mut |commit| judge.judge(commit),
        &|state| state.save(&file),
        &said,
    )
    .into_diagnostic()?;
    // Without a run on both sides there is nothing to compare.
    if [&found.good, &found.bad]
        .iter()
        .any(|verdict| matches!(verdict, Verdict::Fails(_)))
    {
        return Ok((found, Location::default()));
    }
    let before = git.parent(&found.first_bad.id).into_diagnostic()?;
    let programs = [before, found.first_bad.clone()].map(|commit| builder.build(&commit, &said));
    let location = match programs {
        [Ok(Built::Program(before)), Ok(Built::Program(since))] => {
            let profile = profile(args, question, Some(&found.bad));
            part(question, &before, &since, &profile, &scratch)?
        }
        // One of them could not be built, as the search said.
        _ => Location::default(),
    };
    Ok((found, location))
}

/// Asks builds of commits.
struct Judge<'a> {
    builder: &'a Builder,
    question: &'a Question,
    scratch: &'a Path,
    good: Commit,
}

impl Judge<'_> {
    fn judge(&mut self, commit: &Commit) -> Result<Known, BisectError> {
        let Built::Program(program) = self.builder.build(commit, &said)? else {
            return Ok(Known::Unbuildable);
        };
        // Without expectations, what the good build does is expected. Its trace is kept.
        let kept = self.scratch.join("good.mcap");
        if self.question.expected.is_empty() && commit.id == self.good.id {
            let profile = &self.question.profile;
            if let Err(reason) = self.question.run(&program, profile, false, &kept)? {
                return Ok(Known::Judged(Verdict::Fails(reason)));
            }
        }
        let reference = match self.question.expected.is_empty() {
            true => Some(produced(&kept)?),
            false => None,
        };
        let verdict = self
            .question
            .ask(&program, self.scratch, reference.as_deref())?;
        Ok(Known::Judged(verdict))
    }
}

/// The profile under which a difference is looked for: the one named, or that of the first expectation that is missed.
fn profile(args: &Args, question: &Question, bad: Option<&Verdict>) -> String {
    if let Some(profile) = &args.profile {
        return profile.clone();
    }
    let missed = match bad {
        Some(Verdict::Runs(places)) => places
            .iter()
            .find(|(_, place)| place.is_some())
            .map(|(oracle, _)| oracle.as_str()),
        _ => None,
    };
    let oracle = missed.or_else(|| question.expected.keys().next().map(String::as_str));
    match oracle {
        Some(oracle) if question.expected.contains_key(oracle) => {
            crate::run::profile_of(oracle).to_owned()
        }
        _ => question.profile.clone(),
    }
}

fn programs(args: &Args, question: &Question, good: &Path, bad: &Path) -> miette::Result<Location> {
    let folder = tempfile::tempdir().into_diagnostic()?;
    let scratch = scratch(folder.path())?;
    let ask = |program: &Path| question.ask(program, &scratch, None);
    let verdicts = match question.expected.is_empty() {
        true => None,
        false => Some([ask(good).into_diagnostic()?, ask(bad).into_diagnostic()?]),
    };
    if let Some([good, bad]) = &verdicts {
        said(&format!("good: {}", good.line()));
        said(&format!("bad:  {}", bad.line()));
    }
    let profile = profile(args, question, verdicts.as_ref().map(|[_, bad]| bad));
    part(question, good, bad, &profile, &scratch)
}

/// Runs two programs with checkpoints and says where they part.
fn part(
    question: &Question,
    good: &Path,
    bad: &Path,
    profile: &str,
    scratch: &Path,
) -> miette::Result<Location> {
    said(&format!("looking for the stage, under profile {profile}"));
    let traces = ["good-stages.mcap", "bad-stages.mcap"].map(|name| scratch.join(name));
    for (program, out) in [good, bad].into_iter().zip(&traces) {
        let run = |checkpoints| question.run(program, profile, checkpoints, out);
        // An older build may not know checkpoints: then there are states only.
        if let Err(first) = run(true).into_diagnostic()?
            && let Err(reason) = run(false).into_diagnostic()?
        {
            said(&format!("{} does not run: {first}", program.display()));
            return Err(miette!(
                help = "where it fails is in what it says; there are no states to compare",
                "{} does not run the trace: {reason}",
                program.display()
            ));
        }
    }
    locate(&traces[0], &traces[1]).into_diagnostic()
}
