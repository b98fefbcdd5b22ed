//! State machines: the running state of each instance, kept from frame to frame, and the kernel
//! that advances them.

use opencl3::error_codes::ClError;
use populace_device::layout::{Float4, RUNNING_ELEMENTS, Running};
use populace_device::{BackendError, Frame, Tables};

use crate::OpenClDevice;
use crate::buffer::{Buffer, INVALID_VALUE};
use crate::handles::{CommandQueue, Event, Kernel};
use crate::launch::{Launch, WorkSize};
use crate::program::Form;
use crate::tables::DeviceTables;

/// Elements of one machine instance.
const EACH: usize = RUNNING_ELEMENTS as usize;

pub(crate) struct Machines {
    advance: Kernel,
    pub(crate) running: Buffer<Running>,
    /// The same before the newest frame.
    before: Buffer<Running>,
    /// Whether `before` was kept since the last update.
    has_kept: bool,
    group: usize,
}

impl Machines {
    /// Takes the kernel from the program of `form`, which the schedule builds anyway.
    pub(crate) fn new(
        device: &OpenClDevice,
        form: Form,
        group: usize,
    ) -> Result<Self, BackendError> {
        let empty = || Buffer::new(device, 0, "an empty buffer");
        let advance = device.kernel(form, "", "advance")?;
        Ok(Self { advance, running: empty()?, before: empty()?, has_kept: false, group })
    }

    /// Grows to the size that the tables need, and keeps the contents.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        let count = tables.machine_instances().as_slice().len();
        self.has_kept = false;
        let pair = [&mut self.before, &mut self.running];
        Buffer::grow_pair(pair, device, queue, count, "state machines")
    }

    /// Enqueues a copy of all states, before a frame advances them.
    pub(crate) fn keep(&mut self, queue: &CommandQueue) -> Result<(), ClError> {
        self.before.copy_from(queue, &self.running)?;
        self.has_kept = true;
        Ok(())
    }

    /// Takes back what the frame since the last update changed.
    pub(crate) fn undo_frame(&mut self) {
        if std::mem::take(&mut self.has_kept) {
            std::mem::swap(&mut self.running, &mut self.before);
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.running.bytes() + self.before.bytes()
    }

    /// Returns whether the memory suffices for the tables, as it does after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        tables.machine_instances().as_slice().len() <= self.running.len()
    }

    /// Reads elements, three for each machine instance, and waits.
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

    /// Writes elements, three for each machine instance, and waits.
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

    /// Enqueues one step of all machines. Enqueues nothing if there are none.
    pub(crate) fn advance(
        &self,
        queue: &CommandQueue,
        host: &Tables,
        tables: &DeviceTables,
        frame: Frame,
    ) -> Result<Option<Event>, ClError> {
        let count = host.machine_instances().as_slice().len();
        if count == 0 {
            return Ok(None);
        }
        let launch = Launch::of(&self.advance)
            .buffer("machine_instances", &tables.machine_instances.buffer)
            .buffer("machine_parameters", &tables.machine_parameters.buffer)
            .buffer("machine_states", &tables.machine_states.buffer)
            .buffer("transitions", &tables.transitions.buffer)
            .buffer("conditions", &tables.conditions.buffer)
            .ulong("tick", frame.tick)
            .count("machine_instance_count", count)
            .buffer("running", &self.running);
        launch.run(queue, WorkSize::of(count, self.group)).map(Some)
    }
}

/// Returns the machine instance that begins at element `first`. Only whole machine instances are
/// read and written.
fn first_machine_instance(first: usize, count: usize) -> Result<usize, ClError> {
    if first.is_multiple_of(EACH) && count.is_multiple_of(EACH) {
        return Ok(first / EACH);
    }
    Err(ClError(INVALID_VALUE))
}
