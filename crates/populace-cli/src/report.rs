//! Results on stdout, talk on stderr.

use std::io::Write;
use std::path::Path;

use serde_json::Value;

use crate::failure::Failure;

/// Prints one JSON document.
pub(crate) fn json(document: &Value) -> Result<(), Failure> {
    text(&format!("{document}\n"))
}

/// Prints text; a closed pipe ends the program quietly.
pub(crate) fn text(text: &str) -> Result<(), Failure> {
    bytes(text.as_bytes())
}

/// Prints a path on a line of its own, to the byte.
pub(crate) fn path(path: &Path) -> Result<(), Failure> {
    #[cfg(unix)]
    let name = std::os::unix::ffi::OsStrExt::as_bytes(path.as_os_str());
    #[cfg(not(unix))]
    let name = path.to_string_lossy();
    #[cfg(not(unix))]
    let name = name.as_bytes();
    bytes(&[name, b"\n"].concat())
}

fn bytes(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(bytes)?;
    Ok(out.flush()?)
}

/// A number as it was typed, not its nearest f32 written out in full.
pub(crate) fn as_typed(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

/// Says something on stderr, formatted as by `format!`. Where nobody can hear it, that is no reason
/// to stop.
macro_rules! talk {
    ($($text:tt)*) => {
        crate::report::say(&format!($($text)*))
    };
}
pub(crate) use talk;

/// See [`talk!`].
pub(crate) fn say(message: &str) {
    crate::progress::suspended(|| {
        let _ = writeln!(std::io::stderr(), "populace: {message}");
    });
}
