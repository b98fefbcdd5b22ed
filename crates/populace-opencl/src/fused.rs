//! The fused schedules: one kernel for the whole frame, so that nothing but palettes goes through
//! global memory.

mod reading;
mod spread;

use opencl3::error_codes::ClError;
use opencl3::event::Event;
use opencl3::kernel::Kernel;
use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{BackendError, Frame, StageBuffer, Tables};

use crate::OpenClDevice;
use crate::backend::{On, narrow};
use crate::buffer::Buffer;
use crate::keeping::Writes;
use crate::launch::Launch;
use crate::program::Form;
use crate::tables::DevicePages;
use reading::{Reading, Sheet};
use spread::Spread;

/// A matrix in Float4s: a float16 of its own.
const MATRIX: usize = 4;
/// The kernels of a whole frame, and of one member's joints.
const WIDE: [&str; 2] = ["fused_wide", "fused_wide_joints"];
const GROUPED: [&str; 2] = ["fused_grouped", "fused_grouped_joints"];

/// The kernels, and what they keep beside the tables.
pub(crate) struct Fused {
    /// Kernels that run users' stages: those below.
    pub(crate) stage_kernels: (Form, [&'static str; 2]),
    whole: Kernel,
    joints: Kernel,
    spread: Spread,
    /// The members of each page.
    pub(crate) lists: DevicePages,
    /// Of the last frame's runs.
    events: Vec<Vec<Event>>,
    last: Frame,
    reading: Option<Reading>,
}

impl Fused {
    /// For CPUs: sixteen joints at a time.
    pub(crate) fn wide(device: &OpenClDevice) -> Result<Self, BackendError> {
        let kernel = |name| device.kernel(Form::Wide, "", name);
        let kernels = [kernel(WIDE[0])?, kernel(WIDE[1])?];
        Ok(Self::of((Form::Wide, WIDE), kernels, Spread::wide(device)?))
    }

    /// For GPUs: so many work-items for each member, or as many as the device allows.
    pub(crate) fn grouped(device: &OpenClDevice, wished: usize) -> Result<Self, BackendError> {
        let group = device.group_size(wished);
        let form = Form::Grouped { group };
        let kernel = |name| device.kernel(form, "", name);
        let kernels = [kernel(GROUPED[0])?, kernel(GROUPED[1])?];
        let spread = Spread::grouped(device, &kernels[0], group)?;
        Ok(Self::of((form, GROUPED), kernels, spread))
    }

    fn of(
        stage_kernels: (Form, [&'static str; 2]),
        [whole, joints]: [Kernel; 2],
        spread: Spread,
    ) -> Self {
        let (lists, events, last) = (DevicePages::new(), Vec::new(), Frame::of_all(0));
        Self { stage_kernels, whole, joints, spread, lists, events, last, reading: None }
    }

    /// Takes kernels of another program.
    pub(crate) fn take_stages(&mut self, [whole, joints]: [Kernel; 2]) {
        (self.whole, self.joints) = (whole, joints);
    }

    /// Makes room for the matrices of the largest body.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        self.reading = None;
        self.spread.update(device, tables)
    }

    /// Whether there is room for what the tables hold, as there is after an update.
    pub(crate) fn holds(&self, tables: &Tables) -> bool {
        self.spread.holds(tables) && self.lists.hold(tables)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.spread.bytes() + self.lists.bytes()
    }

    pub(crate) fn events(&self) -> &[Vec<Event>] {
        &self.events
    }

    #[cfg(test)]
    pub(crate) fn kernel_name(&self) -> String {
        self.whole.function_name().unwrap_or_default()
    }

    /// Enqueues a frame's phases.
    pub(crate) fn run(&mut self, on: &On, frame: Frame) -> Result<(), ClError> {
        let mut events = Vec::new();
        if frame.begins() {
            self.events.clear();
            events.extend(on.machines.advance(on, frame)?);
        }
        (self.last, self.reading) = (frame, None);
        for phase in frame.phases(on.host) {
            for (page, palette) in on.pages.iter().enumerate() {
                let count = on.host.page_members(page).as_slice().len();
                if count > 0 {
                    events.push(self.run_page(
                        on,
                        frame.of_phase(phase),
                        (page, palette),
                        count,
                    )?);
                }
            }
        }
        self.events.push(events);
        Ok(())
    }

    fn run_page(
        &self,
        on: &On,
        frame: Frame,
        (page, palette): (usize, &Buffer<Float4>),
        count: usize,
    ) -> Result<Event, ClError> {
        let launch = self
            .launch(on, &self.whole, frame, Writes::Frame)
            .buffer("page_members", &self.lists.lists[page].buffer)
            .buffer("entries", &on.tables.entries.buffer)
            .uint("place_first", frame.place_first)
            .uint("place_end", frame.place_end)
            .uint("phase", frame.phase_first)
            .uint("page_first", narrow(page * PAGE_ENTRIES as usize))
            .buffer("palette", palette);
        let (launch, (global, local)) = self.spread.frame(launch, on.host, count);
        launch.run(on.queue, global, local)
    }

    /// What all kernels read.
    fn launch<'a>(&self, on: &On, kernel: &'a Kernel, frame: Frame, writes: Writes) -> Launch<'a> {
        let tables = on.tables;
        let launch = Launch::of(kernel)
            .buffer("members", &tables.members.buffer)
            .buffer("bodies", &tables.bodies.buffer)
            .buffer("parents", &tables.parents.buffer)
            .buffer("slots", &tables.slots.buffer)
            .buffer("machine_states", &tables.machine_states.buffer)
            .buffer("running", &on.machines.running)
            .buffer("layers", &tables.layers.buffer)
            .buffer("bound_clips", &tables.bound_clips.buffer)
            .buffer("bound_blocks", &tables.bound_blocks.buffer)
            .buffer("clips", &tables.clips.buffer)
            .buffer("row_blocks", &tables.row_blocks.buffer)
            .buffer("rows", &tables.rows.buffer)
            .buffer("row_times", &tables.row_times.buffer)
            .buffer("buckets", &tables.buckets.buffer)
            .buffer("poses", &tables.poses.buffer)
            .buffer("masks", &tables.masks.buffer);
        let launch = self
            .spread
            .tables(launch, tables)
            .ulong("tick", frame.tick)
            .uint("slots_per_member", narrow(on.host.slots_per_member()))
            .buffer("joint_scales", &tables.joint_scales.buffer);
        on.keeping.parameters(launch, tables, frame, writes)
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
            let sheet = Sheet::new(device, on.host, place)?;
            self.run_joints(on, place, &sheet)
                .map_err(|e| device.failed("read a member's joints", &e))?;
            self.reading = Some(sheet.read(on, device, place)?);
        }
        let reading = self.reading.as_ref().ok_or_else(past_the_end)?;
        for (offset, element) in into.iter_mut().enumerate() {
            *element = reading.element(buffer, at + offset).ok_or_else(past_the_end)?;
        }
        Ok(())
    }

    fn run_joints(&self, on: &On, place: u32, sheet: &Sheet) -> Result<Event, ClError> {
        let launch = self
            .launch(on, &self.joints, self.last, Writes::Aside)
            .uint("owner", place)
            .buffer("samples", &sheet.samples)
            .buffer("planes", &sheet.planes)
            .buffer("matrices", &sheet.matrices);
        let (launch, (global, local)) = self.spread.member(launch, 1);
        launch.run(on.queue, global, local)
    }
}
