//! The contact map: the part of the sky's light that arrives on the floor.

use std::rc::Rc;

use glow::HasContext as _;

use super::Target;
use crate::Error;
use crate::gl::Gl;

/// One number from 0 to 1 for each pixel of a picture.
pub(crate) struct ContactTarget {
    target: Target,
    size: [i32; 2],
}

impl ContactTarget {
    /// Allocates a map of the size of a picture.
    pub(crate) fn new(gl: &Rc<Gl>, size: [i32; 2]) -> Result<Self, Error> {
        let mut target = Target::new(gl)?;
        let parameters =
            [glow::TEXTURE_MIN_FILTER, glow::TEXTURE_MAG_FILTER].map(|name| (name, glow::NEAREST));
        target.attach_texture(glow::COLOR_ATTACHMENT0, glow::R8, size, &parameters)?;
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
