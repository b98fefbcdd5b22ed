//! Formats by their content.

use crate::input::Input;
use crate::{Error, Format};

/// Returns the format of a file.
pub(crate) fn recognise(input: &Input) -> Result<Format, Error> {
    let head = input.head()?;
    let text = String::from_utf8_lossy(&head);
    if text.lines().any(|line| line.starts_with('#') && line.contains("frame")) {
        return Ok(Format::PeTrack);
    }
    Err(Error::Unknown {
        path: input.path().to_owned(),
        seen: "its beginning fits no format".to_owned(),
        remedy: "--format NAME reads it as a format".to_owned(),
    })
}
