//! Framebuffers: the picture, the shadow map, and others.

mod contacts;
mod marks;

use std::rc::Rc;

use glow::HasContext as _;
use populace_character::Image;

use super::{DrawState, Gl};
use crate::Error;
pub(crate) use contacts::ContactTarget;
pub(crate) use marks::MarkTarget;

/// Parameters of textures without mip levels that are interpolated between texels.
pub(super) const SMOOTH: [(u32, u32); 4] = [
    (glow::TEXTURE_MIN_FILTER, glow::LINEAR),
    (glow::TEXTURE_MAG_FILTER, glow::LINEAR),
    (glow::TEXTURE_WRAP_S, glow::CLAMP_TO_EDGE),
    (glow::TEXTURE_WRAP_T, glow::CLAMP_TO_EDGE),
];

/// A framebuffer and its attachments.
struct Target {
    gl: Rc<Gl>,
    framebuffer: glow::Framebuffer,
    renderbuffers: Vec<glow::Renderbuffer>,
    texture: Option<glow::Texture>,
}

impl Target {
    fn new(gl: &Rc<Gl>) -> Result<Self, Error> {
        // SAFETY: the context is current.
        let framebuffer = unsafe { gl.functions.create_framebuffer() }
            .map_err(|code| Error::GlError { operation: "create a framebuffer".into(), code })?;
        Ok(Self { gl: Rc::clone(gl), framebuffer, renderbuffers: Vec::new(), texture: None })
    }

    fn bind(&self, target: u32) {
        // SAFETY: the context is current, and the object exists.
        unsafe { self.gl.functions.bind_framebuffer(target, Some(self.framebuffer)) }
    }

    fn attach(
        &mut self,
        attachment: u32,
        format: u32,
        [width, height]: [i32; 2],
    ) -> Result<(), Error> {
        let functions = &self.gl.functions;
        self.bind(glow::FRAMEBUFFER);
        // SAFETY: the context is current.
        let renderbuffer = unsafe { functions.create_renderbuffer() }
            .map_err(|code| Error::GlError { operation: "create a renderbuffer".into(), code })?;
        self.renderbuffers.push(renderbuffer);
        // SAFETY: the context is current and the framebuffer bound. `check` reports a size that
        // the driver rejects.
        unsafe {
            functions.bind_renderbuffer(glow::RENDERBUFFER, Some(renderbuffer));
            functions.renderbuffer_storage(glow::RENDERBUFFER, format, width, height);
            functions.framebuffer_renderbuffer(
                glow::FRAMEBUFFER,
                attachment,
                glow::RENDERBUFFER,
                Some(renderbuffer),
            );
        }
        self.gl.check("allocate a renderbuffer")
    }

    /// Attaches a texture without mip levels. `complete` reports a size that the driver rejects.
    fn attach_texture(
        &mut self,
        attachment: u32,
        format: u32,
        [width, height]: [i32; 2],
        parameters: &[(u32, u32)],
    ) -> Result<(), Error> {
        let functions = &self.gl.functions;
        self.bind(glow::FRAMEBUFFER);
        // SAFETY: the context is current.
        let texture = unsafe { functions.create_texture() }
            .map_err(|code| Error::GlError { operation: "create a texture".into(), code })?;
        self.texture = Some(texture);
        self.bind_texture(glow::TEXTURE_2D, 0);
        // SAFETY: the context is current, and framebuffer and texture bound; enumerants are below
        // 2^31.
        unsafe {
            functions.tex_storage_2d(glow::TEXTURE_2D, 1, format, width, height);
            for &(name, value) in parameters {
                functions.tex_parameter_i32(glow::TEXTURE_2D, name, value.cast_signed());
            }
            functions.framebuffer_texture_2d(
                glow::FRAMEBUFFER,
                attachment,
                glow::TEXTURE_2D,
                Some(texture),
                0,
            );
        }
        Ok(())
    }

    /// Binds the texture to a texture unit.
    fn bind_texture(&self, target: u32, unit: u32) {
        // SAFETY: the context is current; OpenGL 4.3 has at least 48 units, and this crate uses
        // lower numbers only.
        unsafe {
            self.gl.functions.active_texture(glow::TEXTURE0 + unit);
            self.gl.functions.bind_texture(target, self.texture);
        }
    }

    /// Checks that the framebuffer can be drawn to.
    fn complete(&self, operation: &str) -> Result<(), Error> {
        self.bind(glow::FRAMEBUFFER);
        // SAFETY: the context is current.
        let status = unsafe { self.gl.functions.check_framebuffer_status(glow::FRAMEBUFFER) };
        if status == glow::FRAMEBUFFER_COMPLETE {
            return self.gl.check(operation);
        }
        let code = format!("framebuffer status 0x{status:04x}");
        Err(Error::GlError { operation: operation.to_owned(), code })
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        if self.gl.make_current().is_err() {
            return;
        }
        // SAFETY: the context is current, and `self` owns the objects.
        unsafe {
            self.gl.functions.delete_framebuffer(self.framebuffer);
            for renderbuffer in &self.renderbuffers {
                self.gl.functions.delete_renderbuffer(*renderbuffer);
            }
            if let Some(texture) = self.texture {
                self.gl.functions.delete_texture(texture);
            }
        }
    }
}

/// The picture: sRGB colour and depth of the members on a grid of samples, and pixels to blend them
/// with their surroundings and to read back.
///
/// The grid is turned by 45 degrees. Its samples lie in the middle of the edges of pixels, two for each
/// pixel, and each pixel is the average of the four on its edges. Pixels share samples as in T.
/// Akenine-Möller and J. Ström, "Graphics for the Masses", SIGGRAPH 2003.
pub(crate) struct PictureTarget {
    grid: Target,
    resolved: Target,
    size: [i32; 2],
}

impl PictureTarget {
    /// Allocates a target of `size` pixels (width, height).
    pub(crate) fn new(gl: &Rc<Gl>, size: [u32; 2]) -> Result<Self, Error> {
        let [width, height] = size;
        if width == 0 || height == 0 {
            return Err(Error::EmptyPicture { width, height });
        }
        let limit = u64::from(gl.limits().picture_size);
        let side = u64::from(width) + u64::from(height);
        let (Ok(w), Ok(h), true) = (i32::try_from(width), i32::try_from(height), side <= limit)
        else {
            return Err(Error::TooLarge {
                what: "width plus height of a picture",
                size: side,
                limit,
            });
        };
        let size = [w, h];
        let mut grid = Target::new(gl)?;
        let format = glow::SRGB8_ALPHA8;
        grid.attach_texture(glow::COLOR_ATTACHMENT0, format, [w + h; 2], &SMOOTH)?;
        grid.attach(glow::DEPTH_ATTACHMENT, glow::DEPTH_COMPONENT24, [w + h; 2])?;
        grid.complete("create a framebuffer of the picture's samples")?;
        let mut resolved = Target::new(gl)?;
        resolved.attach(glow::COLOR_ATTACHMENT0, format, size)?;
        resolved.complete("create a framebuffer of the picture's size")?;
        Ok(Self { grid, resolved, size })
    }

    /// Makes the members' framebuffer the current one and clears it to no coverage. Vertex shaders
    /// that draw to the picture write one clip distance.
    pub(crate) fn begin(&self) {
        self.grid.bind(glow::FRAMEBUFFER);
        // Clearing writes the colours and depths that draws write.
        self.grid.gl.set_state(DrawState::OPAQUE);
        let functions = &self.grid.gl.functions;
        let [width, height] = self.size;
        // SAFETY: the context is current and the framebuffer bound.
        unsafe {
            functions.viewport(0, 0, width + height, width + height);
            functions.enable(glow::FRAMEBUFFER_SRGB);
            functions.enable(glow::CLIP_DISTANCE0);
            functions.clear_color(0.0, 0.0, 0.0, 0.0);
            functions.clear_depth_f32(1.0);
            functions.clear(glow::COLOR_BUFFER_BIT | glow::DEPTH_BUFFER_BIT);
        }
    }

    /// Returns width and height in pixels.
    pub(crate) fn size(&self) -> [i32; 2] {
        self.size
    }

    /// Makes the framebuffer that is read back the current one and clears it to black of this
    /// alpha. Binds the members' samples to texture unit `unit`.
    pub(crate) fn begin_resolve(&self, unit: u32, alpha: f32) {
        self.resolved.bind(glow::FRAMEBUFFER);
        // Clearing writes the colours that draws write.
        self.resolved.gl.set_state(DrawState::OPAQUE);
        let [width, height] = self.size;
        // SAFETY: the context is current and the framebuffer bound.
        unsafe {
            self.resolved.gl.functions.viewport(0, 0, width, height);
            self.resolved.gl.functions.clear_color(0.0, 0.0, 0.0, alpha);
            self.resolved.gl.functions.clear(glow::COLOR_BUFFER_BIT);
        }
        self.grid.bind_texture(glow::TEXTURE_2D, unit);
    }

    /// Copies the picture into the window, byte by byte; its upper left corner comes to `at`, in
    /// pixels from the upper left corner of the window of `height` pixels.
    pub(crate) fn copy_to_window(&self, at: [i32; 2], height: u32) {
        let functions = &self.resolved.gl.functions;
        let [wide, high] = self.size;
        let low = i32::try_from(height).unwrap_or(i32::MAX) - at[1] - high;
        self.resolved.bind(glow::READ_FRAMEBUFFER);
        // SAFETY: the context is current and has a window, which `Renderer` checks. Without
        // FRAMEBUFFER_SRGB, colours are neither decoded nor encoded.
        unsafe {
            functions.disable(glow::FRAMEBUFFER_SRGB);
            functions.bind_framebuffer(glow::DRAW_FRAMEBUFFER, None);
            functions.blit_framebuffer(
                0,
                0,
                wide,
                high,
                at[0],
                low,
                at[0] + wide,
                low + high,
                glow::COLOR_BUFFER_BIT,
                glow::NEAREST,
            );
        }
    }

    /// Reads the picture back, top row first.
    pub(crate) fn read(&self) -> Result<Image, Error> {
        let gl = &self.resolved.gl;
        let [width, height] = self.size;
        let row_bytes = 4 * width.unsigned_abs() as usize;
        let mut rgba = vec![0; row_bytes * height.unsigned_abs() as usize];
        self.resolved.bind(glow::READ_FRAMEBUFFER);
        // SAFETY: the context is current, and the framebuffer has the size `size`. The driver
        // writes width x height x 4 bytes, the length of `rgba`: rows of 4-byte pixels have no
        // padding.
        unsafe {
            let pixels = glow::PixelPackData::Slice(Some(&mut rgba));
            let functions = &gl.functions;
            functions.read_pixels(0, 0, width, height, glow::RGBA, glow::UNSIGNED_BYTE, pixels);
        }
        gl.check("read the picture")?;
        flip_rows(&mut rgba, row_bytes);
        Ok(Image { width: width.unsigned_abs(), height: height.unsigned_abs(), rgba })
    }
}

/// Reverses the order of rows, since the first row of OpenGL is the lowest.
pub(super) fn flip_rows(rgba: &mut [u8], row_bytes: usize) {
    let (upper, lower) = rgba.split_at_mut(rgba.len() / row_bytes / 2 * row_bytes);
    for (a, b) in upper.chunks_exact_mut(row_bytes).zip(lower.chunks_exact_mut(row_bytes).rev()) {
        a.swap_with_slice(b);
    }
}

/// The shadow map: depth as seen from the sun, sampled with comparison.
pub(crate) struct ShadowTarget {
    target: Target,
    size: i32,
}

impl ShadowTarget {
    /// Allocates a square map with a side of `size` texels, or of the largest texture size.
    pub(crate) fn new(gl: &Rc<Gl>, size: u32) -> Result<Self, Error> {
        let size = size.min(gl.limits().texture_size).cast_signed();
        let mut target = Target::new(gl)?;
        let compared = [
            (glow::TEXTURE_COMPARE_MODE, glow::COMPARE_REF_TO_TEXTURE),
            (glow::TEXTURE_COMPARE_FUNC, glow::LEQUAL),
        ];
        let format = glow::DEPTH_COMPONENT24;
        target.attach_texture(
            glow::DEPTH_ATTACHMENT,
            format,
            [size; 2],
            &[&SMOOTH[..], &compared].concat(),
        )?;
        // SAFETY: the context is current and the framebuffer bound. Without colour attachments,
        // drawing to no buffer is valid.
        unsafe {
            gl.functions.draw_buffer(glow::NONE);
            gl.functions.read_buffer(glow::NONE);
        }
        target.complete("create a shadow map")?;
        Ok(Self { target, size })
    }

    /// Returns the side of the map in texels.
    pub(crate) fn size(&self) -> u16 {
        u16::try_from(self.size).unwrap_or(u16::MAX)
    }

    /// Makes this the current framebuffer and clears it to the largest depth.
    pub(crate) fn begin(&self) {
        self.target.bind(glow::FRAMEBUFFER);
        let functions = &self.target.gl.functions;
        // SAFETY: the context is current and the framebuffer bound.
        unsafe {
            functions.viewport(0, 0, self.size, self.size);
            functions.disable(glow::CLIP_DISTANCE0);
            functions.depth_mask(true);
            functions.clear_depth_f32(1.0);
            functions.clear(glow::DEPTH_BUFFER_BIT);
        }
    }

    /// Binds the map to a texture unit.
    pub(crate) fn bind_texture(&self, unit: u32) {
        self.target.bind_texture(glow::TEXTURE_2D, unit);
    }
}
