//! The command line of `ac-conform`.
//!
//! Exit codes of every command: 0 = nothing is wrong; 1 = something differs; 2 = it could not run (the message says what,
//! where, and what to do).

mod bless;
mod gate;
mod hash;
mod import;
mod merge;
mod run;
mod sensitivity;
mod status;
mod vectors;

use std::{io::Write, path::Path, process::ExitCode};

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
    /// Take the divergences of the bundled traces into the baseline, after showing what changes in it.
    Bless(bless::Args),
    /// Print one state hash per scene, or check them against a file: were the same bits computed?
    Hash(hash::Args),
    /// Make traces of scenes and the files that oracles wrote for them.
    Import(import::Args),
    /// Find the numbered differences between reconstructions that each scene is sensitive to, by setting one at a time.
    Sensitivity(sensitivity::Args),
    /// Put the results of all shards of a run together and judge them as one.
    Merge(merge::Args),
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
        Command::Bless(args) => bless::run(&args, &simulator(None)),
        Command::Hash(args) => hash::run(&args, &simulator(args.worlds.as_deref())),
        Command::Import(args) => import::run(&args),
        Command::Sensitivity(args) => sensitivity::run(&args, &simulator(args.worlds.as_deref())),
        Command::Merge(args) => merge::run(&args),
        Command::Status(args) => status::run(&args, &simulator(None)),
        Command::Vectors(args) => vectors::run(&args),
    };
    outcome.unwrap_or_else(|report| {
        eprintln!("{report:?}");
        ExitCode::from(COULD_NOT_RUN)
    })
}

/// The client library on the worlds of a folder; without one on the bundled worlds.
fn simulator(worlds: Option<&Path>) -> ClientSimulator {
    ClientSimulator::new(worlds.map_or_else(|| corpus::bundled().join("worlds"), Into::into))
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
