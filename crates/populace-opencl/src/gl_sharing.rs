//! Memory that OpenGL lends for palettes, and OpenCL contexts made for a context of OpenGL's.
//!
//! Sharing follows the extension `cl_khr_gl_sharing` of the OpenCL 3.0 extension specification
//! ("Lifetime of Shared Objects", "Synchronizing OpenCL and OpenGL Access to Shared Objects"). It
//! has not been run on a graphics processor yet: every driver at hand refuses it.
#![expect(
    unsafe_code,
    reason = "the OpenCL API is C; memory that it does not own is part of the crate's boundary to \
              it"
)]

use std::ffi::c_void;
use std::ptr;
use std::sync::Arc;

use opencl3::command_queue::CommandQueue;
use opencl3::context::Context;
use opencl3::device::Device;
use opencl3::error_codes::ClError;
use opencl3::memory::{Buffer as ClBuffer, CL_MEM_READ_WRITE, CL_MEM_USE_HOST_PTR, ClMem};
use populace_device::layout::Float4;
use populace_device::{BackendError, GlContext, MappedPage, PAGE_SETS, PaletteTarget, SharedPage};

use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::waits;

const EXTENSION: &str = "cl_khr_gl_sharing";
// Names of the properties of a context, from the specifications of OpenCL 1.0 and
// cl_khr_gl_sharing.
const CONTEXT_PLATFORM: isize = 0x1084;
const GL_CONTEXT: isize = 0x2008;
const EGL_DISPLAY: isize = 0x2009;

/// Why buffers are not shared where the driver cannot do it at all.
pub(crate) const NOT_OFFERED: &str = "its driver does not offer cl_khr_gl_sharing";

pub(crate) fn is_offered(device: &Device) -> Result<bool, ClError> {
    Ok(device.extensions()?.split_whitespace().any(|name| name == EXTENSION))
}

/// A context that shares with one of OpenGL's, which is alive and must stay so for as long as this
/// one.
pub(crate) fn context_for(device: &Device, gl: &dyn GlContext) -> Result<Context, ClError> {
    let gl = gl.handles();
    let platform = device.platform()? as isize;
    let (context, display) = (gl.context.cast_signed(), gl.display.cast_signed());
    let properties = [GL_CONTEXT, context, EGL_DISPLAY, display, CONTEXT_PLATFORM, platform, 0];
    Context::from_devices(&[device.id()], &properties, None, ptr::null_mut())
}

/// Two sets of pages that OpenGL lends, written in turns.
pub(crate) struct LentPages {
    sets: [Vec<LentPage>; PAGE_SETS],
    /// The set that the last frame was written into, or is to be while there is none.
    current: usize,
    /// Whether OpenGL draws from it, so that the next frame goes into the other.
    handed_over: bool,
    /// Whether the current set, of shared pages, is acquired from OpenGL.
    acquired: bool,
    /// The only queue that the pages are used on.
    queue: Arc<CommandQueue>,
}

/// A page, and whoever owns its memory; in this order, since OpenCL must let go of it first.
struct LentPage {
    buffer: Buffer<Float4>,
    lender: Lender,
}

enum Lender {
    Mapped(
        #[expect(dead_code, reason = "held so that the memory stays valid")] Box<dyn MappedPage>,
    ),
    Shared(
        #[expect(dead_code, reason = "held so that the buffer stays in OpenGL")]
        Box<dyn SharedPage>,
    ),
}

impl LentPages {
    /// `None` for a target that lends nothing.
    pub(crate) fn new(
        device: &OpenClDevice,
        queue: &Arc<CommandQueue>,
        target: PaletteTarget,
    ) -> Result<Option<Self>, BackendError> {
        let fail = |e: ClError| device.failed("write palettes into memory of OpenGL's", &e);
        let sets = match target {
            PaletteTarget::Copied => return Ok(None),
            PaletteTarget::Mapped(sets) => {
                sets.map(|set| set.into_iter().map(|page| LentPage::mapped(device, page)).collect())
            }
            PaletteTarget::Shared(sets) => {
                sets.map(|set| set.into_iter().map(|page| LentPage::shared(device, page)).collect())
            }
        };
        let [first, second]: [Result<Vec<_>, _>; PAGE_SETS] = sets;
        let sets = [first.map_err(fail)?, second.map_err(fail)?];
        Ok(Some(Self {
            sets,
            current: 0,
            handed_over: false,
            acquired: false,
            queue: Arc::clone(queue),
        }))
    }

    /// Makes each page of both sets as long as that many entries, or says that there is no room.
    pub(crate) fn resize(&mut self, entries: &[usize]) -> bool {
        self.sets.iter_mut().all(|set| {
            entries.len() <= set.len()
                && set
                    .iter_mut()
                    .zip(entries)
                    .all(|(page, entries)| page.buffer.resize(entries * 3))
        })
    }

    /// The pages that were written last.
    pub(crate) fn pages(&self) -> impl Iterator<Item = &Buffer<Float4>> {
        self.sets[self.current].iter().map(|page| &page.buffer)
    }

    pub(crate) fn get_mut(&mut self, page: usize) -> Option<&mut Buffer<Float4>> {
        self.sets[self.current].get_mut(page).map(|page| &mut page.buffer)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.sets.iter().flatten().map(|page| page.buffer.capacity_bytes()).sum()
    }

    /// Turns to a set that OpenGL does not draw from.
    pub(crate) fn begin_frame(&mut self) -> Result<(), ClError> {
        if std::mem::take(&mut self.handed_over) {
            self.current = (self.current + 1) % PAGE_SETS;
        }
        self.acquire()
    }

    /// Waits for the frame and gives the set to OpenGL.
    pub(crate) fn hand_over(&mut self) -> Result<usize, ClError> {
        if !self.handed_over {
            self.release()?;
            for page in &mut self.sets[self.current] {
                // What a device wrote into memory of the host's counts as being there once it was
                // mapped.
                if matches!(page.lender, Lender::Mapped(_)) {
                    page.buffer.map(&self.queue, &mut |_| ())?;
                }
            }
            self.handed_over = true;
        }
        Ok(self.current)
    }

    /// Calls `job` with the set that was written last, whoever has it just now. OpenGL may be
    /// drawing from it; a job that only reads takes nothing away from it.
    pub(crate) fn look_at<R>(
        &mut self,
        job: impl FnOnce(&mut Self) -> Result<R, ClError>,
    ) -> Result<R, ClError> {
        if !self.handed_over {
            self.acquire()?;
            return job(self);
        }
        self.acquire()?;
        let result = job(self);
        self.release()?;
        result
    }

    /// Takes shared pages from OpenGL. Their lender promised that OpenGL is done with new ones, and
    /// a renderer waits until it is done with a set before a frame goes there.
    fn acquire(&mut self) -> Result<(), ClError> {
        let objects = self.shared_objects();
        if !(self.acquired || objects.is_empty()) {
            // SAFETY: all are buffers that `LentPage::shared` made from OpenGL's, in the queue's
            // context, which was made for OpenGL; their lenders keep them there.
            unsafe { self.queue.enqueue_acquire_gl_objects(&objects, &[]) }?;
            self.acquired = true;
        }
        Ok(())
    }

    /// Gives shared pages back to OpenGL, and waits until it can have them.
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
        let shared =
            self.sets[self.current].iter().filter(|page| matches!(page.lender, Lender::Shared(_)));
        shared.map(|page| page.buffer.handle().cast_const()).collect()
    }
}

impl Drop for LentPages {
    fn drop(&mut self) {
        // The driver counts references to its own memory, but lent memory goes when its lender
        // does.
        if self.release().and_then(|()| waits::for_queue(&self.queue)).is_err() {
            // A device that cannot say that it is done may still write: nobody gets this memory
            // back.
            self.sets.iter_mut().flat_map(std::mem::take).for_each(std::mem::forget);
        }
    }
}

impl LentPage {
    fn mapped(device: &OpenClDevice, mut page: Box<dyn MappedPage>) -> Result<Self, ClError> {
        let elements = page.elements();
        let (len, address) = (elements.len(), elements.as_mut_ptr());
        let flags = CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR;
        // SAFETY: `MappedPage` promises that the memory is valid until the page is dropped, and
        // `LentPages` drops it only once the queue is done with the buffer.
        let memory = unsafe { ClBuffer::create(&device.context, flags, len, address.cast()) }?;
        // SAFETY: the memory was made for `len` elements just now.
        let buffer = unsafe { Buffer::from_memory(memory, len) };
        Ok(Self { buffer, lender: Lender::Mapped(page) })
    }

    fn shared(device: &OpenClDevice, page: Box<dyn SharedPage>) -> Result<Self, ClError> {
        const INVALID_CONTEXT: i32 = -34;
        const INVALID_BUFFER_SIZE: i32 = -61;
        if device.gl.as_ref().map(|gl| gl.handles()) != Some(page.handles()) {
            return Err(ClError(INVALID_CONTEXT));
        }
        // SAFETY: the context was made for the one that the page is of, as checked above;
        // `SharedPage` promises that the buffer is there until the page is dropped, and `LentPages`
        // drops it only once the queue is done with it.
        let memory = unsafe {
            ClBuffer::create_from_gl_buffer(&device.context, CL_MEM_READ_WRITE, page.buffer().get())
        }?;
        let len = page.len();
        if memory.size()? < len.saturating_mul(size_of::<Float4>()) {
            return Err(ClError(INVALID_BUFFER_SIZE));
        }
        // SAFETY: the driver says that there is room for `len` elements.
        let buffer = unsafe { Buffer::from_memory(memory, len) };
        Ok(Self { buffer, lender: Lender::Shared(page) })
    }
}
