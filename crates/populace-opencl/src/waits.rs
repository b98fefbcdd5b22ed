//! How often the host waited for a device.

use std::sync::atomic::{AtomicU64, Ordering};

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::event::{CL_COMPLETE, Event};

/// Of all devices of the process: what waits is deep below what could tell whose it is.
static WAITS: AtomicU64 = AtomicU64::new(0);

/// How often the host waited.
pub(crate) fn count() -> u64 {
    WAITS.load(Ordering::Relaxed)
}

/// Says that the host is about to wait.
pub(crate) fn begin() {
    WAITS.fetch_add(1, Ordering::Relaxed);
}

/// Waits until a queue has done all its work.
pub(crate) fn for_queue(queue: &CommandQueue) -> Result<(), ClError> {
    begin();
    queue.finish()
}

/// Whether what an event stands for is done; an error where it failed.
pub(crate) fn is_done(event: &Event) -> Result<bool, ClError> {
    let status = event.command_execution_status()?.0;
    if status < 0 { Err(ClError(status)) } else { Ok(status == CL_COMPLETE) }
}

/// Waits until what an event stands for is done.
pub(crate) fn for_event(event: &Event) -> Result<(), ClError> {
    if is_done(event)? {
        return Ok(());
    }
    begin();
    event.wait()
}
