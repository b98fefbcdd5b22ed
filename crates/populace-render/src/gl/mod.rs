//! Safe wrappers of EGL and OpenGL: the only module with `unsafe` code.
//!
//! Objects own a reference to their context and delete themselves when dropped. Preconditions that
//! the compiler cannot check, for example that drawn ranges lie within their buffers, are checked
//! here, or named in the `SAFETY` comments with the code that guarantees them.
#![expect(
    unsafe_code,
    reason = "EGL and OpenGL are C; this module is the crate's only boundary to them"
)]

mod buffer;
mod egl;
mod interface;
mod meshes;
mod page;
mod program;
mod target;
mod texture;
mod timer;
mod vectors;
mod vertex_array;
mod window;

use std::rc::Rc;
use std::sync::Arc;

use glow::HasContext as _;

use populace_device::GlContext;

use crate::Error;

use meshes::MultiDraw;

pub(crate) use buffer::{Buffer, BufferUse};
pub(crate) use interface::{InterfaceTexture, Triangles, WindowPicture};
pub(crate) use meshes::{DrawCommand, DrawCommands, Format, MeshPlace, Meshes};
pub(crate) use page::{Fence, Page};
pub(crate) use program::Program;
pub(crate) use target::{ContactTarget, MarkTarget, PictureTarget, ShadowTarget};
pub(crate) use texture::{Coding, Sampling, Texture};
pub(crate) use timer::Timers;
pub(crate) use vectors::Vectors;
pub(crate) use vertex_array::VertexArray;
pub use window::WindowTarget;

/// Limits and features of the driver.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    /// Largest side of a texture in texels.
    pub(crate) texture_size: u32,
    /// Largest side of a picture in pixels.
    pub(crate) picture_size: u32,
    /// Largest size of [`Vectors`] in bytes.
    pub(crate) vectors_bytes: u64,
    /// True if buffers can stay mapped while they are drawn from.
    pub(crate) maps_buffers: bool,
    /// Triangles after which a pass hands over what it has drawn. Software rasterizers fill pixels
    /// while the next vertices are computed, which they do on one thread.
    pub(crate) handed_over: usize,
    /// Largest anisotropy of texture filters, 1 if unsupported or too slow.
    pub(crate) anisotropy: f32,
}

/// A context and its functions.
pub(crate) struct Gl {
    functions: glow::Context,
    multi_draw: MultiDraw,
    limits: Limits,
    driver: String,
    // Declared last, since it must outlive the functions that were loaded from it.
    context: Arc<egl::Context>,
}

/// Face culling, and the winding of front faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Cull {
    /// No culling; front faces are counter-clockwise.
    Nothing,
    /// No culling; front faces are clockwise, as in mirrored meshes. Shaders need the winding.
    NothingMirrored,
    /// Back faces are culled; front faces are counter-clockwise.
    Back,
    /// Back faces are culled; front faces are clockwise, as in mirrored meshes.
    BackMirrored,
}

/// The fixed-function state of a draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DrawState {
    pub(crate) cull: Cull,
    pub(crate) blend: bool,
    pub(crate) depth_write: bool,
    pub(crate) color_write: bool,
    /// Depth offset away from the eye: factor of the slope, and constant in units of the depth
    /// buffer's precision.
    pub(crate) depth_offset: [f32; 2],
    /// True to clamp depth to the near and far planes instead of clipping.
    pub(crate) depth_clamp: bool,
}

impl DrawState {
    pub(crate) const OPAQUE: Self = Self {
        cull: Cull::Back,
        blend: false,
        depth_write: true,
        color_write: true,
        depth_offset: [0.0; 2],
        depth_clamp: false,
    };
}

impl Gl {
    /// Creates a windowless context and loads its functions.
    pub(crate) fn headless() -> Result<Rc<Self>, Error> {
        Self::of(egl::Context::headless()?)
    }

    /// Creates a context that draws into a window of `size` pixels (width, height).
    pub(crate) fn in_window(
        target: Arc<dyn WindowTarget>,
        size: [u32; 2],
    ) -> Result<Rc<Self>, Error> {
        Self::of(egl::Context::in_window(target, size)?)
    }

    /// Loads the functions of a context that is current.
    fn of(context: egl::Context) -> Result<Rc<Self>, Error> {
        let context = Arc::new(context);
        // SAFETY: the functions of `egl::Context` that create one made the context current on this
        // thread. The loader returns addresses of that context's functions, or null, which glow
        // checks before each call.
        let functions =
            unsafe { glow::Context::from_loader_function(|name| context.proc_address(name)) };
        let multi_draw = MultiDraw::load(&context)?;
        let limits = Limits::of(&functions)?;
        // SAFETY: the context is current; both are strings of core OpenGL.
        let [renderer, version] = [glow::RENDERER, glow::VERSION]
            .map(|name| unsafe { functions.get_parameter_string(name) });
        let driver = format!("{renderer}, OpenGL {version}");
        let gl = Self { functions, multi_draw, limits, driver, context };
        gl.check("query the driver's limits")?;
        Ok(Rc::new(gl))
    }

    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Returns the context, for devices that write its buffers.
    pub(crate) fn context(&self) -> Arc<dyn GlContext> {
        Arc::<egl::Context>::clone(&self.context)
    }

    pub(crate) fn driver(&self) -> &str {
        &self.driver
    }

    /// Returns true if the context draws into a window.
    pub(crate) fn has_window(&self) -> bool {
        self.context.has_window()
    }

    /// Tells the window's surface its size in pixels.
    pub(crate) fn resize_window(&self, size: [u32; 2]) {
        self.context.resize_window(size);
    }

    /// Shows what was drawn into the window.
    pub(crate) fn swap(&self) -> Result<(), Error> {
        self.context.swap()
    }

    /// Makes the context current on this thread. Each public function of the crate that calls
    /// OpenGL calls this first. The `SAFETY` comments of this module rely on it where they say "the
    /// context is current".
    pub(crate) fn make_current(&self) -> Result<(), Error> {
        self.context.make_current()
    }

    /// Returns the first error that OpenGL recorded since the last check, and clears the rest.
    /// `operation` is a verb phrase for the message.
    pub(crate) fn check(&self, operation: &str) -> Result<(), Error> {
        let mut first = glow::NO_ERROR;
        // The number of reads is bounded, since a lost context may return errors forever.
        for _ in 0..16 {
            // SAFETY: the context is current; the call has no other precondition.
            let code = unsafe { self.functions.get_error() };
            if code == glow::NO_ERROR {
                break;
            }
            if first == glow::NO_ERROR {
                first = code;
            }
        }
        let operation = operation.to_owned();
        match first {
            glow::NO_ERROR => Ok(()),
            glow::OUT_OF_MEMORY => Err(Error::OutOfMemory { operation }),
            code => Err(Error::GlError { operation, code: error_name(code) }),
        }
    }

    /// Hands what was drawn so far to the device.
    pub(crate) fn flush(&self) {
        // SAFETY: the context is current; the call has no other precondition.
        unsafe { self.functions.flush() }
    }

    /// Sets the fixed-function state.
    pub(crate) fn set_state(&self, state: DrawState) {
        let gl = &self.functions;
        let switch = |capability, on| {
            // SAFETY: the context is current; the capabilities below are in core OpenGL 4.3.
            unsafe { if on { gl.enable(capability) } else { gl.disable(capability) } }
        };
        switch(glow::CULL_FACE, matches!(state.cull, Cull::Back | Cull::BackMirrored));
        switch(glow::BLEND, state.blend);
        switch(glow::DEPTH_TEST, true);
        switch(glow::DEPTH_CLAMP, state.depth_clamp);
        switch(glow::POLYGON_OFFSET_FILL, state.depth_offset != [0.0; 2]);
        let mirrored = matches!(state.cull, Cull::BackMirrored | Cull::NothingMirrored);
        let front = if mirrored { glow::CW } else { glow::CCW };
        let [slope, units] = state.depth_offset;
        // SAFETY: the context is current; all enumerants are valid for their functions.
        unsafe {
            gl.front_face(front);
            gl.depth_func(glow::LEQUAL);
            gl.depth_mask(state.depth_write);
            let [red, green, blue, alpha] = [state.color_write; 4];
            gl.color_mask(red, green, blue, alpha);
            gl.polygon_offset(slope, units);
            gl.blend_func_separate(
                glow::SRC_ALPHA,
                glow::ONE_MINUS_SRC_ALPHA,
                glow::ONE,
                glow::ONE_MINUS_SRC_ALPHA,
            );
        }
    }

    /// Draws a triangle strip whose vertices the shader computes from `gl_VertexID`.
    pub(crate) fn draw_strip(
        &self,
        program: &Program,
        vertex_array: &VertexArray,
        vertex_count: u16,
    ) {
        program.bind();
        vertex_array.bind();
        // SAFETY: the context is current. `vertex_array` has no attributes, see
        // `VertexArray::empty`, so that no buffer is read past its end.
        unsafe {
            self.functions.draw_arrays(glow::TRIANGLE_STRIP, 0, i32::from(vertex_count));
        }
    }
}

impl Drop for Gl {
    /// Releases the context from this thread. If a device still uses its buffers, the context
    /// outlives `self`, and another thread may have to make it current.
    fn drop(&mut self) {
        self.context.release_current();
    }
}

impl Limits {
    /// Queries the limits of the current context.
    fn of(functions: &glow::Context) -> Result<Self, Error> {
        // SAFETY: the context is current. Each parameter below is one integer of OpenGL 4.3, which
        // `egl::Context::headless` requires.
        let get = |name| u32::try_from(unsafe { functions.get_parameter_i32(name) }).unwrap_or(0);
        let mut viewport = [0; 2];
        // SAFETY: the context is current; this parameter is two integers, the length of `viewport`.
        unsafe { functions.get_parameter_i32_slice(glow::MAX_VIEWPORT_DIMS, &mut viewport) }
        let viewport = viewport.map(|side| u32::try_from(side).unwrap_or(0));
        let anisotropic =
            ["GL_ARB_texture_filter_anisotropic", "GL_EXT_texture_filter_anisotropic"]
                .iter()
                .any(|name| functions.supported_extensions().contains(*name));
        // SAFETY: the context is current; this is a string of core OpenGL.
        let renderer = unsafe { functions.get_parameter_string(glow::RENDERER) };
        let software =
            ["llvmpipe", "softpipe", "swrast"].iter().any(|name| renderer.contains(name));
        // Software rasterizers take three times as long for a picture with anisotropic filtering.
        let anisotropy = if anisotropic && !software {
            // SAFETY: the context is current and has the extension that defines the parameter.
            unsafe { functions.get_parameter_f32(glow::MAX_TEXTURE_MAX_ANISOTROPY_EXT) }
        } else {
            1.0
        };
        Ok(Self {
            texture_size: get(glow::MAX_TEXTURE_SIZE),
            picture_size: get(glow::MAX_RENDERBUFFER_SIZE)
                .min(get(glow::MAX_TEXTURE_SIZE))
                .min(viewport[0])
                .min(viewport[1]),
            vectors_bytes: 16 * u64::from(get(glow::MAX_TEXTURE_BUFFER_SIZE)),
            maps_buffers: functions.version().major > 4
                || (functions.version().major == 4 && functions.version().minor >= 4)
                || functions.supported_extensions().contains("GL_ARB_buffer_storage"),
            handed_over: if software { 60_000 } else { usize::MAX },
            anisotropy,
        })
    }
}

fn error_name(code: u32) -> String {
    match code {
        glow::INVALID_ENUM => "GL_INVALID_ENUM".into(),
        glow::INVALID_VALUE => "GL_INVALID_VALUE".into(),
        glow::INVALID_OPERATION => "GL_INVALID_OPERATION".into(),
        glow::INVALID_FRAMEBUFFER_OPERATION => "GL_INVALID_FRAMEBUFFER_OPERATION".into(),
        glow::CONTEXT_LOST => "GL_CONTEXT_LOST".into(),
        other => format!("error 0x{other:04x}"),
    }
}
