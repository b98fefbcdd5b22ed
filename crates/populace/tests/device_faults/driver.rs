//! A layer between libOpenCL and the driver, in which chosen calls fail.
//!
//! Each OpenCL object begins with a pointer to the driver's table of functions (extension
//! `cl_khr_icd`), through which libOpenCL calls. The layer gives platform and devices a table of its
//! own, and every object that is made from them.
#![expect(unsafe_code, reason = "the layer stands between C and C")]
#![expect(non_snake_case, reason = "each function has the name of the one that it stands before")]

use std::ffi::{c_char, c_void};
use std::ptr;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use opencl_sys::cl_icd::cl_icd_dispatch as Table;
use opencl_sys::{
    CL_DEVICE_TYPE_ALL, CL_SUCCESS, cl_bool, cl_command_queue, cl_command_queue_properties,
    cl_context, cl_device_id, cl_event, cl_event_info, cl_int, cl_kernel, cl_map_flags, cl_mem,
    cl_mem_flags, cl_program, cl_uint,
};

macro_rules! named {
    ($(#[$doc:meta])* $name:ident { $($(#[$of:meta])* $variant:ident),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum $name { $($(#[$of])* $variant),* }

        impl $name {
            pub(crate) const ALL: &'static [Self] = &[$(Self::$variant),*];
        }
    };
}

named! {
    /// A function of OpenCL that can fail.
    Call {
        CreateCommandQueue, CreateBuffer, CreateProgramWithSource, BuildProgram, CreateKernel,
        SetKernelArg, EnqueueNDRangeKernel, EnqueueReadBuffer, EnqueueWriteBuffer,
        EnqueueCopyBuffer, EnqueueFillBuffer, EnqueueMapBuffer, EnqueueUnmapMemObject, Flush,
        Finish, WaitForEvents, GetEventInfo,
    }
}

named! {
    /// What a failing call does.
    Manner {
        /// It does nothing but report the error.
        Refused,
        /// It does its work and then reports the error, as a time-out does.
        Late,
        /// It and all later calls fail.
        Lost,
        /// It reports success and does nothing; all later calls fail.
        LostSilently,
        /// As `Lost`, and the release of each object reports an error, too.
        LostForGood,
    }
}

impl Manner {
    /// Returns whether the device is of no use afterwards.
    pub(crate) fn loses_device(self) -> bool {
        matches!(self, Self::Lost | Self::LostSilently | Self::LostForGood)
    }
}

/// A call that fails.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fault {
    pub(crate) call: Call,
    /// How many calls of the same function go well before it.
    pub(crate) after: usize,
    pub(crate) manner: Manner,
    pub(crate) code: cl_int,
}

/// Objects that were made and not yet released.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Objects {
    pub(crate) queues: isize,
    pub(crate) buffers: isize,
    pub(crate) events: isize,
    pub(crate) kernels: isize,
}

struct State {
    fault: Option<Fault>,
    has_failed: bool,
    is_lost: bool,
    releases_fail: bool,
    counts: [usize; Call::ALL.len()],
    objects: Objects,
}

static STATE: Mutex<State> = Mutex::new(State {
    fault: None,
    has_failed: false,
    is_lost: false,
    releases_fail: false,
    counts: [0; Call::ALL.len()],
    objects: Objects { queues: 0, buffers: 0, events: 0, kernels: 0 },
});

/// The driver's table and the layer's, as addresses.
static TABLES: OnceLock<[usize; 2]> = OnceLock::new();

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Begins to count calls, of which one fails if a fault is given.
pub(crate) fn begin(fault: Option<Fault>) {
    let mut state = state();
    let objects = state.objects;
    *state = State {
        fault,
        has_failed: false,
        is_lost: false,
        releases_fail: false,
        counts: [0; Call::ALL.len()],
        objects,
    };
}

/// Returns whether the fault's call has failed.
pub(crate) fn has_failed() -> bool {
    state().has_failed
}

/// Returns how often a function was called since [`begin`].
pub(crate) fn count(call: Call) -> usize {
    state().counts[call as usize]
}

pub(crate) fn objects() -> Objects {
    state().objects
}

enum Verdict {
    Runs,
    /// With the error that it reports.
    Refused(cl_int),
    Late(cl_int),
    DoesNothing,
}

fn verdict(call: Call) -> Verdict {
    let mut state = state();
    let before = state.counts[call as usize];
    state.counts[call as usize] += 1;
    let Some(fault) = state.fault else { return Verdict::Runs };
    if state.is_lost {
        return Verdict::Refused(fault.code);
    }
    if fault.call != call || fault.after != before {
        return Verdict::Runs;
    }
    state.has_failed = true;
    state.is_lost = fault.manner.loses_device();
    state.releases_fail = fault.manner == Manner::LostForGood;
    match fault.manner {
        Manner::Late => Verdict::Late(fault.code),
        Manner::LostSilently if call == Call::EnqueueNDRangeKernel => Verdict::DoesNothing,
        _ => Verdict::Refused(fault.code),
    }
}

/// Puts the layer before the driver of the first platform. Does nothing the second time.
pub(crate) fn install() {
    TABLES.get_or_init(|| {
        let platform = cl3::platform::get_platform_ids().expect("a platform")[0];
        let devices = cl3::device::get_device_ids(platform, CL_DEVICE_TYPE_ALL).expect("a device");
        // SAFETY: the platform begins with a pointer to the driver's table, as the extension has
        // it. The driver keeps its table, so a copy is as good for as long.
        let (driver, mut table) = unsafe {
            let driver = *platform.cast::<*const Table>();
            (driver, Box::new(*driver))
        };
        replace(&mut table);
        let layer = ptr::from_ref::<Table>(Box::leak(table));
        for object in devices.into_iter().chain([platform]) {
            // SAFETY: the object begins with the pointer; no other thread makes calls yet.
            unsafe { *object.cast::<*const Table>() = layer };
        }
        [driver.addr(), layer.addr()]
    });
}

macro_rules! replaced {
    ($table:ident: $($name:ident),* $(,)?) => { $($table.$name = Some($name);)* };
}

fn replace(table: &mut Table) {
    replaced! {
        table:
        clCreateContext, clCreateCommandQueue, clCreateBuffer, clCreateProgramWithSource,
        clBuildProgram, clCreateKernel, clSetKernelArg, clEnqueueNDRangeKernel,
        clEnqueueReadBuffer, clEnqueueWriteBuffer, clEnqueueCopyBuffer, clEnqueueFillBuffer,
        clEnqueueMapBuffer, clEnqueueUnmapMemObject, clFlush, clFinish, clWaitForEvents,
        clGetEventInfo, clReleaseCommandQueue, clReleaseMemObject, clReleaseEvent,
        clReleaseKernel,
    }
}

fn tables() -> [*const Table; 2] {
    let [driver, layer] = TABLES.get().expect("the layer is installed");
    [ptr::with_exposed_provenance(*driver), ptr::with_exposed_provenance(*layer)]
}

/// Returns the driver's table.
fn driver_table() -> &'static Table {
    // SAFETY: the table is the driver's own, which it keeps.
    unsafe { &*tables()[0] }
}

/// The driver's function of a name.
macro_rules! driver {
    ($name:ident) => {
        driver_table().$name.expect("a function of OpenCL 1.2")
    };
}

/// Gives an object the layer's table.
unsafe fn adopt(object: *mut c_void) {
    if !object.is_null() {
        // SAFETY: the driver made the object just now, and it begins with the pointer.
        unsafe { *object.cast::<*const Table>() = tables()[1] };
    }
}

/// Takes an event over from the driver, or gives it back if the call reports an error.
unsafe fn take_event(event: *mut cl_event, error: cl_int) {
    if event.is_null() {
        return;
    }
    // SAFETY: the driver wrote the event just now; the layer's callers are the driver's.
    unsafe {
        if error == CL_SUCCESS {
            adopt(*event);
            state().objects.events += 1;
        } else {
            driver!(clReleaseEvent)(*event);
            *event = ptr::null_mut();
        }
    }
}

/// Functions that return their error.
macro_rules! checked {
    ($($name:ident = $call:ident($($argument:ident: $type:ty),*);)*) => {$(
        unsafe extern "C" fn $name($($argument: $type),*) -> cl_int {
            // SAFETY: the arguments are those of the layer's own caller.
            let run = || unsafe { driver!($name)($($argument),*) };
            match verdict(Call::$call) {
                Verdict::Runs => run(),
                Verdict::Refused(code) => code,
                Verdict::Late(code) => { run(); code }
                Verdict::DoesNothing => CL_SUCCESS,
            }
        }
    )*};
}

checked! {
    clBuildProgram = BuildProgram(
        program: cl_program, count: cl_uint, devices: *const cl_device_id, options: *const c_char,
        notify: Option<unsafe extern "C" fn(cl_program, *mut c_void)>, data: *mut c_void
    );
    clSetKernelArg = SetKernelArg(
        kernel: cl_kernel, index: cl_uint, size: usize, value: *const c_void
    );
    clFlush = Flush(queue: cl_command_queue);
    clFinish = Finish(queue: cl_command_queue);
    clWaitForEvents = WaitForEvents(count: cl_uint, events: *const cl_event);
    clGetEventInfo = GetEventInfo(
        event: cl_event, name: cl_event_info, size: usize, value: *mut c_void, written: *mut usize
    );
}

/// Functions that enqueue a command and return its event.
macro_rules! enqueued {
    ($($name:ident = $call:ident($queue:ident; $($argument:ident: $type:ty),*);)*) => {$(
        unsafe extern "C" fn $name(
            $queue: cl_command_queue, $($argument: $type,)*
            count: cl_uint, before: *const cl_event, event: *mut cl_event,
        ) -> cl_int {
            // SAFETY: the arguments are those of the layer's own caller.
            unsafe {
                let run = || driver!($name)($queue, $($argument,)* count, before, event);
                let (error, reported) = match verdict(Call::$call) {
                    Verdict::Refused(code) => return code,
                    Verdict::Runs => { let error = run(); (error, error) }
                    Verdict::Late(code) => (run(), code),
                    Verdict::DoesNothing => {
                        let marker = driver!(clEnqueueMarkerWithWaitList);
                        let error = marker($queue, count, before, event);
                        (error, error)
                    }
                };
                if error == CL_SUCCESS {
                    take_event(event, reported);
                }
                reported
            }
        }
    )*};
}

enqueued! {
    clEnqueueNDRangeKernel = EnqueueNDRangeKernel(queue;
        kernel: cl_kernel, dimensions: cl_uint, offset: *const usize, global: *const usize,
        local: *const usize
    );
    clEnqueueCopyBuffer = EnqueueCopyBuffer(queue;
        from: cl_mem, to: cl_mem, first: usize, to_first: usize, bytes: usize
    );
    clEnqueueFillBuffer = EnqueueFillBuffer(queue;
        buffer: cl_mem, pattern: *const c_void, pattern_bytes: usize, first: usize, bytes: usize
    );
    clEnqueueUnmapMemObject = EnqueueUnmapMemObject(queue; memory: cl_mem, address: *mut c_void);
}

/// A command that copies to or from memory of the host. Late ones are those that block: a driver
/// that reports an error for another one must not touch that memory later.
macro_rules! copied {
    ($($name:ident = $call:ident($address:ty, $spoilt:expr);)*) => {$(
        unsafe extern "C" fn $name(
            queue: cl_command_queue, buffer: cl_mem, blocks: cl_bool, first: usize, bytes: usize,
            address: $address, count: cl_uint, before: *const cl_event, event: *mut cl_event,
        ) -> cl_int {
            // SAFETY: the arguments are those of the layer's own caller.
            unsafe {
                let run = || driver!($name)(
                    queue, buffer, blocks, first, bytes, address, count, before, event,
                );
                let (error, reported) = match verdict(Call::$call) {
                    Verdict::Runs | Verdict::DoesNothing => { let error = run(); (error, error) }
                    Verdict::Late(code) if blocks != 0 => (run(), code),
                    Verdict::Refused(code) | Verdict::Late(code) => {
                        $spoilt(address, bytes);
                        return code;
                    }
                };
                if error == CL_SUCCESS {
                    take_event(event, reported);
                }
                reported
            }
        }
    )*};
}

copied! {
    // What a failed read leaves must not be used: all bits set are NaN.
    clEnqueueReadBuffer = EnqueueReadBuffer(
        *mut c_void,
        |address: *mut c_void, bytes| ptr::write_bytes(address.cast::<u8>(), 255, bytes)
    );
    clEnqueueWriteBuffer = EnqueueWriteBuffer(*const c_void, |_, _| ());
}

/// Functions that return an object, and their error through a pointer.
macro_rules! created {
    ($(
        $name:ident = $call:ident($($argument:ident: $type:ty),*) -> $object:ty, $made:expr;
    )*) => {$(
        unsafe extern "C" fn $name($($argument: $type,)* error: *mut cl_int) -> $object {
            // SAFETY: the arguments are those of the layer's own caller.
            unsafe {
                if let Verdict::Refused(code) | Verdict::Late(code) = verdict(Call::$call) {
                    if !error.is_null() {
                        *error = code;
                    }
                    return ptr::null_mut();
                }
                let object = driver!($name)($($argument,)* error);
                adopt(object);
                if !object.is_null() {
                    let made: fn(&mut Objects) = $made;
                    made(&mut state().objects);
                }
                object
            }
        }
    )*};
}

created! {
    clCreateCommandQueue = CreateCommandQueue(
        context: cl_context, device: cl_device_id, properties: cl_command_queue_properties
    ) -> cl_command_queue, |objects| objects.queues += 1;
    clCreateBuffer = CreateBuffer(
        context: cl_context, flags: cl_mem_flags, bytes: usize, address: *mut c_void
    ) -> cl_mem, |objects| objects.buffers += 1;
    clCreateProgramWithSource = CreateProgramWithSource(
        context: cl_context, count: cl_uint, texts: *mut *const c_char, lengths: *const usize
    ) -> cl_program, |_| ();
    clCreateKernel = CreateKernel(
        program: cl_program, name: *const c_char
    ) -> cl_kernel, |objects| objects.kernels += 1;
}

unsafe extern "C" fn clCreateContext(
    properties: *const isize,
    count: cl_uint,
    devices: *const cl_device_id,
    notify: Option<unsafe extern "C" fn(*const c_char, *const c_void, usize, *mut c_void)>,
    data: *mut c_void,
    error: *mut cl_int,
) -> cl_context {
    // SAFETY: the arguments are those of the layer's own caller.
    unsafe {
        let context = driver!(clCreateContext)(properties, count, devices, notify, data, error);
        adopt(context);
        context
    }
}

unsafe extern "C" fn clEnqueueMapBuffer(
    queue: cl_command_queue,
    buffer: cl_mem,
    blocks: cl_bool,
    flags: cl_map_flags,
    first: usize,
    bytes: usize,
    count: cl_uint,
    before: *const cl_event,
    event: *mut cl_event,
    error: *mut cl_int,
) -> *mut c_void {
    // SAFETY: the arguments are those of the layer's own caller.
    unsafe {
        if let Verdict::Refused(code) | Verdict::Late(code) = verdict(Call::EnqueueMapBuffer) {
            *error = code;
            return ptr::null_mut();
        }
        let map = driver!(clEnqueueMapBuffer);
        let address = map(queue, buffer, blocks, flags, first, bytes, count, before, event, error);
        if *error == CL_SUCCESS {
            take_event(event, CL_SUCCESS);
        }
        address
    }
}

/// Functions that release an object. They always do.
macro_rules! released {
    ($($name:ident($object:ty): $kind:ident;)*) => {$(
        unsafe extern "C" fn $name(object: $object) -> cl_int {
            // SAFETY: the argument is that of the layer's own caller.
            let error = unsafe { driver!($name)(object) };
            let mut state = state();
            state.objects.$kind -= 1;
            match state.fault {
                Some(fault) if state.releases_fail => fault.code,
                _ => error,
            }
        }
    )*};
}

released! {
    clReleaseCommandQueue(cl_command_queue): queues;
    clReleaseMemObject(cl_mem): buffers;
    clReleaseEvent(cl_event): events;
    clReleaseKernel(cl_kernel): kernels;
}
