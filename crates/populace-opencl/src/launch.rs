//! Kernel launches with arguments that are checked by name and type against the compiled kernel.
#![expect(
    unsafe_code,
    reason = "the OpenCL API is C; arguments and launches are part of the crate's boundary to it"
)]

use std::ptr;

use opencl3::error_codes::ClError;

use crate::buffer::{Buffer, Element};
use crate::handles::{CommandQueue, Event, Kernel};

/// `CL_KERNEL_ARG_INFO_NOT_AVAILABLE`.
const NO_ARGUMENT_INFO: i32 = -19;

/// The work-items of a launch, and of each of its work-groups.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorkSize {
    global: usize,
    /// Divides `global`.
    local: usize,
}

impl WorkSize {
    /// `count` work-items, padded to whole groups of `group`.
    pub(crate) fn of(count: usize, group: usize) -> Self {
        Self { global: count.next_multiple_of(group), local: group }
    }
}

/// Builds a launch: arguments in the kernel's order, then [`run`](Self::run).
///
/// Debug builds, and so all tests, compare names and types with what the compiled kernel reports. A
/// mismatch is a bug of this crate.
pub(crate) struct Launch<'a> {
    kernel: &'a Kernel,
    next: u32,
    error: Option<ClError>,
}

impl<'a> Launch<'a> {
    pub(crate) fn of(kernel: &'a Kernel) -> Self {
        Self { kernel, next: 0, error: None }
    }

    pub(crate) fn buffer<T: Element>(self, name: &str, buffer: &Buffer<T>) -> Self {
        self.check(name, &format!("{}*", T::TYPE_NAME));
        self.set(&buffer.handle())
    }

    /// Passes a buffer of any element type to a kernel that sees it as words.
    pub(crate) fn words<T: Element>(self, name: &str, buffer: &mut Buffer<T>) -> Self {
        self.check(name, "uint*");
        self.set(&buffer.handle())
    }

    pub(crate) fn uint(self, name: &str, value: u32) -> Self {
        self.check(name, "uint");
        self.set(&value)
    }

    /// Passes a count, which tables keep within 32 bits.
    pub(crate) fn count(self, name: &str, count: usize) -> Self {
        debug_assert!(u32::try_from(count).is_ok(), "{name} is {count}");
        #[expect(clippy::cast_possible_truncation, reason = "tables refuse to grow past 32 bits")]
        let narrowed = count as u32;
        self.uint(name, narrowed)
    }

    pub(crate) fn ulong(self, name: &str, value: u64) -> Self {
        self.check(name, "ulong");
        self.set(&value)
    }

    /// Allocates local memory of `len` elements, at least one, for each work-group.
    pub(crate) fn local<T: Element>(self, name: &str, len: usize) -> Self {
        self.check(name, &format!("{}*", T::TYPE_NAME));
        // SAFETY: no address is given, only a size: the driver takes the memory from each group's
        // own, and refuses a place that is no local argument, and launches that ask for more than
        // the device has.
        let result = unsafe { self.kernel.set_arg_local_buffer(self.next, len * size_of::<T>()) };
        self.record(result)
    }

    fn check(&self, name: &str, kind: &str) {
        if cfg!(debug_assertions) && self.reports_arguments() {
            let text = |reported: Result<String, ClError>| {
                reported.unwrap_or_default().trim_end_matches('\0').to_owned()
            };
            let (real, index) = (text(self.kernel.get_arg_name(self.next)), self.next);
            assert_eq!(real, name, "argument {index} of {:?}", self.kernel.function_name());
            let real = text(self.kernel.get_arg_type_name(self.next));
            assert_eq!(real, kind, "type of argument {name} of {:?}", self.kernel.function_name());
        }
    }

    /// Returns whether the driver reports arguments. Some drop them from a program's binary.
    fn reports_arguments(&self) -> bool {
        self.kernel.get_arg_name(self.next) != Err(ClError(NO_ARGUMENT_INFO))
    }

    fn set<A>(self, value: &A) -> Self {
        // SAFETY: `value` is a memory object, a `u32` or a `u64`, as the callers above have it; the
        // driver copies it and refuses a size or a place that does not fit the kernel.
        let result = unsafe { self.kernel.set_arg(self.next, value) };
        self.record(result)
    }

    fn record(mut self, result: Result<(), ClError>) -> Self {
        self.error = self.error.or(result.err());
        self.next += 1;
        self
    }

    /// Enqueues the kernel.
    pub(crate) fn run(self, queue: &CommandQueue, size: WorkSize) -> Result<Event, ClError> {
        if let Some(error) = self.error {
            return Err(error);
        }
        debug_assert_eq!(
            self.kernel.num_args(),
            Ok(self.next),
            "{:?}",
            self.kernel.function_name()
        );
        let (global, local) = (&raw const size.global, &raw const size.local);
        // SAFETY: both sizes are one number, for the one dimension named; every argument was set
        // just now, and buffers are freed only after the queue is done with them, since the driver
        // counts references, and `InteropPages` waits before it gives back other memory.
        // Kernels stay inside their buffers: each compares its index with a count given as an
        // argument, the backend refuses to run before its buffers hold what the tables do, and
        // `Tables` takes only indices that point into itself. Users' stages are given a struct of
        // their own and no buffer; that they stay within it is for those who write them, as
        // `UserStage` says.
        let event = unsafe {
            queue.enqueue_nd_range_kernel(self.kernel.get(), 1, ptr::null(), global, local, &[])
        };
        event.map(Event::from)
    }
}
