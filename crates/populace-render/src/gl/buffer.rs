//! Typed OpenGL buffers.

use std::marker::PhantomData;
use std::mem::MaybeUninit;
use std::rc::Rc;

use glow::HasContext as _;
use populace_device::layout::Float4;
use rayon::prelude::*;

use super::{Gl, Vectors};
use crate::Error;
use crate::layout::UniformBlock;

/// Size in bytes from which contents are written into mapped memory, on all threads. NVIDIA's driver
/// copies smaller contents faster: it takes 0.3 ms for 1.3 MB, and up to 2 ms if it maps them.
const MAPPED_BYTES: usize = 8 << 20;
/// Bytes that a thread writes at a time.
const SHARE_BYTES: usize = 256 << 10;

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
        let raw = create(gl)?;
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
        // SAFETY: the context is current, and the object exists.
        unsafe { functions.bind_buffer(glow::COPY_WRITE_BUFFER, Some(self.raw)) };
        let is_written = fits && bytes.len() >= MAPPED_BYTES && self.write_mapped(bytes);
        // SAFETY: the context is current. The slice gives the number of bytes read; `capacity`,
        // which the driver confirmed, is large enough for them.
        unsafe {
            if !fits {
                functions.buffer_data_u8_slice(glow::COPY_WRITE_BUFFER, bytes, self.usage);
            } else if !is_written {
                functions.buffer_sub_data_u8_slice(glow::COPY_WRITE_BUFFER, 0, bytes);
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

    /// Makes room for `len` elements. Those that are new have no contents yet.
    pub(crate) fn grow(&mut self, len: usize, operation: &str) -> Result<(), Error> {
        if len <= self.len {
            return Ok(());
        }
        let mut larger = Self {
            gl: Rc::clone(&self.gl),
            raw: create(&self.gl)?,
            usage: self.usage,
            len: 0,
            capacity: 0,
            element: PhantomData,
        };
        let (old, new) = (bytes_of::<T>(self.len)?, bytes_of::<T>(len)?);
        let functions = &self.gl.functions;
        // SAFETY: the context is current, and the object exists.
        unsafe {
            functions.bind_buffer(glow::COPY_WRITE_BUFFER, Some(larger.raw));
            functions.buffer_data_size(glow::COPY_WRITE_BUFFER, new, self.usage);
        }
        self.gl.check(operation)?;
        if old > 0 {
            let [from, to] = [glow::COPY_READ_BUFFER, glow::COPY_WRITE_BUFFER];
            // SAFETY: the context is current, and both objects exist. The old one holds `old`
            // bytes, and the new one more, which the driver confirmed.
            unsafe {
                functions.bind_buffer(from, Some(self.raw));
                functions.copy_buffer_sub_data(from, to, 0, 0, old);
            }
            self.gl.check(operation)?;
        }
        (larger.len, larger.capacity) = (len, len);
        *self = larger;
        Ok(())
    }

    /// Replaces the elements from `first` on. Those that would lie past the end are left out.
    pub(crate) fn write(&self, first: usize, data: &[T], operation: &str) -> Result<(), Error> {
        let data = &data[..data.len().min(self.len.saturating_sub(first))];
        let offset = bytes_of::<T>(first)?;
        // SAFETY: the context is current, and the buffer holds the elements.
        unsafe {
            let (functions, bytes) = (&self.gl.functions, bytemuck::cast_slice(data));
            functions.bind_buffer(glow::COPY_WRITE_BUFFER, Some(self.raw));
            functions.buffer_sub_data_u8_slice(glow::COPY_WRITE_BUFFER, offset, bytes);
        }
        self.gl.check(operation)
    }

    /// Maps the buffer, which is bound to `GL_COPY_WRITE_BUFFER`, and writes its first bytes.
    /// Returns false if the driver cannot map it.
    fn write_mapped(&self, bytes: &[u8]) -> bool {
        const ACCESS: u32 = glow::MAP_WRITE_BIT | glow::MAP_INVALIDATE_BUFFER_BIT;
        let (functions, target) = (&self.gl.functions, glow::COPY_WRITE_BUFFER);
        let Ok(len) = i32::try_from(bytes.len()) else { return false };
        // SAFETY: the context is current, and the buffer holds that many bytes.
        let address = unsafe { functions.map_buffer_range(target, 0, len, ACCESS) };
        if address.is_null() {
            // The error is that of the mapping, which the caller does without.
            let _ = self.gl.check("map a buffer");
            return false;
        }
        // SAFETY: the mapping is that long and writable, nothing else has its address, and
        // `MaybeUninit` allows bytes without values.
        let mapped = unsafe {
            std::slice::from_raw_parts_mut(address.cast::<MaybeUninit<u8>>(), bytes.len())
        };
        let shares = mapped.par_chunks_mut(SHARE_BYTES).zip(bytes.par_chunks(SHARE_BYTES));
        shares.for_each(|(to, from)| {
            let to = to.as_mut_ptr().cast::<u8>();
            // SAFETY: both chunks have the same length, and a mapping overlaps no other memory.
            unsafe { to.copy_from_nonoverlapping(from.as_ptr(), from.len()) }
        });
        // A driver may lose the contents, for example when a screen changes its mode. `glow` does
        // not tell. The next frame writes them again.
        //
        // SAFETY: the context is current, the buffer is bound and mapped, and `mapped` is not used
        // from here on.
        unsafe { functions.unmap_buffer(target) };
        true
    }

    /// Returns the number of elements.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn raw(&self) -> glow::Buffer {
        self.raw
    }
}

fn create(gl: &Gl) -> Result<glow::Buffer, Error> {
    // SAFETY: the context is current.
    unsafe { gl.functions.create_buffer() }
        .map_err(|code| Error::GlError { operation: "create a buffer".into(), code })
}

/// Returns the size of elements in bytes, as OpenGL takes it.
fn bytes_of<T>(len: usize) -> Result<i32, Error> {
    let size = len as u64 * size_of::<T>() as u64;
    let limit = u64::from(i32::MAX.unsigned_abs());
    let too_large = |_| Error::TooLarge { what: "the size of a buffer in bytes", size, limit };
    i32::try_from(size).map_err(too_large)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
    #[test]
    fn long_contents_are_written_whole_and_replaced() {
        let gl = Gl::headless().unwrap();
        let mut buffer = Buffer::<u32>::new(&gl, BufferUse::Stream).unwrap();
        let len = MAPPED_BYTES / 4 + 1001;
        // The first call allocates, the second maps, and the third leaves the end.
        for (factor, len) in [(3, len), (5, len), (7, len - 2), (11, 10)] {
            let numbers: Vec<u32> = (0..u32::try_from(len).unwrap()).map(|n| n * factor).collect();
            buffer.fill(&numbers, "fill").unwrap();
            let mut read = vec![0; len * 4];
            // SAFETY: the context is current, and the buffer holds that many bytes.
            unsafe {
                gl.functions.bind_buffer(glow::COPY_READ_BUFFER, Some(buffer.raw));
                gl.functions.get_buffer_sub_data(glow::COPY_READ_BUFFER, 0, &mut read);
            }
            assert!(bytemuck::cast_slice::<u32, u8>(&numbers) == read, "factor {factor}");
            assert_eq!(buffer.len(), len);
        }
        gl.check("read the buffer").unwrap();
    }
}
