//! Device memory with a known length and element type, so that copies are safe functions.
#![expect(
    unsafe_code,
    reason = "the OpenCL API is C; allocation and copies are part of the crate's boundary to it"
)]

use std::ffi::c_void;
use std::ops::Range;
use std::ptr;

use opencl3::command_queue::{enqueue_read_buffer, enqueue_write_buffer};
use opencl3::error_codes::ClError;
use opencl3::event;
use opencl3::memory::{
    Buffer as ClBuffer, CL_MAP_READ, CL_MAP_WRITE_INVALIDATE_REGION, CL_MEM_ALLOC_HOST_PTR,
    CL_MEM_READ_WRITE, ClMem,
};
use opencl3::types::{CL_BLOCKING, CL_NON_BLOCKING, cl_map_flags};
use populace_device::BackendError;
use populace_device::layout::{
    Body, BoundBlock, BoundClip, ClipRows, Condition, Constraint, Contact, Control, DeviceStruct,
    Entry, Float4, Ground, Layer, Link, MachineInstance, MachineState, Member, Override, Running,
    Slot, SlotSample, Step, Target, Transition,
};

use crate::handles::{CommandQueue, Event, Memory};
use crate::{OpenClDevice, waits};

/// An element type that kernels know by name.
pub(crate) trait Element: bytemuck::Pod {
    /// The name in OpenCL C.
    const TYPE_NAME: &'static str;
}

macro_rules! elements {
    ($($rust:ty => $name:expr),* $(,)?) => {
        $(impl Element for $rust {
            const TYPE_NAME: &'static str = $name;
        })*
    };
}
macro_rules! struct_elements {
    ($($name:ident),* $(,)?) => { elements! { $($name => $name::NAME),* } };
}
elements! { f32 => "float", u32 => "uint", Float4 => "float4" }
struct_elements! {
    Body, Entry, ClipRows, BoundClip, BoundBlock, Slot, Layer, Member, SlotSample,
    Contact, Control, Step, Override, Constraint, Link, Target, Ground, MachineState, Transition,
    Condition, MachineInstance, Running,
}

/// Elements that are written at once to fill a buffer with zeros.
const ZEROS: usize = 1 << 16;

/// `CL_OUT_OF_HOST_MEMORY`.
const OUT_OF_HOST_MEMORY: i32 = -6;
/// `CL_INVALID_VALUE`.
pub(crate) const INVALID_VALUE: i32 = -30;

/// Words of host memory that a device reads asynchronously.
#[derive(Default)]
pub(crate) struct StagingWords {
    words: Vec<u32>,
    /// Uploads from these words that may not have completed.
    reads: Vec<Event>,
}

impl StagingWords {
    /// Returns whether all uploads have completed.
    pub(crate) fn is_done(&self) -> Result<bool, ClError> {
        for read in &self.reads {
            if !waits::is_done(read)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Waits until all uploads have completed, and returns the words for changing.
    pub(crate) fn words(&mut self) -> Result<&mut Vec<u32>, ClError> {
        for read in &self.reads {
            waits::for_event(read)?;
        }
        self.reads.clear();
        Ok(&mut self.words)
    }
}

impl Drop for StagingWords {
    fn drop(&mut self) {
        if self.words().is_err() {
            // The device may still read the words, since it does not tell whether it has finished.
            std::mem::forget(std::mem::take(&mut self.words));
        }
    }
}

/// `len` elements on a device.
pub(crate) struct Buffer<T> {
    memory: Memory<T>,
    len: usize,
    /// Elements that fit into the memory.
    capacity: usize,
}

/// Elements that a device writes asynchronously.
#[derive(Default)]
pub(crate) struct AsyncRead<T> {
    elements: Vec<T>,
    /// The read that writes them, if it may not have completed.
    read: Option<Event>,
}

impl<T> AsyncRead<T> {
    /// Returns whether the read has completed.
    pub(crate) fn is_done(&mut self) -> Result<bool, ClError> {
        if let Some(read) = &self.read
            && !waits::is_done(read)?
        {
            return Ok(false);
        }
        self.read = None;
        Ok(true)
    }

    /// Returns the elements; none while the read is in progress.
    pub(crate) fn elements(&self) -> &[T] {
        if self.read.is_none() { &self.elements } else { &[] }
    }
}

impl<T> Drop for AsyncRead<T> {
    fn drop(&mut self) {
        // The device writes into the elements until then. If it does not tell whether it has
        // finished, they are never freed.
        if let Some(read) = &self.read
            && waits::for_event(read).is_err()
        {
            std::mem::forget(std::mem::take(&mut self.elements));
        }
    }
}

impl<T: Element> Buffer<T> {
    /// Allocates `len` elements. `what` names the buffer in errors. An empty buffer holds one
    /// element, since devices refuse empty ones.
    pub(crate) fn new(device: &OpenClDevice, len: usize, what: &str) -> Result<Self, BackendError> {
        let count = len.max(1);
        let bytes = count.saturating_mul(size_of::<T>());
        let out_of_memory = || BackendError::OutOfMemory {
            device: device.info.name.clone(),
            what: what.into(),
            bytes,
        };
        if bytes as u64 > device.info.max_allocation_bytes {
            return Err(out_of_memory());
        }
        // Host-visible memory lets a page be mapped without a copy if host and device share memory.
        let flags = CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR;
        // SAFETY: no host pointer is given, and the context is alive in `device`.
        let memory = unsafe { ClBuffer::create(&device.context, flags, count, ptr::null_mut()) };
        let memory = memory.map_err(|error| match error {
            ClError(-6..=-4 | -61) => out_of_memory(),
            other => device.failed(&format!("allocate {what}"), &other),
        })?;
        Ok(Self { memory: memory.into(), len, capacity: count })
    }

    /// Wraps existing memory.
    ///
    /// # Safety
    ///
    /// The memory must hold at least `len` elements, and must stay valid for as long as the queue
    /// uses the buffer.
    pub(crate) unsafe fn from_memory(memory: ClBuffer<T>, len: usize) -> Self {
        Self { memory: memory.into(), len, capacity: len }
    }

    /// Sets the length and returns true if the memory suffices, else returns false.
    pub(crate) fn resize(&mut self, len: usize) -> bool {
        let fits = len <= self.capacity;
        if fits {
            self.len = len;
        }
        fits
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(crate) fn bytes(&self) -> usize {
        self.len * size_of::<T>()
    }

    pub(crate) fn capacity_bytes(&self) -> usize {
        self.capacity * size_of::<T>()
    }

    pub(crate) fn handle(&self) -> *mut c_void {
        self.memory.get()
    }

    fn check(&self, first: usize, count: usize) -> Result<(), ClError> {
        if first.checked_add(count).is_some_and(|end| end <= self.len) {
            Ok(())
        } else {
            Err(ClError(INVALID_VALUE))
        }
    }

    /// Copies elements to the device and waits.
    pub(crate) fn write(
        &mut self,
        queue: &CommandQueue,
        first: usize,
        from: &[T],
    ) -> Result<(), ClError> {
        self.check(first, from.len())?;
        if !from.is_empty() {
            waits::begin();
            // SAFETY: the range was checked, and the write blocks, so `from` outlives it.
            unsafe {
                queue.enqueue_write_buffer(
                    &mut self.memory,
                    CL_BLOCKING,
                    first * size_of::<T>(),
                    from,
                    &[],
                )
            }?;
        }
        Ok(())
    }

    /// Copies elements to the device without waiting, from word `word_first` of `from` on, which
    /// keeps the words until they are read.
    pub(crate) fn write_staged(
        &mut self,
        queue: &CommandQueue,
        elements: Range<usize>,
        from: &mut StagingWords,
        word_first: usize,
    ) -> Result<(), ClError> {
        self.check(elements.start, elements.len())?;
        let bytes = elements.len() * size_of::<T>();
        let words = word_first..word_first + bytes.div_ceil(size_of::<u32>());
        let words = from.words.get(words).ok_or(ClError(INVALID_VALUE))?;
        if words.is_empty() {
            return Ok(());
        }
        let (offset, address) = (elements.start * size_of::<T>(), words.as_ptr().cast());
        let (queue, memory) = (queue.get(), self.memory.get_mut());
        // SAFETY: both ranges were checked. `from` changes or frees its words only after the event
        // kept here, and the driver counts references to the buffer.
        let event = unsafe {
            enqueue_write_buffer(
                queue,
                memory,
                CL_NON_BLOCKING,
                offset,
                bytes,
                address,
                0,
                ptr::null(),
            )
        }
        .map_err(ClError)?;
        from.reads.push(event::Event::new(event).into());
        Ok(())
    }

    /// Copies elements from the device and waits.
    pub(crate) fn read(
        &self,
        queue: &CommandQueue,
        first: usize,
        into: &mut [T],
    ) -> Result<(), ClError> {
        self.check(first, into.len())?;
        if !into.is_empty() {
            waits::begin();
            // SAFETY: the range was checked, the read blocks, so `into` outlives it, and any bytes
            // are a `T`.
            unsafe {
                queue.enqueue_read_buffer(
                    &self.memory,
                    CL_BLOCKING,
                    first * size_of::<T>(),
                    into,
                    &[],
                )
            }?;
        }
        Ok(())
    }

    /// Starts a copy of the first `count` elements from the device. `into` must have no read in
    /// progress.
    pub(crate) fn read_async(
        &self,
        queue: &CommandQueue,
        count: usize,
        into: &mut AsyncRead<T>,
    ) -> Result<(), ClError> {
        self.check(0, count)?;
        if into.read.is_some() {
            return Err(ClError(INVALID_VALUE));
        }
        let additional = count.saturating_sub(into.elements.len());
        into.elements.try_reserve(additional).map_err(|_| ClError(OUT_OF_HOST_MEMORY))?;
        into.elements.resize(count, T::zeroed());
        if count > 0 {
            let (bytes, address) = (count * size_of::<T>(), into.elements.as_mut_ptr().cast());
            let (queue, memory) = (queue.get(), self.memory.get());
            // SAFETY: the range was checked. `into` neither shows, changes nor frees its elements
            // before the event kept here is done, any bytes are a `T`, and the driver counts
            // references to the buffer.
            let event = unsafe {
                enqueue_read_buffer(
                    queue,
                    memory,
                    CL_NON_BLOCKING,
                    0,
                    bytes,
                    address,
                    0,
                    ptr::null(),
                )
            };
            into.read = Some(event::Event::new(event.map_err(ClError)?).into());
        }
        Ok(())
    }

    /// Grows to at least `count` elements. The contents stay, and zeros follow.
    pub(crate) fn grow(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        count: usize,
        what: &str,
    ) -> Result<(), BackendError> {
        if let Some(larger) = self.grown(device, queue, count, what)? {
            *self = larger;
        }
        Ok(())
    }

    /// Grows two buffers of equal length, which are copied to each other: both or, after an error,
    /// neither.
    pub(crate) fn grow_pair(
        [first, second]: [&mut Self; 2],
        device: &OpenClDevice,
        queue: &CommandQueue,
        count: usize,
        what: &str,
    ) -> Result<(), BackendError> {
        let larger_first = first.grown(device, queue, count, what)?;
        if let Some(larger) = second.grown(device, queue, count, what)? {
            *second = larger;
        }
        if let Some(larger) = larger_first {
            *first = larger;
        }
        Ok(())
    }

    /// Returns a buffer of at least `count` elements with the same contents and zeros after them;
    /// `None` if this one is as long.
    fn grown(
        &self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        count: usize,
        what: &str,
    ) -> Result<Option<Self>, BackendError> {
        if count <= self.len {
            return Ok(None);
        }
        let capacity = count.next_power_of_two();
        let mut larger = Self::new(device, capacity, what)?;
        let zeros = vec![T::zeroed(); capacity.min(ZEROS)];
        let mut firsts = (0..capacity).step_by(ZEROS);
        let filled = firsts.try_for_each(|first| {
            larger.write(queue, first, &zeros[..ZEROS.min(capacity - first)])
        });
        filled
            .and_then(|()| larger.copy_from(queue, self))
            .map_err(|e| device.failed("grow a buffer", &e))?;
        Ok(Some(larger))
    }

    /// Enqueues the filling of a range with zeros.
    pub(crate) fn clear(
        &mut self,
        queue: &CommandQueue,
        elements: Range<usize>,
    ) -> Result<(), ClError> {
        self.check(elements.start, elements.len())?;
        if !elements.is_empty() {
            let (offset, bytes) =
                (elements.start * size_of::<T>(), elements.len() * size_of::<T>());
            // SAFETY: the range was checked, and the driver copies the pattern before the call
            // returns.
            unsafe {
                queue.enqueue_fill_buffer(&mut self.memory, &[T::zeroed()], offset, bytes, &[])
            }?;
        }
        Ok(())
    }

    /// Enqueues a copy of all elements of `from`, which must not be longer than this buffer.
    pub(crate) fn copy_from(&mut self, queue: &CommandQueue, from: &Self) -> Result<(), ClError> {
        self.copy_first(queue, from, from.len)
    }

    /// Enqueues a copy of the first `count` elements of `from`.
    pub(crate) fn copy_first(
        &mut self,
        queue: &CommandQueue,
        from: &Self,
        count: usize,
    ) -> Result<(), ClError> {
        self.check(0, count)?;
        from.check(0, count)?;
        if count > 0 {
            let bytes = count * size_of::<T>();
            // SAFETY: both buffers hold that many bytes, and they differ, since one is borrowed
            // mutably.
            unsafe { queue.enqueue_copy_buffer(&from.memory, &mut self.memory, 0, 0, bytes, &[]) }?;
        }
        Ok(())
    }

    /// Maps the buffer and passes its elements to `reader`, without a copy if host and device share
    /// memory.
    pub(crate) fn map(
        &mut self,
        queue: &CommandQueue,
        reader: &mut dyn FnMut(&[T]),
    ) -> Result<(), ClError> {
        if self.len == 0 {
            reader(&[]);
            return Ok(());
        }
        self.mapped(queue, CL_MAP_READ, |address| {
            // SAFETY: the mapping holds `len` elements, aligned by the driver to its largest type
            // (128 bytes), any bytes are a `T`, and `self` is borrowed mutably, so nothing is
            // enqueued on the buffer until it is unmapped.
            reader(unsafe { std::slice::from_raw_parts(address.cast::<T>(), self.len) });
        })
    }

    /// Asks for large pages for new memory of a device that shares memory with the host. The
    /// contents are lost.
    #[cfg(target_os = "linux")]
    pub(crate) fn prefer_large_pages(&self, queue: &CommandQueue) -> Result<(), ClError> {
        if self.len == 0 {
            return Ok(());
        }
        self.mapped(queue, CL_MAP_WRITE_INVALIDATE_REGION, |address| {
            // SAFETY: the mapping holds the whole buffer.
            unsafe { crate::large_pages::ask_for(address, self.bytes()) }
        })
    }

    /// Maps the whole buffer and passes its address.
    fn mapped(
        &self,
        queue: &CommandQueue,
        flags: cl_map_flags,
        act: impl FnOnce(*mut c_void),
    ) -> Result<(), ClError> {
        let mut address = ptr::null_mut();
        waits::begin();
        // SAFETY: the whole buffer is mapped, and the call blocks until the mapping is valid.
        unsafe {
            queue.enqueue_map_buffer(
                &self.memory,
                CL_BLOCKING,
                flags,
                0,
                self.bytes(),
                &mut address,
                &[],
            )
        }?;
        act(address);
        // SAFETY: the address is the one that mapping this buffer gave, and `act` is done with it.
        unsafe { queue.enqueue_unmap_mem_object(self.memory.get(), address, &[]) }?;
        waits::for_queue(queue)
    }
}
