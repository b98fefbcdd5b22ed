//! What can go wrong when drawing.

use std::path::PathBuf;

/// Why something was not drawn. After any of these the renderer can still be used.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No OpenGL that this crate can draw with.
    #[error("no usable OpenGL on this machine ({tried}); {remedy}")]
    NoGl {
        /// What was tried, and how each attempt ended.
        tried: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// The context is no longer there, for example after the device was lost.
    #[error("the OpenGL context cannot be made current: {cause}")]
    ContextLost {
        /// The driver's own words.
        cause: String,
    },
    /// A shader that the driver refuses.
    #[error("the driver refuses shader {name}: {log}")]
    Shader {
        /// Which shader.
        name: String,
        /// The compiler's or linker's log.
        log: String,
    },
    /// Memory that could not be had.
    #[error("the OpenGL driver has no room for {operation}")]
    OutOfMemory {
        /// What the memory was for.
        operation: String,
    },
    /// A call that the driver failed.
    #[error("OpenGL failed to {operation}: {code}")]
    GlError {
        /// What was being done.
        operation: String,
        /// The error's name in OpenGL, or its number.
        code: String,
    },
    /// More than the driver can hold.
    #[error("{what} of {size} is past this driver's limit of {limit}")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// Its size.
        size: u64,
        /// The greatest size that can be had.
        limit: u64,
    },
    /// A picture without pixels.
    #[error("a picture of {width} x {height} pixels has nothing to draw; both must be at least 1")]
    EmptyPicture {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// A camera that sees nothing.
    #[error("the camera {what}")]
    BadCamera {
        /// What is wrong, and the rule.
        what: &'static str,
    },
    /// A scene's setting that is no number.
    #[error("the scene's {what} must be finite, and a direction must have a length")]
    BadScene {
        /// Which setting.
        what: &'static str,
    },
    /// An instance of a character that this renderer does not hold.
    #[error("instance {instance} names a character of another renderer; this one holds {count}")]
    UnknownCharacter {
        /// Index of the instance.
        instance: usize,
        /// Characters held.
        count: usize,
    },
    /// An instance whose palette was not uploaded.
    #[error(
        "instance {instance} needs {count} palette entries from {first} of page {page}, which \
         holds {available}"
    )]
    NoPalette {
        /// Index of the instance.
        instance: usize,
        /// The page.
        page: usize,
        /// First entry within the page.
        first: usize,
        /// Entries that the character needs.
        count: usize,
        /// Entries that were uploaded to the page.
        available: usize,
    },
    /// A palette that is cut off in the middle of a matrix.
    #[error("a page of {len} elements is not whole matrices; each palette entry is three elements")]
    PartialMatrix {
        /// Elements given.
        len: usize,
    },
    /// A device that failed, or refuses what it is lent.
    #[error(transparent)]
    Device(#[from] populace_device::BackendError),
    /// A driver whose buffers cannot be drawn from while they are mapped.
    #[error("this driver offers neither OpenGL 4.4 nor GL_ARB_buffer_storage")]
    NoBufferStorage,
    /// Palettes that reach OpenGL in no way at all.
    #[error("palettes do not reach OpenGL: {reasons}")]
    NoWay {
        /// Why not, for each way.
        reasons: String,
    },
    /// A picture that PNG cannot hold.
    #[error("the picture cannot be encoded as PNG: {cause}")]
    Encoding {
        /// The encoder's own words.
        cause: String,
    },
    /// A picture that could not be written.
    #[error("cannot write {}", path.display())]
    Output {
        /// Where to.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
}
