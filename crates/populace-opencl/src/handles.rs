//! Handles of OpenCL objects whose release never panics.
//!
//! The binding panics if a driver refuses to release an object, which it may once a device is lost.
//! Nothing can be done about it then, so the refusal is ignored.
#![expect(
    unsafe_code,
    reason = "the OpenCL API is C; releasing objects is part of the crate's boundary to it"
)]

use std::mem::ManuallyDrop;
use std::ops::{Deref, DerefMut};

use opencl3::error_codes::ClError;
use opencl3::memory::ClMem;
use opencl3::program::Program;
use opencl3::types::cl_int;
use opencl3::{command_queue, event, kernel, memory};

/// An object of the binding that counts as one reference.
pub(crate) trait Object {
    /// Gives up the reference.
    ///
    /// # Safety
    ///
    /// The object must not be used afterwards.
    unsafe fn release(&self) -> Result<(), cl_int>;
}

macro_rules! objects {
    ($([$($generic:ident)?] $object:ty: $release:path;)*) => {
        $(impl<$($generic)?> Object for $object {
            unsafe fn release(&self) -> Result<(), cl_int> {
                // SAFETY: the caller does not use the object afterwards.
                unsafe { $release(self.get()) }
            }
        })*
    };
}
objects! {
    [] kernel::Kernel: kernel::release_kernel;
    [] event::Event: event::release_event;
    [] command_queue::CommandQueue: command_queue::release_command_queue;
    [T] memory::Buffer<T>: memory::release_mem_object;
}

/// An object that is released when it is dropped.
pub(crate) struct Owned<T: Object>(ManuallyDrop<T>);

pub(crate) type Kernel = Owned<kernel::Kernel>;
pub(crate) type Event = Owned<event::Event>;
pub(crate) type CommandQueue = Owned<command_queue::CommandQueue>;
pub(crate) type Memory<T> = Owned<memory::Buffer<T>>;

impl<T: Object> From<T> for Owned<T> {
    fn from(object: T) -> Self {
        Self(ManuallyDrop::new(object))
    }
}

impl<T: Object> Deref for Owned<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Object> DerefMut for Owned<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}

impl<T: Object> Drop for Owned<T> {
    fn drop(&mut self) {
        // SAFETY: the object is gone afterwards, and its own release never runs.
        let _refused = unsafe { self.0.release() };
    }
}

impl Kernel {
    /// Finds a kernel of a program by its name.
    pub(crate) fn create(program: &Program, name: &str) -> Result<Self, ClError> {
        kernel::Kernel::create(program, name).map(Self::from)
    }
}
