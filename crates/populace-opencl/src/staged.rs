//! The staged schedule: the kernels Pose, Transform and Write-Back of Lister & Day 2012, section 3,
//! with one work-item for each joint, through global memory. A small kernel evaluates slots from
//! the clock first.

use std::ops::Range;

use opencl3::error_codes::ClError;
use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{BackendError, Frame, Stage};

use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::context::FrameContext;
use crate::handles::{Event, Kernel};
use crate::history::WriteTarget;
use crate::launch::{Launch, WorkSize};
use crate::program::Form;
use crate::shape::DispatchShape;
use crate::stage_buffers::StageBuffers;
use crate::tables::DeviceBlockTables;
use crate::user_stages::StageKernels;

/// A level of the hierarchy.
#[derive(Clone, Copy)]
struct Level {
    index: usize,
    /// Joints of the widest body at this level.
    width: usize,
}

/// A page of palettes.
struct Page<'a> {
    index: usize,
    entry_count: usize,
    palette: &'a Buffer<Float4>,
}

/// The kernels and the buffers between them.
pub(crate) struct Staged {
    evaluate: Kernel,
    pose: Kernel,
    transform: Kernel,
    write_back: Kernel,
    /// Tables that only these kernels read.
    pub(crate) blocks: DeviceBlockTables,
    pub(crate) buffers: StageBuffers,
    shape: DispatchShape,
    /// Events of the last frame, for each stage and run.
    events: [Vec<Vec<Event>>; Stage::ALL.len()],
}

impl Staged {
    pub(crate) fn new(device: &OpenClDevice, shape: DispatchShape) -> Result<Self, BackendError> {
        let kernel = |name| device.kernel(Form::Staged, "", name);
        Ok(Self {
            evaluate: kernel("evaluate")?,
            pose: kernel("pose")?,
            transform: kernel("transform")?,
            write_back: kernel("write_back")?,
            blocks: DeviceBlockTables::new(device)?,
            buffers: StageBuffers::new(device)?,
            shape: DispatchShape { group: device.group_size(shape.group), ..shape },
            events: Default::default(),
        })
    }

    /// The kernels that run users' stages.
    pub(crate) const STAGE_KERNELS: StageKernels =
        StageKernels { form: Form::Staged, names: ["pose", "transform"] };

    /// Replaces those kernels by the same ones of another program.
    pub(crate) fn take_stages(&mut self, kernels: [Kernel; 2]) {
        [self.pose, self.transform] = kernels;
    }

    /// Enqueues one stage of a frame.
    pub(crate) fn run(
        &mut self,
        context: &FrameContext,
        frame: Frame,
        stage: Stage,
    ) -> Result<(), ClError> {
        let events = self.enqueue(context, frame, stage)?;
        let runs = &mut self.events[stage as usize];
        if stage != Stage::Transform || frame.begins() {
            runs.clear();
        }
        runs.push(events);
        Ok(())
    }

    /// Returns the events of the last frame's runs of a stage.
    pub(crate) fn events(&self, stage: Stage) -> &[Vec<Event>] {
        &self.events[stage as usize]
    }

    fn evaluate(&self, context: &FrameContext, frame: Frame) -> Result<Event, ClError> {
        let count = context.host.member_places() * context.host.slots_per_member();
        Launch::of(&self.evaluate)
            .buffer("slots", &context.tables.slots.buffer)
            .buffer("machine_states", &context.tables.machine_states.buffer)
            .buffer("running", &context.machines.running)
            .buffer("bound_clips", &context.tables.bound_clips.buffer)
            .buffer("clips", &context.tables.clips.buffer)
            .buffer("row_times", &context.tables.row_times.buffer)
            .buffer("buckets", &context.tables.buckets.buffer)
            .ulong("tick", frame.tick)
            .count("slot_count", count)
            .buffer("samples", &self.buffers.samples)
            .run(context.queue, WorkSize::of(count, self.shape.group))
    }

    fn pose(&self, context: &FrameContext, frame: Frame) -> Result<Event, ClError> {
        let count = context.host.joint_places();
        Launch::of(&self.pose)
            .buffer("members", &context.tables.members.buffer)
            .buffer("joint_blocks", &self.blocks.joint_blocks.buffer)
            .buffer("bodies", &context.tables.bodies.buffer)
            .buffer("slots", &context.tables.slots.buffer)
            .buffer("machine_states", &context.tables.machine_states.buffer)
            .buffer("running", &context.machines.running)
            .buffer("samples", &self.buffers.samples)
            .buffer("layers", &context.tables.layers.buffer)
            .buffer("bound_clips", &context.tables.bound_clips.buffer)
            .buffer("bound_blocks", &context.tables.bound_blocks.buffer)
            .buffer("clips", &context.tables.clips.buffer)
            .buffer("rows", &context.tables.rows.buffer)
            .buffer("poses", &context.tables.poses.buffer)
            .buffer("masks", &context.tables.masks.buffer)
            .count("slots_per_member", context.host.slots_per_member())
            .count("place_count", count)
            .uint("member_first", frame.place_first)
            .uint("member_end", frame.place_end)
            .buffer("controls", &context.tables.controls.buffer)
            .buffer("overrides", &context.tables.overrides.buffer)
            .buffer("joint_scales", &context.tables.joint_scales.buffer)
            .buffer("steps", &context.tables.steps.buffer)
            .buffer("stage_values", &context.tables.stage_values.buffer)
            .ulong("tick", frame.tick)
            .uint("elapsed_ticks", frame.elapsed_ticks)
            .buffer("translations", &self.buffers.translations)
            .buffer("rotations", &self.buffers.rotations)
            .buffer("scales", &self.buffers.scales)
            .run(context.queue, WorkSize::of(count, self.shape.group))
    }

    fn transform_level(
        &self,
        context: &FrameContext,
        frame: Frame,
        level: Level,
        members: Range<usize>,
    ) -> Result<Event, ClError> {
        let size = WorkSize::of(level.width * members.len(), self.shape.group);
        let launch = Launch::of(&self.transform)
            .buffer("members", &context.tables.members.buffer)
            .buffer("bodies", &context.tables.bodies.buffer)
            .buffer("parents", &context.tables.parents.buffer)
            .buffer("levels", &context.tables.levels.buffer)
            .count("level", level.index)
            .count("level_width", level.width)
            .count("member_first", members.start)
            .count("member_end", members.end)
            .uint("phase", frame.phase_first)
            .buffer("translations", &self.buffers.translations)
            .buffer("rotations", &self.buffers.rotations)
            .buffer("scales", &self.buffers.scales)
            .buffer("slots", &context.tables.slots.buffer)
            .buffer("machine_states", &context.tables.machine_states.buffer)
            .buffer("running", &context.machines.running)
            .buffer("layers", &context.tables.layers.buffer)
            .buffer("bound_clips", &context.tables.bound_clips.buffer)
            .buffer("clips", &context.tables.clips.buffer)
            .buffer("masks", &context.tables.masks.buffer)
            .count("slots_per_member", context.host.slots_per_member())
            .ulong("tick", frame.tick);
        context
            .history
            .parameters(launch, context.tables, frame, WriteTarget::Frame)
            .buffer("step_rotations", &self.buffers.step_rotations)
            .buffer("row0", &self.buffers.models[0])
            .buffer("row1", &self.buffers.models[1])
            .buffer("row2", &self.buffers.models[2])
            .run(context.queue, size)
    }

    fn transform(
        &self,
        context: &FrameContext,
        frame: Frame,
        mut events: Vec<Event>,
    ) -> Result<Vec<Event>, ClError> {
        let end = context.host.member_places().min(frame.place_end as usize);
        for first in (frame.place_first as usize..end).step_by(self.shape.members) {
            let members = first..first.saturating_add(self.shape.members).min(end);
            for (index, &width) in context.host.level_widths().iter().enumerate() {
                let level = Level { index, width };
                events.push(self.transform_level(context, frame, level, members.clone())?);
            }
        }
        Ok(events)
    }

    fn write_back_page(
        &self,
        context: &FrameContext,
        frame: Frame,
        page: &Page,
    ) -> Result<Event, ClError> {
        Launch::of(&self.write_back)
            .buffer("members", &context.tables.members.buffer)
            .buffer("palette_blocks", &self.blocks.palette_blocks.buffer)
            .buffer("bodies", &context.tables.bodies.buffer)
            .buffer("entries", &context.tables.entries.buffer)
            .buffer("row0", &self.buffers.models[0])
            .buffer("row1", &self.buffers.models[1])
            .buffer("row2", &self.buffers.models[2])
            .count("page_first", page.index * PAGE_ENTRIES as usize)
            .count("entry_count", page.entry_count)
            .uint("member_first", frame.place_first)
            .uint("member_end", frame.place_end)
            .buffer("palette", page.palette)
            .run(context.queue, WorkSize::of(page.entry_count, self.shape.group))
    }

    fn enqueue(
        &self,
        context: &FrameContext,
        frame: Frame,
        stage: Stage,
    ) -> Result<Vec<Event>, ClError> {
        if context.host.member_places() == 0 {
            return Ok(Vec::new());
        }
        match stage {
            Stage::Evaluate => {
                let advanced = context.advance(frame)?;
                Ok(advanced.into_iter().chain([self.evaluate(context, frame)?]).collect())
            }
            Stage::Pose => Ok(vec![self.pose(context, frame)?]),
            Stage::Transform => {
                let mut phases = frame.phases(context.host);
                phases.try_fold(Vec::new(), |events, phase| {
                    self.transform(context, frame.of_phase(phase), events)
                })
            }
            Stage::WriteBack => {
                let pages = context.host.page_lengths().zip(context.pages.iter()).enumerate();
                let write = |(index, (entry_count, palette))| {
                    self.write_back_page(context, frame, &Page { index, entry_count, palette })
                };
                pages.map(write).collect()
            }
        }
    }
}
