//! The framebuffer of marks: two whole numbers for each pixel.

use std::rc::Rc;

use glow::HasContext as _;

use super::{Target, flip_rows};
use crate::Error;
use crate::gl::Gl;

/// One sample per pixel of two 32-bit numbers, and depth.
pub(crate) struct MarkTarget {
    target: Target,
    size: [i32; 2],
}

impl MarkTarget {
    /// Allocates a target of the size of a picture.
    pub(crate) fn new(gl: &Rc<Gl>, size: [i32; 2]) -> Result<Self, Error> {
        let mut target = Target::new(gl)?;
        target.attach(glow::COLOR_ATTACHMENT0, glow::RG32UI, size)?;
        target.attach(glow::DEPTH_ATTACHMENT, glow::DEPTH_COMPONENT24, size)?;
        target.complete("create a framebuffer of depths")?;
        Ok(Self { target, size })
    }

    /// Makes this the current framebuffer and clears it to zeros. Vertex shaders that draw to it
    /// write one clip distance.
    pub(crate) fn begin(&self) {
        self.target.bind(glow::FRAMEBUFFER);
        let functions = &self.target.gl.functions;
        let [width, height] = self.size;
        // SAFETY: the context is current and the framebuffer bound; a colour has four numbers.
        unsafe {
            functions.viewport(0, 0, width, height);
            functions.enable(glow::CLIP_DISTANCE0);
            functions.depth_mask(true);
            functions.clear_depth_f32(1.0);
            functions.clear(glow::DEPTH_BUFFER_BIT);
            functions.clear_buffer_u32_slice(glow::COLOR, 0, &[0; 4]);
        }
    }

    /// Reads the pairs of numbers back, top row first.
    pub(crate) fn read(&self) -> Result<Vec<[u32; 2]>, Error> {
        let gl = &self.target.gl;
        let [width, height] = self.size.map(i32::unsigned_abs);
        let mut bytes = vec![0; size_of::<[u32; 2]>() * width as usize * height as usize];
        self.target.bind(glow::READ_FRAMEBUFFER);
        // SAFETY: the context is current, and the framebuffer has the size `size`. The driver
        // writes width x height x 8 bytes, the length of `bytes`.
        unsafe {
            let pixels = glow::PixelPackData::Slice(Some(&mut bytes));
            let (format, kind) = (glow::RG_INTEGER, glow::UNSIGNED_INT);
            let [width, height] = self.size;
            gl.functions.read_pixels(0, 0, width, height, format, kind, pixels);
        }
        gl.check("read depths")?;
        flip_rows(&mut bytes, size_of::<[u32; 2]>() * width as usize);
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}
