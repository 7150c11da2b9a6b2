//! `ac-conform bless`.

use std::{
    io::{BufRead, IsTerminal, Write},
    path::PathBuf,
    process::ExitCode,
};

use ac_replayer::Simulator;
use globset::{Glob, GlobSet, GlobSetBuilder};
use miette::{IntoDiagnostic, miette};
use rayon::prelude::*;

use super::{COULD_NOT_RUN, DIFFERS, emit, run::progress};
use crate::{
    bless::{self, Change, human, write},
    run::{SELF, cases},
};

/// Arguments of `ac-conform bless`.
#[derive(clap::Args)]
#[command(
    after_help = "Shows, scene by scene, in which fields the library's own profile `retail` no longer does what its expectation \
    (oracle `self`) says, and writes the new expectation of those that are accepted: by answering on a terminal, or with --accept.\n\n\
    Expectations of oracles are never written: they are what somebody else computed. To go on with a known divergence from an \
    oracle, see `ac-conform baseline`.\n\n\
    Exit codes:\n  0  nothing changes, or everything that changes was accepted\n  1  something changes and was not accepted\n  \
    2  something could not run"
)]
pub struct Args {
    /// Traces (`*.mcap`), scenes (`*.scene.json`), or folders of them. Default: the bundled traces.
    pub(super) paths: Vec<PathBuf>,
    /// Folder of the worlds. Default: `worlds` in a given folder, else the bundled worlds.
    #[arg(long)]
    pub(super) worlds: Option<PathBuf>,
    /// Accept the changes of scenes with this name, like `jump/*`; `*` is all. May be given more than once.
    #[arg(long, value_name = "GLOB")]
    accept: Vec<String>,
    /// Folder for expectations of scenes that have none yet. Default for the bundled traces: `golden-traces/self`.
    #[arg(long, value_name = "DIR")]
    into: Option<PathBuf>,
    /// Whose expectations: only `self` can be blessed.
    #[arg(long, default_value = SELF)]
    oracle: String,
}

/// Shows what changes and writes what is accepted.
///
/// # Errors
/// When nothing can be run or written, or another oracle than `self` is named.
pub fn run(args: &Args, simulator: &dyn Simulator) -> miette::Result<ExitCode> {
    if args.oracle != SELF {
        return Err(miette!(
            help = "if the library is wrong, mend it; if the divergence has to stay for now, say why with `ac-conform baseline --reason`",
            "the expectations of oracle `{}` cannot be blessed: they are what an independent reconstruction computed, not what \
             this library happens to do",
            args.oracle
        ));
    }
    let accept = globs(&args.accept)?;
    let cases = cases::find_or_bundled(&args.paths, None, None).into_diagnostic()?;
    let into = args
        .into
        .clone()
        .or_else(|| args.paths.is_empty().then(bless::bundled));
    let bar = progress(cases.len() as u64);
    let collected = bless::collect(simulator, &cases, into.as_deref(), || bar.inc(1));
    bar.finish_and_clear();
    for error in &collected.errors {
        eprintln!("could not run: {error}");
    }
    let terminal = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
    let accepted = if args.accept.is_empty() && terminal {
        ask(
            &collected.changes,
            &mut std::io::stdin().lock(),
            &mut std::io::stderr(),
        )
        .into_diagnostic()?
    } else {
        for change in &collected.changes {
            emit(&human(change))?;
        }
        let changes = collected.changes.iter();
        changes
            .filter(|change| accept.is_match(&change.scene))
            .collect()
    };
    let worlds = super::worlds_of(args.worlds.as_deref(), &args.paths);
    accepted
        .par_iter()
        .try_for_each(|change| write::write(simulator, &worlds, change))
        .into_diagnostic()?;
    if args.paths.is_empty() {
        write::update_hashes(simulator, &accepted).into_diagnostic()?;
    }
    let left = collected.changes.len() - accepted.len();
    emit(&last_line(collected.scenes, accepted.len(), left))?;
    Ok(if !collected.errors.is_empty() {
        ExitCode::from(COULD_NOT_RUN)
    } else if left > 0 {
        ExitCode::from(DIFFERS)
    } else {
        ExitCode::SUCCESS
    })
}

fn last_line(scenes: usize, accepted: usize, left: usize) -> String {
    let mut text = format!("{scenes} scenes, {accepted} written, {left} changed and not written");
    if left > 0 {
        text += "; --accept GLOB accepts, like --accept 'jump/*'";
    }
    text + "\n"
}

fn globs(patterns: &[String]) -> miette::Result<GlobSet> {
    let mut set = GlobSetBuilder::new();
    for pattern in patterns {
        set.add(Glob::new(pattern).into_diagnostic()?);
    }
    set.build().into_diagnostic()
}

/// Shows each change and asks. The end of the input is a no to everything that is left.
fn ask<'a>(
    changes: &'a [Change],
    input: &mut dyn BufRead,
    out: &mut dyn Write,
) -> std::io::Result<Vec<&'a Change>> {
    let mut accepted = Vec::new();
    let mut rest = None;
    for (index, change) in changes.iter().enumerate() {
        if rest == Some(false) {
            break;
        }
        write!(out, "[{}/{}] {}", index + 1, changes.len(), human(change))?;
        if rest.is_none() {
            rest = question(change, input, out, &mut accepted)?;
        }
        if rest == Some(true) {
            accepted.push(change);
        }
    }
    Ok(accepted)
}

/// Asks for one change. The answer is `Some` if it is for all that follow too.
fn question<'a>(
    change: &'a Change,
    input: &mut dyn BufRead,
    out: &mut dyn Write,
    accepted: &mut Vec<&'a Change>,
) -> std::io::Result<Option<bool>> {
    loop {
        write!(
            out,
            "accept {}? [y]es, [n]o, [a]ll from here, [q]uit: ",
            change.scene
        )?;
        out.flush()?;
        let mut answer = String::new();
        if input.read_line(&mut answer)? == 0 {
            writeln!(out)?;
            return Ok(Some(false));
        }
        match answer.trim() {
            "y" | "yes" => {
                accepted.push(change);
                return Ok(None);
            }
            "n" | "no" => return Ok(None),
            "a" | "all" => return Ok(Some(true)),
            "q" | "quit" => return Ok(Some(false)),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{bless::Difference, run::Case};

    fn answers(text: &str) -> (Vec<String>, String) {
        let changes = ["a/one", "a/two", "b/three"].map(|scene| Change {
            scene: scene.into(),
            case: Case::Trace("x.mcap".into()),
            target: "x.mcap".into(),
            new: true,
            other_scene: false,
            difference: Difference {
                frames: 2,
                ..Difference::default()
            },
        });
        let mut out = Vec::new();
        let accepted = ask(&changes, &mut text.as_bytes(), &mut out).unwrap();
        let names = accepted.iter().map(|change| change.scene.clone()).collect();
        (names, String::from_utf8(out).unwrap())
    }

    #[test]
    fn answers_are_for_one_or_for_all_that_follow() {
        assert_eq!(answers("y\nn\ny\n").0, ["a/one", "b/three"]);
        assert_eq!(answers("n\na\n").0, ["a/two", "b/three"]);
        assert_eq!(answers("y\nq\n").0, ["a/one"]);
        assert_eq!(answers("y\n").0, ["a/one"], "the input ends");
        insta::assert_snapshot!(answers("what\nn\nq\n").1, @r"
        [1/3] a/one: 2 frames, no expectation of its own yet
        accept a/one? [y]es, [n]o, [a]ll from here, [q]uit: accept a/one? [y]es, [n]o, [a]ll from here, [q]uit: [2/3] a/two: 2 frames, no expectation of its own yet
        accept a/two? [y]es, [n]o, [a]ll from here, [q]uit: 
        ");
    }

    #[test]
    fn a_star_is_every_scene() {
        let set = globs(&["*".into()]).unwrap();
        assert!(set.is_match("jump/high"));
        assert!(!globs(&["jump/*".into()]).unwrap().is_match("clock/zero"));
        assert!(!globs(&[]).unwrap().is_match("clock/zero"));
    }
}
