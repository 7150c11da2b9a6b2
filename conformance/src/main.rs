//! `ac-conform`: see `ac-conform --help`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ac_conformance::cli::main()
}
