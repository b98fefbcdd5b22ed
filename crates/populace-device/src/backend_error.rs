//! What can go wrong on a device.

/// What went wrong on a device. The crowd's state lives on the host and survives all of these.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BackendError {
    /// No driver that gives a device.
    #[error("OpenCL cannot be used: {cause}; or choose the native device")]
    NoRuntime {
        /// What each driver lacks, or that there is none.
        cause: String,
    },
    /// A device whose driver lacks something on this machine.
    #[error("{device} cannot be used: {cause}; or choose the native device")]
    Unusable {
        /// The device's name.
        device: String,
        /// What it lacks, and how to mend it.
        cause: String,
    },
    /// A device that does not exist.
    #[error("there is no OpenCL device {index}; {count} found (`populace devices` lists them)")]
    NoDevice {
        /// The index asked for.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A device that is not to be had in so many equal parts.
    #[error("{device} cannot be cut into {parts} equal parts: {cause}; name the whole device")]
    NoPart {
        /// The device's name.
        device: String,
        /// How many parts were asked for.
        parts: usize,
        /// Why not.
        cause: String,
    },
    /// Memory that could not be had.
    #[error("{device} has no room for {bytes} bytes of {what}")]
    OutOfMemory {
        /// The device's name.
        device: String,
        /// What the memory was for.
        what: String,
        /// How much was asked for.
        bytes: usize,
    },
    /// A body whose joints do not fit what the work-items of a group share.
    #[error(
        "{device} has {available} bytes of local memory, and a body of {joints} joints takes \
         {bytes} bytes of it when fused; use --schedule staged, which takes bodies of any size"
    )]
    BodyTooLarge {
        /// The device's name.
        device: String,
        /// The body's joints.
        joints: usize,
        /// How much it takes.
        bytes: u64,
        /// How much there is.
        available: u64,
    },
    /// A user's stage without the form that a device runs.
    #[error("{device} cannot run the stage \"{stage}\": it needs {form}, and was given none")]
    NoForm {
        /// The device's name.
        device: String,
        /// The stage's name.
        stage: String,
        /// What is missing.
        form: &'static str,
    },
    /// A user's stages that do not compile.
    #[error(
        "{device} cannot compile the user stages; each line is that of the stage's own \
         text:\n{log}"
    )]
    BadStages {
        /// The device's name.
        device: String,
        /// The compiler's own words.
        log: String,
    },
    /// A read of what no frame has evaluated: before the first update, after a move to another
    /// device, after an update that failed, or of a member that came since.
    #[error("nothing has been evaluated yet that could be read; update the crowd first")]
    NotEvaluated,
    /// A call that the device or its driver failed.
    #[error("{device} failed to {operation}: {cause}")]
    Failed {
        /// The device's name.
        device: String,
        /// What was being done.
        operation: String,
        /// The driver's own words or code.
        cause: String,
    },
}
