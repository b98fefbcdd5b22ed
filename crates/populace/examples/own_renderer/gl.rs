//! Calls to EGL and OpenGL that every renderer makes.

use glow::HasContext;
use khronos_egl as egl;

use crate::Result;

/// `EGL_PLATFORM_SURFACELESS_MESA`.
const SURFACELESS: egl::Enum = 0x31dd;

/// Creates an OpenGL context without a window and makes it current.
pub(crate) fn context() -> Result<glow::Context> {
    // SAFETY: libEGL is a system library that follows the specification. It is never unloaded,
    // since its instance is leaked. The surfaceless platform takes the default display.
    unsafe {
        let egl = Box::leak(Box::new(egl::DynamicInstance::<egl::EGL1_5>::load_required()?));
        let display =
            egl.get_platform_display(SURFACELESS, egl::DEFAULT_DISPLAY, &[egl::ATTRIB_NONE])?;
        egl.initialize(display)?;
        egl.bind_api(egl::OPENGL_API)?;
        let wanted = [egl::SURFACE_TYPE, egl::PBUFFER_BIT, egl::RENDERABLE_TYPE, egl::OPENGL_BIT];
        let wanted = [&wanted[..], &[egl::NONE]].concat();
        let config = egl.choose_first_config(display, &wanted)?.ok_or("EGL offers no OpenGL")?;
        let version = [egl::CONTEXT_MAJOR_VERSION, 4, egl::CONTEXT_MINOR_VERSION, 3, egl::NONE];
        let context = egl.create_context(display, config, None, &version)?;
        egl.make_current(display, None, None, Some(context))?;
        let address = |name: &str| egl.get_proc_address(name).map_or(std::ptr::null(), |f| f as _);
        Ok(glow::Context::from_loader_function(address))
    }
}

/// Compiles and links a program.
///
/// # Safety
///
/// The context is current.
pub(crate) unsafe fn program(
    gl: &glow::Context,
    vertex: &str,
    fragment: &str,
) -> Result<glow::Program> {
    // SAFETY: the caller promises a current context.
    unsafe {
        let program = gl.create_program()?;
        for (kind, source) in [(glow::VERTEX_SHADER, vertex), (glow::FRAGMENT_SHADER, fragment)] {
            let shader = gl.create_shader(kind)?;
            gl.shader_source(shader, source);
            gl.compile_shader(shader);
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        let linked = gl.get_program_link_status(program);
        if linked { Ok(program) } else { Err(gl.get_program_info_log(program).into()) }
    }
}
