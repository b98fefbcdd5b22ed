//! Writers of the frames of a film.

use std::path::PathBuf;

use crate::Error;

/// A film that grows frame by frame.
pub(crate) trait FrameWriter: Send {
    /// Appends a frame of RGBA.
    fn write(&mut self, rgba: &[u8]) -> Result<(), Error>;

    /// Writes what is not in the file yet, and leaves the part.
    fn stop(&mut self) -> Result<(), Error>;

    /// Completes the film under its own name, which is returned, and removes the part.
    fn finish(self: Box<Self>) -> Result<PathBuf, Error>;
}
