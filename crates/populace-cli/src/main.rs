//! The `populace` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    populace_cli::main()
}
