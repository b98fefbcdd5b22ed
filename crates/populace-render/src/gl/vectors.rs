//! Buffers as tables of vectors, which shaders fetch by index.

use std::rc::Rc;

use glow::HasContext as _;

use super::Gl;
use crate::Error;

/// A view of a buffer as a texture of four-component vectors. Software rasterizers fetch whole
/// vectors from a texture, but single numbers from a storage buffer.
pub(crate) struct Vectors {
    gl: Rc<Gl>,
    raw: glow::Texture,
}

impl Vectors {
    /// Views the whole of `buffer`, also after it gets other contents or another size.
    pub(super) fn of(gl: &Rc<Gl>, buffer: glow::Buffer) -> Result<Self, Error> {
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.create_texture() }
            .map_err(|code| Error::GlError { operation: "create a texture".into(), code })?;
        let vectors = Self { gl: Rc::clone(gl), raw };
        vectors.bind(0);
        // SAFETY: the context is current, the texture bound, and the buffer exists: both of its
        // owners have bound it before.
        unsafe { gl.functions.tex_buffer(glow::TEXTURE_BUFFER, glow::RGBA32F, Some(buffer)) }
        gl.check("view a buffer as a texture")?;
        Ok(vectors)
    }

    /// Binds the texture to a texture unit.
    pub(crate) fn bind(&self, unit: u32) {
        // SAFETY: the context is current; OpenGL 4.3 has at least 48 units, and this crate uses
        // lower numbers only.
        unsafe {
            self.gl.functions.active_texture(glow::TEXTURE0 + unit);
            self.gl.functions.bind_texture(glow::TEXTURE_BUFFER, Some(self.raw));
        }
    }
}

impl Drop for Vectors {
    fn drop(&mut self) {
        if self.gl.make_current().is_ok() {
            // SAFETY: the context is current, and `self` owns the texture.
            unsafe { self.gl.functions.delete_texture(self.raw) }
        }
    }
}
