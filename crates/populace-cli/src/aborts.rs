//! Turns an abort into exit code 4, the code of a run that failed.
//!
//! Rust aborts where memory runs out, and so do compilers and drivers in this process. Both say on
//! stderr why. Allocations that fail with an error value, as those of palettes, go on as errors:
//! this module sees none of them.

#![expect(
    unsafe_code,
    reason = "what runs in a signal's handler must be promised to be safe there"
)]

use std::fs::File;
use std::io::Write;
use std::mem::ManuallyDrop;
use std::os::fd::FromRawFd;

use signal_hook::consts::SIGABRT;
use signal_hook::low_level;

use crate::unfinished;

const TOLD: &[u8] = b"populace: stopped: memory ran out, or a driver gave up, as told above; \
    take fewer members or a smaller size, or raise the limit on memory\n";
const CODE: i32 = 4;

/// Ends the program on SIGABRT without the file that is being written, and with a plain line.
/// Drivers that bring a compiler put a handler of their own in this one's place when they start, so
/// this is called again after that.
pub(crate) fn end_with_a_code() {
    let handler: extern "C" fn(libc::c_int) = aborted;
    // SAFETY: the handler takes no lock that it waits for, allocates nothing, and calls unlink(2),
    // write(2) and _exit(2) alone.
    unsafe { libc::signal(SIGABRT, handler as libc::sighandler_t) };
}

extern "C" fn aborted(_signal: libc::c_int) {
    unfinished::remove_from_a_handler();
    // SAFETY: stderr is open from the start to the end of the program, and `ManuallyDrop` never
    // closes it.
    let mut stderr = ManuallyDrop::new(unsafe { File::from_raw_fd(libc::STDERR_FILENO) });
    let _ = stderr.write_all(TOLD);
    low_level::exit(CODE);
}
