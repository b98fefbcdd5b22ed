//! The trait that every device implements, and its errors.

use std::ops::Range;

use crate::backend_error::BackendError;
use crate::hand_over::PaletteSource;
use crate::layout::{Float4, Member};
use crate::stage::UserStage;
use crate::stage_buffer::{Stage, StageBuffer};
use crate::tables::Tables;

/// How the stages are mapped to work-items. All give the same poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Schedule {
    /// One kernel for each stage, one work-item for each joint, through global memory (Lister & Day
    /// 2012, sections 3 and 3.1): the faithful one, and the baseline of every benchmark.
    Staged,
    /// All stages in one, in the form that suits the kind of device.
    #[default]
    Fused,
    /// All stages in one for CPUs: a work-item for a run of members, sixteen joints at a time.
    FusedWide,
    /// All stages in one for GPUs: a work-group for each member, a work-item for each joint.
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

/// One frame's arguments.
///
/// Members that are attached to others are evaluated after those, in the next phase. All phases of
/// a frame can run at once, or one after the other: the first begins the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The crowd's clock.
    pub tick: u64,
    /// Ticks since the frame before.
    pub elapsed_ticks: u32,
    /// The first place of the members to evaluate.
    pub place_first: u32,
    /// The end of those places.
    pub place_end: u32,
    /// The first phase to run.
    pub phase_first: u32,
    /// The end of those phases.
    pub phase_end: u32,
}

impl Frame {
    /// A frame of all members.
    #[must_use]
    pub const fn of_all(tick: u64) -> Self {
        let (place_end, phase_end) = (u32::MAX, u32::MAX);
        Self { tick, elapsed_ticks: 0, place_first: 0, place_end, phase_first: 0, phase_end }
    }

    /// With the time since the frame before, which what moves on from frame to frame needs.
    #[must_use]
    pub const fn after_ticks(mut self, elapsed_ticks: u32) -> Self {
        self.elapsed_ticks = elapsed_ticks;
        self
    }

    /// One phase of it.
    #[must_use]
    pub const fn of_phase(mut self, phase: u32) -> Self {
        (self.phase_first, self.phase_end) = (phase, phase + 1);
        self
    }

    /// Seconds since the frame before.
    #[must_use]
    pub fn elapsed_secs(self) -> f32 {
        self.elapsed_ticks as f32 * populace_clip::TICK_SECS
    }

    /// Whether the member at a place is one of the frame's.
    #[inline]
    #[must_use]
    pub const fn evaluates(self, place: u32) -> bool {
        self.place_first <= place && place < self.place_end
    }

    /// Whether a member's phase is one of the frame's.
    #[inline]
    #[must_use]
    pub const fn reaches(self, member: &Member) -> bool {
        self.phase_first <= member.phase() && member.phase() < self.phase_end
    }

    /// Whether these phases are the first ones of the frame.
    #[inline]
    #[must_use]
    pub const fn begins(self) -> bool {
        self.phase_first == 0
    }

    /// The phases of these that some member is evaluated in.
    #[must_use]
    pub fn phases(self, tables: &Tables) -> Range<u32> {
        self.phase_first..self.phase_end.min(tables.phase_count())
    }

    /// Whether a stage runs with these phases. What comes before Transform runs with the first for
    /// all members, what comes after it with the last.
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
/// The host's [`Tables`] are the truth. [`update`](Self::update) brings the device's copy up to
/// date; then [`run`](Self::run) computes a frame. Stages can run alone and their buffers can be
/// read and written, so that each is tested against the same input. Palettes leave a device as a
/// [`PaletteSource`].
pub trait Backend: PaletteSource + Send {
    /// The device's name, for people.
    fn device_name(&self) -> String;

    /// How stages are mapped to work-items.
    fn schedule(&self) -> Schedule;

    /// Takes over what changed in the tables since the last call: of each table its
    /// [`changed`](crate::Table::changed) elements and its [`tail`](crate::Table::tail).
    ///
    /// # Errors
    ///
    /// Memory that cannot be had, or a failing device.
    fn update(&mut self, tables: &Tables) -> Result<(), BackendError>;

    /// Takes users' stages, by number, in place of those before; they run from the next
    /// [`update`](Self::update) on.
    ///
    /// # Errors
    ///
    /// [`BackendError::NoForm`], [`BackendError::BadStages`], or a failing device; what ran before
    /// then goes on.
    fn set_stages(&mut self, stages: &[Option<UserStage>]) -> Result<(), BackendError> {
        match stages.iter().flatten().next() {
            None => Ok(()),
            Some(stage) => Err(BackendError::NoForm {
                device: self.device_name(),
                stage: stage.name().into(),
                form: "a device that runs users' stages",
            }),
        }
    }

    /// Runs one stage for the frame's members, from what the stage before left. Of a frame's phases
    /// only [`Stage::Transform`] makes a difference.
    ///
    /// # Errors
    ///
    /// A failing device, or a schedule other than [`Schedule::Staged`], which has no stages of its
    /// own.
    fn run_stage(
        &mut self,
        tables: &Tables,
        frame: Frame,
        stage: Stage,
    ) -> Result<(), BackendError>;

    /// Runs a frame's phases: slots to palettes.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError>;

    /// Whether [`run`](Self::run) returns while the device is still at work, so that the host can
    /// start others meanwhile.
    fn runs_ahead(&self) -> bool {
        false
    }

    /// Reads elements of a buffer as of the last frame, waiting for what was enqueued before. A
    /// fused schedule keeps only the palettes; of other buffers it reads those of one member at a
    /// time, which it evaluates once more for that. `tables` are as of the last
    /// [`update`](Self::update), see [`Tables::with_taken_over`].
    ///
    /// # Errors
    ///
    /// [`BackendError::NotEvaluated`] before the first frame, a failing device, or a range past the
    /// end or, for a fused schedule, past the member.
    fn read(
        &mut self,
        tables: &Tables,
        buffer: StageBuffer,
        first: usize,
        into: &mut [Float4],
    ) -> Result<(), BackendError>;

    /// Writes elements of a buffer, for a stage that is then run alone.
    ///
    /// # Errors
    ///
    /// A failing device, a range past the end, or a fused schedule.
    fn write(
        &mut self,
        buffer: StageBuffer,
        first: usize,
        from: &[Float4],
    ) -> Result<(), BackendError>;

    /// Waits until all that was enqueued is done.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn finish(&mut self) -> Result<(), BackendError>;

    /// Lets what is watched come to the host as of the last frame, which was that of a clock,
    /// without waiting for it. A device that is frames behind leaves it out.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn fetch_watched(&mut self, tables: &Tables, tick: u64) -> Result<(), BackendError>;

    /// The newest of what was watched that has come to the host, and the clock when it was so;
    /// `None` before the first.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError>;

    /// How often the host has waited for a device of this kind since the process began. Frames do
    /// not make it wait.
    fn waits(&self) -> u64 {
        0
    }

    /// Milliseconds of device time that the last frame took, where the device measures it and has
    /// finished.
    fn frame_time_ms(&mut self) -> Option<f64>;

    /// Milliseconds of device time that the last run of each stage took, where there are stages and
    /// the device measures it.
    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        Vec::new()
    }

    /// Writes every palette with a constant and computes nothing: the floor under any schedule, for
    /// benchmarks. The fastest of several ways to write is taken; returns its time in milliseconds.
    ///
    /// # Errors
    ///
    /// A failing device.
    fn write_floor(&mut self, tables: &Tables) -> Result<f64, BackendError>;

    /// Bytes that the device holds for tables and stage buffers.
    fn memory_bytes(&self) -> usize;
}
