//! `ac-record`: see `ac-record --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ac_recorder::cli::main()
}
