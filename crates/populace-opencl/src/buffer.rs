//! Device memory whose length and element type are known, so that copies are safe functions.
#![expect(
    unsafe_code,
    reason = "the OpenCL API is C; allocation and copies are part of the crate's boundary to it"
)]

use std::ffi::c_void;
use std::ptr;

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::memory::{Buffer as ClBuffer, CL_MAP_READ, CL_MEM_ALLOC_HOST_PTR, CL_MEM_READ_WRITE, ClMem};
use opencl3::types::CL_BLOCKING;
use populace_core::BackendError;
use populace_core::layout::{
    Body, BoundBlock, BoundClip, ClipRows, DeviceStruct, Entry, Float4, Layer, Member, RowBlock, Slot,
    SlotSample, Source,
};

use crate::OpenClDevice;

/// A type that kernels know by name.
pub(crate) trait Element: bytemuck::Pod {
    /// The name in OpenCL C.
    const TYPE_NAME: &'static str;
}

macro_rules! elements {
    ($($rust:ty => $name:expr),* $(,)?) => { $(impl Element for $rust { const TYPE_NAME: &'static str = $name; })* };
}
elements! {
    f32 => "float", u32 => "uint", Float4 => "float4",
    Body => Body::NAME, Entry => Entry::NAME, ClipRows => ClipRows::NAME, BoundClip => BoundClip::NAME,
    RowBlock => RowBlock::NAME, BoundBlock => BoundBlock::NAME, Source => Source::NAME,
    Slot => Slot::NAME, Layer => Layer::NAME, Member => Member::NAME, SlotSample => SlotSample::NAME,
}

/// `len` elements on a device.
pub(crate) struct Buffer<T> {
    memory: ClBuffer<T>,
    len: usize,
}

impl<T: Element> Buffer<T> {
    /// Allocates; a buffer of no elements still holds one, since devices refuse empty ones.
    pub(crate) fn new(device: &OpenClDevice, len: usize, what: &str) -> Result<Self, BackendError> {
        let count = len.max(1);
        let bytes = count.saturating_mul(size_of::<T>());
        let no_room =
            || BackendError::OutOfMemory { device: device.info.name.clone(), what: what.into(), bytes };
        if bytes as u64 > device.info.max_allocation_bytes {
            return Err(no_room());
        }
        // Host-visible memory lets a page be handed over without a copy where host and device share it.
        let flags = CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR;
        // SAFETY: no host pointer is given, and the context is alive in `device`.
        let memory = unsafe { ClBuffer::create(&device.context, flags, count, ptr::null_mut()) };
        let memory = memory.map_err(|error| match error {
            ClError(-6..=-4 | -61) => no_room(),
            other => device.failed(&format!("allocate {what}"), &other),
        })?;
        Ok(Self { memory, len })
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(crate) fn bytes(&self) -> usize {
        self.len * size_of::<T>()
    }

    pub(crate) fn handle(&self) -> *mut c_void {
        self.memory.get()
    }

    fn check(&self, first: usize, count: usize) -> Result<(), ClError> {
        const INVALID_VALUE: i32 = -30;
        if first.checked_add(count).is_some_and(|end| end <= self.len) {
            Ok(())
        } else {
            Err(ClError(INVALID_VALUE))
        }
    }

    /// Copies elements to the device and waits.
    pub(crate) fn write(&mut self, queue: &CommandQueue, first: usize, from: &[T]) -> Result<(), ClError> {
        self.check(first, from.len())?;
        if !from.is_empty() {
            // SAFETY: the range was checked, and the write blocks, so `from` outlives it.
            unsafe {
                queue.enqueue_write_buffer(&mut self.memory, CL_BLOCKING, first * size_of::<T>(), from, &[])
            }?;
        }
        Ok(())
    }

    /// Copies elements from the device and waits.
    pub(crate) fn read(&self, queue: &CommandQueue, first: usize, into: &mut [T]) -> Result<(), ClError> {
        self.check(first, into.len())?;
        if !into.is_empty() {
            // SAFETY: the range was checked, the read blocks, so `into` outlives it, and any bytes are a `T`.
            unsafe {
                queue.enqueue_read_buffer(&self.memory, CL_BLOCKING, first * size_of::<T>(), into, &[])
            }?;
        }
        Ok(())
    }

    /// Shows the elements to `reader`, without a copy where host and device share memory.
    pub(crate) fn map(&mut self, queue: &CommandQueue, reader: &mut dyn FnMut(&[T])) -> Result<(), ClError> {
        if self.len == 0 {
            reader(&[]);
            return Ok(());
        }
        let mut address = ptr::null_mut();
        // SAFETY: the whole buffer is mapped, and the call blocks until the mapping is valid.
        unsafe {
            queue.enqueue_map_buffer(
                &self.memory,
                CL_BLOCKING,
                CL_MAP_READ,
                0,
                self.bytes(),
                &mut address,
                &[],
            )
        }?;
        // SAFETY: the mapping holds `len` elements, aligned by the driver to its largest type (128 bytes), any bytes
        // are a `T`, and `self` is borrowed mutably, so nothing is enqueued on the buffer until it is unmapped below.
        reader(unsafe { std::slice::from_raw_parts(address.cast::<T>(), self.len) });
        // SAFETY: the address is the one that mapping this buffer gave; the slice is gone.
        unsafe { queue.enqueue_unmap_mem_object(self.memory.get(), address, &[]) }?;
        queue.finish()
    }
}
