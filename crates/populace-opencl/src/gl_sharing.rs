//! Palette pages in memory shared with OpenGL.
//!
//! Sharing follows the extension `cl_khr_gl_sharing` of the OpenCL 3.0 extension specification
//! ("Lifetime of Shared Objects", "Synchronizing OpenCL and OpenGL Access to Shared Objects"). It
//! has not been run on a graphics processor yet, because no available driver supports it.
#![expect(
    unsafe_code,
    reason = "the OpenCL API is C; memory that it does not own is part of the crate's boundary to \
              it"
)]

use std::ffi::c_void;
use std::sync::Arc;

use opencl3::error_codes::ClError;
use opencl3::memory::{Buffer as ClBuffer, CL_MEM_READ_WRITE, CL_MEM_USE_HOST_PTR, ClMem};
use populace_device::layout::Float4;
use populace_device::{BackendError, MappedPage, PAGE_SETS, PaletteTarget, SharedPage};

use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::handles::CommandQueue;
use crate::waits;

/// Two sets of pages from OpenGL, written alternately.
pub(crate) struct InteropPages {
    sets: [Vec<InteropPage>; PAGE_SETS],
    /// The set of the last frame, or of the first frame before there is one.
    current: usize,
    /// True if OpenGL draws from the current set, so that the next frame goes into the other.
    released: bool,
    /// True if the current set, of shared pages, is acquired from OpenGL.
    acquired: bool,
    /// The only queue that uses the pages.
    queue: Arc<CommandQueue>,
}

/// A page and the owner of its memory, in this order, since OpenCL must release the buffer first.
struct InteropPage {
    buffer: Buffer<Float4>,
    owner: PageOwner,
}

enum PageOwner {
    Mapped(
        #[expect(dead_code, reason = "held so that the memory stays valid")] Box<dyn MappedPage>,
    ),
    Shared(
        #[expect(dead_code, reason = "held so that the buffer stays in OpenGL")]
        Box<dyn SharedPage>,
    ),
}

impl InteropPages {
    /// Returns `None` for a target without memory of its own.
    pub(crate) fn new(
        device: &OpenClDevice,
        queue: &Arc<CommandQueue>,
        target: PaletteTarget,
    ) -> Result<Option<Self>, BackendError> {
        let fail = |e: ClError| device.failed("write palettes into OpenGL memory", &e);
        let sets = match target {
            PaletteTarget::Copied => return Ok(None),
            PaletteTarget::Mapped(sets) => sets
                .map(|set| set.into_iter().map(|page| InteropPage::mapped(device, page)).collect()),
            PaletteTarget::Shared(sets) => sets
                .map(|set| set.into_iter().map(|page| InteropPage::shared(device, page)).collect()),
        };
        let [first, second]: [Result<Vec<_>, _>; PAGE_SETS] = sets;
        let sets = [first.map_err(fail)?, second.map_err(fail)?];
        Ok(Some(Self {
            sets,
            current: 0,
            released: false,
            acquired: false,
            queue: Arc::clone(queue),
        }))
    }

    /// Sets the lengths of the pages of both sets, in entries. Returns false if they do not fit.
    pub(crate) fn resize(&mut self, entries: &[usize]) -> bool {
        self.sets.iter_mut().all(|set| {
            entries.len() <= set.len()
                && set
                    .iter_mut()
                    .zip(entries)
                    .all(|(page, entries)| page.buffer.resize(entries * 3))
        })
    }

    /// Returns the pages of the last frame.
    pub(crate) fn pages(&self) -> impl Iterator<Item = &Buffer<Float4>> {
        self.sets[self.current].iter().map(|page| &page.buffer)
    }

    pub(crate) fn get_mut(&mut self, page: usize) -> Option<&mut Buffer<Float4>> {
        self.sets[self.current].get_mut(page).map(|page| &mut page.buffer)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.sets.iter().flatten().map(|page| page.buffer.capacity_bytes()).sum()
    }

    /// Switches to a set that OpenGL does not draw from.
    pub(crate) fn begin_frame(&mut self) -> Result<(), ClError> {
        if std::mem::take(&mut self.released) {
            self.current = (self.current + 1) % PAGE_SETS;
        }
        self.acquire()
    }

    /// Waits for the frame and releases the set to OpenGL. Returns the set's index.
    pub(crate) fn release_current(&mut self) -> Result<usize, ClError> {
        if !self.released {
            self.release()?;
            for page in &mut self.sets[self.current] {
                // The host sees what a device wrote into host memory only after mapping it.
                if matches!(page.owner, PageOwner::Mapped(_)) {
                    page.buffer.map(&self.queue, &mut |_| ())?;
                }
            }
            self.released = true;
        }
        Ok(self.current)
    }

    /// Calls `job` with the set of the last frame, acquiring it if OpenGL has it. OpenGL may be
    /// drawing from it, so a job that only reads is always safe.
    pub(crate) fn with_buffer<R>(
        &mut self,
        job: impl FnOnce(&mut Self) -> Result<R, ClError>,
    ) -> Result<R, ClError> {
        if !self.released {
            self.acquire()?;
            return job(self);
        }
        self.acquire()?;
        let result = job(self);
        self.release()?;
        result
    }

    /// Acquires shared pages from OpenGL. Their owner guarantees that OpenGL has finished with new
    /// pages, and a renderer waits until it has finished with a set before a frame goes there.
    fn acquire(&mut self) -> Result<(), ClError> {
        let objects = self.shared_objects();
        if !(self.acquired || objects.is_empty()) {
            // SAFETY: all are buffers that `InteropPage::shared` made from OpenGL's, in the queue's
            // context, which was made for OpenGL; their owners keep them there.
            unsafe { self.queue.enqueue_acquire_gl_objects(&objects, &[]) }?;
            self.acquired = true;
        }
        Ok(())
    }

    /// Releases shared pages to OpenGL, and waits until it can use them.
    fn release(&mut self) -> Result<(), ClError> {
        if self.acquired {
            // SAFETY: as in `acquire`; they were acquired on the same queue.
            unsafe { self.queue.enqueue_release_gl_objects(&self.shared_objects(), &[]) }?;
            self.acquired = false;
            waits::for_queue(&self.queue)?;
        }
        Ok(())
    }

    fn shared_objects(&self) -> Vec<*const c_void> {
        let shared = self.sets[self.current]
            .iter()
            .filter(|page| matches!(page.owner, PageOwner::Shared(_)));
        shared.map(|page| page.buffer.handle().cast_const()).collect()
    }
}

impl Drop for InteropPages {
    fn drop(&mut self) {
        // The driver counts references to its own memory, but shared memory goes when its owner
        // does.
        if self.release().and_then(|()| waits::for_queue(&self.queue)).is_err() {
            // A device that cannot tell that it has finished may still write, so this memory is
            // never freed.
            self.sets.iter_mut().flat_map(std::mem::take).for_each(std::mem::forget);
        }
    }
}

impl InteropPage {
    fn mapped(device: &OpenClDevice, mut page: Box<dyn MappedPage>) -> Result<Self, ClError> {
        let elements = page.elements();
        let (len, address) = (elements.len(), elements.as_mut_ptr());
        let flags = CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR;
        // SAFETY: `MappedPage` promises that the memory is valid until the page is dropped, and
        // `InteropPages` drops it only once the queue is done with the buffer.
        let memory = unsafe { ClBuffer::create(&device.context, flags, len, address.cast()) }?;
        // SAFETY: the memory was made for `len` elements just now.
        let buffer = unsafe { Buffer::from_memory(memory, len) };
        Ok(Self { buffer, owner: PageOwner::Mapped(page) })
    }

    fn shared(device: &OpenClDevice, page: Box<dyn SharedPage>) -> Result<Self, ClError> {
        const INVALID_CONTEXT: i32 = -34;
        const INVALID_BUFFER_SIZE: i32 = -61;
        if device.gl.as_ref().map(|gl| gl.handles()) != Some(page.handles()) {
            return Err(ClError(INVALID_CONTEXT));
        }
        // SAFETY: the context was made for the page's OpenGL context, as checked above;
        // `SharedPage` promises that the buffer is there until the page is dropped, and
        // `InteropPages` drops it only once the queue is done with it.
        let memory = unsafe {
            ClBuffer::create_from_gl_buffer(&device.context, CL_MEM_READ_WRITE, page.buffer().get())
        }?;
        let len = page.len();
        if memory.size()? < len.saturating_mul(size_of::<Float4>()) {
            return Err(ClError(INVALID_BUFFER_SIZE));
        }
        // SAFETY: the driver says that there is room for `len` elements.
        let buffer = unsafe { Buffer::from_memory(memory, len) };
        Ok(Self { buffer, owner: PageOwner::Shared(page) })
    }
}
