//! Counter of the times that the host waited for a device.

use std::sync::atomic::{AtomicU64, Ordering};

use opencl3::error_codes::ClError;
use opencl3::event::CL_COMPLETE;

use crate::handles::{CommandQueue, Event};

/// For all devices of the process, since the waiting code does not know its backend.
static WAITS: AtomicU64 = AtomicU64::new(0);

/// Returns how often the host has waited.
pub(crate) fn count() -> u64 {
    WAITS.load(Ordering::Relaxed)
}

/// Counts a wait that is about to begin.
pub(crate) fn begin() {
    WAITS.fetch_add(1, Ordering::Relaxed);
}

/// Waits until all work of a queue is done.
pub(crate) fn for_queue(queue: &CommandQueue) -> Result<(), ClError> {
    begin();
    queue.finish()
}

/// Returns whether the command of an event has completed, or its error if it failed.
pub(crate) fn is_done(event: &Event) -> Result<bool, ClError> {
    let status = event.command_execution_status()?.0;
    if status < 0 { Err(ClError(status)) } else { Ok(status == CL_COMPLETE) }
}

/// Waits until the command of an event has completed.
pub(crate) fn for_event(event: &Event) -> Result<(), ClError> {
    if is_done(event)? {
        return Ok(());
    }
    begin();
    event.wait()
}
