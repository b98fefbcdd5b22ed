//! OpenGL shader programs.

use std::rc::Rc;

use glow::HasContext as _;

use super::Gl;
use crate::Error;

/// A linked program of a vertex and a fragment shader.
pub(crate) struct Program {
    gl: Rc<Gl>,
    raw: glow::Program,
}

impl Program {
    /// Compiles and links a program. `name` is for error messages.
    pub(crate) fn new(
        gl: &Rc<Gl>,
        name: &str,
        vertex: &str,
        fragment: &str,
    ) -> Result<Self, Error> {
        let functions = &gl.functions;
        let fail = |log: String| Error::Shader { name: name.to_owned(), log };
        // SAFETY: the context is current.
        let raw = unsafe { functions.create_program() }.map_err(fail)?;
        let program = Self { gl: Rc::clone(gl), raw };
        for (stage, extension, text) in
            [(glow::VERTEX_SHADER, "vert", vertex), (glow::FRAGMENT_SHADER, "frag", fragment)]
        {
            // SAFETY: the context is current. The shader is attached, so that it is deleted with
            // the program.
            let log = unsafe {
                let shader = functions.create_shader(stage).map_err(fail)?;
                functions.shader_source(shader, text);
                functions.compile_shader(shader);
                functions.attach_shader(raw, shader);
                functions.delete_shader(shader);
                (!functions.get_shader_compile_status(shader))
                    .then(|| functions.get_shader_info_log(shader))
            };
            if let Some(log) = log {
                return Err(Error::Shader { name: format!("{name}.{extension}"), log });
            }
        }
        // SAFETY: the context is current; both shaders are attached and compiled.
        let linked = unsafe {
            functions.link_program(raw);
            functions.get_program_link_status(raw)
        };
        if !linked {
            // SAFETY: the context is current, the program exists.
            return Err(fail(unsafe { functions.get_program_info_log(raw) }));
        }
        gl.check("link a shader program")?;
        Ok(program)
    }

    /// Makes this the current program.
    pub(crate) fn bind(&self) {
        // SAFETY: the context is current; `new` linked the program.
        unsafe { self.gl.functions.use_program(Some(self.raw)) }
    }

    /// Returns the driver's byte offsets of uniform block fields, -1 for a field that the shader
    /// does not use.
    #[cfg(test)]
    pub(crate) fn field_offsets(&self, names: &[&str]) -> Vec<i32> {
        let functions = &self.gl.functions;
        // SAFETY: the context is current and the program linked.
        let indices = unsafe { functions.get_uniform_indices(self.raw, names) };
        let offset = |index: Option<u32>| {
            // SAFETY: as above, and the driver returned the index.
            index.map_or(-1, |i| unsafe {
                functions.get_active_uniforms_parameter(self.raw, &[i], glow::UNIFORM_OFFSET)[0]
            })
        };
        indices.into_iter().map(offset).collect()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        if self.gl.make_current().is_ok() {
            // SAFETY: the context is current, and `self` owns the program.
            unsafe { self.gl.functions.delete_program(self.raw) }
        }
    }
}
