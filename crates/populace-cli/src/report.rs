//! Results on stdout, talk on stderr.

use std::io::Write;

use serde_json::Value;

use crate::failure::Failure;

/// Prints one JSON document.
pub(crate) fn json(document: &Value) -> Result<(), Failure> {
    text(&format!("{document}\n"))
}

/// Prints text; a closed pipe ends the program quietly.
pub(crate) fn text(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// A number as it was typed, not its nearest f32 written out in full.
pub(crate) fn as_typed(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

/// Says something on stderr, formatted as by `format!`. Where nobody can hear it, that is no reason to stop.
macro_rules! talk {
    ($($text:tt)*) => {
        crate::report::say(&format!($($text)*))
    };
}
pub(crate) use talk;

/// See [`talk!`].
pub(crate) fn say(message: &str) {
    let _ = writeln!(std::io::stderr(), "populace: {message}");
}
