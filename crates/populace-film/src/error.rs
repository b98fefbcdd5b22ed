//! Errors of writing films.

use std::io;
use std::path::PathBuf;

/// The reason why a film or picture was not written.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file name whose extension is no format of films.
    #[error("{} does not end in .mp4 or .gif; a film is written as one of these", path.display())]
    UnknownFormat {
        /// The file name.
        path: PathBuf,
    },
    /// A number out of its range.
    #[error("{what} is {value}; it must be {rule}")]
    BadValue {
        /// The quantity.
        what: &'static str,
        /// The value.
        value: String,
        /// The values that are allowed.
        rule: &'static str,
    },
    /// A frame whose number of bytes does not fit the size of the film.
    #[error("a picture of {width}x{height} pixels has {found} bytes; it needs {expected}")]
    FrameSize {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Number of bytes given.
        found: usize,
        /// Number of bytes of the size.
        expected: u64,
    },
    /// A film without frames.
    #[error("the film {} has no frame; push at least one", path.display())]
    NoFrames {
        /// The file name of the film.
        path: PathBuf,
    },
    /// An encoder that this build lacks.
    #[error(
        "this build has no encoder of H.264; build with the feature openh264 (mp4 of the program), \
         choose ffmpeg, or write a GIF"
    )]
    WithoutOpenH264,
    /// A missing program.
    #[error(
        "ffmpeg does not start; install it so that it is found on the PATH, or choose the encoder \
         openh264"
    )]
    NoFfmpeg {
        /// The reason.
        source: io::Error,
    },
    /// A failure of an encoder.
    #[error("{encoder} failed: {cause}")]
    Encoder {
        /// The encoder.
        encoder: &'static str,
        /// Its message.
        cause: String,
    },
    /// Bytes that are no picture.
    #[error("this is no picture in PNG that can be read: {cause}; write it again")]
    BadPng {
        /// The reason.
        cause: String,
    },
    /// A file that cannot be written.
    #[error("cannot write {}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
}
