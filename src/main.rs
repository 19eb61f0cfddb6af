//! The `canloop` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    canloop::cli::main()
}
