//! Runs the tests of the Python package with this build of the program.
//!
//! `POPULACE_PYTHON` names another Python than `python3`, for example one that has pandas, pedpy or
//! ray. Without Python the tests show as ignored, and so does that of Ray without ray.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};

use libtest_mimic::{Arguments, Failed, Trial};

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let runs = |code: &str| python().args(["-c", code]).output().is_ok_and(|o| o.status.success());
    let (has_python, has_ray) = (runs("import unittest"), runs("import ray"));
    let trial = |name: &'static str, module: &'static str, can_run: bool, needs: &str| {
        let name = if can_run { name.to_owned() } else { format!("{name} ({needs})") };
        Trial::test(name, move || check(module)).with_ignored_flag(!can_run)
    };
    let needs_python = "python3 is missing";
    let draws = !cfg!(skip_gl);
    let trials = vec![
        trial("finding the program", "tests.test_program", has_python, needs_python),
        trial("render", "tests.test_render", has_python, needs_python),
        trial("farm", "tests.test_farm", has_ray && draws, "it needs ray and OpenGL"),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn python() -> Command {
    let name = std::env::var_os("POPULACE_PYTHON").unwrap_or_else(|| OsString::from("python3"));
    let mut command = Command::new(name);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../python");
    command.current_dir(folder).env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// Runs the tests of one module.
fn check(module: &str) -> Result<(), Failed> {
    let skipped = if cfg!(skip_gl) { "gl" } else { "" };
    let output = python()
        .args(["-W", "error::ResourceWarning", "-m", "unittest", module])
        .env("POPULACE", env!("CARGO_BIN_EXE_populace"))
        .env("POPULACE_SKIP", skipped)
        .output()?;
    if output.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned().into())
}
