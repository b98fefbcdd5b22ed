//! The `populace` program: draws crowds of animated characters and shows what is in their files.
//!
//! Results go to stdout, talk to stderr. Exit codes: 0 done, 1 input rejected, 2 usage or unknown
//! name, 3 no usable device or GL, 4 output or run failed, 130 interrupted by SIGINT, 143 by
//! SIGTERM.

#[cfg(unix)]
mod aborts;
mod aim;
mod bench;
mod cast;
mod cli;
mod commands;
mod failure;
mod film;
mod fit;
mod input;
mod mix;
mod names;
mod output;
mod placement;
mod progress;
mod report;
mod skin;
mod staging;
mod studio;
mod unfinished;

use std::process::ExitCode;

use cli::Command;
use failure::Failure;

fn main() -> ExitCode {
    match run(cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn run(command: Command) -> Result<(), Failure> {
    #[cfg(unix)]
    {
        aborts::end_with_a_code();
        unfinished::end_on_signals()?;
    }
    match command {
        Command::Demo(args) => commands::demo::run(&args),
        Command::Render(args) => commands::render::run(&args),
        Command::Inspect(args) => commands::inspect::run(&args),
        Command::Pose(args) => commands::pose::run(&args),
        Command::Devices(args) => commands::devices::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
    }
}
