//! Formats by their content.

use crate::input::Input;
use crate::{Error, Format, vadere};

/// Returns the format of a file.
pub(crate) fn recognise(input: &Input) -> Result<Format, Error> {
    let head = input.head()?;
    if head.starts_with(b"SQLite format 3\0") {
        return Ok(Format::JuPedSim);
    }
    if head.starts_with(b"\x89HDF\r\n\x1a\n") {
        return Ok(Format::Hdf5);
    }
    let text = String::from_utf8_lossy(&head);
    if text.lines().find(|line| !line.trim().is_empty()).is_some_and(vadere::is_header) {
        return Ok(Format::Vadere);
    }
    if text.lines().any(|line| line.starts_with('#') && line.contains("frame")) {
        return Ok(Format::PeTrack);
    }
    Err(Error::Unknown {
        path: input.path().to_owned(),
        seen: "its beginning fits no format".to_owned(),
        remedy: "--format NAME reads it as a format".to_owned(),
    })
}
