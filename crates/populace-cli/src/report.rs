//! Results on stdout.

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
