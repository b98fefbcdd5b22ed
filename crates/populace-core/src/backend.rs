//! The trait that every device implements, and its errors.

use crate::Tables;
use crate::layout::Float4;

/// A step of a frame (Lister & Day 2012, section 4; design of evaluate: slots are closed-form).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Finds each slot's rows and weight from the clock.
    Evaluate,
    /// Mixes each member's slots, layer by layer, into local transforms.
    Pose,
    /// Runs local transforms down the hierarchy.
    Transform,
    /// Multiplies by `joint_from_bind`, giving the matrix palettes.
    WriteBack,
}

impl Stage {
    /// All stages in the order they run.
    pub const ALL: [Self; 4] = [Self::Evaluate, Self::Pose, Self::Transform, Self::WriteBack];

    /// The stage's name in code, kernels and tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Evaluate => "evaluate",
            Self::Pose => "pose",
            Self::Transform => "transform",
            Self::WriteBack => "write_back",
        }
    }
}

/// What stages write and the next ones read; each element is 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StageBuffer {
    /// [`SlotSample`](crate::layout::SlotSample)s, `members x slots`, slots fastest.
    Samples,
    /// The joint buffer's local translations, `x y z 0`, joints fastest.
    Translations,
    /// The joint buffer's local rotations, `x y z w`.
    Rotations,
    /// The joint buffer's local scales, `x y z 0`.
    Scales,
    /// First rows of `model_from_joint`. Rows stand in arrays of their own: a rotated child under non-uniform scale
    /// shears, and no translation, rotation and scale can hold that.
    ModelRow0,
    /// Second rows.
    ModelRow1,
    /// Third rows.
    ModelRow2,
    /// The matrix palettes: three elements for each palette entry.
    Palette,
}

impl StageBuffer {
    /// All buffers.
    pub const ALL: [Self; 8] = [
        Self::Samples,
        Self::Translations,
        Self::Rotations,
        Self::Scales,
        Self::ModelRow0,
        Self::ModelRow1,
        Self::ModelRow2,
        Self::Palette,
    ];
}

/// One frame's arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The crowd's clock.
    pub tick: u64,
}

/// What went wrong on a device. The crowd's state lives on the host and survives all of these.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BackendError {
    /// No driver to load.
    #[error("no OpenCL runtime on this machine; install a GPU driver or PoCL, or choose the native device")]
    NoRuntime,
    /// A device that does not exist.
    #[error("there is no OpenCL device {index}; {count} found (`populace devices` lists them)")]
    NoDevice {
        /// The index asked for.
        index: usize,
        /// How many there are.
        count: usize,
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

/// A device that evaluates the tables of a crowd.
///
/// The host's [`Tables`] are the truth. [`update`](Self::update) brings the device's copy up to date; then
/// [`run`](Self::run) computes a frame. Stages can run alone and their buffers can be read and written, so that each
/// is tested against the same input.
pub trait Backend: Send {
    /// The device's name, for people.
    fn device_name(&self) -> String;

    /// The schedule's name: how stages are mapped to work-items.
    fn schedule(&self) -> &'static str;

    /// Takes over what changed in the tables since the last call: of each table its
    /// [`changed`](crate::Table::changed) elements and its [`tail`](crate::Table::tail).
    ///
    /// # Errors
    ///
    /// Memory that cannot be had, or a failing device.
    fn update(&mut self, tables: &Tables) -> Result<(), BackendError>;

    /// Runs one stage for all members, from what the stage before left.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn run_stage(&mut self, tables: &Tables, frame: Frame, stage: Stage) -> Result<(), BackendError>;

    /// Runs a whole frame: slots to palettes.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        Stage::ALL.into_iter().try_for_each(|stage| self.run_stage(tables, frame, stage))
    }

    /// Reads elements of a buffer, waiting for what was enqueued before.
    ///
    /// # Errors
    ///
    /// A failing device, or a range past the end.
    fn read(&mut self, buffer: StageBuffer, first: usize, into: &mut [Float4]) -> Result<(), BackendError>;

    /// Writes elements of a buffer.
    ///
    /// # Errors
    ///
    /// A failing device, or a range past the end.
    fn write(&mut self, buffer: StageBuffer, first: usize, from: &[Float4]) -> Result<(), BackendError>;

    /// Hands a page of palettes to `reader`, waiting for the frame to be done: three elements for each palette entry
    /// of the page, up to the last entry in use.
    ///
    /// # Errors
    ///
    /// A failing device, or a page that does not exist.
    fn with_page(&mut self, page: usize, reader: &mut dyn FnMut(&[Float4])) -> Result<(), BackendError>;

    /// Waits until all that was enqueued is done.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn finish(&mut self) -> Result<(), BackendError>;

    /// Milliseconds of device time that the last run of each stage took, where the device measures it.
    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        Vec::new()
    }

    /// Writes every palette with a constant and computes nothing: the floor under any schedule, for benchmarks. The
    /// fastest of several ways to write is taken; returns its time in milliseconds.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn write_floor(&mut self, tables: &Tables) -> Result<f64, BackendError>;

    /// Bytes that the device holds for tables and stage buffers.
    fn memory_bytes(&self) -> usize;
}
