//! Palette buffers shared with compute devices, and fences that tell when OpenGL has read them.

use std::num::NonZeroU32;
use std::ptr::NonNull;
use std::rc::Rc;
use std::sync::Arc;

use glow::HasContext as _;
use populace_device::layout::Float4;
use populace_device::{EglHandles, GlContext as _, MappedPage, SharedPage};

use super::{Gl, Vectors, egl};
use crate::Error;

/// Access of mapped pages. It includes reads, since a crowd also reads its palettes back from here.
const MAPPED: u32 =
    glow::MAP_READ_BIT | glow::MAP_WRITE_BIT | glow::MAP_PERSISTENT_BIT | glow::MAP_COHERENT_BIT;

/// The renderer's side of a page of palettes that a device writes and OpenGL draws from.
pub(crate) struct Page {
    gl: Rc<Gl>,
    raw: glow::Buffer,
    vectors: Vectors,
    /// Cloned by the device's side; unique again once that is dropped.
    in_use: Arc<()>,
}

/// Length of a page, and the references of the device's side that keep its buffer alive.
struct PageRef {
    /// Elements of 16 bytes.
    len: usize,
    /// Clone of [`Page::in_use`]: the page does not delete the buffer while this exists.
    _in_use: Arc<()>,
    /// Keeps the context, and with it the buffer, alive if the renderer is dropped first.
    context: Arc<egl::Context>,
}

/// The device's side of a persistently mapped page.
struct DeviceMapping {
    address: NonNull<Float4>,
    page: PageRef,
}

/// The device's side of a page that OpenCL acquires as a buffer.
struct DeviceBuffer {
    buffer: NonZeroU32,
    page: PageRef,
}

impl Page {
    /// Allocates a persistently mapped page of `elements` zeros. Returns it with its mapping.
    pub(crate) fn mapped(
        gl: &Rc<Gl>,
        elements: usize,
    ) -> Result<(Self, Box<dyn MappedPage>), Error> {
        let (page, bytes) = Self::new(gl, elements)?;
        // SAFETY: the context is current and offers buffer storage: callers check
        // `Limits::maps_buffers`. The buffer is bound; errors are reported by `check`.
        let address = unsafe {
            gl.functions.buffer_storage(glow::COPY_WRITE_BUFFER, bytes, None, MAPPED);
            gl.functions.map_buffer_range(glow::COPY_WRITE_BUFFER, 0, bytes, MAPPED)
        };
        gl.check("map a page of palettes")?;
        let Some(address) = NonNull::new(address.cast::<Float4>()).filter(|a| a.is_aligned())
        else {
            let (operation, code) = ("map a page of palettes".into(), "null address".into());
            return Err(Error::GlError { operation, code });
        };
        // SAFETY: the mapping is `elements` long and writable, and its address is not shared yet.
        unsafe { address.as_ptr().write_bytes(0, elements) };
        let page_ref = page.page_ref(elements);
        Ok((page, Box::new(DeviceMapping { address, page: page_ref })))
    }

    /// Allocates a page of `elements` for OpenCL to acquire. Returns it with its buffer. Waits
    /// until OpenGL is idle.
    pub(crate) fn shared(
        gl: &Rc<Gl>,
        elements: usize,
    ) -> Result<(Self, Box<dyn SharedPage>), Error> {
        let (page, bytes) = Self::new(gl, elements)?;
        // SAFETY: the context is current and the buffer bound; errors are reported by `check`.
        unsafe {
            gl.functions.buffer_data_size(glow::COPY_WRITE_BUFFER, bytes, glow::DYNAMIC_COPY)
        };
        gl.check("allocate a page of palettes")?;
        // SAFETY: the context is current. OpenCL requires pending OpenGL commands on a buffer to be
        // complete before it acquires the buffer.
        unsafe { gl.functions.finish() };
        let (buffer, page_ref) = (page.raw.0, page.page_ref(elements));
        Ok((page, Box::new(DeviceBuffer { buffer, page: page_ref })))
    }

    /// Creates a buffer without storage, bound to `GL_COPY_WRITE_BUFFER`. Returns it with the size
    /// of `elements` in bytes.
    fn new(gl: &Rc<Gl>, elements: usize) -> Result<(Self, i32), Error> {
        let size = (elements * size_of::<Float4>()) as u64;
        let limit = gl.limits().vectors_bytes.min(i32::MAX as u64);
        let bytes = i32::try_from(size).ok().filter(|_| size <= limit);
        let bytes =
            bytes.ok_or(Error::TooLarge { what: "the size of a page in bytes", size, limit })?;
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.create_buffer() }
            .map_err(|code| Error::GlError { operation: "create a buffer".into(), code })?;
        // SAFETY: the context is current, and the object exists.
        unsafe { gl.functions.bind_buffer(glow::COPY_WRITE_BUFFER, Some(raw)) };
        let vectors = Vectors::of(gl, raw)?;
        Ok((Self { gl: Rc::clone(gl), raw, vectors, in_use: Arc::default() }, bytes))
    }

    fn page_ref(&self, len: usize) -> PageRef {
        PageRef { len, _in_use: Arc::clone(&self.in_use), context: Arc::clone(&self.gl.context) }
    }

    /// Returns the page as shaders read it.
    pub(crate) fn vectors(&self) -> &Vectors {
        &self.vectors
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // While the device's side exists the buffer stays. It is then deleted with the context,
        // which the device's side keeps alive.
        if Arc::get_mut(&mut self.in_use).is_some() && self.gl.make_current().is_ok() {
            // SAFETY: the context is current. This page owns the buffer, and the device's side,
            // which had the address, is dropped.
            unsafe { self.gl.functions.delete_buffer(self.raw) }
        }
    }
}

// SAFETY: a persistent mapping lies in the client's address space, which all threads share. Its
// address stays valid as long as the mapping, also while OpenGL draws (OpenGL 4.4, sections 6.2 and
// 6.3). `page` keeps the buffer and the context alive.
unsafe impl Send for DeviceMapping {}

// SAFETY: address and length are those of one mapping, made by `Page::mapped`, which returns the
// only handle to it. The mapping lasts until the buffer is deleted, which `Page` does not do while
// `page` exists, or until the context is destroyed, which `page` keeps alive. OpenGL only reads the
// memory, as a texture.
unsafe impl MappedPage for DeviceMapping {
    fn elements(&mut self) -> &mut [Float4] {
        // SAFETY: as above. The mutable borrow of `self` makes the access exclusive. The memory was
        // zeroed, and any bit pattern is a valid float.
        unsafe { std::slice::from_raw_parts_mut(self.address.as_ptr(), self.page.len) }
    }
}

// SAFETY: the buffer has storage for `len` elements, allocated by `Page::shared`, which waited for
// OpenGL. It is never resized. It lasts until it is deleted, which `Page` does not do while `page`
// exists, or until the context is destroyed, which `page` keeps alive.
unsafe impl SharedPage for DeviceBuffer {
    fn buffer(&self) -> NonZeroU32 {
        self.buffer
    }

    fn handles(&self) -> EglHandles {
        self.page.context.handles()
    }

    fn len(&self) -> usize {
        self.page.len
    }
}

/// A point in OpenGL's command stream.
pub(crate) struct Fence {
    gl: Rc<Gl>,
    raw: glow::Fence,
}

impl Fence {
    /// Inserts a fence after all commands issued so far.
    pub(crate) fn new(gl: &Rc<Gl>) -> Result<Self, Error> {
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.fence_sync(glow::SYNC_GPU_COMMANDS_COMPLETE, 0) }
            .map_err(|code| Error::GlError { operation: "create a fence".into(), code })?;
        Ok(Self { gl: Rc::clone(gl), raw })
    }

    /// Returns true if all commands before the fence are complete. Does not wait.
    #[cfg(test)]
    pub(crate) fn is_reached(&self) -> bool {
        // SAFETY: the context is current, the fence exists, and the parameter is one integer.
        let status =
            unsafe { self.gl.functions.get_sync_parameter_i32(self.raw, glow::SYNC_STATUS) };
        status == glow::SIGNALED.cast_signed()
    }

    /// Waits until all commands before the fence are complete, for 20 seconds at most.
    pub(crate) fn wait(self) -> Result<(), Error> {
        const NANOSECS_PER_WAIT: i32 = 1_000_000_000;
        const WAITS: usize = 20;
        for _ in 0..WAITS {
            // SAFETY: the context is current and the fence exists. The flush makes sure that the
            // wait ends.
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
                glow::WAIT_FAILED => return self.gl.check("wait for the previous draw"),
                _ => return Ok(()),
            }
        }
        let (operation, code) = ("draw the crowd".into(), "no result within 20 s".into());
        Err(Error::GlError { operation, code })
    }
}

impl Drop for Fence {
    fn drop(&mut self) {
        if self.gl.make_current().is_ok() {
            // SAFETY: the context is current, and `self` owns the fence.
            unsafe { self.gl.functions.delete_sync(self.raw) }
        }
    }
}
