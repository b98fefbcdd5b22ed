//! OpenCL contexts made for an OpenGL context, with `cl_khr_gl_sharing`.

use std::ptr;

use opencl3::context::Context;
use opencl3::device::Device;
use opencl3::error_codes::ClError;
use populace_device::GlContext;

const EXTENSION: &str = "cl_khr_gl_sharing";
// Names of context properties, from the specifications of OpenCL 1.0 and cl_khr_gl_sharing.
const CONTEXT_PLATFORM: isize = 0x1084;
const GL_CONTEXT: isize = 0x2008;
const EGL_DISPLAY: isize = 0x2009;

/// Reason given if the driver cannot share buffers at all.
pub(crate) const NOT_OFFERED: &str = "its driver does not offer cl_khr_gl_sharing";

pub(crate) fn is_offered(device: &Device) -> Result<bool, ClError> {
    Ok(device.extensions()?.split_whitespace().any(|name| name == EXTENSION))
}

/// Creates a context that shares with `gl`, which must stay alive for as long as the new context.
pub(crate) fn context_for(device: &Device, gl: &dyn GlContext) -> Result<Context, ClError> {
    let gl = gl.handles();
    let platform = device.platform()? as isize;
    let (context, display) = (gl.context.cast_signed(), gl.display.cast_signed());
    let properties = [GL_CONTEXT, context, EGL_DISPLAY, display, CONTEXT_PLATFORM, platform, 0];
    Context::from_devices(&[device.id()], &properties, None, ptr::null_mut())
}
