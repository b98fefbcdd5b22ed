//! Vertex array objects.

use std::rc::Rc;

use glow::HasContext as _;

use super::{Buffer, Gl};
use crate::Error;
use crate::layout::{Attribute, Component, Corner, VertexStruct};

/// Binding point of vertices. Those with two structs have the second at the next one.
const VERTICES: u32 = 0;
/// Binding point of instances.
pub(super) const INSTANCES: u32 = 2;

/// Formats of attributes, and the buffers that they are read from.
pub(crate) struct VertexArray {
    gl: Rc<Gl>,
    raw: glow::VertexArray,
}

impl VertexArray {
    /// Creates a vertex array without attributes, for shaders that compute their vertices.
    pub(crate) fn empty(gl: &Rc<Gl>) -> Result<Self, Error> {
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.create_vertex_array() }
            .map_err(|code| Error::GlError { operation: "create a vertex array".into(), code })?;
        Ok(Self { gl: Rc::clone(gl), raw })
    }

    /// Creates the vertex array of the user interface.
    pub(crate) fn corners(gl: &Rc<Gl>) -> Result<Self, Error> {
        Self::with(gl, &[(VERTICES, Corner::ATTRIBUTES)])
    }

    /// Creates a vertex array with the attributes of each binding point, at consecutive locations.
    pub(super) fn with(
        gl: &Rc<Gl>,
        bindings: &[(u32, &'static [Attribute])],
    ) -> Result<Self, Error> {
        let array = Self::empty(gl)?;
        array.bind();
        let attributes =
            bindings.iter().flat_map(|(binding, list)| list.iter().map(move |a| (*binding, a)));
        for (location, (binding, attribute)) in (0..).zip(attributes) {
            array.declare(location, binding, attribute);
        }
        // SAFETY: the context is current and the vertex array bound.
        unsafe { gl.functions.vertex_binding_divisor(INSTANCES, 1) }
        gl.check("set the vertex format")?;
        Ok(array)
    }

    fn declare(&self, location: u32, binding: u32, attribute: &Attribute) {
        let functions = &self.gl.functions;
        let count = i32::from(attribute.component_count);
        let offset = u32::try_from(attribute.offset_bytes).unwrap_or(u32::MAX);
        // SAFETY: the context is current and the vertex array bound. There are at most 16
        // attributes; OpenGL 4.3 has at least as many.
        unsafe {
            functions.enable_vertex_attrib_array(location);
            functions.vertex_attrib_binding(location, binding);
            let integer = match attribute.component {
                Component::F32 => None,
                Component::U8 => Some(glow::UNSIGNED_BYTE),
                Component::U16 => Some(glow::UNSIGNED_SHORT),
                Component::U32 => Some(glow::UNSIGNED_INT),
            };
            match integer {
                None => {
                    functions.vertex_attrib_format_f32(location, count, glow::FLOAT, false, offset);
                }
                Some(kind) => functions.vertex_attrib_format_i32(location, count, kind, offset),
            }
        }
    }

    pub(super) fn bind(&self) {
        // SAFETY: the context is current, and the vertex array exists.
        unsafe { self.gl.functions.bind_vertex_array(Some(self.raw)) }
    }

    /// Draws the triangles of a run of indices: the first, and their number. Draws nothing if the
    /// run ends past the indices. Each index must be less than the number of vertices.
    pub(crate) fn draw_corners(
        &self,
        vertices: &Buffer<Corner>,
        indices: &Buffer<u32>,
        [first, count]: [usize; 2],
    ) {
        self.bind_buffer(VERTICES, vertices);
        let bytes = i32::try_from(first * size_of::<u32>());
        let (Ok(offset), Ok(count)) = (bytes, i32::try_from(count)) else { return };
        if first + count.unsigned_abs() as usize > indices.len() {
            return;
        }
        // SAFETY: the context is current. The run lies within the indices, and
        // `renderer/interface.rs` checks that each is less than the number of vertices.
        unsafe {
            let functions = &self.gl.functions;
            functions.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(indices.raw()));
            functions.draw_elements(glow::TRIANGLES, count, glow::UNSIGNED_INT, offset);
        }
    }

    /// Makes a buffer the source of the attributes of a binding point.
    pub(super) fn bind_buffer<V: VertexStruct>(&self, binding: u32, buffer: &Buffer<V>) {
        self.bind_stream(binding, buffer.raw(), size_of::<V>());
    }

    /// As [`bind_buffer`](Self::bind_buffer), for a buffer of structs of `stride` bytes.
    pub(super) fn bind_stream(&self, binding: u32, buffer: glow::Buffer, stride: usize) {
        self.bind();
        let stride = i32::try_from(stride).unwrap_or(0);
        // SAFETY: the context is current and the vertex array bound.
        unsafe { self.gl.functions.bind_vertex_buffer(binding, Some(buffer), 0, stride) }
    }
}

impl Drop for VertexArray {
    fn drop(&mut self) {
        if self.gl.make_current().is_ok() {
            // SAFETY: the context is current, and `self` owns the vertex array.
            unsafe { self.gl.functions.delete_vertex_array(self.raw) }
        }
    }
}
