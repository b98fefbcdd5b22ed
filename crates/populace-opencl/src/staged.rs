//! The staged schedule: the kernels Pose, Transform and Write-Back of Lister & Day 2012, section 3,
//! one work-item per joint, through global memory, after a small kernel that evaluates slots from
//! the clock.

use std::ops::Range;

use opencl3::error_codes::ClError;
use opencl3::event::Event;
use opencl3::kernel::Kernel;
use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{BackendError, Frame, Stage};

use crate::OpenClDevice;
use crate::backend::{On, narrow};
use crate::buffer::Buffer;
use crate::keeping::Writes;
use crate::launch::Launch;
use crate::program::Form;
use crate::stage_buffers::StageBuffers;
use crate::tables::DeviceBlockTables;

/// How work is cut for a kind of device.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    /// Work-items per group.
    pub(crate) group: usize,
    /// Members whose levels are transformed one after the other before those of the next.
    members: usize,
}

/// Groups are whole blocks of 16 joints, and a multiple of the 32 or 64 lanes that run together.
pub(crate) const GPU_SHAPE: Shape = Shape { group: 64, members: usize::MAX };
/// On a CPU a group is a loop on one core, and handing it over costs more than a joint does: larger
/// groups win. The joints of a run of members stay in its caches from one level to the next.
pub(crate) const CPU_SHAPE: Shape = Shape { group: 1024, members: 512 };

/// The kernels and what stands between them.
pub(crate) struct Staged {
    evaluate: Kernel,
    pose: Kernel,
    transform: Kernel,
    write_back: Kernel,
    /// Read by these kernels alone.
    pub(crate) blocks: DeviceBlockTables,
    pub(crate) buffers: StageBuffers,
    shape: Shape,
    /// The events of the last frame's runs of each stage.
    events: [Vec<Vec<Event>>; Stage::ALL.len()],
}

impl Staged {
    pub(crate) fn new(device: &OpenClDevice, shape: Shape) -> Result<Self, BackendError> {
        let kernel = |name| device.kernel(Form::Staged, "", name);
        Ok(Self {
            evaluate: kernel("evaluate")?,
            pose: kernel("pose")?,
            transform: kernel("transform")?,
            write_back: kernel("write_back")?,
            blocks: DeviceBlockTables::new(device)?,
            buffers: StageBuffers::new(device)?,
            shape: Shape { group: device.group_size(shape.group), ..shape },
            events: Default::default(),
        })
    }

    /// Kernels that run users' stages.
    pub(crate) const STAGE_KERNELS: (Form, [&str; 2]) = (Form::Staged, ["pose", "transform"]);

    /// Takes those of another program.
    pub(crate) fn take_stages(&mut self, kernels: [Kernel; 2]) {
        [self.pose, self.transform] = kernels;
    }

    /// Enqueues a stage.
    pub(crate) fn run(&mut self, on: &On, frame: Frame, stage: Stage) -> Result<(), ClError> {
        let events = self.enqueue(on, frame, stage)?;
        let runs = &mut self.events[stage as usize];
        if stage != Stage::Transform || frame.begins() {
            runs.clear();
        }
        runs.push(events);
        Ok(())
    }

    /// The events of the last frame's runs of a stage.
    pub(crate) fn events(&self, stage: Stage) -> &[Vec<Event>] {
        &self.events[stage as usize]
    }

    fn evaluate(&self, on: &On, frame: Frame) -> Result<Event, ClError> {
        let count = on.host.member_places() * on.host.slots_per_member();
        Launch::of(&self.evaluate)
            .buffer("slots", &on.tables.slots.buffer)
            .buffer("machine_states", &on.tables.machine_states.buffer)
            .buffer("running", &on.machines.running)
            .buffer("bound_clips", &on.tables.bound_clips.buffer)
            .buffer("clips", &on.tables.clips.buffer)
            .buffer("row_times", &on.tables.row_times.buffer)
            .buffer("buckets", &on.tables.buckets.buffer)
            .ulong("tick", frame.tick)
            .uint("slot_count", narrow(count))
            .buffer("samples", &self.buffers.samples)
            .run(on.queue, [count.next_multiple_of(self.shape.group), 1], [self.shape.group, 1])
    }

    fn pose(&self, on: &On, frame: Frame) -> Result<Event, ClError> {
        let count = on.host.joint_places();
        Launch::of(&self.pose)
            .buffer("members", &on.tables.members.buffer)
            .buffer("joint_blocks", &self.blocks.joint_blocks.buffer)
            .buffer("bodies", &on.tables.bodies.buffer)
            .buffer("slots", &on.tables.slots.buffer)
            .buffer("machine_states", &on.tables.machine_states.buffer)
            .buffer("running", &on.machines.running)
            .buffer("samples", &self.buffers.samples)
            .buffer("layers", &on.tables.layers.buffer)
            .buffer("bound_clips", &on.tables.bound_clips.buffer)
            .buffer("bound_blocks", &on.tables.bound_blocks.buffer)
            .buffer("clips", &on.tables.clips.buffer)
            .buffer("row_blocks", &on.tables.row_blocks.buffer)
            .buffer("joint_maps", &on.tables.joint_maps.buffer)
            .buffer("rows", &on.tables.rows.buffer)
            .buffer("poses", &on.tables.poses.buffer)
            .buffer("masks", &on.tables.masks.buffer)
            .uint("slots_per_member", narrow(on.host.slots_per_member()))
            .uint("place_count", narrow(count))
            .uint("member_first", frame.place_first)
            .uint("member_end", frame.place_end)
            .buffer("controls", &on.tables.controls.buffer)
            .buffer("overrides", &on.tables.overrides.buffer)
            .buffer("joint_scales", &on.tables.joint_scales.buffer)
            .buffer("steps", &on.tables.steps.buffer)
            .buffer("stage_values", &on.tables.stage_values.buffer)
            .ulong("tick", frame.tick)
            .uint("elapsed_ticks", frame.elapsed_ticks)
            .buffer("translations", &self.buffers.translations)
            .buffer("rotations", &self.buffers.rotations)
            .buffer("scales", &self.buffers.scales)
            .run(on.queue, [count.next_multiple_of(self.shape.group), 1], [self.shape.group, 1])
    }

    fn transform_level(
        &self,
        on: &On,
        frame: Frame,
        (level, width): (usize, usize),
        members: Range<usize>,
    ) -> Result<Event, ClError> {
        // Groups hold the whole width of a level where they can, and as many members as then fit.
        let wide = width.min(self.shape.group);
        let local = [wide, (self.shape.group / wide).max(1)];
        let launch = Launch::of(&self.transform)
            .buffer("members", &on.tables.members.buffer)
            .buffer("bodies", &on.tables.bodies.buffer)
            .buffer("parents", &on.tables.parents.buffer)
            .buffer("levels", &on.tables.levels.buffer)
            .uint("level", narrow(level))
            .uint("member_first", narrow(members.start))
            .uint("member_end", narrow(members.end))
            .uint("phase", frame.phase_first)
            .buffer("translations", &self.buffers.translations)
            .buffer("rotations", &self.buffers.rotations)
            .buffer("scales", &self.buffers.scales)
            .buffer("slots", &on.tables.slots.buffer)
            .buffer("machine_states", &on.tables.machine_states.buffer)
            .buffer("running", &on.machines.running)
            .buffer("layers", &on.tables.layers.buffer)
            .buffer("bound_clips", &on.tables.bound_clips.buffer)
            .buffer("clips", &on.tables.clips.buffer)
            .buffer("masks", &on.tables.masks.buffer)
            .uint("slots_per_member", narrow(on.host.slots_per_member()))
            .ulong("tick", frame.tick);
        on.keeping
            .parameters(launch, on.tables, frame, Writes::Frame)
            .buffer("turns", &self.buffers.turns)
            .buffer("row0", &self.buffers.models[0])
            .buffer("row1", &self.buffers.models[1])
            .buffer("row2", &self.buffers.models[2])
            .run(
                on.queue,
                [width.next_multiple_of(local[0]), members.len().next_multiple_of(local[1])],
                local,
            )
    }

    fn transform(
        &self,
        on: &On,
        frame: Frame,
        mut events: Vec<Event>,
    ) -> Result<Vec<Event>, ClError> {
        let end = on.host.member_places().min(frame.place_end as usize);
        for first in (frame.place_first as usize..end).step_by(self.shape.members) {
            let members = first..first.saturating_add(self.shape.members).min(end);
            for (level, &width) in on.host.level_widths().iter().enumerate() {
                events.push(self.transform_level(on, frame, (level, width), members.clone())?);
            }
        }
        Ok(events)
    }

    fn write_back_page(
        &self,
        on: &On,
        frame: Frame,
        page: usize,
        entry_count: usize,
        palette: &Buffer<Float4>,
    ) -> Result<Event, ClError> {
        Launch::of(&self.write_back)
            .buffer("members", &on.tables.members.buffer)
            .buffer("palette_blocks", &self.blocks.palette_blocks.buffer)
            .buffer("bodies", &on.tables.bodies.buffer)
            .buffer("entries", &on.tables.entries.buffer)
            .buffer("row0", &self.buffers.models[0])
            .buffer("row1", &self.buffers.models[1])
            .buffer("row2", &self.buffers.models[2])
            .uint("page_first", narrow(page * PAGE_ENTRIES as usize))
            .uint("entry_count", narrow(entry_count))
            .uint("member_first", frame.place_first)
            .uint("member_end", frame.place_end)
            .buffer("palette", palette)
            .run(
                on.queue,
                [entry_count.next_multiple_of(self.shape.group), 1],
                [self.shape.group, 1],
            )
    }

    fn enqueue(&self, on: &On, frame: Frame, stage: Stage) -> Result<Vec<Event>, ClError> {
        if on.host.member_places() == 0 {
            return Ok(Vec::new());
        }
        match stage {
            Stage::Evaluate => {
                let advanced = on.machines.advance(on, frame)?;
                Ok(advanced.into_iter().chain([self.evaluate(on, frame)?]).collect())
            }
            Stage::Pose => Ok(vec![self.pose(on, frame)?]),
            Stage::Transform => {
                let mut phases = frame.phases(on.host);
                phases.try_fold(Vec::new(), |events, phase| {
                    self.transform(on, frame.of_phase(phase), events)
                })
            }
            Stage::WriteBack => {
                let pages = on.host.page_lengths().zip(on.pages.iter()).enumerate();
                let write = |(page, (count, palette))| {
                    self.write_back_page(on, frame, page, count, palette)
                };
                pages.map(write).collect()
            }
        }
    }
}
