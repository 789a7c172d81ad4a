//! The `parafovea` program. Everything is in the library; this file only hands over the arguments and the exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    parafovea::cli::main()
}
