//! The contact map: the part of the sky's light that arrives on the floor.

use std::rc::Rc;

use glow::HasContext as _;

use super::{SMOOTH, Target};
use crate::Error;
use crate::gl::Gl;

/// One number from 0 to 1 for each square of two by two pixels of a picture. Contact shadows are
/// soft, and their areas overlap many times.
pub(crate) struct ContactTarget {
    target: Target,
    size: [i32; 2],
}

impl ContactTarget {
    /// Allocates the map of a picture of `size` pixels (width, height).
    pub(crate) fn new(gl: &Rc<Gl>, size: [i32; 2]) -> Result<Self, Error> {
        let mut target = Target::new(gl)?;
        let size = size.map(|side| side / 2 + side % 2);
        target.attach_texture(glow::COLOR_ATTACHMENT0, glow::R8, size, &SMOOTH)?;
        target.complete("create a contact map")?;
        Ok(Self { target, size })
    }

    /// Makes this the current framebuffer and clears it to 1. Vertex shaders that draw to it write
    /// one clip distance.
    pub(crate) fn begin(&self) {
        self.target.bind(glow::FRAMEBUFFER);
        let functions = &self.target.gl.functions;
        let [width, height] = self.size;
        // SAFETY: the context is current and the framebuffer bound.
        unsafe {
            functions.viewport(0, 0, width, height);
            functions.enable(glow::CLIP_DISTANCE0);
            functions.clear_color(1.0, 1.0, 1.0, 1.0);
            functions.clear(glow::COLOR_BUFFER_BIT);
        }
    }

    /// Binds the map to a texture unit.
    pub(crate) fn bind_texture(&self, unit: u32) {
        self.target.bind_texture(glow::TEXTURE_2D, unit);
    }
}
