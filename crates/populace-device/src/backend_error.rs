//! Errors of devices.

use populace_model::ErrorKind;

/// A failure of a device. The crowd's state is on the host and survives all of these.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BackendError {
    /// No driver offers a device.
    #[error("OpenCL cannot be used: {cause}; alternatively choose the native device")]
    NoRuntime {
        /// The fault of each driver, or that no driver is installed.
        cause: String,
    },
    /// A device whose driver lacks something on this machine.
    #[error("{device} cannot be used: {cause}; alternatively choose the native device")]
    Unusable {
        /// The device's name.
        device: String,
        /// The fault and how to mend it.
        cause: String,
    },
    /// A device that does not exist.
    #[error("there is no OpenCL device {index}; {count} found (`populace devices` lists them)")]
    NoDevice {
        /// The index asked for.
        index: usize,
        /// The number of devices.
        count: usize,
    },
    /// A device that cannot be divided into the requested number of equal parts, or has no part of
    /// the requested number.
    #[error("{device} {cause}")]
    NoPart {
        /// The device's name.
        device: String,
        /// The requested number of parts.
        parts: usize,
        /// The reason and how to mend it.
        cause: String,
    },
    /// Memory that could not be allocated.
    #[error("{device} cannot allocate {bytes} bytes of {what}")]
    OutOfMemory {
        /// The device's name.
        device: String,
        /// The purpose of the memory.
        what: String,
        /// The requested size.
        bytes: usize,
    },
    /// A body with more joints than the local memory of a work-group holds.
    #[error(
        "{device} has {available} bytes of local memory, and a body of {joints} joints takes \
         {bytes} bytes of it when fused; use --schedule staged, which takes bodies of any size"
    )]
    BodyTooLarge {
        /// The device's name.
        device: String,
        /// The body's joints.
        joints: usize,
        /// The bytes that the body needs.
        bytes: u64,
        /// The bytes of local memory.
        available: u64,
    },
    /// A user stage without the form that a device runs.
    #[error("{device} cannot run the stage \"{stage}\": it needs {form}, and none was given")]
    NoForm {
        /// The device's name.
        device: String,
        /// The stage's name.
        stage: String,
        /// The missing form.
        form: &'static str,
    },
    /// User stages that do not compile.
    #[error(
        "{device} cannot compile the user stages; line numbers are those of each stage's own \
         text:\n{log}"
    )]
    BadStages {
        /// The device's name.
        device: String,
        /// The compiler's messages.
        log: String,
    },
    /// A read of what the last update has not evaluated: before the first update, after a failed
    /// update, or of a member that was spawned since or is hidden.
    #[error(
        "the last update has not evaluated what is to be read; update the crowd first, and watch a \
         joint of a member that its view hides"
    )]
    NotEvaluated,
    /// A call that failed on the device or in its driver.
    #[error("{device} failed to {operation}: {cause}")]
    Failed {
        /// The device's name.
        device: String,
        /// The operation.
        operation: String,
        /// The driver's message or error code.
        cause: String,
    },
}

impl BackendError {
    /// The kind of the error.
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::NoRuntime { .. }
            | Self::Unusable { .. }
            | Self::NoPart { .. }
            | Self::NoForm { .. } => ErrorKind::Unsupported,
            Self::NoDevice { .. } => ErrorKind::NotFound,
            Self::OutOfMemory { .. } | Self::BodyTooLarge { .. } => ErrorKind::TooLarge,
            Self::BadStages { .. } => ErrorKind::InvalidInput,
            Self::NotEvaluated => ErrorKind::Stale,
            Self::Failed { .. } => ErrorKind::Device,
        }
    }
}
