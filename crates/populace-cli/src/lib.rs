//! The `populace` program: draws crowds of animated characters and inspects their files.
//!
//! Results go to stdout, messages to stderr. Exit codes: 0 success, 1 input rejected, 2 wrong usage
//! or unknown name, 3 no usable device or OpenGL, 4 output or run failed, 130 interrupted by
//! SIGINT, 143 by SIGTERM.
//!
//! As a library it is for fuzzing, which needs its readers without a process.

#[cfg(unix)]
mod aborts;
mod aim;
mod built_in;
mod camera;
mod cli;
mod clip_words;
mod commands;
mod crowd_renderer;
mod doubts;
mod draw;
mod exposure;
mod failure;
mod film_length;
mod filming;
mod fit;
mod folder;
mod frame_loop;
mod frames;
mod given;
mod image_files;
mod input;
mod legs;
mod levels;
mod mix;
mod names;
mod output;
mod people;
mod placement;
mod population;
mod progress;
mod replay;
mod report;
mod roles;
mod scene;
mod series;
mod sinks;
mod skin;
mod text_file;
mod trajectory;
mod unfinished;
#[cfg(feature = "viewer")]
mod view;
#[cfg(feature = "viewer")]
mod watched;

#[cfg(test)]
#[path = "../../../fuzz/seeds.rs"]
mod fuzz_seeds;

use std::process::ExitCode;

use cli::Command;
use failure::Failure;

/// Runs the program with the arguments of the process.
#[must_use]
pub fn main() -> ExitCode {
    match run(cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => report::failure(&failure),
    }
}

/// Parses the arguments after the program's name, and runs nothing. The error is what the program
/// would print.
///
/// # Errors
///
/// Arguments that no command has, and values out of their range.
pub fn check_command_line<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Result<(), String> {
    let parsed = cli::try_parse(std::iter::once("populace").chain(arguments));
    parsed.map(drop).map_err(|error| error.to_string())
}

/// Reads the text of a file of camera positions (`--camera PATH.toml`). The error is what the
/// program would print.
///
/// # Errors
///
/// Text that is no TOML, unknown and missing keys, and numbers out of range.
pub fn check_camera_file(text: &str) -> Result<(), String> {
    camera::Keys::parse(text).map(drop)
}

fn run(command: Command) -> Result<(), Failure> {
    #[cfg(unix)]
    {
        aborts::exit_on_abort();
        unfinished::exit_on_signals()?;
    }
    match command {
        Command::Demo(args) => commands::demo::run(args),
        Command::Render(args) => commands::render::run(args),
        #[cfg(feature = "viewer")]
        Command::View(args) => commands::view::run(&args),
        #[cfg(not(feature = "viewer"))]
        Command::View(_) => Err(absent("view")),
        Command::Plan(args) => commands::plan::run(&args),
        Command::Film(args) => commands::film::run(&args),
        Command::Cast(args) => commands::cast::run(&args),
        Command::Inspect(args) => commands::inspect::run(&args),
        Command::Pose(args) => commands::pose::run(&args),
        Command::Devices(args) => commands::devices::run(&args),
        #[cfg(feature = "bench")]
        Command::Bench(args) => commands::bench::run(&args),
        #[cfg(not(feature = "bench"))]
        Command::Bench(_) => Err(absent("bench")),
    }
}

#[cfg(any(not(feature = "bench"), not(feature = "viewer")))]
fn absent(command: &str) -> Failure {
    Failure::usage(format!(
        "this program was built without the command {command}; `make release` builds one that has \
         it: target/release/populace"
    ))
}
