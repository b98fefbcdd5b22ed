//! A display without a screen.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use libtest_mimic::Failed;

/// An X server of its own, which ends with the test.
pub(super) struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// Returns true if there is a server to start.
    pub(super) fn is_installed() -> bool {
        Command::new("Xvfb").arg("-help").output().is_ok()
    }

    /// Starts a server on a free display.
    pub(super) fn start() -> Result<Self, Failed> {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1400x900x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let mut number = String::new();
        let output = server.stdout.take().ok_or("Xvfb has an output")?;
        BufReader::new(output).read_line(&mut number)?;
        let display = Self { server, name: format!(":{}", number.trim()) };
        match number.trim().is_empty() {
            true => Err("Xvfb did not start".into()),
            false => Ok(display),
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
