//! The error type of this crate.

/// Errors of rendering. The renderer stays usable after any of them.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The machine has no OpenGL that this crate can draw with.
    #[error("no usable OpenGL on this machine ({tried}); {remedy}")]
    NoGl {
        /// The attempts, each with its failure.
        tried: String,
        /// Action that mends it.
        remedy: &'static str,
    },
    /// The context cannot be made current, for example after the device was lost.
    #[error("the OpenGL context cannot be made current: {cause}")]
    ContextLost {
        /// Message of the driver.
        cause: String,
    },
    /// The renderer has no window.
    #[error("this renderer has no window to draw into; create it by Renderer::in_window")]
    NoWindow,
    /// The driver rejected a shader.
    #[error("the driver rejected shader {name}: {log}")]
    Shader {
        /// Name of the shader variant.
        name: String,
        /// Log of the compiler or linker.
        log: String,
    },
    /// The driver ran out of memory.
    #[error(
        "the OpenGL driver ran out of memory trying to {operation}; draw fewer characters, or \
         smaller meshes, textures or pictures"
    )]
    OutOfMemory {
        /// The operation that needed the memory.
        operation: String,
    },
    /// A call to the driver failed.
    #[error("OpenGL failed to {operation}: {code}")]
    GlError {
        /// The operation that failed.
        operation: String,
        /// Name of the error in OpenGL, or its number.
        code: String,
    },
    /// A size exceeds the limit of the driver or of the palette layout.
    #[error("{what} is {size}; it must be at most {limit}")]
    TooLarge {
        /// The quantity that is too large.
        what: &'static str,
        /// Its value.
        size: u64,
        /// The largest value that is allowed.
        limit: u64,
    },
    /// The picture has no pixels.
    #[error("a picture of {width} x {height} pixels is empty; both sides must be at least 1")]
    EmptyPicture {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The camera has no valid projection.
    #[error("the camera {what}")]
    BadCamera {
        /// The fault and the rule it breaks.
        what: &'static str,
    },
    /// A setting of the scene is out of its range.
    #[error("the scene's {what} must be {rule}")]
    BadScene {
        /// The setting.
        what: &'static str,
        /// The values that are allowed.
        rule: &'static str,
    },
    /// The palette of an instance lies past the end of its page.
    #[error(
        "instance {instance} needs {count} palette entries from entry {first} of page {page}, \
         which holds {available}; call `Crowd::update` after members are added, and acquire its \
         palettes before drawing"
    )]
    NoPalette {
        /// Index of the instance.
        instance: usize,
        /// Number of the page.
        page: usize,
        /// First entry within the page.
        first: usize,
        /// Number of entries that the character needs.
        count: usize,
        /// Number of entries that the page holds.
        available: usize,
    },
    /// A page of palettes ends in the middle of a matrix.
    #[error("a page of {len} elements ends inside a matrix; each palette entry has 3 elements")]
    PartialMatrix {
        /// Number of elements of 16 bytes that were passed.
        len: usize,
    },
    /// The device failed, or rejected the buffers that it was given.
    #[error(transparent)]
    Device(#[from] populace_device::BackendError),
    /// The driver cannot draw from mapped buffers.
    #[error("this driver offers neither OpenGL 4.4 nor GL_ARB_buffer_storage")]
    NoBufferStorage,
    /// No transport brings the palettes to OpenGL.
    #[error("palettes do not reach OpenGL: {reasons}")]
    NoTransport {
        /// The reason for each transport.
        reasons: String,
    },
}
