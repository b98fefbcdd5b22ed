//! The staged schedule: one work-item per joint, through global memory.

use std::ops::Range;
use std::sync::Arc;

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::event::Event;
use opencl3::kernel::Kernel;
use populace_core::layout::{Float4, PAGE_ENTRIES};
use populace_core::{Backend, BackendError, Frame, Stage, StageBuffer, Tables};

use crate::launch::Launch;
use crate::program::Form;
use crate::stage_buffers::StageBuffers;
use crate::tables::DeviceTables;
use crate::{DeviceKind, OpenClDevice};

/// How work is cut for a kind of device.
struct Shape {
    /// Work-items per group.
    group: usize,
    /// Members whose levels are transformed one after the other before those of the next.
    members: usize,
}

/// Groups are whole blocks of 16 joints, and a multiple of the 32 or 64 lanes that run together.
const GPU_SHAPE: Shape = Shape { group: 64, members: usize::MAX };
/// On a CPU a group is a loop on one core, and handing it over costs more than a joint does: larger groups win. The
/// joints of a run of members stay in its caches from one level to the next.
const CPU_SHAPE: Shape = Shape { group: 1024, members: 512 };

/// Evaluates crowds on an OpenCL device by the staged schedule.
pub struct OpenClBackend {
    device: Arc<OpenClDevice>,
    queue: CommandQueue,
    kernels: Kernels,
    tables: DeviceTables,
    buffers: StageBuffers,
    shape: Shape,
    /// The events of the last run of each stage.
    events: [Vec<Event>; Stage::ALL.len()],
}

struct Kernels {
    evaluate: Kernel,
    pose: Kernel,
    transform: Kernel,
    write_back: Kernel,
    /// Each with the float4s that one work-item writes.
    floors: [(Kernel, usize); 3],
}

impl OpenClBackend {
    /// A backend for one crowd on a device.
    ///
    /// # Errors
    ///
    /// Memory that cannot be had, or a failing device.
    pub fn new(device: &Arc<OpenClDevice>) -> Result<Self, BackendError> {
        Self::with_shape(device, if device.info.kind == DeviceKind::Cpu { CPU_SHAPE } else { GPU_SHAPE })
    }

    fn with_shape(device: &Arc<OpenClDevice>, shape: Shape) -> Result<Self, BackendError> {
        let kernel = |name| device.kernel(Form::Staged, name);
        Ok(Self {
            queue: device.queue()?,
            kernels: Kernels {
                evaluate: kernel("evaluate")?,
                pose: kernel("pose")?,
                transform: kernel("transform")?,
                write_back: kernel("write_back")?,
                floors: [
                    (kernel("floor_float4")?, 1),
                    (kernel("floor_matrix")?, 3),
                    (kernel("floor_run")?, 48),
                ],
            },
            tables: DeviceTables::new(device)?,
            buffers: StageBuffers::new(device)?,
            shape: Shape { group: device.group_size(shape.group), ..shape },
            events: Default::default(),
            device: Arc::clone(device),
        })
    }

    fn evaluate(&self, tables: &Tables, frame: Frame) -> Result<Event, ClError> {
        let count = tables.member_places() * tables.slots_per_member();
        Launch::of(&self.kernels.evaluate)
            .buffer("slots", &self.tables.slots.buffer)
            .buffer("bound_clips", &self.tables.bound_clips.buffer)
            .buffer("clips", &self.tables.clips.buffer)
            .buffer("row_times", &self.tables.row_times.buffer)
            .buffer("buckets", &self.tables.buckets.buffer)
            .ulong("tick", frame.tick)
            .uint("slot_count", narrow(count))
            .buffer("samples", &self.buffers.samples)
            .run(&self.queue, [count.next_multiple_of(self.shape.group), 1], [self.shape.group, 1])
    }

    fn pose(&self, tables: &Tables) -> Result<Event, ClError> {
        let count = tables.joint_places();
        Launch::of(&self.kernels.pose)
            .buffer("members", &self.tables.members.buffer)
            .buffer("joint_blocks", &self.tables.joint_blocks.buffer)
            .buffer("bodies", &self.tables.bodies.buffer)
            .buffer("slots", &self.tables.slots.buffer)
            .buffer("samples", &self.buffers.samples)
            .buffer("layers", &self.tables.layers.buffer)
            .buffer("bound_clips", &self.tables.bound_clips.buffer)
            .buffer("clips", &self.tables.clips.buffer)
            .buffer("row_blocks", &self.tables.row_blocks.buffer)
            .buffer("joint_maps", &self.tables.joint_maps.buffer)
            .buffer("rows", &self.tables.rows.buffer)
            .buffer("poses", &self.tables.poses.buffer)
            .buffer("masks", &self.tables.masks.buffer)
            .uint("slots_per_member", narrow(tables.slots_per_member()))
            .uint("place_count", narrow(count))
            .buffer("translations", &self.buffers.translations)
            .buffer("rotations", &self.buffers.rotations)
            .buffer("scales", &self.buffers.scales)
            .run(&self.queue, [count.next_multiple_of(self.shape.group), 1], [self.shape.group, 1])
    }

    fn transform_level(&self, level: usize, width: usize, members: Range<usize>) -> Result<Event, ClError> {
        // Groups hold the whole width of a level where they can, and as many members as then fit.
        let wide = width.min(self.shape.group);
        let local = [wide, (self.shape.group / wide).max(1)];
        Launch::of(&self.kernels.transform)
            .buffer("members", &self.tables.members.buffer)
            .buffer("bodies", &self.tables.bodies.buffer)
            .buffer("parents", &self.tables.parents.buffer)
            .buffer("levels", &self.tables.levels.buffer)
            .uint("level", narrow(level))
            .uint("member_first", narrow(members.start))
            .uint("member_end", narrow(members.end))
            .buffer("translations", &self.buffers.translations)
            .buffer("rotations", &self.buffers.rotations)
            .buffer("scales", &self.buffers.scales)
            .buffer("row0", &self.buffers.models[0])
            .buffer("row1", &self.buffers.models[1])
            .buffer("row2", &self.buffers.models[2])
            .run(
                &self.queue,
                [width.next_multiple_of(local[0]), members.len().next_multiple_of(local[1])],
                local,
            )
    }

    fn write_back_page(&self, page: usize, entry_count: usize) -> Result<Event, ClError> {
        Launch::of(&self.kernels.write_back)
            .buffer("members", &self.tables.members.buffer)
            .buffer("palette_blocks", &self.tables.palette_blocks.buffer)
            .buffer("bodies", &self.tables.bodies.buffer)
            .buffer("entries", &self.tables.entries.buffer)
            .buffer("row0", &self.buffers.models[0])
            .buffer("row1", &self.buffers.models[1])
            .buffer("row2", &self.buffers.models[2])
            .uint("page_first", narrow(page * PAGE_ENTRIES as usize))
            .uint("entry_count", narrow(entry_count))
            .buffer("palette", &self.buffers.pages[page])
            .run(&self.queue, [entry_count.next_multiple_of(self.shape.group), 1], [self.shape.group, 1])
    }

    fn enqueue(&self, tables: &Tables, frame: Frame, stage: Stage) -> Result<Vec<Event>, ClError> {
        if tables.member_places() == 0 {
            return Ok(Vec::new());
        }
        match stage {
            Stage::Evaluate => Ok(vec![self.evaluate(tables, frame)?]),
            Stage::Pose => Ok(vec![self.pose(tables)?]),
            Stage::Transform => {
                let (places, widths) = (tables.member_places(), tables.level_widths());
                let mut events = Vec::new();
                for first in (0..places).step_by(self.shape.members) {
                    let members = first..(first + self.shape.members).min(places);
                    for (level, &width) in widths.iter().enumerate() {
                        events.push(self.transform_level(level, width, members.clone())?);
                    }
                }
                Ok(events)
            }
            Stage::WriteBack => {
                let pages = tables.page_lengths().into_iter().enumerate();
                pages.map(|(page, entry_count)| self.write_back_page(page, entry_count)).collect()
            }
        }
    }

    /// Device time of events, from the start of the first to the end of the last, in milliseconds.
    fn time_ms(events: &[Event]) -> Option<f64> {
        let start = events.first()?.profiling_command_start().ok()?;
        let end = events.last()?.profiling_command_end().ok()?;
        Some(end.saturating_sub(start) as f64 * 1e-6)
    }

    fn floor_ms(&self, kernel: &Kernel, per_item: usize) -> Result<f64, ClError> {
        let mut events = Vec::new();
        for page in &self.buffers.pages {
            let items = page.len().div_ceil(per_item).next_multiple_of(self.shape.group);
            let launch = Launch::of(kernel).buffer("palette", page).uint("count", narrow(page.len()));
            events.push(launch.run(&self.queue, [items, 1], [self.shape.group, 1])?);
        }
        self.queue.finish()?;
        Ok(Self::time_ms(&events).unwrap_or(0.0))
    }
}

/// Counts that tables hold below 2^32.
#[expect(clippy::cast_possible_truncation, reason = "tables refuse to grow past 32 bits")]
fn narrow(count: usize) -> u32 {
    debug_assert!(u32::try_from(count).is_ok());
    count as u32
}

impl Backend for OpenClBackend {
    fn device_name(&self) -> String {
        let info = self.device.info();
        format!("OpenCL: {} ({})", info.name, info.driver)
    }

    fn schedule(&self) -> &'static str {
        "staged"
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        self.tables.update(&self.device, &self.queue, tables)?;
        self.buffers.update(&self.device, tables)
    }

    fn run_stage(&mut self, tables: &Tables, frame: Frame, stage: Stage) -> Result<(), BackendError> {
        if !(self.tables.hold(tables) && self.buffers.hold(tables)) {
            let (device, operation) =
                (self.device.info.name.clone(), format!("run the stage {}", stage.name()));
            let cause = "the tables grew since the last update; update first".into();
            return Err(BackendError::Failed { device, operation, cause });
        }
        let events = self.enqueue(tables, frame, stage);
        self.events[stage as usize] =
            events.map_err(|e| self.device.failed(&format!("run the stage {}", stage.name()), &e))?;
        Ok(())
    }

    fn read(&mut self, buffer: StageBuffer, first: usize, into: &mut [Float4]) -> Result<(), BackendError> {
        let result = self.buffers.read(&self.queue, buffer, first, into);
        result.map_err(|e| self.device.failed(&format!("read {buffer:?} from element {first} on"), &e))
    }

    fn write(&mut self, buffer: StageBuffer, first: usize, from: &[Float4]) -> Result<(), BackendError> {
        let result = self.buffers.write(&self.queue, buffer, first, from);
        result.map_err(|e| self.device.failed(&format!("write {buffer:?} from element {first} on"), &e))
    }

    fn with_page(&mut self, page: usize, reader: &mut dyn FnMut(&[Float4])) -> Result<(), BackendError> {
        const INVALID_BUFFER: i32 = -38;
        let result = match self.buffers.pages.get_mut(page) {
            Some(palettes) => palettes.map(&self.queue, reader),
            None => Err(ClError(INVALID_BUFFER)),
        };
        result.map_err(|e| self.device.failed(&format!("hand over page {page} of the palettes"), &e))
    }

    fn finish(&mut self) -> Result<(), BackendError> {
        self.queue.finish().map_err(|e| self.device.failed("finish its work", &e))
    }

    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        let times =
            Stage::ALL.into_iter().map(|stage| Some((stage, Self::time_ms(&self.events[stage as usize])?)));
        times.flatten().collect()
    }

    fn write_floor(&mut self, _tables: &Tables) -> Result<f64, BackendError> {
        let mut best = f64::INFINITY;
        for (kernel, per_item) in &self.kernels.floors {
            let ms =
                self.floor_ms(kernel, *per_item).map_err(|e| self.device.failed("write the floor", &e))?;
            best = best.min(ms);
        }
        Ok(best)
    }

    fn memory_bytes(&self) -> usize {
        self.tables.bytes() + self.buffers.bytes()
    }
}

#[cfg(test)]
mod tests;
