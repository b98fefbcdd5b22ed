//! Buffers that devices write palettes into, and fences that tell when OpenGL has read them.

use std::num::NonZeroU32;
use std::ptr::NonNull;
use std::rc::Rc;
use std::sync::Arc;

use glow::HasContext as _;
use populace_device::layout::Float4;
use populace_device::{EglHandles, GlContext as _, MappedPage, SharedPage};

use super::{Gl, egl};
use crate::Error;

/// Reads too: a crowd gives its palettes to whoever asks, wherever they stand.
const MAPPED: u32 =
    glow::MAP_READ_BIT | glow::MAP_WRITE_BIT | glow::MAP_PERSISTENT_BIT | glow::MAP_COHERENT_BIT;

/// A page of palettes for a device to write and OpenGL to draw from.
pub(crate) struct Page {
    gl: Rc<Gl>,
    raw: glow::Buffer,
    /// Shared with the loan until it is dropped.
    loan: Arc<()>,
}

/// What every loan holds.
struct Loan {
    len: usize,
    /// The buffer is not deleted while a clone of the page's own is held.
    _page: Arc<()>,
    /// The context, and with it the buffer, outlives the renderer if need be.
    context: Arc<egl::Context>,
}

struct MappedLoan {
    address: NonNull<Float4>,
    loan: Loan,
}

struct SharedLoan {
    buffer: NonZeroU32,
    loan: Loan,
}

impl Page {
    /// A page that stays mapped, of zeros, and its memory.
    pub(crate) fn mapped(
        gl: &Rc<Gl>,
        elements: usize,
    ) -> Result<(Self, Box<dyn MappedPage>), Error> {
        let (page, bytes) = Self::new(gl, elements)?;
        // SAFETY: the context is current and offers buffer storage, which `Limits::maps_buffers`
        // told the caller; the buffer is bound, and what is refused shows in `check`.
        let address = unsafe {
            gl.functions.buffer_storage(glow::COPY_WRITE_BUFFER, bytes, None, MAPPED);
            gl.functions.map_buffer_range(glow::COPY_WRITE_BUFFER, 0, bytes, MAPPED)
        };
        gl.check("map a page of palettes")?;
        let Some(address) = NonNull::new(address.cast::<Float4>()).filter(|a| a.is_aligned())
        else {
            let (operation, code) = ("map a page of palettes".into(), "no address".into());
            return Err(Error::GlError { operation, code });
        };
        // SAFETY: the mapping is `elements` long and writable, and nobody else has its address.
        unsafe { address.as_ptr().write_bytes(0, elements) };
        let loan = page.loan(elements);
        Ok((page, Box::new(MappedLoan { address, loan })))
    }

    /// A page that OpenCL takes over as a buffer of its own.
    pub(crate) fn shared(
        gl: &Rc<Gl>,
        elements: usize,
    ) -> Result<(Self, Box<dyn SharedPage>), Error> {
        let (page, bytes) = Self::new(gl, elements)?;
        // SAFETY: the context is current and the buffer bound; what is refused shows in `check`.
        unsafe {
            gl.functions.buffer_data_size(glow::COPY_WRITE_BUFFER, bytes, glow::DYNAMIC_COPY)
        };
        gl.check("make a page of palettes")?;
        // SAFETY: the context is current. OpenCL asks that OpenGL be done with a buffer before it
        // takes it over.
        unsafe { gl.functions.finish() };
        let (buffer, loan) = (page.raw.0, page.loan(elements));
        Ok((page, Box::new(SharedLoan { buffer, loan })))
    }

    /// A buffer without storage, bound for copying, and the bytes that so many elements take.
    fn new(gl: &Rc<Gl>, elements: usize) -> Result<(Self, i32), Error> {
        let size = (elements * size_of::<Float4>()) as u64;
        let limit = gl.limits().storage_bytes.min(i32::MAX as u64);
        let bytes = i32::try_from(size).ok().filter(|_| size <= limit);
        let bytes =
            bytes.ok_or(Error::TooLarge { what: "the size in bytes of a page", size, limit })?;
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.create_buffer() }
            .map_err(|code| Error::GlError { operation: "create a buffer".into(), code })?;
        // SAFETY: the context is current; the name is ours.
        unsafe { gl.functions.bind_buffer(glow::COPY_WRITE_BUFFER, Some(raw)) };
        Ok((Self { gl: Rc::clone(gl), raw, loan: Arc::default() }, bytes))
    }

    fn loan(&self, len: usize) -> Loan {
        Loan { len, _page: Arc::clone(&self.loan), context: Arc::clone(&self.gl.context) }
    }

    /// Binds the whole page as the storage block of a binding point.
    pub(crate) fn bind_storage(&self, binding: u32) {
        // SAFETY: the context is current; OpenGL 4.3 has at least 8 binding points, and ours are
        // below.
        unsafe {
            self.gl.functions.bind_buffer_base(
                glow::SHADER_STORAGE_BUFFER,
                binding,
                Some(self.raw),
            );
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // While the loan lasts the buffer stays, and goes with its context, which the loan keeps.
        if Arc::get_mut(&mut self.loan).is_some() && self.gl.make_current().is_ok() {
            // SAFETY: the context is current, the name is ours alone, and nobody has the address
            // any more.
            unsafe { self.gl.functions.delete_buffer(self.raw) }
        }
    }
}

// SAFETY: a persistent mapping lies in the client's address space, which all threads share, and its
// address stays valid as long as the mapping, also while OpenGL draws (OpenGL 4.4, sections 6.2 and
// 6.3); the loan keeps buffer and context.
unsafe impl Send for MappedLoan {}

// SAFETY: the address and length are those of one mapping, made by `Page::mapped`, which returned
// the only loan of it. The mapping lasts until the buffer is deleted, which `Page` does not do
// before the loan is gone, or until the context is destroyed, which the loan holds. OpenGL only
// reads it, as a shader's read-only block.
unsafe impl MappedPage for MappedLoan {
    fn elements(&mut self) -> &mut [Float4] {
        // SAFETY: as above, and borrowing `self` mutably keeps others out; the memory was zeroed,
        // and any bytes are floats.
        unsafe { std::slice::from_raw_parts_mut(self.address.as_ptr(), self.loan.len) }
    }
}

// SAFETY: the buffer has storage for `len` elements, made by `Page::shared`, which waited for it.
// It is never resized; it lasts until it is deleted, which `Page` does not do before the loan is
// gone, or until the context is destroyed, which the loan holds.
unsafe impl SharedPage for SharedLoan {
    fn buffer(&self) -> NonZeroU32 {
        self.buffer
    }

    fn handles(&self) -> EglHandles {
        self.loan.context.handles()
    }

    fn len(&self) -> usize {
        self.loan.len
    }
}

/// A point in OpenGL's stream of commands.
pub(crate) struct Fence {
    gl: Rc<Gl>,
    raw: glow::Fence,
}

impl Fence {
    /// After everything that OpenGL was told so far.
    pub(crate) fn new(gl: &Rc<Gl>) -> Result<Self, Error> {
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.fence_sync(glow::SYNC_GPU_COMMANDS_COMPLETE, 0) }
            .map_err(|code| Error::GlError { operation: "set a fence".into(), code })?;
        Ok(Self { gl: Rc::clone(gl), raw })
    }

    /// Whether OpenGL got there, without waiting.
    #[cfg(test)]
    pub(crate) fn is_reached(&self) -> bool {
        // SAFETY: the context is current, the fence exists, and the parameter is one integer.
        let status =
            unsafe { self.gl.functions.get_sync_parameter_i32(self.raw, glow::SYNC_STATUS) };
        status == glow::SIGNALED.cast_signed()
    }

    /// Waits until OpenGL got there.
    pub(crate) fn wait(self) -> Result<(), Error> {
        const NANOSECS_PER_WAIT: i32 = 1_000_000_000;
        const WAITS: usize = 20;
        for _ in 0..WAITS {
            // SAFETY: the context is current, the fence exists; flushing makes sure that it is
            // reached at all.
            let answer = unsafe {
                let functions = &self.gl.functions;
                functions.client_wait_sync(
                    self.raw,
                    glow::SYNC_FLUSH_COMMANDS_BIT,
                    NANOSECS_PER_WAIT,
                )
            };
            match answer {
                glow::TIMEOUT_EXPIRED => {}
                glow::WAIT_FAILED => return self.gl.check("wait for the crowd to be drawn"),
                _ => return Ok(()),
            }
        }
        let (operation, code) = ("draw the crowd".into(), "it takes more than 20 s".into());
        Err(Error::GlError { operation, code })
    }
}

impl Drop for Fence {
    fn drop(&mut self) {
        if self.gl.make_current().is_ok() {
            // SAFETY: the context is current, and the fence is ours alone.
            unsafe { self.gl.functions.delete_sync(self.raw) }
        }
    }
}
