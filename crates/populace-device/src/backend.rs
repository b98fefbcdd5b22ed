//! The trait that every device implements, and its errors.

use std::ops::Range;

use crate::backend_error::BackendError;
use crate::interop::PaletteSource;
use crate::layout::{Float4, Member};
use crate::stage::UserStage;
use crate::stage_buffer::{Stage, StageBuffer};
use crate::tables::Tables;

/// Mapping of stages to work-items. All schedules give the same poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Schedule {
    /// One kernel per stage and one work-item per joint, through global memory (Lister & Day 2012,
    /// sections 3 and 3.1). It follows the paper and is the baseline of all benchmarks.
    Staged,
    /// All stages in one kernel, in the variant that suits the kind of device.
    #[default]
    Fused,
    /// All stages in one kernel, for CPUs: one work-item per run of members, which stand side by
    /// side in the lanes of vectors.
    FusedWide,
    /// All stages in one kernel, for GPUs: one work-group per member, one work-item per joint.
    FusedGrouped,
}

impl Schedule {
    /// All schedules.
    pub const ALL: [Self; 4] = [Self::Staged, Self::Fused, Self::FusedWide, Self::FusedGrouped];

    /// The schedule's name in code, kernels, tables and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Staged => "staged",
            Self::Fused => "fused",
            Self::FusedWide => "fused-wide",
            Self::FusedGrouped => "fused-grouped",
        }
    }
}

impl std::fmt::Display for Schedule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for Schedule {
    type Err = crate::Error;

    /// Reads a schedule's [`name`](Self::name).
    fn from_str(name: &str) -> Result<Self, crate::Error> {
        let known = Self::ALL.into_iter().find(|schedule| schedule.name() == name);
        known.ok_or_else(|| crate::Error::UnknownSchedule { name: name.to_owned() })
    }
}

/// The arguments of one frame.
///
/// Members that are attached to others are evaluated in the phase after these. The phases of a
/// frame can run in one call or in several; the first phase begins the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The crowd's clock.
    pub tick: u64,
    /// Ticks since the previous frame.
    pub elapsed_ticks: u32,
    /// First index of the members to evaluate.
    pub place_first: u32,
    /// End of these indices.
    pub place_end: u32,
    /// The first phase to run.
    pub phase_first: u32,
    /// End of these phases.
    pub phase_end: u32,
}

impl Frame {
    /// Creates a frame of all members and phases at a clock tick, with no elapsed time.
    #[must_use]
    pub const fn of_all(tick: u64) -> Self {
        let (place_end, phase_end) = (u32::MAX, u32::MAX);
        Self { tick, elapsed_ticks: 0, place_first: 0, place_end, phase_first: 0, phase_end }
    }

    /// Sets the time since the previous frame, which stateful constraints and root motion need.
    #[must_use]
    pub const fn after_ticks(mut self, elapsed_ticks: u32) -> Self {
        self.elapsed_ticks = elapsed_ticks;
        self
    }

    /// Restricts the frame to one phase.
    #[must_use]
    pub const fn of_phase(mut self, phase: u32) -> Self {
        (self.phase_first, self.phase_end) = (phase, phase + 1);
        self
    }

    /// Seconds since the previous frame.
    #[must_use]
    pub fn elapsed_secs(self) -> f32 {
        self.elapsed_ticks as f32 * populace_clip::TICK_SECS
    }

    /// Returns whether the frame evaluates the member of this index.
    #[inline]
    #[must_use]
    pub const fn evaluates(self, place: u32) -> bool {
        self.place_first <= place && place < self.place_end
    }

    /// Returns whether the member's phase is one of the frame's phases, and it is not hidden.
    #[inline]
    #[must_use]
    pub const fn reaches(self, member: &Member) -> bool {
        !member.is_hidden() && self.phase_first <= member.phase() && member.phase() < self.phase_end
    }

    /// Returns whether the frame's phases include the first one.
    #[inline]
    #[must_use]
    pub const fn begins(self) -> bool {
        self.phase_first == 0
    }

    /// The frame's phases, up to the last one with members.
    #[must_use]
    pub fn phases(self, tables: &Tables) -> Range<u32> {
        self.phase_first..self.phase_end.min(tables.phase_count())
    }

    /// Returns whether a stage runs with these phases. Stages before Transform run for all members
    /// with the first phase, stages after it with the last.
    #[must_use]
    pub fn runs(self, stage: Stage, tables: &Tables) -> bool {
        match stage {
            Stage::Evaluate | Stage::Pose => self.begins(),
            Stage::Transform => true,
            Stage::WriteBack => self.phase_end >= tables.phase_count(),
        }
    }
}

/// A device that evaluates the tables of a crowd.
///
/// The host's [`Tables`] are authoritative. [`update`](Self::update) copies their changes to the
/// device, then [`run`](Self::run) computes a frame. Stages can also run alone, and their buffers
/// can be read and written, so that each stage can be tested on the same input. Palettes leave a
/// device through [`PaletteSource`].
pub trait Backend: PaletteSource + Send {
    /// The device's name for display.
    fn device_name(&self) -> String;

    /// The mapping of stages to work-items.
    fn schedule(&self) -> Schedule;

    /// Copies the changes in the tables since the last call: for each table its
    /// [`changed`](crate::Table::changed) elements and its [`tail`](crate::Table::tail).
    ///
    /// # Errors
    ///
    /// Memory cannot be allocated, or the device fails.
    fn update(&mut self, tables: &Tables) -> Result<(), BackendError>;

    /// Replaces the user stages, indexed by stage number. They run from the next
    /// [`update`](Self::update) on.
    ///
    /// # Errors
    ///
    /// [`BackendError::NoForm`], [`BackendError::BadStages`], or a device failure. The previous
    /// stages then stay in use.
    fn set_stages(&mut self, stages: &[Option<UserStage>]) -> Result<(), BackendError> {
        match stages.iter().flatten().next() {
            None => Ok(()),
            Some(stage) => Err(BackendError::NoForm {
                device: self.device_name(),
                stage: stage.name().into(),
                form: "a device that runs user stages",
            }),
        }
    }

    /// Runs one stage for the frame's members on the output of the previous stage. The frame's
    /// phases matter for [`Stage::Transform`] only.
    ///
    /// # Errors
    ///
    /// A device failure, or a schedule other than [`Schedule::Staged`], which has no separate
    /// stages.
    fn run_stage(
        &mut self,
        tables: &Tables,
        frame: Frame,
        stage: Stage,
    ) -> Result<(), BackendError>;

    /// Runs a frame's phases, from slots to palettes.
    ///
    /// # Errors
    ///
    /// A device failure.
    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError>;

    /// Takes back what the frame since the last [`update`](Self::update) changed for later frames:
    /// states of constraints, watched joints and state machines. For a frame that failed, on this
    /// device or on one that shares the crowd. Its results cannot be read. Does nothing without a
    /// frame.
    fn undo_frame(&mut self);

    /// Returns whether [`run`](Self::run) returns while the device is still working, so that the
    /// host can start other devices meanwhile.
    fn runs_ahead(&self) -> bool {
        false
    }

    /// Reads elements of a buffer as of the last frame, waiting for the device. A fused schedule
    /// stores only palettes. It reads other buffers of one member per call, for which it evaluates
    /// the member again. `tables` must be those of the last [`update`](Self::update), see
    /// [`Tables::with_taken_over`].
    ///
    /// # Errors
    ///
    /// [`BackendError::NotEvaluated`] before the first frame, a device failure, or a range past the
    /// end of the buffer or, for a fused schedule, past the member.
    fn read(
        &mut self,
        tables: &Tables,
        buffer: StageBuffer,
        first: usize,
        into: &mut [Float4],
    ) -> Result<(), BackendError>;

    /// Writes elements of a buffer, as input for a stage that is then run alone.
    ///
    /// # Errors
    ///
    /// A device failure, a range past the end of the buffer, or a fused schedule.
    fn write(
        &mut self,
        buffer: StageBuffer,
        first: usize,
        from: &[Float4],
    ) -> Result<(), BackendError>;

    /// Waits until the device has done all its work.
    ///
    /// # Errors
    ///
    /// A device failure.
    fn finish(&mut self) -> Result<(), BackendError>;

    /// Starts an asynchronous read of all watched joints as of the last frame, whose clock tick was
    /// `tick`. A device that is frames behind skips the read.
    ///
    /// # Errors
    ///
    /// A device failure.
    fn fetch_watched(&mut self, tables: &Tables, tick: u64) -> Result<(), BackendError>;

    /// The latest completed read of watched joints and its clock tick; `None` before the first.
    ///
    /// # Errors
    ///
    /// A device failure.
    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError>;

    /// Forgets all reads of watched joints, completed and under way.
    fn forget_fetched(&mut self);

    /// Number of times that the host has waited for devices of this kind since the process began.
    /// Frames do not wait.
    fn waits(&self) -> u64 {
        0
    }

    /// Device time of the last frame in milliseconds, if the device measures it and has finished.
    fn frame_time_ms(&mut self) -> Option<f64>;

    /// Device time of the last run of each stage in milliseconds, if there are stages and the
    /// device measures it.
    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        Vec::new()
    }

    /// Writes a constant to every palette without computing anything and returns the time in
    /// milliseconds. This is the lower bound of any schedule, for benchmarks. Several methods of
    /// writing are tried; the fastest counts.
    ///
    /// # Errors
    ///
    /// A device failure.
    fn write_floor(&mut self, tables: &Tables) -> Result<f64, BackendError>;

    /// Device memory used for tables and stage buffers, in bytes.
    fn memory_bytes(&self) -> usize;
}
