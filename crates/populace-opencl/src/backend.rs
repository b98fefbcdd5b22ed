//! A backend that evaluates a crowd on an OpenCL device, with any schedule.

use std::sync::Arc;

use opencl3::error_codes::ClError;
use populace_device::layout::Float4;
use populace_device::{
    Backend, BackendError, Frame, GlContext, PaletteSource, PaletteTarget, PaletteTransport,
    ReleasedPalettes, Schedule, Stage, StageBuffer, Tables, TargetMark, UserStage,
};

use crate::context::FrameContext;
use crate::fused::Fused;
use crate::handles::{CommandQueue, Event, Kernel};
use crate::history::History;
use crate::launch::{Launch, WorkSize};
use crate::machines::Machines;
use crate::pages::Pages;
use crate::program::Form;
use crate::shape::DispatchShape;
use crate::staged::Staged;
use crate::tables::DeviceTables;
use crate::upload::{Copies, Uploader};
use crate::user_stages::UserStages;
use crate::{DeviceKind, OpenClDevice, waits};

/// Evaluates one crowd on an OpenCL device.
pub struct OpenClBackend {
    queue: Arc<CommandQueue>,
    schedule: Schedule,
    plan: SchedulePlan,
    user_stages: UserStages,
    tables: DeviceTables,
    uploader: Uploader,
    history: History,
    machines: Machines,
    pages: Pages,
    floors: Floors,
    /// True once a frame, or a stage of one, was enqueued.
    has_run: bool,
    // Declared last: the OpenGL context that the device may share with must outlive all other
    // fields.
    device: Arc<OpenClDevice>,
}

/// The kernels and buffers of a schedule.
enum SchedulePlan {
    Staged(Box<Staged>),
    Fused(Box<Fused>),
}

/// Kernels that write palettes with a constant, for benchmarks.
struct Floors {
    /// Built when a floor is first written.
    kernels: Vec<FloorKernel>,
    group: usize,
}

struct FloorKernel {
    kernel: Kernel,
    /// `float4`s that one work-item writes.
    per_item: usize,
}

/// Names of the kernels of [`Floors`], each with its [`FloorKernel::per_item`].
const FLOORS: [(&str, usize); 3] = [("floor_float4", 1), ("floor_matrix", 3), ("floor_run", 48)];

impl OpenClBackend {
    /// Creates a backend for one crowd on a device. [`Schedule::Fused`] picks the form that suits
    /// the device's kind. On CPUs, the environment variable `POPULACE_LANES` (4, 8 or 16) is the
    /// most members side by side in the wide form; 4 counts as 8. Results are the same.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] if memory cannot be allocated, the device fails, or
    /// `POPULACE_LANES` has another value.
    pub fn new(device: &Arc<OpenClDevice>, schedule: Schedule) -> Result<Self, BackendError> {
        Self::with_shape(device, schedule, DispatchShape::of(device)?)
    }

    fn with_shape(
        device: &Arc<OpenClDevice>,
        schedule: Schedule,
        shape: DispatchShape,
    ) -> Result<Self, BackendError> {
        let on_cpu = device.info.kind == DeviceKind::Cpu;
        let plan = match schedule {
            Schedule::Staged => SchedulePlan::Staged(Box::new(Staged::new(device, shape)?)),
            Schedule::Fused if on_cpu => {
                SchedulePlan::Fused(Box::new(Fused::wide(device, shape.lanes)?))
            }
            Schedule::FusedWide => SchedulePlan::Fused(Box::new(Fused::wide(device, shape.lanes)?)),
            Schedule::Fused | Schedule::FusedGrouped => {
                SchedulePlan::Fused(Box::new(Fused::grouped(device, shape.fused_group)?))
            }
        };
        let form = match &plan {
            SchedulePlan::Staged(_) => Staged::STAGE_KERNELS.form,
            SchedulePlan::Fused(fused) => fused.stage_kernels.form,
        };
        let group = device.group_size(shape.group);
        Ok(Self {
            queue: Arc::new(device.queue()?),
            schedule,
            plan,
            user_stages: UserStages::default(),
            tables: DeviceTables::new(device)?,
            uploader: Uploader::new(device, group)?,
            history: History::new(device)?,
            machines: Machines::new(device, form, group)?,
            pages: Pages::default(),
            has_run: false,
            floors: Floors { kernels: Vec::new(), group },
            device: Arc::clone(device),
        })
    }

    /// Returns whether all buffers of a frame suffice for the tables, as they do after an update.
    fn holds(&self, tables: &Tables) -> bool {
        let schedule_part = match &self.plan {
            SchedulePlan::Staged(staged) => {
                staged.blocks.hold(tables) && staged.buffers.hold(tables)
            }
            SchedulePlan::Fused(fused) => fused.holds(tables),
        };
        let shared = self.history.hold(tables) && self.machines.hold(tables);
        schedule_part && shared && self.tables.hold(tables) && self.pages.hold(tables)
    }

    fn check_updated(&self, tables: &Tables, operation: &str) -> Result<(), BackendError> {
        if self.holds(tables) {
            return Ok(());
        }
        let cause = "the tables grew since the last update; update first".into();
        Err(self.refused(operation, cause))
    }

    fn refused(&self, operation: &str, cause: String) -> BackendError {
        BackendError::Failed {
            device: self.device.info.name.clone(),
            operation: operation.into(),
            cause,
        }
    }

    /// Runs `work`, which enqueues launches, and flushes the queue.
    fn enqueue(
        &mut self,
        tables: &Tables,
        operation: &str,
        work: impl FnOnce(&mut SchedulePlan, &FrameContext) -> Result<(), ClError>,
    ) -> Result<(), BackendError> {
        let Self { queue, plan, pages, history, machines, .. } = self;
        let context =
            FrameContext { queue, host: tables, tables: &self.tables, history, machines, pages };
        // Some drivers start no work before a flush, and nothing here waits for the work.
        let result = work(plan, &context).and_then(|()| queue.flush());
        result.map_err(|e| self.device.failed(operation, &e))?;
        self.has_run = true;
        Ok(())
    }

    fn floor_ms(&self, floor: &FloorKernel) -> Result<f64, ClError> {
        let (mut events, group) = (Vec::new(), self.floors.group);
        for page in self.pages.iter() {
            let items = page.len().div_ceil(floor.per_item);
            let launch =
                Launch::of(&floor.kernel).buffer("palette", page).count("count", page.len());
            events.push(launch.run(&self.queue, WorkSize::of(items, group))?);
        }
        waits::for_queue(&self.queue)?;
        Ok(time_ms(&[events]).unwrap_or(0.0))
    }
}

/// Returns the device time of `runs` in milliseconds: for each run, from the start of its first
/// event to the end of its last.
fn time_ms(runs: &[Vec<Event>]) -> Option<f64> {
    runs.first()?;
    let time = |run: &Vec<Event>| {
        let start = run.first()?.profiling_command_start().ok()?;
        let end = run.last()?.profiling_command_end().ok()?;
        Some(end.saturating_sub(start) as f64 * 1e-6)
    };
    runs.iter().map(time).sum()
}

impl Backend for OpenClBackend {
    fn device_name(&self) -> String {
        let info = self.device.info();
        format!("OpenCL: {} ({})", info.name, info.driver)
    }

    fn schedule(&self) -> Schedule {
        self.schedule
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        let schedule_part: &mut dyn Copies = match &mut self.plan {
            SchedulePlan::Staged(staged) => &mut staged.blocks,
            SchedulePlan::Fused(fused) => &mut fused.lists,
        };
        self.uploader.update(
            &self.device,
            &self.queue,
            tables,
            &mut [&mut self.tables, schedule_part],
        )?;
        if let Some(kernels) = self.user_stages.next.take() {
            match &mut self.plan {
                SchedulePlan::Staged(staged) => staged.take_stages(kernels),
                SchedulePlan::Fused(fused) => fused.take_stages(kernels),
            }
        }
        match &mut self.plan {
            SchedulePlan::Staged(staged) => staged.buffers.update(&self.device, tables)?,
            SchedulePlan::Fused(fused) => fused.update(&self.device, tables)?,
        }
        self.history.update(&self.device, &self.queue, tables)?;
        self.machines.update(&self.device, &self.queue, tables)?;
        self.pages.update(&self.device, &self.queue, tables)
    }

    fn set_stages(&mut self, stages: &[Option<UserStage>]) -> Result<(), BackendError> {
        let kernels = match &self.plan {
            SchedulePlan::Staged(_) => Staged::STAGE_KERNELS,
            SchedulePlan::Fused(fused) => fused.stage_kernels,
        };
        self.user_stages.set(&self.device, kernels, stages)
    }

    fn run_stage(
        &mut self,
        tables: &Tables,
        frame: Frame,
        stage: Stage,
    ) -> Result<(), BackendError> {
        let operation = match stage {
            Stage::Evaluate => "run the stage evaluate",
            Stage::Pose => "run the stage pose",
            Stage::Transform => "run the stage transform",
            Stage::WriteBack => "run the stage write_back",
        };
        if matches!(self.plan, SchedulePlan::Fused(_)) {
            return Err(self.refused(
                operation,
                "a fused schedule has no stages; use the staged schedule".into(),
            ));
        }
        self.check_updated(tables, operation)?;
        if stage == Stage::Evaluate {
            self.machines.keep(&self.queue).map_err(|e| self.device.failed(operation, &e))?;
        }
        if stage == Stage::WriteBack {
            self.pages.begin_frame().map_err(|e| self.device.failed(operation, &e))?;
        }
        if stage == Stage::Transform && frame.begins() {
            self.history.begin_frame(&self.queue).map_err(|e| self.device.failed(operation, &e))?;
        }
        self.enqueue(tables, operation, |plan, context| match plan {
            SchedulePlan::Staged(staged) => staged.run(context, frame, stage),
            SchedulePlan::Fused(_) => Ok(()),
        })
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        if matches!(self.plan, SchedulePlan::Staged(_)) {
            let mut stages = Stage::ALL.into_iter().filter(|stage| frame.runs(*stage, tables));
            return stages.try_for_each(|stage| self.run_stage(tables, frame, stage));
        }
        const OPERATION: &str = "run a frame";
        self.check_updated(tables, OPERATION)?;
        if frame.begins() {
            let begun = self
                .pages
                .begin_frame()
                .and_then(|()| self.machines.keep(&self.queue))
                .and_then(|()| self.history.begin_frame(&self.queue));
            begun.map_err(|e| self.device.failed(OPERATION, &e))?;
        }
        self.enqueue(tables, OPERATION, |plan, context| match plan {
            SchedulePlan::Staged(_) => Ok(()),
            SchedulePlan::Fused(fused) => fused.run(context, frame),
        })
    }

    fn undo_frame(&mut self) {
        self.history.undo_frame();
        self.machines.undo_frame();
    }

    fn runs_ahead(&self) -> bool {
        true
    }

    fn read(
        &mut self,
        tables: &Tables,
        buffer: StageBuffer,
        first: usize,
        into: &mut [Float4],
    ) -> Result<(), BackendError> {
        let Self { queue, plan, pages, history, machines, device, .. } = self;
        if let Some(elements) = history.buffer(buffer) {
            let result = elements.read(queue, first, into);
            return result.map_err(|e| {
                device.failed(&format!("read {buffer:?} from element {first} on"), &e)
            });
        }
        if !self.has_run && buffer != StageBuffer::Running {
            return Err(BackendError::NotEvaluated);
        }
        let result = match plan {
            _ if buffer == StageBuffer::Palette => pages.read(queue, first, into),
            _ if buffer == StageBuffer::Running => machines.read(queue, first, into),
            SchedulePlan::Staged(staged) => staged.buffers.read(queue, buffer, first, into),
            SchedulePlan::Fused(fused) => {
                history.prepare_scratch(device, queue)?;
                let context = FrameContext {
                    queue,
                    host: tables,
                    tables: &self.tables,
                    history,
                    machines,
                    pages,
                };
                return fused.read(&context, device, buffer, first, into);
            }
        };
        result.map_err(|e| device.failed(&format!("read {buffer:?} from element {first} on"), &e))
    }

    fn write(
        &mut self,
        buffer: StageBuffer,
        first: usize,
        from: &[Float4],
    ) -> Result<(), BackendError> {
        let operation = format!("write {buffer:?} from element {first} on");
        if let Some(elements) = self.history.buffer(buffer) {
            return elements
                .write(&self.queue, first, from)
                .map_err(|e| self.device.failed(&operation, &e));
        }
        let result = match &mut self.plan {
            _ if buffer == StageBuffer::Palette => self.pages.write(&self.queue, first, from),
            _ if buffer == StageBuffer::Running => self.machines.write(&self.queue, first, from),
            SchedulePlan::Staged(staged) => staged.buffers.write(&self.queue, buffer, first, from),
            SchedulePlan::Fused(_) => {
                return Err(self.refused(
                    &operation,
                    "a fused schedule stores palettes only; use the staged schedule".into(),
                ));
            }
        };
        result.map_err(|e| self.device.failed(&operation, &e))
    }

    fn finish(&mut self) -> Result<(), BackendError> {
        waits::for_queue(&self.queue).map_err(|e| self.device.failed("finish its work", &e))
    }

    fn fetch_watched(&mut self, tables: &Tables, tick: u64) -> Result<(), BackendError> {
        let result = self.history.fetch(&self.queue, tick, tables.watched_elements());
        result.map_err(|e| self.device.failed("read the watched joints", &e))
    }

    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError> {
        self.history.fetched().map_err(|e| self.device.failed("read the watched joints", &e))
    }

    fn forget_fetched(&mut self) {
        self.history.forget_fetched();
    }

    fn waits(&self) -> u64 {
        waits::count()
    }

    fn frame_time_ms(&mut self) -> Option<f64> {
        match &self.plan {
            SchedulePlan::Staged(staged) => {
                Stage::ALL.into_iter().map(|stage| time_ms(staged.events(stage))).sum()
            }
            SchedulePlan::Fused(fused) => time_ms(fused.events()),
        }
    }

    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        let SchedulePlan::Staged(staged) = &self.plan else { return Vec::new() };
        let times =
            Stage::ALL.into_iter().map(|stage| Some((stage, time_ms(staged.events(stage))?)));
        times.flatten().collect()
    }

    fn write_floor(&mut self, _tables: &Tables) -> Result<f64, BackendError> {
        if self.floors.kernels.is_empty() {
            let build = |(name, per_item)| {
                Ok(FloorKernel { kernel: self.device.kernel(Form::Floor, "", name)?, per_item })
            };
            self.floors.kernels = FLOORS.into_iter().map(build).collect::<Result<_, _>>()?;
        }
        self.pages.begin_frame().map_err(|e| self.device.failed("write the floor", &e))?;
        let mut best = f64::INFINITY;
        for floor in &self.floors.kernels {
            let ms = self.floor_ms(floor).map_err(|e| self.device.failed("write the floor", &e))?;
            best = best.min(ms);
        }
        Ok(best)
    }

    fn memory_bytes(&self) -> usize {
        let schedule_part = match &self.plan {
            SchedulePlan::Staged(staged) => staged.blocks.bytes() + staged.buffers.bytes(),
            SchedulePlan::Fused(fused) => fused.bytes(),
        };
        let machines = self.machines.bytes();
        let shared = self.uploader.bytes() + self.history.bytes() + machines + self.pages.bytes();
        self.tables.bytes() + shared + schedule_part
    }
}

impl PaletteSource for OpenClBackend {
    fn page_lengths(&self) -> Vec<usize> {
        self.pages.lengths().to_vec()
    }

    fn refuses(&self, transport: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        self.device.refuses(transport, context)
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.pages.set_target(&self.device, &self.queue, target, mark)
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        let set = self.pages.release();
        set.map_err(|e| self.device.failed("release its palettes to OpenGL", &e))
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        if !self.has_run {
            return Err(BackendError::NotEvaluated);
        }
        let count = self.pages.lengths().len();
        if page >= count {
            let cause = format!("there is no page {page}; {count} are in use");
            return Err(self.refused("map palettes", cause));
        }
        let result = self.pages.with_page(&self.queue, page, reader);
        result.map_err(|e| self.device.failed(&format!("map page {page} of the palettes"), &e))
    }
}

#[cfg(test)]
mod tests;
