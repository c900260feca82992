//! The `bozzetto` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    bozzetto::cli::main()
}
