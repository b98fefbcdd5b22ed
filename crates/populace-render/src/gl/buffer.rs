//! Typed OpenGL buffers.

use std::marker::PhantomData;
use std::rc::Rc;

use glow::HasContext as _;
use populace_device::layout::Float4;

use super::{Gl, Vectors};
use crate::Error;
use crate::layout::UniformBlock;

/// Usage hint of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BufferUse {
    /// Filled once.
    Static,
    /// Filled every frame.
    Stream,
}

/// An OpenGL buffer of elements of type `T`.
pub(crate) struct Buffer<T> {
    gl: Rc<Gl>,
    raw: glow::Buffer,
    usage: u32,
    len: usize,
    capacity: usize,
    element: PhantomData<T>,
}

impl<T: bytemuck::Pod> Buffer<T> {
    /// Creates an empty buffer.
    pub(crate) fn new(gl: &Rc<Gl>, usage: BufferUse) -> Result<Self, Error> {
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.create_buffer() }
            .map_err(|code| Error::GlError { operation: "create a buffer".into(), code })?;
        let usage = match usage {
            BufferUse::Static => glow::STATIC_DRAW,
            BufferUse::Stream => glow::STREAM_DRAW,
        };
        Ok(Self { gl: Rc::clone(gl), raw, usage, len: 0, capacity: 0, element: PhantomData })
    }

    /// Creates a buffer with the contents `data`. `operation` is for error messages.
    pub(crate) fn with(
        gl: &Rc<Gl>,
        usage: BufferUse,
        data: &[T],
        operation: &str,
    ) -> Result<Self, Error> {
        let mut buffer = Self::new(gl, usage)?;
        buffer.fill(data, operation)?;
        Ok(buffer)
    }

    /// Replaces the contents. Reallocates only if the capacity is too small. `operation` is for
    /// error messages.
    pub(crate) fn fill(&mut self, data: &[T], operation: &str) -> Result<(), Error> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let functions = &self.gl.functions;
        let fits = data.len() <= self.capacity && !data.is_empty();
        // SAFETY: the context is current. The slice gives the number of bytes read; `capacity`,
        // which the driver confirmed, is large enough for them.
        unsafe {
            functions.bind_buffer(glow::COPY_WRITE_BUFFER, Some(self.raw));
            if fits {
                functions.buffer_sub_data_u8_slice(glow::COPY_WRITE_BUFFER, 0, bytes);
            } else {
                functions.buffer_data_u8_slice(glow::COPY_WRITE_BUFFER, bytes, self.usage);
            }
        }
        if !fits {
            (self.len, self.capacity) = (0, 0);
        }
        self.gl.check(operation)?;
        self.len = data.len();
        self.capacity = self.capacity.max(data.len());
        Ok(())
    }

    /// Returns the number of elements.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn raw(&self) -> glow::Buffer {
        self.raw
    }
}

impl Buffer<Float4> {
    /// Returns a view of the buffer, which must have been filled once.
    pub(crate) fn vectors(&self) -> Result<Vectors, Error> {
        Vectors::of(&self.gl, self.raw)
    }
}

impl<T: UniformBlock> Buffer<T> {
    /// Binds the buffer to the binding point of the uniform block `T`.
    pub(crate) fn bind_uniform(&self) {
        // SAFETY: the context is current; OpenGL 4.3 has at least 36 binding points, and this crate
        // uses lower numbers only.
        unsafe {
            self.gl.functions.bind_buffer_base(glow::UNIFORM_BUFFER, T::BINDING, Some(self.raw));
        }
    }
}

impl<T> Drop for Buffer<T> {
    fn drop(&mut self) {
        if self.gl.make_current().is_ok() {
            // SAFETY: the context is current, and `self` owns the buffer.
            unsafe { self.gl.functions.delete_buffer(self.raw) }
        }
    }
}
