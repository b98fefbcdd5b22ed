//! A crowd on an OpenCL device, by any schedule.

use std::sync::Arc;

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::event::Event;
use opencl3::kernel::Kernel;
use populace_device::layout::Float4;
use populace_device::{
    Backend, BackendError, Frame, GlContext, HandedOver, PaletteSource, PaletteTarget,
    PaletteTransport, Schedule, Stage, StageBuffer, Tables, TargetMark, UserStage,
};

use crate::fused::Fused;
use crate::keeping::Keeping;
use crate::launch::Launch;
use crate::machines::Machines;
use crate::pages::Pages;
use crate::program::Form;
use crate::staged::{CPU_SHAPE, GPU_SHAPE, Shape, Staged};
use crate::tables::DeviceTables;
use crate::upload::{Copies, Uploader};
use crate::user_stages::UserStages;
use crate::{DeviceKind, OpenClDevice, waits};

/// Evaluates crowds on an OpenCL device.
pub struct OpenClBackend {
    queue: Arc<CommandQueue>,
    schedule: Schedule,
    plan: Plan,
    user_stages: UserStages,
    tables: DeviceTables,
    uploader: Uploader,
    keeping: Keeping,
    machines: Machines,
    pages: Pages,
    floors: Floors,
    /// Whether a frame, or a stage of one, was enqueued.
    has_run: bool,
    // Declared last: a context of OpenGL's that it was made for must outlive everything above.
    device: Arc<OpenClDevice>,
}

/// What a schedule keeps beside tables and palettes.
enum Plan {
    Staged(Box<Staged>),
    Fused(Box<Fused>),
}

/// What a schedule's launches work on.
pub(crate) struct On<'a> {
    pub(crate) queue: &'a CommandQueue,
    pub(crate) host: &'a Tables,
    pub(crate) tables: &'a DeviceTables,
    pub(crate) keeping: &'a Keeping,
    pub(crate) machines: &'a Machines,
    pub(crate) pages: &'a Pages,
}

/// Ways to write palettes with a constant.
struct Floors {
    /// Each with the float4s that one work-item writes; built when a floor is first written.
    kernels: Vec<(Kernel, usize)>,
    group: usize,
}

/// The kernels of [`Floors`], each with the float4s that one work-item writes.
const FLOORS: [(&str, usize); 3] = [("floor_float4", 1), ("floor_matrix", 3), ("floor_run", 48)];

impl OpenClBackend {
    /// A backend for one crowd on a device. [`Schedule::Fused`] takes the form that suits its kind.
    ///
    /// # Errors
    ///
    /// Memory that cannot be had, or a failing device.
    pub fn new(device: &Arc<OpenClDevice>, schedule: Schedule) -> Result<Self, BackendError> {
        Self::with_shape(device, schedule, Shape::of(device.info.kind))
    }

    fn with_shape(
        device: &Arc<OpenClDevice>,
        schedule: Schedule,
        shape: Shape,
    ) -> Result<Self, BackendError> {
        let on_cpu = device.info.kind == DeviceKind::Cpu;
        let plan = match schedule {
            Schedule::Staged => Plan::Staged(Box::new(Staged::new(device, shape)?)),
            Schedule::Fused if on_cpu => Plan::Fused(Box::new(Fused::wide(device)?)),
            Schedule::FusedWide => Plan::Fused(Box::new(Fused::wide(device)?)),
            Schedule::Fused | Schedule::FusedGrouped => {
                Plan::Fused(Box::new(Fused::grouped(device, shape.group.min(GPU_SHAPE.group))?))
            }
        };
        let form = match &plan {
            Plan::Staged(_) => Staged::STAGE_KERNELS.0,
            Plan::Fused(fused) => fused.stage_kernels.0,
        };
        let group = device.group_size(shape.group);
        Ok(Self {
            queue: Arc::new(device.queue()?),
            schedule,
            plan,
            user_stages: UserStages::default(),
            tables: DeviceTables::new(device)?,
            uploader: Uploader::new(device, group)?,
            keeping: Keeping::new(device)?,
            machines: Machines::new(device, form, group)?,
            pages: Pages::default(),
            has_run: false,
            floors: Floors { kernels: Vec::new(), group },
            device: Arc::clone(device),
        })
    }

    /// Whether all that a frame reads and writes has room here, as it has after an update.
    fn holds(&self, tables: &Tables) -> bool {
        let beside = match &self.plan {
            Plan::Staged(staged) => staged.blocks.hold(tables) && staged.buffers.hold(tables),
            Plan::Fused(fused) => fused.holds(tables),
        };
        let kept = self.keeping.hold(tables) && self.machines.hold(tables);
        beside && kept && self.tables.hold(tables) && self.pages.hold(tables)
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

    /// Lets a schedule enqueue its work.
    fn enqueue(
        &mut self,
        tables: &Tables,
        operation: &str,
        work: impl FnOnce(&mut Plan, &On) -> Result<(), ClError>,
    ) -> Result<(), BackendError> {
        let Self { queue, plan, pages, keeping, machines, .. } = self;
        let on = On { queue, host: tables, tables: &self.tables, keeping, machines, pages };
        // Some drivers start nothing before they are told to, and nothing here waits.
        let result = work(plan, &on).and_then(|()| queue.flush());
        result.map_err(|e| self.device.failed(operation, &e))?;
        self.has_run = true;
        Ok(())
    }

    fn floor_ms(&self, kernel: &Kernel, per_item: usize) -> Result<f64, ClError> {
        let (mut events, group) = (Vec::new(), self.floors.group);
        for page in self.pages.iter() {
            let items = page.len().div_ceil(per_item).next_multiple_of(group);
            let launch =
                Launch::of(kernel).buffer("palette", page).uint("count", narrow(page.len()));
            events.push(launch.run(&self.queue, [items, 1], [group, 1])?);
        }
        waits::for_queue(&self.queue)?;
        Ok(time_ms(&[events]).unwrap_or(0.0))
    }
}

impl Shape {
    fn of(kind: DeviceKind) -> Self {
        if kind == DeviceKind::Cpu { CPU_SHAPE } else { GPU_SHAPE }
    }
}

/// Device time of runs, each from the start of its first event to the end of its last, in
/// milliseconds.
fn time_ms(runs: &[Vec<Event>]) -> Option<f64> {
    runs.first()?;
    let time = |run: &Vec<Event>| {
        let start = run.first()?.profiling_command_start().ok()?;
        let end = run.last()?.profiling_command_end().ok()?;
        Some(end.saturating_sub(start) as f64 * 1e-6)
    };
    runs.iter().map(time).sum()
}

/// Counts that tables hold below 2^32.
#[expect(clippy::cast_possible_truncation, reason = "tables refuse to grow past 32 bits")]
pub(crate) fn narrow(count: usize) -> u32 {
    debug_assert!(u32::try_from(count).is_ok());
    count as u32
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
        let beside: &mut dyn Copies = match &mut self.plan {
            Plan::Staged(staged) => &mut staged.blocks,
            Plan::Fused(fused) => &mut fused.lists,
        };
        self.uploader.update(&self.device, &self.queue, tables, &mut [&mut self.tables, beside])?;
        if let Some(kernels) = self.user_stages.next.take() {
            match &mut self.plan {
                Plan::Staged(staged) => staged.take_stages(kernels),
                Plan::Fused(fused) => fused.take_stages(kernels),
            }
        }
        match &mut self.plan {
            Plan::Staged(staged) => staged.buffers.update(&self.device, tables)?,
            Plan::Fused(fused) => fused.update(&self.device, tables)?,
        }
        self.keeping.update(&self.device, &self.queue, tables)?;
        self.machines.update(&self.device, &self.queue, tables)?;
        self.pages.update(&self.device, tables)
    }

    fn set_stages(&mut self, stages: &[Option<UserStage>]) -> Result<(), BackendError> {
        let kernels = match &self.plan {
            Plan::Staged(_) => Staged::STAGE_KERNELS,
            Plan::Fused(fused) => fused.stage_kernels,
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
        if matches!(self.plan, Plan::Fused(_)) {
            return Err(self
                .refused(operation, "a fused schedule has no stages; run the staged one".into()));
        }
        self.check_updated(tables, operation)?;
        if stage == Stage::WriteBack {
            self.pages.begin_frame().map_err(|e| self.device.failed(operation, &e))?;
        }
        if stage == Stage::Transform && frame.begins() {
            self.keeping.begin_frame(&self.queue).map_err(|e| self.device.failed(operation, &e))?;
        }
        self.enqueue(tables, operation, |plan, on| match plan {
            Plan::Staged(staged) => staged.run(on, frame, stage),
            Plan::Fused(_) => Ok(()),
        })
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        if matches!(self.plan, Plan::Staged(_)) {
            let mut stages = Stage::ALL.into_iter().filter(|stage| frame.runs(*stage, tables));
            return stages.try_for_each(|stage| self.run_stage(tables, frame, stage));
        }
        const OPERATION: &str = "run a frame";
        self.check_updated(tables, OPERATION)?;
        if frame.begins() {
            let begun =
                self.pages.begin_frame().and_then(|()| self.keeping.begin_frame(&self.queue));
            begun.map_err(|e| self.device.failed(OPERATION, &e))?;
        }
        self.enqueue(tables, OPERATION, |plan, on| match plan {
            Plan::Staged(_) => Ok(()),
            Plan::Fused(fused) => fused.run(on, frame),
        })
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
        let Self { queue, plan, pages, keeping, machines, device, .. } = self;
        if let Some(kept) = keeping.buffer(buffer) {
            let result = kept.read(queue, first, into);
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
            Plan::Staged(staged) => staged.buffers.read(queue, buffer, first, into),
            Plan::Fused(fused) => {
                keeping.prepare_aside(device, queue)?;
                let on = On { queue, host: tables, tables: &self.tables, keeping, machines, pages };
                return fused.read(&on, device, buffer, first, into);
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
        if let Some(kept) = self.keeping.buffer(buffer) {
            return kept
                .write(&self.queue, first, from)
                .map_err(|e| self.device.failed(&operation, &e));
        }
        let result = match &mut self.plan {
            _ if buffer == StageBuffer::Palette => self.pages.write(&self.queue, first, from),
            _ if buffer == StageBuffer::Running => self.machines.write(&self.queue, first, from),
            Plan::Staged(staged) => staged.buffers.write(&self.queue, buffer, first, from),
            Plan::Fused(_) => {
                return Err(self.refused(&operation, "a fused schedule keeps palettes only".into()));
            }
        };
        result.map_err(|e| self.device.failed(&operation, &e))
    }

    fn finish(&mut self) -> Result<(), BackendError> {
        waits::for_queue(&self.queue).map_err(|e| self.device.failed("finish its work", &e))
    }

    fn fetch_watched(&mut self, tables: &Tables, tick: u64) -> Result<(), BackendError> {
        let result = self.keeping.fetch(&self.queue, tick, tables.watched_elements());
        result.map_err(|e| self.device.failed("bring what is watched to the host", &e))
    }

    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError> {
        self.keeping
            .fetched()
            .map_err(|e| self.device.failed("bring what is watched to the host", &e))
    }

    fn waits(&self) -> u64 {
        waits::count()
    }

    fn frame_time_ms(&mut self) -> Option<f64> {
        match &self.plan {
            Plan::Staged(staged) => {
                Stage::ALL.into_iter().map(|stage| time_ms(staged.events(stage))).sum()
            }
            Plan::Fused(fused) => time_ms(fused.events()),
        }
    }

    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        let Plan::Staged(staged) = &self.plan else { return Vec::new() };
        let times =
            Stage::ALL.into_iter().map(|stage| Some((stage, time_ms(staged.events(stage))?)));
        times.flatten().collect()
    }

    fn write_floor(&mut self, _tables: &Tables) -> Result<f64, BackendError> {
        if self.floors.kernels.is_empty() {
            let kernel =
                |(name, float4s)| Ok((self.device.kernel(Form::Floor, "", name)?, float4s));
            self.floors.kernels = FLOORS.into_iter().map(kernel).collect::<Result<_, _>>()?;
        }
        self.pages.begin_frame().map_err(|e| self.device.failed("write the floor", &e))?;
        let mut best = f64::INFINITY;
        for (kernel, per_item) in &self.floors.kernels {
            let ms = self
                .floor_ms(kernel, *per_item)
                .map_err(|e| self.device.failed("write the floor", &e))?;
            best = best.min(ms);
        }
        Ok(best)
    }

    fn memory_bytes(&self) -> usize {
        let beside = match &self.plan {
            Plan::Staged(staged) => staged.blocks.bytes() + staged.buffers.bytes(),
            Plan::Fused(fused) => fused.bytes(),
        };
        let machines = self.machines.running.bytes();
        let kept = self.uploader.bytes() + self.keeping.bytes() + machines + self.pages.bytes();
        self.tables.bytes() + kept + beside
    }
}

impl PaletteSource for OpenClBackend {
    fn page_lengths(&self) -> Vec<usize> {
        self.pages.lengths().to_vec()
    }

    fn refuses(&self, way: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        self.device.refuses(way, context)
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.pages.set_target(&self.device, &self.queue, target, mark)
    }

    fn hand_over(&mut self) -> Result<Option<HandedOver>, BackendError> {
        let handed = self.pages.hand_over();
        handed.map_err(|e| self.device.failed("hand its palettes to OpenGL", &e))
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
            return Err(self.refused("hand over palettes", cause));
        }
        let result = self.pages.with_page(&self.queue, page, reader);
        result
            .map_err(|e| self.device.failed(&format!("hand over page {page} of the palettes"), &e))
    }
}

#[cfg(test)]
mod tests;
