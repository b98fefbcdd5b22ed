//! Vertex array objects and instanced draws.

use std::rc::Rc;

use glow::HasContext as _;

use super::{Buffer, Gl};
use crate::Error;
use crate::layout::{Attribute, Component, Contact, Corner, InstanceData, Vertex, VertexStruct};

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
        Self::with(
            gl,
            &[
                (VERTICES, Vertex::ATTRIBUTES),
                (INFLUENCES, I::ATTRIBUTES),
                (INSTANCES, InstanceData::ATTRIBUTES),
            ],
        )
    }

    /// Creates the vertex array of contact shadows.
    pub(crate) fn contacts(gl: &Rc<Gl>) -> Result<Self, Error> {
        let instances = (INSTANCES, InstanceData::ATTRIBUTES);
        Self::with(gl, &[(VERTICES, Contact::ATTRIBUTES), instances])
    }

    /// Creates the vertex array of the user interface.
    pub(crate) fn corners(gl: &Rc<Gl>) -> Result<Self, Error> {
        Self::with(gl, &[(VERTICES, Corner::ATTRIBUTES)])
    }

    fn with(gl: &Rc<Gl>, bindings: &[(u32, &'static [Attribute])]) -> Result<Self, Error> {
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

    /// Draws with the bound program, blocks and textures. Draws nothing if the range ends past the
    /// instances, or if vertices and influences differ in length.
    pub(crate) fn draw<I: VertexStruct>(&self, range: &DrawRange<'_, I>) {
        if range.vertices.len() != range.influences.len() {
            return;
        }
        self.bind_buffer(VERTICES, range.vertices);
        self.bind_buffer(INFLUENCES, range.influences);
        let instances = (range.first_instance, range.instance_count);
        self.draw_indexed((range.indices, range.indices.len()), range.instances, instances);
    }

    /// Draws the rectangles of contact shadows whose indices are the first `indices.1`, as
    /// [`draw`](Self::draw) does.
    pub(crate) fn draw_contacts(
        &self,
        vertices: &Buffer<Contact>,
        indices: (&Buffer<u32>, usize),
        instances: &Buffer<InstanceData>,
        range: (u32, u32),
    ) {
        self.bind_buffer(VERTICES, vertices);
        self.draw_indexed(indices, instances, range);
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
    fn bind_buffer<V: VertexStruct>(&self, binding: u32, buffer: &Buffer<V>) {
        self.bind();
        let stride = i32::try_from(size_of::<V>()).unwrap_or(0);
        // SAFETY: the context is current and the vertex array bound.
        unsafe {
            self.gl.functions.bind_vertex_buffer(binding, Some(buffer.raw()), 0, stride);
        }
    }

    fn draw_indexed(
        &self,
        (indices, index_count): (&Buffer<u32>, usize),
        instances: &Buffer<InstanceData>,
        (first_instance, instance_count): (u32, u32),
    ) {
        let end = first_instance as usize + instance_count as usize;
        let counts = (i32::try_from(index_count), i32::try_from(instance_count));
        let (Ok(count), Ok(instance_count)) = counts else {
            return;
        };
        if end > instances.len() || index_count > indices.len() {
            return;
        }
        self.bind_buffer(INSTANCES, instances);
        // SAFETY: the context is current. Indices are less than the number of vertices:
        // `populace_character::Character::new` checks them, and `model.rs` uploads them unchanged;
        // those of contact shadows are made with their vertices. The ranges of indices and
        // instances were checked above. Palette reads lie within the bound page, since `batch.rs`
        // checks each instance against it.
        unsafe {
            let functions = &self.gl.functions;
            functions.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(indices.raw()));
            functions.draw_elements_instanced_base_vertex_base_instance(
                glow::TRIANGLES,
                count,
                glow::UNSIGNED_INT,
                0,
                instance_count,
                0,
                first_instance,
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
