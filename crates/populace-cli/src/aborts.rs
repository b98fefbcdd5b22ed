//! Turns an abort into exit code 4, the code of a failed run.
//!
//! Rust aborts if memory runs out, and so do compilers and drivers in this process. They print the
//! reason on stderr. Allocations that return an error, such as those of palettes, do not get here.

#![expect(unsafe_code, reason = "code in a signal handler must be async-signal-safe")]

use std::fs::File;
use std::io::Write;
use std::mem::ManuallyDrop;
use std::os::fd::FromRawFd;

use signal_hook::consts::SIGABRT;
use signal_hook::low_level;

use crate::unfinished;

const MESSAGE: &[u8] = b"populace: stopped: memory ran out, or a driver gave up (see above); \
    use fewer members or a smaller size, or raise the memory limit\n";
const EXIT_CODE: i32 = 4;

/// Installs a SIGABRT handler that removes the temporary files, prints one line and exits.
///
/// Drivers with a compiler replace the handler when they start, so this is called again after that.
pub(crate) fn exit_on_abort() {
    let handler: extern "C" fn(libc::c_int) = aborted;
    // SAFETY: the handler waits for no lock, allocates nothing, and calls only unlink(2), write(2)
    // and _exit(2).
    unsafe { libc::signal(SIGABRT, handler as libc::sighandler_t) };
}

extern "C" fn aborted(_signal: libc::c_int) {
    unfinished::remove_in_signal_handler();
    // SAFETY: stderr is open while the program runs, and `ManuallyDrop` never closes it.
    let mut stderr = ManuallyDrop::new(unsafe { File::from_raw_fd(libc::STDERR_FILENO) });
    let _ = stderr.write_all(MESSAGE);
    low_level::exit(EXIT_CODE);
}
