//! State machines: where each is, kept from frame to frame, and the kernel that moves it on.

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::event::Event;
use opencl3::kernel::Kernel;
use populace_device::layout::{Float4, RUNNING_ELEMENTS, Running};
use populace_device::{BackendError, Frame, Tables};

use crate::OpenClDevice;
use crate::backend::{On, narrow};
use crate::buffer::{Buffer, INVALID_VALUE};
use crate::launch::Launch;
use crate::program::Form;

/// Elements of each machine instance.
const EACH: usize = RUNNING_ELEMENTS as usize;

pub(crate) struct Machines {
    advance: Kernel,
    pub(crate) running: Buffer<Running>,
    group: usize,
}

impl Machines {
    /// `form` is that of a program that is built anyway.
    pub(crate) fn new(
        device: &OpenClDevice,
        form: Form,
        group: usize,
    ) -> Result<Self, BackendError> {
        let running = Buffer::new(device, 0, "an empty buffer")?;
        Ok(Self { advance: device.kernel(form, "", "advance")?, running, group })
    }

    /// Makes room for what the tables hold, and keeps what is there.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        let count = tables.machine_instances().as_slice().len();
        self.running.grow(device, queue, count, "where state machines are")
    }

    /// Whether there is room for what the tables hold, as there is after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        tables.machine_instances().as_slice().len() <= self.running.len()
    }

    /// Reads elements of which each machine instance has three, and waits.
    pub(crate) fn read(
        &self,
        queue: &CommandQueue,
        first: usize,
        into: &mut [Float4],
    ) -> Result<(), ClError> {
        self.running.read(
            queue,
            first_machine_instance(first, into.len())?,
            bytemuck::cast_slice_mut(into),
        )
    }

    /// Writes such elements, and waits.
    pub(crate) fn write(
        &mut self,
        queue: &CommandQueue,
        first: usize,
        from: &[Float4],
    ) -> Result<(), ClError> {
        self.running.write(
            queue,
            first_machine_instance(first, from.len())?,
            bytemuck::cast_slice(from),
        )
    }

    /// Enqueues a step of all machines; nothing where there are none.
    pub(crate) fn advance(&self, on: &On, frame: Frame) -> Result<Option<Event>, ClError> {
        let count = on.host.machine_instances().as_slice().len();
        if count == 0 {
            return Ok(None);
        }
        let launch = Launch::of(&self.advance)
            .buffer("machine_instances", &on.tables.machine_instances.buffer)
            .buffer("machine_parameters", &on.tables.machine_parameters.buffer)
            .buffer("machine_states", &on.tables.machine_states.buffer)
            .buffer("transitions", &on.tables.transitions.buffer)
            .buffer("conditions", &on.tables.conditions.buffer)
            .ulong("tick", frame.tick)
            .uint("machine_instance_count", narrow(count))
            .buffer("running", &self.running);
        launch.run(on.queue, [count.next_multiple_of(self.group), 1], [self.group, 1]).map(Some)
    }
}

/// The machine instance whose elements begin at `first`; machine instances are read and written
/// whole.
fn first_machine_instance(first: usize, count: usize) -> Result<usize, ClError> {
    if first.is_multiple_of(EACH) && count.is_multiple_of(EACH) {
        return Ok(first / EACH);
    }
    Err(ClError(INVALID_VALUE))
}
