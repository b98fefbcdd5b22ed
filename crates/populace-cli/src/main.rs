//! The `populace` program: draws crowds of animated characters and shows what is in their files.
//!
//! Results go to stdout, talk to stderr. Exit codes: 0 done, 1 input rejected, 2 usage or unknown name, 3 no usable
//! device or GL, 4 output or run failed.

mod aim;
mod bench;
mod cast;
mod cli;
mod commands;
mod failure;
mod input;
mod mix;
mod placement;
mod report;
mod skin;
mod staging;
mod studio;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Demo(args) => commands::demo::run(&args),
        Command::Render(args) => commands::render::run(&args),
        Command::Inspect(args) => commands::inspect::run(&args),
        Command::Pose(args) => commands::pose::run(&args),
        Command::Devices(args) => commands::devices::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
