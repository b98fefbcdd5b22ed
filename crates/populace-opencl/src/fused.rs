//! The fused schedules: one kernel for the whole frame, so that only palettes go through global
//! memory.

mod dispatch;
mod readback;

use opencl3::error_codes::ClError;
use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{BackendError, Frame, StageBuffer, Tables};

use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::context::FrameContext;
use crate::handles::{Event, Kernel};
use crate::history::WriteTarget;
use crate::launch::Launch;
use crate::program::{Form, GroupShape};
use crate::tables::DevicePages;
use crate::user_stages::StageKernels;
use dispatch::Dispatch;
use readback::{MemberReadback, ScratchOutputs};

/// `Float4`s of one matrix that is read back, which is a float16.
const MATRIX: usize = 4;
/// The kernels of a whole frame and of one member's joints.
const WIDE: [&str; 2] = ["fused_wide", "fused_wide_joints"];
const GROUPED: [&str; 2] = ["fused_grouped", "fused_grouped_joints"];
/// The kernel of members that only mix the slots of layer 0.
const GROUPED_PLAIN: &str = "fused_grouped_plain";

/// A page of palettes and its members.
struct Page<'a> {
    index: usize,
    member_count: usize,
    palette: &'a Buffer<Float4>,
}

/// The kernels of a fused schedule and their buffers.
pub(crate) struct Fused {
    /// The names of the two kernels below, which run users' stages.
    pub(crate) stage_kernels: StageKernels,
    whole: Kernel,
    joints: Kernel,
    /// Takes plain members from `whole`, in the grouped form.
    plain: Option<Kernel>,
    dispatch: Dispatch,
    /// The members of each page.
    pub(crate) lists: DevicePages,
    /// Events of the last frame, for each run.
    events: Vec<Vec<Event>>,
    last: Frame,
    readback: Option<MemberReadback>,
}

impl Fused {
    /// For CPUs: as many members of a body side by side as there are `lanes`.
    pub(crate) fn wide(device: &OpenClDevice, lanes: usize) -> Result<Self, BackendError> {
        let form = Form::Wide { lanes };
        let kernel = |name| device.kernel(form, "", name);
        let (whole, joints) = (kernel(WIDE[0])?, kernel(WIDE[1])?);
        let stage_kernels = StageKernels { form, names: WIDE };
        Ok(Self::of(stage_kernels, whole, joints, None, Dispatch::wide(device, lanes)?))
    }

    /// For GPUs: work-groups of `wished` work-items, or of as many as the device allows.
    pub(crate) fn grouped(device: &OpenClDevice, wished: usize) -> Result<Self, BackendError> {
        let shape = GroupShape::of(device.group_size(wished));
        let form = Form::Grouped(shape);
        let kernel = |name| device.kernel(form, "", name);
        let (whole, joints) = (kernel(GROUPED[0])?, kernel(GROUPED[1])?);
        let dispatch = Dispatch::grouped(device, &whole, shape)?;
        let stage_kernels = StageKernels { form, names: GROUPED };
        Ok(Self::of(stage_kernels, whole, joints, Some(kernel(GROUPED_PLAIN)?), dispatch))
    }

    fn of(
        stage_kernels: StageKernels,
        whole: Kernel,
        joints: Kernel,
        plain: Option<Kernel>,
        dispatch: Dispatch,
    ) -> Self {
        let (lists, events, last) = (DevicePages::new(), Vec::new(), Frame::of_all(0));
        Self { stage_kernels, whole, joints, plain, dispatch, lists, events, last, readback: None }
    }

    /// Replaces the kernels by those of another program.
    pub(crate) fn take_stages(&mut self, [whole, joints]: [Kernel; 2]) {
        (self.whole, self.joints) = (whole, joints);
    }

    /// Grows scratch memory to the matrices of the largest body.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        self.readback = None;
        self.dispatch.update(device, tables)
    }

    /// Returns whether the memory suffices for the tables, as it does after an update.
    pub(crate) fn holds(&self, tables: &Tables) -> bool {
        self.dispatch.holds(tables) && self.lists.hold(tables)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.dispatch.bytes() + self.lists.bytes()
    }

    pub(crate) fn events(&self) -> &[Vec<Event>] {
        &self.events
    }

    #[cfg(test)]
    pub(crate) fn kernel_name(&self) -> String {
        self.whole.function_name().unwrap_or_default()
    }

    /// Enqueues all phases of a frame.
    pub(crate) fn run(&mut self, context: &FrameContext, frame: Frame) -> Result<(), ClError> {
        let mut events = Vec::new();
        if frame.begins() {
            self.events.clear();
            events.extend(context.advance(frame)?);
        }
        (self.last, self.readback) = (frame, None);
        for phase in frame.phases(context.host) {
            for (index, palette) in context.pages.iter().enumerate() {
                let member_count = context.host.page_members(index).as_slice().len();
                if member_count > 0 {
                    let page = Page { index, member_count, palette };
                    self.run_page(context, frame.of_phase(phase), &page, &mut events)?;
                }
            }
        }
        self.events.push(events);
        Ok(())
    }

    fn run_page(
        &self,
        context: &FrameContext,
        frame: Frame,
        page: &Page,
        events: &mut Vec<Event>,
    ) -> Result<(), ClError> {
        // The other kernel takes all members of later phases. Nearly all have constraint programs.
        let plain = self.plain.as_ref().filter(|_| frame.phase_first == 0);
        let kernels = plain.map(|kernel| (kernel, true)).into_iter().chain([(&self.whole, false)]);
        for (kernel, plain) in kernels {
            let launch = self
                .launch(context, kernel, frame, WriteTarget::Frame)
                .buffer("page_members", &self.lists.lists[page.index].buffer)
                .buffer("entries", &context.tables.entries.buffer)
                .uint("place_first", frame.place_first)
                .uint("place_end", frame.place_end)
                .uint("phase", frame.phase_first)
                .count("page_first", page.index * PAGE_ENTRIES as usize)
                .buffer("palette", page.palette);
            let (launch, size) =
                self.dispatch.frame(launch, context.host, page.member_count, plain);
            events.push(launch.run(context.queue, size)?);
        }
        Ok(())
    }

    /// Sets the arguments that all kernels share.
    fn launch<'a>(
        &self,
        context: &FrameContext,
        kernel: &'a Kernel,
        frame: Frame,
        writes: WriteTarget,
    ) -> Launch<'a> {
        let tables = context.tables;
        let launch = Launch::of(kernel)
            .buffer("members", &tables.members.buffer)
            .buffer("bodies", &tables.bodies.buffer)
            .buffer("parents", &tables.parents.buffer)
            .buffer("slots", &tables.slots.buffer)
            .buffer("machine_states", &tables.machine_states.buffer)
            .buffer("running", &context.machines.running)
            .buffer("layers", &tables.layers.buffer)
            .buffer("bound_clips", &tables.bound_clips.buffer)
            .buffer("bound_blocks", &tables.bound_blocks.buffer)
            .buffer("clips", &tables.clips.buffer)
            .buffer("rows", &tables.rows.buffer)
            .buffer("row_times", &tables.row_times.buffer)
            .buffer("buckets", &tables.buckets.buffer)
            .buffer("poses", &tables.poses.buffer)
            .buffer("masks", &tables.masks.buffer);
        let launch = self
            .dispatch
            .tables(launch, tables)
            .ulong("tick", frame.tick)
            .count("slots_per_member", context.host.slots_per_member())
            .buffer("joint_scales", &tables.joint_scales.buffer);
        context.history.parameters(launch, tables, frame, writes)
    }

    /// Reads elements of one member's joints or samples, as of the last frame.
    pub(crate) fn read(
        &mut self,
        context: &FrameContext,
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
        let (member, at) = context.host.place_of(buffer, first).ok_or_else(past_the_end)?;
        if self.readback.as_ref().is_none_or(|readback| readback.member != member) {
            let outputs = ScratchOutputs::new(device, context.host, member)?;
            self.run_joints(context, member, &outputs)
                .map_err(|e| device.failed("read a member's joints", &e))?;
            self.readback = Some(outputs.read(context, device, member)?);
        }
        let readback = self.readback.as_ref().ok_or_else(past_the_end)?;
        for (offset, element) in into.iter_mut().enumerate() {
            *element = readback.element(buffer, at + offset).ok_or_else(past_the_end)?;
        }
        Ok(())
    }

    fn run_joints(
        &self,
        context: &FrameContext,
        member: u32,
        outputs: &ScratchOutputs,
    ) -> Result<Event, ClError> {
        let launch = self
            .launch(context, &self.joints, self.last, WriteTarget::Scratch)
            .uint("owner", member)
            .buffer("samples", &outputs.samples)
            .buffer("planes", &outputs.planes)
            .buffer("matrices", &outputs.matrices);
        let (launch, size) = self.dispatch.member(launch);
        launch.run(context.queue, size)
    }
}
