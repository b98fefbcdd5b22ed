//! The fused schedules: one kernel for the whole frame, so that nothing but palettes goes through global memory.

use opencl3::error_codes::ClError;
use opencl3::event::Event;
use opencl3::kernel::Kernel;
use populace_core::layout::{Float4, PAGE_ENTRIES, POSE_PLANES, SLOTS_MOST, SlotSample};
use populace_core::{BackendError, Frame, StageBuffer, Tables};

use crate::OpenClDevice;
use crate::backend::{On, narrow};
use crate::buffer::Buffer;
use crate::launch::Launch;
use crate::program::Form;
use crate::tables::DevicePages;

/// Work-items for each core: enough to even out their work, few enough that their matrices take little memory.
const ITEMS_PER_CORE: usize = 32;
/// A matrix in Float4s: a float16 of its own.
const MATRIX: usize = 4;

/// The kernels, and what they keep beside the tables.
pub(crate) struct Fused {
    whole: Kernel,
    joints: Kernel,
    items: usize,
    /// `model_from_joint` of the member that each work-item is at.
    matrices: Buffer<Float4>,
    /// The members of each page.
    pub(crate) lists: DevicePages,
    events: Vec<Event>,
    last_tick: u64,
    reading: Option<Reading>,
}

/// What lies between slots and palette, of one member.
struct Reading {
    place: u32,
    samples: Vec<SlotSample>,
    planes: Vec<f32>,
    matrices: Vec<Float4>,
}

impl Fused {
    pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
        Ok(Self {
            whole: device.kernel(Form::Wide, "fused_wide")?,
            joints: device.kernel(Form::Wide, "fused_wide_joints")?,
            items: device.info.compute_units as usize * ITEMS_PER_CORE,
            matrices: Buffer::new(device, 0, "an empty buffer")?,
            lists: DevicePages::new(),
            events: Vec::new(),
            last_tick: 0,
            reading: None,
        })
    }

    /// Makes room for the matrices of the largest body.
    pub(crate) fn update(&mut self, device: &OpenClDevice, tables: &Tables) -> Result<(), BackendError> {
        self.reading = None;
        if self.room_for(tables) > self.matrices.len() {
            self.matrices = Buffer::new(device, self.room_for(tables), "the matrices of members at work")?;
        }
        Ok(())
    }

    fn room_for(&self, tables: &Tables) -> usize {
        self.items * tables.padded_most() * MATRIX
    }

    /// Whether there is room for what the tables hold, as there is after an update.
    pub(crate) fn holds(&self, tables: &Tables) -> bool {
        self.room_for(tables) <= self.matrices.len() && self.lists.hold(tables)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.matrices.bytes() + self.lists.bytes()
    }

    pub(crate) fn events(&self) -> &[Event] {
        &self.events
    }

    /// Enqueues a frame.
    pub(crate) fn run(&mut self, on: &On, frame: Frame) -> Result<(), ClError> {
        self.events.clear();
        (self.last_tick, self.reading) = (frame.tick, None);
        for (page, palette) in on.pages.iter().enumerate() {
            let count = on.host.page_members(page).as_slice().len();
            if count > 0 {
                self.events.push(self.run_page(on, frame, (page, palette), count)?);
            }
        }
        Ok(())
    }

    fn run_page(
        &self,
        on: &On,
        frame: Frame,
        (page, palette): (usize, &Buffer<Float4>),
        count: usize,
    ) -> Result<Event, ClError> {
        let run = count.div_ceil(self.items);
        let tables = on.tables;
        Launch::of(&self.whole)
            .buffer("members", &tables.members.buffer)
            .buffer("page_members", &self.lists.lists[page].buffer)
            .buffer("bodies", &tables.bodies.buffer)
            .buffer("parents", &tables.parents.buffer)
            .buffer("entries", &tables.entries.buffer)
            .buffer("slots", &tables.slots.buffer)
            .buffer("layers", &tables.layers.buffer)
            .buffer("bound_clips", &tables.bound_clips.buffer)
            .buffer("bound_blocks", &tables.bound_blocks.buffer)
            .buffer("sources", &tables.sources.buffer)
            .buffer("source_lanes", &tables.source_lanes.buffer)
            .buffer("clips", &tables.clips.buffer)
            .buffer("row_blocks", &tables.row_blocks.buffer)
            .buffer("rows", &tables.rows.buffer)
            .buffer("row_times", &tables.row_times.buffer)
            .buffer("buckets", &tables.buckets.buffer)
            .buffer("poses", &tables.poses.buffer)
            .buffer("masks", &tables.masks.buffer)
            .ulong("tick", frame.tick)
            .uint("slots_per_member", narrow(on.host.slots_per_member()))
            .uint("place_first", frame.place_first)
            .uint("place_end", frame.place_end)
            .uint("page_first", narrow(page * PAGE_ENTRIES as usize))
            .uint("member_count", narrow(count))
            .uint("run", narrow(run))
            .uint("padded_most", narrow(on.host.padded_most()))
            .buffer("matrices", &self.matrices)
            .buffer("palette", palette)
            .run(on.queue, [count.div_ceil(run), 1], [1, 1])
    }

    /// Reads elements of one member's joints or samples as of the last frame.
    pub(crate) fn read(
        &mut self,
        on: &On,
        device: &OpenClDevice,
        buffer: StageBuffer,
        first: usize,
        into: &mut [Float4],
    ) -> Result<(), BackendError> {
        let past_the_end = || BackendError::Failed {
            device: device.info.name.clone(),
            operation: format!("read {buffer:?} from element {first} on"),
            cause: "it is past the end of a member".into(),
        };
        let (place, at) = on.host.place_of(buffer, first).ok_or_else(past_the_end)?;
        if self.reading.as_ref().is_none_or(|reading| reading.place != place) {
            self.reading = Some(self.evaluate_once_more(on, device, place)?);
        }
        let reading = self.reading.as_ref().ok_or_else(past_the_end)?;
        for (offset, element) in into.iter_mut().enumerate() {
            *element = reading.element(buffer, at + offset).ok_or_else(past_the_end)?;
        }
        Ok(())
    }

    fn evaluate_once_more(
        &self,
        on: &On,
        device: &OpenClDevice,
        place: u32,
    ) -> Result<Reading, BackendError> {
        let body = on.host.bodies().as_slice()[on.host.members().as_slice()[place as usize].body as usize];
        let padded = body.padded_count as usize;
        let samples = Buffer::new(device, SLOTS_MOST as usize, "a member's samples")?;
        let planes = Buffer::new(device, POSE_PLANES * padded, "a member's local transforms")?;
        let matrices = Buffer::new(device, padded * MATRIX, "a member's matrices")?;
        let mut reading = Reading {
            place,
            samples: vec![SlotSample::default(); on.host.slots_per_member()],
            planes: vec![0.0; planes.len()],
            matrices: vec![Float4::default(); body.joint_count as usize * MATRIX],
        };
        let run = self.run_joints(on, place, (&samples, &planes, &matrices));
        let read = run
            .and_then(|_| samples.read(on.queue, 0, &mut reading.samples))
            .and_then(|()| planes.read(on.queue, 0, &mut reading.planes))
            .and_then(|()| matrices.read(on.queue, 0, &mut reading.matrices));
        read.map_err(|e| device.failed("read a member's joints", &e))?;
        Ok(reading)
    }

    fn run_joints(
        &self,
        on: &On,
        place: u32,
        (samples, planes, matrices): (&Buffer<SlotSample>, &Buffer<f32>, &Buffer<Float4>),
    ) -> Result<Event, ClError> {
        let tables = on.tables;
        Launch::of(&self.joints)
            .buffer("members", &tables.members.buffer)
            .buffer("bodies", &tables.bodies.buffer)
            .buffer("parents", &tables.parents.buffer)
            .buffer("slots", &tables.slots.buffer)
            .buffer("layers", &tables.layers.buffer)
            .buffer("bound_clips", &tables.bound_clips.buffer)
            .buffer("bound_blocks", &tables.bound_blocks.buffer)
            .buffer("sources", &tables.sources.buffer)
            .buffer("source_lanes", &tables.source_lanes.buffer)
            .buffer("clips", &tables.clips.buffer)
            .buffer("row_blocks", &tables.row_blocks.buffer)
            .buffer("rows", &tables.rows.buffer)
            .buffer("row_times", &tables.row_times.buffer)
            .buffer("buckets", &tables.buckets.buffer)
            .buffer("poses", &tables.poses.buffer)
            .buffer("masks", &tables.masks.buffer)
            .ulong("tick", self.last_tick)
            .uint("slots_per_member", narrow(on.host.slots_per_member()))
            .uint("owner", place)
            .buffer("samples", samples)
            .buffer("planes", planes)
            .buffer("matrices", matrices)
            .run(on.queue, [1, 1], [1, 1])
    }
}

impl Reading {
    /// An element as the buffers of the staged schedule hold it; `None` past the member's end.
    fn element(&self, buffer: StageBuffer, at: usize) -> Option<Float4> {
        let joint_count = self.matrices.len() / MATRIX;
        if buffer == StageBuffer::Samples {
            return self.samples.get(at).map(|sample| bytemuck::cast(*sample));
        }
        if at >= joint_count {
            return None;
        }
        let padded = self.planes.len() / POSE_PLANES;
        let plane = |plane: usize| self.planes[plane * padded + at];
        let row = |row: usize| self.matrices[at * MATRIX + row];
        Some(match buffer {
            StageBuffer::Rotations => Float4([plane(0), plane(1), plane(2), plane(3)]),
            StageBuffer::Translations => Float4([plane(4), plane(5), plane(6), 0.0]),
            StageBuffer::Scales => Float4([plane(7), plane(8), plane(9), 0.0]),
            StageBuffer::ModelRow0 => row(0),
            StageBuffer::ModelRow1 => row(1),
            StageBuffer::ModelRow2 => row(2),
            StageBuffer::Samples | StageBuffer::Palette => return None,
        })
    }
}
