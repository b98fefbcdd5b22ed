//! Inputs that the launches of all schedules share.

use opencl3::error_codes::ClError;
use populace_device::{Frame, Tables};

use crate::handles::{CommandQueue, Event};
use crate::history::History;
use crate::machines::Machines;
use crate::pages::Pages;
use crate::tables::DeviceTables;

/// The queue, and the memory that the kernels of every schedule use.
pub(crate) struct FrameContext<'a> {
    pub(crate) queue: &'a CommandQueue,
    /// The host's tables.
    pub(crate) host: &'a Tables,
    /// The device's copies of them.
    pub(crate) tables: &'a DeviceTables,
    pub(crate) history: &'a History,
    pub(crate) machines: &'a Machines,
    pub(crate) pages: &'a Pages,
}

impl FrameContext<'_> {
    /// Enqueues one step of all state machines. Enqueues nothing if there are none.
    pub(crate) fn advance(&self, frame: Frame) -> Result<Option<Event>, ClError> {
        self.machines.advance(self.queue, self.host, self.tables, frame)
    }
}
