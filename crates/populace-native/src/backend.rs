//! Native device: buffers, threads and schedules.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::time::Instant;

use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{
    Backend, BackendError, Frame, GlContext, PaletteSource, PaletteTarget, PaletteTransport,
    ReleasedPalettes, Schedule, Stage, StageBuffer, Tables, TargetMark, UserStage, lanes_allowed,
};

use crate::buffers::StageBuffers;
use crate::errors::{DEVICE, failed};
use crate::evaluate::evaluate;
use crate::floor::write_floor;
use crate::frame::FrameInputs;
use crate::fused::fused;
use crate::history::History;
use crate::machines::advance;
use crate::pages::Pages;
use crate::pose::pose;
use crate::processor::{Machine, RegisterLanes};
use crate::reading::{self, Reading};
use crate::scratch::ScratchPool;
use crate::transform::transform;
use crate::user_stages::UserStages;
use crate::write_back::write_back;

/// Evaluates crowds on the CPU.
pub struct NativeBackend {
    pool: rayon::ThreadPool,
    schedule: Schedule,
    machine: Machine,
    scratch: ScratchPool,
    /// The member that a fused schedule last read stage buffers of.
    reading: Reading,
    /// The last frame; `None` before the first.
    last: Option<Frame>,
    history: History,
    stages: UserStages,
    /// User stages that run from the next update on.
    next_stages: Option<UserStages>,
    fetched: Fetched,
    frame_ms: Option<f64>,
    buffers: StageBuffers,
    pages: Pages,
    times_ms: [f64; Stage::ALL.len()],
}

/// Watched joints as of the last call of [`Backend::fetch_watched`].
#[derive(Default)]
struct Fetched {
    /// The clock at that call; `None` before the first.
    tick: Option<u64>,
    watched: Vec<Float4>,
}

/// `Float4` elements of a page of palettes.
const PAGE_ELEMENTS: usize = PAGE_ENTRIES as usize * 3;

/// The most threads that a native device can be asked for.
pub const MAX_THREADS: usize = 1024;

impl NativeBackend {
    /// Starts a pool of `threads` threads, at most [`MAX_THREADS`]; 0 starts one for each core.
    ///
    /// [`Schedule::Fused`] and [`Schedule::FusedWide`] are the same here: sixteen members stand
    /// side by side, in the widest registers of the processor. The environment variable
    /// `POPULACE_LANES` (4, 8 or 16) is the most lanes that registers may have. Results are the
    /// same.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] for more than [`MAX_THREADS`] threads or if the system cannot start
    /// them, for [`Schedule::FusedGrouped`], which is for GPUs, and for another `POPULACE_LANES`.
    pub fn new(threads: usize, schedule: Schedule) -> Result<Self, BackendError> {
        Self::on(machine()?, threads, schedule)
    }

    /// Like [`new`](Self::new), with the registers of `machine`.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] for more than [`MAX_THREADS`] threads or if the system cannot start
    /// them, and for [`Schedule::FusedGrouped`], which is for GPUs.
    pub fn on(machine: Machine, threads: usize, schedule: Schedule) -> Result<Self, BackendError> {
        if schedule == Schedule::FusedGrouped {
            return Err(failed(
                "use the schedule fused-grouped",
                "it supports staged, fused and fused-wide",
            ));
        }
        // The system would start hundreds of thousands, for minutes.
        if threads > MAX_THREADS {
            let cause = format!(
                "it was given {threads} threads, for at most {MAX_THREADS}; give fewer, or 0 for \
                 one per core"
            );
            return Err(failed("start its threads", cause));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("populace-{index}"))
            .build()
            .map_err(|error| failed("start its threads", error))?;
        let scratch = ScratchPool::new(pool.current_num_threads());
        Ok(Self {
            pool,
            schedule,
            machine,
            scratch,
            reading: Reading::default(),
            last: None,
            history: History::default(),
            stages: UserStages::default(),
            next_stages: None,
            fetched: Fetched::default(),
            frame_ms: None,
            buffers: StageBuffers::default(),
            pages: Pages::default(),
            times_ms: [0.0; Stage::ALL.len()],
        })
    }

    /// Returns the number of threads in use.
    #[must_use]
    pub fn thread_count(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn is_staged(&self) -> bool {
        self.schedule == Schedule::Staged
    }

    /// Runs the work that goes phase by phase. Members of a later phase read watched joints that
    /// earlier phases wrote in this frame.
    fn run_phases(&mut self, tables: &Tables, frame: Frame) {
        if frame.begins() {
            self.history.begin_frame();
        }
        let staged = self.is_staged();
        let Self { pool, machine, stages, buffers, pages, scratch, history, .. } = self;
        for phase in frame.phases(tables) {
            let frame = frame.of_phase(phase);
            pool.install(|| {
                let inputs = FrameInputs { tables, frame, stages, history };
                if staged {
                    transform(&inputs, &buffers.joints, scratch, &mut buffers.models);
                } else {
                    fused(&inputs, machine.registers, scratch, pages);
                }
                history.commit(&|job| scratch.for_each_writes(job));
                scratch.iter_mut().for_each(|own| own.writes.clear());
            });
        }
    }

    /// Runs a frame's phases by the schedule.
    fn run_frame(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        let start = Instant::now();
        if self.is_staged() {
            let mut stages = Stage::ALL.into_iter().filter(|stage| frame.runs(*stage, tables));
            stages.try_for_each(|stage| self.run_stage(tables, frame, stage))?;
        } else {
            self.last = Some(frame);
            self.reading.forget();
            if frame.begins() {
                self.pages.begin_frame();
                let Self { pool, history, .. } = self;
                history.keep_running();
                pool.install(|| advance(tables, frame.tick, &mut history.running));
            }
            self.run_phases(tables, frame);
        }
        let before_ms = self.frame_ms.filter(|_| !frame.begins()).unwrap_or(0.0);
        self.frame_ms = Some(before_ms + start.elapsed().as_secs_f64() * 1e3);
        Ok(())
    }

    /// Returns the elements of a buffer from `first` on; of the palettes, those of one page.
    fn elements(&mut self, buffer: StageBuffer, first: usize) -> &mut [Float4] {
        let all: &mut [Float4] = match buffer {
            StageBuffer::States => &mut self.history.now.states,
            StageBuffer::Watched => &mut self.history.now.watched,
            StageBuffer::Running => &mut self.history.running,
            StageBuffer::Palette => {
                let page = self.pages.get_mut(first / PAGE_ELEMENTS).unwrap_or(&mut []);
                return page.get_mut(first % PAGE_ELEMENTS..).unwrap_or(&mut []);
            }
            _ => self.buffers.elements(buffer).unwrap_or(&mut []),
        };
        all.get_mut(first..).unwrap_or(&mut [])
    }
}

/// Returns the widest registers of this machine that `POPULACE_LANES` allows.
fn machine() -> Result<Machine, BackendError> {
    Ok(Machine::at_most(match lanes_allowed(DEVICE)? {
        4 => RegisterLanes::Four,
        8 => RegisterLanes::Eight,
        _ => RegisterLanes::Sixteen,
    }))
}

/// Returns whether all schedules store a buffer.
fn is_always_stored(buffer: StageBuffer) -> bool {
    matches!(
        buffer,
        StageBuffer::Palette | StageBuffer::States | StageBuffer::Watched | StageBuffer::Running
    )
}

fn past_the_end(operation: &str, buffer: StageBuffer, element: usize) -> BackendError {
    failed(&format!("{operation} {buffer:?}"), format!("element {element} is past the end"))
}

impl Backend for NativeBackend {
    fn device_name(&self) -> String {
        let (count, registers) = (self.thread_count(), self.machine.registers.name());
        format!("native ({count} {}, {registers})", if count == 1 { "thread" } else { "threads" })
    }

    fn schedule(&self) -> Schedule {
        self.schedule
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        self.reading.forget();
        if let Some(stages) = self.next_stages.take() {
            self.stages = stages;
        }
        if self.is_staged() {
            self.buffers.grow(tables)?;
        }
        self.history.grow(tables)?;
        self.pages.update(tables)
    }

    fn set_stages(&mut self, stages: &[Option<UserStage>]) -> Result<(), BackendError> {
        self.next_stages = Some(UserStages::new(stages)?);
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
        let Self { pool, stages, buffers, pages, history, .. } = self;
        match stage {
            Stage::Evaluate => pool.install(|| {
                history.keep_running();
                advance(tables, frame.tick, &mut history.running);
                evaluate(tables, &history.running, frame.tick, &mut buffers.samples);
            }),
            Stage::Pose => {
                let inputs = FrameInputs { tables, frame, stages, history };
                pool.install(|| pose(&inputs, &buffers.samples, &mut buffers.joints));
            }
            Stage::Transform => self.run_phases(tables, frame),
            Stage::WriteBack => {
                pages.begin_frame();
                pool.install(|| write_back(tables, frame, &buffers.models, pages));
            }
        }
        let goes_on = stage == Stage::Transform && !frame.begins();
        let before_ms = if goes_on { self.times_ms[stage as usize] } else { 0.0 };
        self.times_ms[stage as usize] = before_ms + start.elapsed().as_secs_f64() * 1e3;
        self.last = Some(frame);
        Ok(())
    }

    /// Takes the frame back if a user stage panics, since a caller may catch the panic.
    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        let run = catch_unwind(AssertUnwindSafe(|| self.run_frame(tables, frame)));
        run.unwrap_or_else(|panic| {
            self.scratch.iter_mut().for_each(|own| own.writes.clear());
            self.undo_frame();
            resume_unwind(panic)
        })
    }

    fn undo_frame(&mut self) {
        self.history.undo_frame();
    }

    fn read(
        &mut self,
        tables: &Tables,
        buffer: StageBuffer,
        mut first: usize,
        mut into: &mut [Float4],
    ) -> Result<(), BackendError> {
        if !self.is_staged() && !is_always_stored(buffer) {
            let frame = self.last.ok_or(BackendError::NotEvaluated)?;
            let (stages, history) = (&self.stages, &self.history);
            let inputs = FrameInputs { tables, frame, stages, history };
            let evaluated = (&inputs, self.machine.registers);
            return reading::read(&mut self.reading, evaluated, buffer, first, into);
        }
        if buffer == StageBuffer::Palette && self.last.is_none() {
            return Err(BackendError::NotEvaluated);
        }
        while !into.is_empty() {
            let from = self.elements(buffer, first);
            let count = from.len().min(into.len());
            if count == 0 {
                return Err(past_the_end("read", buffer, first));
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
        if !self.is_staged() && !is_always_stored(buffer) {
            return Err(failed(
                &format!("write {buffer:?}"),
                "a fused schedule does not store this buffer; use the staged one",
            ));
        }
        while !from.is_empty() {
            let to = self.elements(buffer, first);
            let count = to.len().min(from.len());
            if count == 0 {
                return Err(past_the_end("write", buffer, first));
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
        let Fetched { tick: fetched_at, watched } = &mut self.fetched;
        *fetched_at = Some(tick);
        watched.clear();
        watched.extend_from_slice(
            self.history.now.watched.get(..tables.watched_elements()).unwrap_or(&[]),
        );
        Ok(())
    }

    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError> {
        Ok(self.fetched.tick.map(|tick| (tick, self.fetched.watched.as_slice())))
    }

    fn forget_fetched(&mut self) {
        self.fetched = Fetched::default();
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
        Ok(pool.install(|| write_floor(pages)))
    }

    fn memory_bytes(&self) -> usize {
        let elements =
            self.buffers.element_count() + self.history.element_count() + self.pages.capacity();
        elements * size_of::<Float4>()
    }
}

impl PaletteSource for NativeBackend {
    fn page_lengths(&self) -> Vec<usize> {
        self.pages.lengths().to_vec()
    }

    fn refuses(&self, transport: PaletteTransport, _context: &dyn GlContext) -> Option<String> {
        (transport == PaletteTransport::Shared).then(|| "it needs an OpenCL device".into())
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.pages.set_target(target, mark)
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        Ok(self.pages.release())
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
