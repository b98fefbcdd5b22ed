//! Results on stdout, messages on stderr.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use serde_json::Value;

use crate::failure::Failure;

/// Prints one JSON document.
pub(crate) fn json(document: &Value) -> Result<(), Failure> {
    text(&format!("{document}\n"))
}

/// Returns an object with the fields of `more` added.
pub(crate) fn with_fields(mut document: Value, more: Value) -> Value {
    if let (Value::Object(fields), Value::Object(more)) = (&mut document, more) {
        fields.extend(more);
    }
    document
}

/// Prints text. A closed pipe is reported as [`Failure::ClosedPipe`].
pub(crate) fn text(text: &str) -> Result<(), Failure> {
    bytes(text.as_bytes())
}

/// Prints the exact bytes of a path and a line feed.
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

/// Returns the f64 with the shortest decimal form of an f32: 0.3, not 0.300000012.
pub(crate) fn as_typed(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

/// Returns a number of things in words: "1 frame", "2 frames".
pub(crate) fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// Prints a message on stderr, formatted as by `format!`. Errors of stderr are ignored.
macro_rules! message {
    ($($text:tt)*) => {
        crate::report::print_message(&format!($($text)*))
    };
}
pub(crate) use message;

/// Prints the message of a failure on stderr and returns its exit code.
pub(crate) fn failure(failure: &Failure) -> ExitCode {
    if let Some(error) = failure.error() {
        message!("{error:#}");
    }
    failure.exit_code()
}

/// Prints a message on stderr; see [`message!`].
pub(crate) fn print_message(message: &str) {
    crate::progress::suspended(|| {
        let _ = writeln!(std::io::stderr(), "populace: {message}");
    });
}
