//! `ac-replay`: see `ac-replay --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ac_replayer::cli::main()
}
