//! What the launches of a schedule share.

use opencl3::command_queue::CommandQueue;
use populace_core::Tables;

use crate::history::History;
use crate::machines::Machines;
use crate::pages::Pages;
use crate::tables::DeviceTables;

/// The queue, and the memory that the kernels of a frame read and write whatever the schedule.
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

/// Narrows a count to 32 bits. Tables refuse to grow past that.
#[expect(clippy::cast_possible_truncation, reason = "tables refuse to grow past 32 bits")]
pub(crate) fn narrow(count: usize) -> u32 {
    debug_assert!(u32::try_from(count).is_ok());
    count as u32
}
