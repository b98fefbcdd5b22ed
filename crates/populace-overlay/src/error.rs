//! Errors of overlays.

/// The reason why a call was refused. Nothing has changed after an error.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A buffer that is no picture of its size.
    #[error(
        "a picture of {}x{} pixels has {} bytes of RGBA, and the buffer has {found}; give a buffer \
         of the picture's size",
        size[0], size[1], 4 * u64::from(size[0]) * u64::from(size[1])
    )]
    WrongLength {
        /// The length of the buffer.
        found: usize,
        /// Width and height in pixels.
        size: [u32; 2],
    },
}
