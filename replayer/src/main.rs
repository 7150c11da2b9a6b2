//! `ac-replay`: the command line of the replayer.

#![forbid(unsafe_code)]

use std::process::ExitCode;

use ac_replayer::dat_cmd::{self, DatArgs};
use clap::{Parser, Subcommand};

/// Drives the client library and looks into its data.
#[derive(Debug, Parser)]
#[command(name = "ac-replay", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Looks into dat files and checks them.
    Dat(DatArgs),
}

fn main() -> ExitCode {
    let Cli {
        command: Command::Dat(args),
    } = Cli::parse();
    match dat_cmd::run(&args, &mut std::io::stdout().lock()) {
        Ok(verdict) => ExitCode::from(verdict.code()),
        Err(e) => {
            eprintln!("{:?}", miette::Report::new(e));
            ExitCode::from(2)
        }
    }
}
