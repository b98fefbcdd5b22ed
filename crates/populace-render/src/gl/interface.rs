//! The window's own picture: the renderer's picture, and the user interface over it.

use std::rc::Rc;

use glow::HasContext as _;
use populace_character::Image;

use super::target::{SMOOTH, flip_rows};
use super::{Buffer, BufferUse, Gl, Program, VertexArray};
use crate::Error;
use crate::layout::Corner;

/// A texture of the interface: sRGB with premultiplied alpha, sampled as it is.
pub(crate) struct InterfaceTexture {
    gl: Rc<Gl>,
    raw: glow::Texture,
    size: [i32; 2],
}

impl InterfaceTexture {
    /// Allocates a texture of `size` texels (width, height).
    pub(crate) fn new(gl: &Rc<Gl>, size: [u32; 2]) -> Result<Self, Error> {
        let limit = gl.limits().texture_size;
        let [Ok(width), Ok(height)] = size.map(i32::try_from) else {
            return Err(too_large(size, limit));
        };
        if size[0].max(size[1]) > limit {
            return Err(too_large(size, limit));
        }
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.create_texture() }
            .map_err(|code| Error::GlError { operation: "create a texture".into(), code })?;
        let texture = Self { gl: Rc::clone(gl), raw, size: [width, height] };
        texture.bind();
        // SAFETY: the context is current and the texture bound; enumerants are below 2^31.
        unsafe {
            gl.functions.tex_storage_2d(glow::TEXTURE_2D, 1, glow::RGBA8, width, height);
            for (name, value) in SMOOTH {
                gl.functions.tex_parameter_i32(glow::TEXTURE_2D, name, value.cast_signed());
            }
        }
        gl.check("allocate a texture of the interface")?;
        Ok(texture)
    }

    /// Replaces the texels of a rectangle at `at`. Does nothing if it reaches past the texture or
    /// if `rgba` has another length.
    pub(crate) fn write(&self, at: [u32; 2], size: [u32; 2], rgba: &[u8]) -> Result<(), Error> {
        let [Ok(x), Ok(y)] = at.map(i32::try_from) else { return Ok(()) };
        let [Ok(width), Ok(height)] = size.map(i32::try_from) else { return Ok(()) };
        let ends = [x.saturating_add(width), y.saturating_add(height)];
        let fits = ends[0] <= self.size[0] && ends[1] <= self.size[1];
        if !fits || rgba.len() as u64 != 4 * u64::from(size[0]) * u64::from(size[1]) {
            return Ok(());
        }
        self.bind();
        // SAFETY: the context is current and the texture bound; the rectangle lies in it. The
        // driver reads width x height x 4 bytes, the length of `rgba`.
        unsafe {
            let pixels = glow::PixelUnpackData::Slice(Some(rgba));
            self.gl.functions.tex_sub_image_2d(
                glow::TEXTURE_2D,
                0,
                x,
                y,
                width,
                height,
                glow::RGBA,
                glow::UNSIGNED_BYTE,
                pixels,
            );
        }
        self.gl.check("upload a texture of the interface")
    }

    fn bind(&self) {
        // SAFETY: the context is current, and the texture exists.
        unsafe {
            self.gl.functions.active_texture(glow::TEXTURE0);
            self.gl.functions.bind_texture(glow::TEXTURE_2D, Some(self.raw));
        }
    }
}

impl Drop for InterfaceTexture {
    fn drop(&mut self) {
        if self.gl.make_current().is_ok() {
            // SAFETY: the context is current, and `self` owns the texture.
            unsafe { self.gl.functions.delete_texture(self.raw) }
        }
    }
}

fn too_large(size: [u32; 2], limit: u32) -> Error {
    let size = u64::from(size[0].max(size[1]));
    Error::TooLarge { what: "the side of a texture", size, limit: u64::from(limit) }
}

/// A run of triangles that share a texture and a rectangle outside of which nothing is drawn.
pub(crate) struct Triangles<'a> {
    pub(crate) texture: &'a InterfaceTexture,
    /// First index, and number of indices.
    pub(crate) indices: [usize; 2],
    /// Left, top, width and height in pixels.
    pub(crate) clip: [u32; 4],
}

/// Returns a rectangle (left, top, width, height) of a window as left, distance from the window's
/// bottom, width and height, without the rows past the bottom.
fn from_below([left, top, width, tall]: [u32; 4], window_height: u32) -> [u32; 4] {
    let end = top.saturating_add(tall).min(window_height);
    [left, window_height - end, width, end.saturating_sub(top)]
}

/// The back buffer of a window.
pub(crate) struct WindowPicture {
    gl: Rc<Gl>,
    array: VertexArray,
    vertices: Buffer<Corner>,
    indices: Buffer<u32>,
}

impl WindowPicture {
    pub(crate) fn new(gl: &Rc<Gl>) -> Result<Self, Error> {
        Ok(Self {
            gl: Rc::clone(gl),
            array: VertexArray::corners(gl)?,
            vertices: Buffer::new(gl, BufferUse::Stream)?,
            indices: Buffer::new(gl, BufferUse::Stream)?,
        })
    }

    /// Makes the window the current framebuffer, and clears it to an sRGB colour.
    pub(crate) fn begin(&self, size: [u32; 2], [red, green, blue]: [f32; 3]) {
        let [width, height] = size.map(|side| i32::try_from(side).unwrap_or(i32::MAX));
        let functions = &self.gl.functions;
        // SAFETY: the context is current and has a window, which `Renderer` checks. Without
        // FRAMEBUFFER_SRGB, bytes are written as they are.
        unsafe {
            functions.bind_framebuffer(glow::FRAMEBUFFER, None);
            functions.viewport(0, 0, width, height);
            functions.disable(glow::FRAMEBUFFER_SRGB);
            functions.disable(glow::CLIP_DISTANCE0);
            functions.clear_color(red, green, blue, 1.0);
            functions.clear(glow::COLOR_BUFFER_BIT);
        }
    }

    /// Draws triangles over what is there. Their indices must be less than the number of vertices.
    pub(crate) fn draw(
        &mut self,
        program: &Program,
        (vertices, indices): (&[Corner], &[u32]),
        runs: &[Triangles<'_>],
        height: u32,
    ) -> Result<(), Error> {
        self.vertices.fill(vertices, "upload the interface")?;
        self.indices.fill(indices, "upload the interface")?;
        let functions = &self.gl.functions;
        program.bind();
        // SAFETY: the context is current; the capabilities are in core OpenGL 4.3.
        unsafe {
            functions.disable(glow::CULL_FACE);
            functions.disable(glow::DEPTH_TEST);
            functions.enable(glow::BLEND);
            functions.blend_func_separate(
                glow::ONE,
                glow::ONE_MINUS_SRC_ALPHA,
                glow::ONE_MINUS_DST_ALPHA,
                glow::ONE,
            );
            functions.enable(glow::SCISSOR_TEST);
        }
        for run in runs {
            run.texture.bind();
            let [left, low, width, tall] =
                from_below(run.clip, height).map(|v| i32::try_from(v).unwrap_or(i32::MAX));
            // SAFETY: the context is current; no side is negative.
            unsafe { functions.scissor(left, low, width, tall) }
            self.array.draw_corners(&self.vertices, &self.indices, run.indices);
        }
        // SAFETY: as above.
        unsafe { functions.disable(glow::SCISSOR_TEST) }
        self.gl.check("draw the interface")
    }

    /// Reads the window back before it is shown, top row first.
    pub(crate) fn read(&self, size: [u32; 2]) -> Result<Image, Error> {
        let [Ok(width), Ok(height)] = size.map(i32::try_from) else {
            return Err(too_large(size, self.gl.limits().picture_size));
        };
        let row_bytes = 4 * size[0] as usize;
        let mut rgba = vec![0; row_bytes * size[1] as usize];
        // SAFETY: the context is current and has a window. The driver writes width x height x 4
        // bytes, the length of `rgba`.
        unsafe {
            let pixels = glow::PixelPackData::Slice(Some(&mut rgba));
            let functions = &self.gl.functions;
            functions.bind_framebuffer(glow::FRAMEBUFFER, None);
            functions.read_pixels(0, 0, width, height, glow::RGBA, glow::UNSIGNED_BYTE, pixels);
        }
        self.gl.check("read the window")?;
        if row_bytes > 0 {
            flip_rows(&mut rgba, row_bytes);
        }
        rgba.chunks_exact_mut(4).for_each(|pixel| pixel[3] = u8::MAX);
        Ok(Image { width: size[0], height: size[1], rgba })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_past_the_bottom_of_the_window_are_cut_off() {
        for (clip, wanted) in [
            ([5, 10, 20, 30], [5, 60, 20, 30]),
            ([0, 50, 20, 50], [0, 0, 20, 50]),
            ([0, 90, 20, 50], [0, 0, 20, 10]),
            ([0, 0, u32::MAX, u32::MAX], [0, 0, u32::MAX, 100]),
            ([0, 100, 20, 50], [0, 0, 20, 0]),
            ([0, u32::MAX, 20, 50], [0, 0, 20, 0]),
        ] {
            assert_eq!(from_below(clip, 100), wanted, "{clip:?}");
        }
    }
}
