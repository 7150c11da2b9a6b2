//! The command line of `ac-conform`.
//!
//! Exit codes of every command: 0 = nothing is wrong; 1 = something differs; 2 = it could not run (the message says what,
//! where, and what to do).

mod baseline;
mod bisect;
mod bless;
mod gate;
mod hash;
mod import;
mod merge;
mod precision;
mod run;
mod sensitivity;
mod shrink;
mod stability;
mod status;
mod vectors;

use std::{
    io::Write,
    path::{Path, PathBuf},
    process::ExitCode,
};

use ac_golden_traces::corpus;
use ac_replayer::client::ClientSimulator;
use clap::{Parser, Subcommand, ValueEnum};
use miette::IntoDiagnostic;

/// Something differs.
pub const DIFFERS: u8 = 1;
/// The command could not run.
pub const COULD_NOT_RUN: u8 = 2;

#[derive(Parser)]
#[command(
    name = "ac-conform",
    version,
    about = "Compares the client library with reconstructions of the retail client"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run scenes through the client library and compare every frame with what the oracles expect.
    Run(run::Args),
    /// Take divergences of the bundled traces from oracles into the baseline, after showing what changes in it.
    Baseline(baseline::Args),
    /// Find the commit that changed what a trace says, and the frame, stage and field in which the change begins.
    Bisect(bisect::Args),
    /// Show what changes in the library's own expectations (oracle `self`), and take it in.
    Bless(bless::Args),
    /// Print one state hash per scene, or check them against a file: were the same bits computed?
    Hash(hash::Args),
    /// Make traces of scenes and the files that oracles wrote for them.
    Import(import::Args),
    /// Find the numbered differences between reconstructions that each scene is sensitive to, by setting one at a time.
    Sensitivity(sensitivity::Args),
    /// Make a scene that diverges as small as it can be, with a world of its own.
    Shrink(shrink::Args),
    /// Put the results of all shards of a run together and judge them as one.
    Merge(merge::Args),
    /// Measure what each choice of fidelity costs and what error it makes.
    Precision(precision::Args),
    /// Check stiff and extreme cases, rules that must always hold, and what small changes grow to.
    Stability(stability::Args),
    /// Measure everything that is bundled and write the status page.
    Status(status::Args),
    /// Run vector files: calls of single primitives, compared bit for bit.
    Vectors(vectors::Args),
}

/// How results are written to standard output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Tables for people.
    #[default]
    Human,
    /// One JSON document.
    Json,
}

/// Parses the arguments of the process and runs the command.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return if error.use_stderr() {
                ExitCode::from(COULD_NOT_RUN)
            } else {
                ExitCode::SUCCESS
            };
        }
    };
    let outcome = match cli.command {
        Command::Run(args) => args.simulator().and_then(|s| run::run(&args, &s)),
        Command::Baseline(args) => baseline::run(&args, &simulator(None, &[])),
        Command::Bisect(args) => bisect::run(&args),
        Command::Bless(args) => bless::run(&args, &simulator(args.worlds.as_deref(), &args.paths)),
        Command::Hash(args) => hash::run(&args, &simulator(args.worlds.as_deref(), &args.paths)),
        Command::Import(args) => import::run(&args),
        Command::Sensitivity(args) => {
            sensitivity::run(&args, &simulator(args.worlds.as_deref(), &args.paths))
        }
        Command::Shrink(args) => shrink::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Precision(args) => {
            precision::run(&args, &simulator(args.worlds.as_deref(), &args.scenes))
        }
        Command::Stability(args) => stability::run(&args, &simulator(args.worlds.as_deref(), &[])),
        Command::Status(args) => status::run(&args, &simulator(None, &[])),
        Command::Vectors(args) => vectors::run(&args),
    };
    outcome.unwrap_or_else(|report| {
        eprintln!("{report:?}");
        ExitCode::from(COULD_NOT_RUN)
    })
}

/// The client library on the worlds of a folder; without one on those that a folder of scenes brings along (`PATH/worlds`), and
/// without such a folder on the bundled worlds.
fn simulator(worlds: Option<&Path>, paths: &[PathBuf]) -> ClientSimulator {
    ClientSimulator::new(worlds_of(worlds, paths))
}

fn worlds_of(worlds: Option<&Path>, paths: &[PathBuf]) -> PathBuf {
    let brought = || {
        let folders = paths.iter().map(|path| path.join("worlds"));
        folders.into_iter().find(|folder| folder.is_dir())
    };
    worlds
        .map(Into::into)
        .or_else(brought)
        .unwrap_or_else(|| corpus::bundled().join("worlds"))
}

/// Writes a result to standard output. A reader that has seen enough (`| head`) is no error.
///
/// # Errors
/// When writing fails otherwise.
fn emit(text: &str) -> miette::Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(error).into_diagnostic()
        }
        _ => Ok(()),
    }
}
