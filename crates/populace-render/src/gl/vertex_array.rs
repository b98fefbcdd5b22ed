//! Vertex array objects and instanced draws.

use std::rc::Rc;

use glow::HasContext as _;

use super::{Buffer, Gl};
use crate::Error;
use crate::layout::{Attribute, Component, InstanceData, Vertex, VertexStruct};

/// Vertex buffer binding points.
const VERTICES: u32 = 0;
const INFLUENCES: u32 = 1;
const INSTANCES: u32 = 2;

/// Attribute formats of a mesh: [`Vertex`], a struct of influences, and [`InstanceData`].
pub(crate) struct VertexArray {
    gl: Rc<Gl>,
    raw: glow::VertexArray,
}

/// One draw: all triangles of a mesh for a run of instances.
pub(crate) struct DrawRange<'a, I> {
    pub(crate) vertices: &'a Buffer<Vertex>,
    pub(crate) influences: &'a Buffer<I>,
    pub(crate) indices: &'a Buffer<u32>,
    pub(crate) instances: &'a Buffer<InstanceData>,
    pub(crate) first_instance: u32,
    pub(crate) instance_count: u32,
}

impl VertexArray {
    /// Creates a vertex array without attributes, for shaders that compute their vertices.
    pub(crate) fn empty(gl: &Rc<Gl>) -> Result<Self, Error> {
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.create_vertex_array() }
            .map_err(|code| Error::GlError { operation: "create a vertex array".into(), code })?;
        Ok(Self { gl: Rc::clone(gl), raw })
    }

    /// Creates the vertex array of skinned meshes with influences of type `I`.
    pub(crate) fn skinned<I: VertexStruct>(gl: &Rc<Gl>) -> Result<Self, Error> {
        let array = Self::empty(gl)?;
        array.bind();
        let bindings = [
            (VERTICES, Vertex::ATTRIBUTES),
            (INFLUENCES, I::ATTRIBUTES),
            (INSTANCES, InstanceData::ATTRIBUTES),
        ];
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
        // SAFETY: the context is current and the vertex array bound. There are at most 15
        // attributes; OpenGL 4.3 has at least 16.
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

    /// Draws with the bound program, blocks and textures. Draws nothing if the range ends past the
    /// instances, or if vertices and influences differ in length.
    pub(crate) fn draw<I: VertexStruct>(&self, range: &DrawRange<'_, I>) {
        let end = range.first_instance as usize + range.instance_count as usize;
        let counts = (i32::try_from(range.indices.len()), i32::try_from(range.instance_count));
        let (Ok(index_count), Ok(instance_count)) = counts else {
            return;
        };
        if end > range.instances.len() || range.vertices.len() != range.influences.len() {
            return;
        }
        self.bind();
        let stride = |bytes: usize| i32::try_from(bytes).unwrap_or(0);
        let functions = &self.gl.functions;
        // SAFETY: the context is current. Indices are less than the number of vertices:
        // `populace_character::Character::new` checks them, and `model.rs` uploads them unchanged.
        // The instance range was checked above. Palette reads lie within the bound page, since
        // `batch.rs` checks each instance against it.
        unsafe {
            functions.bind_vertex_buffer(
                VERTICES,
                Some(range.vertices.raw()),
                0,
                stride(size_of::<Vertex>()),
            );
            functions.bind_vertex_buffer(
                INFLUENCES,
                Some(range.influences.raw()),
                0,
                stride(size_of::<I>()),
            );
            let instances = Some(range.instances.raw());
            functions.bind_vertex_buffer(
                INSTANCES,
                instances,
                0,
                stride(size_of::<InstanceData>()),
            );
            functions.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(range.indices.raw()));
            functions.draw_elements_instanced_base_vertex_base_instance(
                glow::TRIANGLES,
                index_count,
                glow::UNSIGNED_INT,
                0,
                instance_count,
                0,
                range.first_instance,
            );
        }
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
