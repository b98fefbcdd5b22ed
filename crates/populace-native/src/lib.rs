//! The stages of the crowd pipeline in Rust, on all cores: no driver needed.
//!
//! [`NativeBackend`] implements [`Backend`] with the *staged* schedule: evaluate, pose, transform
//! and write-back, each for all members, through the same buffers as the OpenCL kernels of the same
//! names; and with the *fused* one: a member's whole frame at once, in lanes, compiled for several
//! processors of which the best is taken at run time. The arithmetic is the same everywhere, and
//! results do not depend on the number of threads.
//!
//! ```
//! use populace_device::{Backend, Frame, PaletteSource, Schedule, Tables};
//! use populace_native::NativeBackend;
//!
//! let mut backend = NativeBackend::new(2, Schedule::Fused)?;
//! let tables = Tables::new(4);
//! backend.update(&tables)?;
//! backend.run(&tables, Frame::of_all(0))?;
//! assert!(backend.with_page(0, &mut |_| ()).is_err(), "an empty crowd has no page of palettes");
//! # Ok::<(), populace_device::BackendError>(())
//! ```

mod controls;
mod dispatch;
mod evaluate;
mod floor;
mod fused;
mod inertialize;
mod joint;
mod lanes;
mod machines;
mod pages;
mod pose;
mod reading;
mod rows;
mod split;
mod stages;
mod transform;
mod turns;
mod write_back;

use std::sync::PoisonError;
use std::time::Instant;

use populace_device::layout::{Float4, PAGE_ENTRIES, SlotSample};
use populace_device::{
    Backend, BackendError, Frame, GlContext, HandedOver, PaletteSource, PaletteTarget,
    PaletteTransport, Schedule, Stage, StageBuffer, Tables, TargetMark, UserStage,
};

use crate::controls::{Clock, Keeping};
use crate::dispatch::Dispatch;
use crate::fused::Scratch;
use crate::pages::Pages;
use crate::reading::Reading;
use crate::stages::Stages;

/// Evaluates crowds on the CPU.
pub struct NativeBackend {
    pool: rayon::ThreadPool,
    schedule: Schedule,
    dispatch: Dispatch,
    /// One for each thread.
    scratch: Vec<Scratch>,
    /// What a fused schedule was last asked to read.
    reading: Option<Reading>,
    /// The last frame; `None` before the first.
    last: Option<Frame>,
    keeping: Keeping,
    stages: Stages,
    /// Those that run from the next update on.
    next_stages: Option<Stages>,
    /// What was watched when it was last asked for, and the clock then.
    fetched: (Option<u64>, Vec<Float4>),
    frame_ms: Option<f64>,
    samples: Vec<SlotSample>,
    joints: JointBuffer,
    models: ModelRows,
    pages: Pages,
    times_ms: [f64; Stage::ALL.len()],
}

/// Each member's local transforms, stored apart (the bone buffer of Lister & Day 2012, section 3.1,
/// fig. 3).
#[derive(Default)]
struct JointBuffer {
    translations: Vec<Float4>,
    rotations: Vec<Float4>,
    scales: Vec<Float4>,
}

/// `model_from_joint` as three arrays of rows.
#[derive(Default)]
struct ModelRows([Vec<Float4>; 3]);

const DEVICE: &str = "the native device";

impl NativeBackend {
    /// Starts a pool of `threads` threads; 0 takes one for each core.
    ///
    /// [`Schedule::Fused`] and [`Schedule::FusedWide`] are the same here.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] where the system gives no threads, and for
    /// [`Schedule::FusedGrouped`], which is for GPUs.
    pub fn new(threads: usize, schedule: Schedule) -> Result<Self, BackendError> {
        if schedule == Schedule::FusedGrouped {
            return Err(failed(
                "take the schedule fused-grouped",
                "it has staged, fused and fused-wide",
            ));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("populace-{index}"))
            .build()
            .map_err(|error| failed("start its threads", error))?;
        let scratch = (0..pool.current_num_threads()).map(|_| Scratch::default()).collect();
        Ok(Self {
            pool,
            schedule,
            dispatch: Dispatch::detect(),
            scratch,
            reading: None,
            last: None,
            keeping: Keeping::default(),
            stages: Stages::default(),
            next_stages: None,
            fetched: (None, Vec::new()),
            frame_ms: None,
            samples: Vec::new(),
            joints: JointBuffer::default(),
            models: ModelRows::default(),
            pages: Pages::default(),
            times_ms: [0.0; Stage::ALL.len()],
        })
    }

    /// The threads in use.
    #[must_use]
    pub fn thread_count(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn is_staged(&self) -> bool {
        self.schedule == Schedule::Staged
    }

    /// Runs what is done phase by phase: members that are attached to others find where those are
    /// in this frame.
    fn run_phases(&mut self, tables: &Tables, frame: Frame) {
        if frame.begins() {
            self.keeping.begin_frame();
        }
        let staged = self.is_staged();
        let Self { pool, dispatch, stages, joints, models, pages, scratch, keeping, .. } = self;
        for phase in frame.phases(tables) {
            let (frame, from) = (frame.of_phase(phase), (&*stages, &*keeping));
            pool.install(|| {
                if staged {
                    transform::run(tables, frame, from, joints, scratch, models);
                } else {
                    fused::run(tables, frame, from, *dispatch, scratch, pages);
                }
            });
            for desk in &mut *scratch {
                keeping.take_over(&mut desk.get_mut().unwrap_or_else(PoisonError::into_inner).left);
            }
        }
    }

    fn grow_stage_buffers(&mut self, tables: &Tables) -> Result<(), BackendError> {
        let joints = tables.joint_places();
        grow(
            &mut self.samples,
            tables.member_places() * tables.slots_per_member(),
            "slot samples",
        )?;
        grow(&mut self.joints.translations, joints, "joint translations")?;
        grow(&mut self.joints.rotations, joints, "joint rotations")?;
        grow(&mut self.joints.scales, joints, "joint scales")?;
        self.models.0.iter_mut().try_for_each(|rows| grow(rows, joints, "model transforms"))
    }

    /// The elements of a buffer from `first` on; of the palettes, those of `first`'s page.
    fn elements(&mut self, buffer: StageBuffer, first: usize) -> &mut [Float4] {
        let all: &mut [Float4] = match buffer {
            StageBuffer::Samples => bytemuck::cast_slice_mut(&mut self.samples),
            StageBuffer::Translations => &mut self.joints.translations,
            StageBuffer::Rotations => &mut self.joints.rotations,
            StageBuffer::Scales => &mut self.joints.scales,
            StageBuffer::ModelRow0 => &mut self.models.0[0],
            StageBuffer::ModelRow1 => &mut self.models.0[1],
            StageBuffer::ModelRow2 => &mut self.models.0[2],
            StageBuffer::States => &mut self.keeping.now.states,
            StageBuffer::Watched => &mut self.keeping.now.watched,
            StageBuffer::Running => &mut self.keeping.running,
            StageBuffer::Palette => {
                let page = self.pages.get_mut(first / PAGE_ELEMENTS).unwrap_or(&mut []);
                return page.get_mut(first % PAGE_ELEMENTS..).unwrap_or(&mut []);
            }
        };
        all.get_mut(first..).unwrap_or(&mut [])
    }
}

/// Whether every schedule keeps a buffer.
fn is_kept(buffer: StageBuffer) -> bool {
    matches!(
        buffer,
        StageBuffer::Palette | StageBuffer::States | StageBuffer::Watched | StageBuffer::Running
    )
}

const PAGE_ELEMENTS: usize = PAGE_ENTRIES as usize * 3;

fn failed(operation: &str, cause: impl std::fmt::Display) -> BackendError {
    BackendError::Failed {
        device: DEVICE.into(),
        operation: operation.into(),
        cause: cause.to_string(),
    }
}

fn grow<T: Clone + Default>(
    buffer: &mut Vec<T>,
    count: usize,
    what: &str,
) -> Result<(), BackendError> {
    let more = count.saturating_sub(buffer.len());
    if buffer.try_reserve_exact(more).is_err() {
        let bytes = count.saturating_mul(size_of::<T>());
        return Err(BackendError::OutOfMemory { device: DEVICE.into(), what: what.into(), bytes });
    }
    buffer.resize(buffer.len() + more, T::default());
    Ok(())
}

impl Backend for NativeBackend {
    fn device_name(&self) -> String {
        let (count, registers) = (self.thread_count(), self.dispatch.name());
        format!("native ({count} {}, {registers})", if count == 1 { "thread" } else { "threads" })
    }

    fn schedule(&self) -> Schedule {
        self.schedule
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        self.reading = None;
        if let Some(stages) = self.next_stages.take() {
            self.stages = stages;
        }
        if self.is_staged() {
            self.grow_stage_buffers(tables)?;
        }
        grow(&mut self.keeping.now.states, tables.state_elements(), "what is kept of members")?;
        grow(
            &mut self.keeping.now.watched,
            tables.watched_elements(),
            "what is watched of members",
        )?;
        grow(&mut self.keeping.running, tables.running_elements(), "where state machines are")?;
        for run in tables.new_watched_elements() {
            self.keeping.now.watched[run].fill(Float4::default());
        }
        self.pages.update(tables)
    }

    fn set_stages(&mut self, stages: &[Option<UserStage>]) -> Result<(), BackendError> {
        self.next_stages = Some(Stages::new(stages)?);
        Ok(())
    }

    fn run_stage(
        &mut self,
        tables: &Tables,
        frame: Frame,
        stage: Stage,
    ) -> Result<(), BackendError> {
        if !self.is_staged() {
            let operation = format!("run the stage {}", stage.name());
            return Err(failed(&operation, "a fused schedule has no stages; run the staged one"));
        }
        let start = Instant::now();
        let Self { pool, stages, samples, joints, models, pages, keeping, .. } = self;
        match stage {
            Stage::Evaluate => pool.install(|| {
                machines::advance(tables, frame.tick, &mut keeping.running);
                evaluate::run(tables, &keeping.running, frame.tick, samples);
            }),
            Stage::Pose => pool.install(|| {
                pose::run(tables, frame, stages, (&keeping.running, samples), joints);
            }),
            Stage::Transform => self.run_phases(tables, frame),
            Stage::WriteBack => {
                pages.begin_frame();
                pool.install(|| write_back::run(tables, frame, models, pages));
            }
        }
        let goes_on = stage == Stage::Transform && !frame.begins();
        let before_ms = if goes_on { self.times_ms[stage as usize] } else { 0.0 };
        self.times_ms[stage as usize] = before_ms + start.elapsed().as_secs_f64() * 1e3;
        self.last = Some(frame);
        Ok(())
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        let start = Instant::now();
        if self.is_staged() {
            let mut stages = Stage::ALL.into_iter().filter(|stage| frame.runs(*stage, tables));
            stages.try_for_each(|stage| self.run_stage(tables, frame, stage))?;
        } else {
            (self.last, self.reading) = (Some(frame), None);
            if frame.begins() {
                self.pages.begin_frame();
                let Self { pool, keeping, .. } = self;
                pool.install(|| machines::advance(tables, frame.tick, &mut keeping.running));
            }
            self.run_phases(tables, frame);
        }
        let before_ms = self.frame_ms.filter(|_| !frame.begins()).unwrap_or(0.0);
        self.frame_ms = Some(before_ms + start.elapsed().as_secs_f64() * 1e3);
        Ok(())
    }

    fn read(
        &mut self,
        tables: &Tables,
        buffer: StageBuffer,
        mut first: usize,
        mut into: &mut [Float4],
    ) -> Result<(), BackendError> {
        if !self.is_staged() && !is_kept(buffer) {
            let last = self.last.ok_or(BackendError::NotEvaluated)?;
            let of = (Clock::of(last, &self.stages), &self.keeping);
            return reading::read(&mut self.reading, tables, of, buffer, first, into);
        }
        if buffer == StageBuffer::Palette && self.last.is_none() {
            return Err(BackendError::NotEvaluated);
        }
        while !into.is_empty() {
            let from = self.elements(buffer, first);
            let count = from.len().min(into.len());
            if count == 0 {
                return Err(failed(
                    &format!("read {buffer:?}"),
                    format!("element {first} is past the end"),
                ));
            }
            into[..count].copy_from_slice(&from[..count]);
            into = &mut into[count..];
            first += count;
        }
        Ok(())
    }

    fn write(
        &mut self,
        buffer: StageBuffer,
        mut first: usize,
        mut from: &[Float4],
    ) -> Result<(), BackendError> {
        if !self.is_staged() && !is_kept(buffer) {
            return Err(failed(
                &format!("write {buffer:?}"),
                "a fused schedule keeps palettes only",
            ));
        }
        while !from.is_empty() {
            let to = self.elements(buffer, first);
            let count = to.len().min(from.len());
            if count == 0 {
                return Err(failed(
                    &format!("write {buffer:?}"),
                    format!("element {first} is past the end"),
                ));
            }
            to[..count].copy_from_slice(&from[..count]);
            from = &from[count..];
            first += count;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), BackendError> {
        Ok(())
    }

    fn fetch_watched(&mut self, tables: &Tables, tick: u64) -> Result<(), BackendError> {
        let (kept_at, watched) = &mut self.fetched;
        *kept_at = Some(tick);
        watched.clear();
        watched.extend_from_slice(
            self.keeping.now.watched.get(..tables.watched_elements()).unwrap_or(&[]),
        );
        Ok(())
    }

    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError> {
        Ok(self.fetched.0.map(|tick| (tick, self.fetched.1.as_slice())))
    }

    fn frame_time_ms(&mut self) -> Option<f64> {
        self.frame_ms
    }

    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        if !self.is_staged() {
            return Vec::new();
        }
        Stage::ALL.into_iter().map(|stage| (stage, self.times_ms[stage as usize])).collect()
    }

    fn write_floor(&mut self, _tables: &Tables) -> Result<f64, BackendError> {
        let Self { pool, pages, .. } = self;
        Ok(pool.install(|| floor::write(pages)))
    }

    fn memory_bytes(&self) -> usize {
        let elements = self.samples.len()
            + self.keeping.now.states.len() * 2
            + self.keeping.now.watched.len() * 2
            + self.keeping.running.len()
            + self.joints.translations.len() * 3
            + self.models.0[0].len() * 3
            + self.pages.capacity();
        elements * size_of::<Float4>()
    }
}

impl PaletteSource for NativeBackend {
    fn page_lengths(&self) -> Vec<usize> {
        self.pages.lengths().to_vec()
    }

    fn refuses(&self, way: PaletteTransport, _context: &dyn GlContext) -> Option<String> {
        (way == PaletteTransport::Shared).then(|| "it takes an OpenCL device".into())
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.pages.set_target(target, mark)
    }

    fn hand_over(&mut self) -> Result<Option<HandedOver>, BackendError> {
        Ok(self.pages.hand_over())
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        if self.last.is_none() {
            return Err(BackendError::NotEvaluated);
        }
        let count = self.pages.lengths().len();
        let palettes = self.pages.get_mut(page).ok_or_else(|| {
            failed("hand over palettes", format!("there is no page {page}; {count} are in use"))
        })?;
        reader(palettes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn staged(threads: usize) -> NativeBackend {
        NativeBackend::new(threads, Schedule::Staged).unwrap()
    }

    fn fused(threads: usize, dispatch: Dispatch) -> NativeBackend {
        NativeBackend { dispatch, ..NativeBackend::new(threads, Schedule::Fused).unwrap() }
    }

    mod conformance {
        populace_testkit::backend_conformance!(super::staged(3));
    }

    mod conformance_on_1_thread {
        populace_testkit::backend_conformance!(super::staged(1));
    }

    mod conformance_fused {
        populace_testkit::fused_conformance!(super::fused(3, super::Dispatch::detect()));
    }

    mod conformance_fused_on_16_threads {
        populace_testkit::fused_conformance!(super::fused(16, super::Dispatch::detect()));
    }

    mod conformance_fused_baseline {
        populace_testkit::fused_conformance!(super::fused(1, super::Dispatch::Baseline));
    }

    #[test]
    fn past_the_end_is_an_error() {
        let mut backend = NativeBackend::new(1, Schedule::Staged).unwrap();
        assert!(
            backend
                .read(&Tables::new(1), StageBuffer::Palette, 0, &mut [Float4::default()])
                .is_err()
        );
        assert!(backend.write(StageBuffer::Scales, 9, &[Float4::default()]).is_err());
    }
}
