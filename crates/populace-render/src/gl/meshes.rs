//! Meshes in common buffers: one call draws any number of them.

use std::cell::RefCell;
use std::ffi::c_void;
use std::ops::Range;
use std::rc::Rc;

use glow::HasContext as _;
use range_alloc::RangeAllocator;

use super::egl::{Context, no_gl};
use super::vertex_array::{INSTANCES, VertexArray};
use super::{Buffer, BufferUse, Gl};
use crate::Error;
use crate::layout::{Attribute, InstanceData, VertexStruct};

/// Meshes of one vertex format.
pub(crate) struct Meshes {
    gl: Rc<Gl>,
    array: VertexArray,
    streams: Vec<Stream>,
    indices: Buffer<u32>,
    free: Rc<RefCell<Free>>,
}

/// Structs of vertices that lie in a buffer of their own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Format {
    attributes: &'static [Attribute],
    stride: usize,
}

/// A buffer of vertex structs.
struct Stream {
    bytes: Buffer<u8>,
    stride: usize,
}

/// Vertices and indices that no mesh uses.
struct Free {
    vertices: RangeAllocator<u32>,
    indices: RangeAllocator<u32>,
}

/// The place of a mesh in [`Meshes`]. It is free again once this is dropped.
pub(crate) struct MeshPlace {
    vertices: Range<u32>,
    indices: Range<u32>,
    free: Rc<RefCell<Free>>,
}

/// A mesh and the instances that it is drawn for: `DrawElementsIndirectCommand` of OpenGL 4.3,
/// section 10.5.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct DrawCommand {
    index_count: u32,
    instance_count: u32,
    first_index: u32,
    first_vertex: i32,
    first_instance: u32,
}

/// Draw commands that a device reads.
pub(crate) struct DrawCommands {
    list: Vec<DrawCommand>,
    buffer: Buffer<DrawCommand>,
}

/// `glMultiDrawElementsIndirect`, which `glow` does not have.
pub(super) struct MultiDraw(MultiDrawElementsIndirect);

type MultiDrawElementsIndirect =
    unsafe extern "system" fn(u32, u32, indirect: *const c_void, i32, i32);

impl MultiDraw {
    /// Loads the function from a context that is current.
    pub(super) fn load(context: &Context) -> Result<Self, Error> {
        const NAME: &str = "glMultiDrawElementsIndirect";
        let address = context.proc_address(NAME);
        if address.is_null() {
            return Err(no_gl(format!("the driver has no {NAME}")));
        }
        // SAFETY: OpenGL 4.3, which `Context` requires, gives this name this type.
        let function =
            unsafe { std::mem::transmute::<*const c_void, MultiDrawElementsIndirect>(address) };
        Ok(Self(function))
    }

    /// Draws triangles with 32-bit indices by `count` commands from `offset` bytes on in the bound
    /// buffer of commands.
    ///
    /// # Safety
    ///
    /// The context must be current. The commands, and everything that they refer to, must lie in
    /// the bound buffers.
    unsafe fn elements(&self, offset: usize, count: i32) {
        let offset = std::ptr::without_provenance(offset);
        // SAFETY: the caller vouches for it. A stride of 0 stands for commands without gaps.
        unsafe { (self.0)(glow::TRIANGLES, glow::UNSIGNED_INT, offset, count, 0) }
    }
}

impl Format {
    pub(crate) fn of<V: VertexStruct>() -> Self {
        Self { attributes: V::ATTRIBUTES, stride: size_of::<V>() }
    }
}

impl Meshes {
    /// Creates room for meshes whose vertices are structs of `formats`, each in a buffer of its
    /// own.
    pub(crate) fn new(gl: &Rc<Gl>, formats: &[Format]) -> Result<Self, Error> {
        let mut bindings: Vec<_> = (0..).zip(formats.iter().map(|f| f.attributes)).collect();
        bindings.push((INSTANCES, InstanceData::ATTRIBUTES));
        let stream = |format: &Format| {
            let bytes = Buffer::new(gl, BufferUse::Static)?;
            Ok(Stream { bytes, stride: format.stride })
        };
        let free = Free { vertices: RangeAllocator::new(0..0), indices: RangeAllocator::new(0..0) };
        Ok(Self {
            gl: Rc::clone(gl),
            array: VertexArray::with(gl, &bindings)?,
            streams: formats.iter().map(stream).collect::<Result<_, Error>>()?,
            indices: Buffer::new(gl, BufferUse::Static)?,
            free: Rc::new(RefCell::new(free)),
        })
    }

    /// Uploads a mesh: the bytes of its vertices in each format, and its triangles. Each index must
    /// be less than the number of vertices, which is the same in each format.
    pub(crate) fn add(&mut self, vertices: &[&[u8]], indices: &[u32]) -> Result<MeshPlace, Error> {
        const OPERATION: &str = "upload a mesh";
        let counts = self.streams.iter().zip(vertices).map(|(s, bytes)| bytes.len() / s.stride);
        let count = counts.min().unwrap_or(0);
        let mut place = MeshPlace { vertices: 0..0, indices: 0..0, free: Rc::clone(&self.free) };
        let Self { streams, indices: index_buffer, .. } = self;
        let widest = streams.iter().map(|stream| stream.stride).max().unwrap_or(1);
        {
            let free = &mut *self.free.borrow_mut();
            place.vertices = allocate(&mut free.vertices, count, widest, &mut |len| {
                let mut streams = streams.iter_mut();
                streams.try_for_each(|s| s.bytes.grow(len * s.stride, OPERATION))
            })?;
            let grow = &mut |len| index_buffer.grow(len, OPERATION);
            place.indices = allocate(&mut free.indices, indices.len(), size_of::<u32>(), grow)?;
        }
        for (stream, bytes) in streams.iter().zip(vertices) {
            let first = place.vertices.start as usize * stream.stride;
            stream.bytes.write(first, &bytes[..count * stream.stride], OPERATION)?;
        }
        index_buffer.write(place.indices.start as usize, indices, OPERATION)?;
        Ok(place)
    }

    /// Draws the commands of a range by one call, with the bound program, blocks and textures.
    /// Draws nothing if the range or its instances are not there. The meshes of the commands must
    /// be in `self`.
    pub(crate) fn draw(
        &self,
        commands: &DrawCommands,
        range: Range<usize>,
        instances: &Buffer<InstanceData>,
    ) {
        let offset = range.start * size_of::<DrawCommand>();
        let Ok(count) = i32::try_from(range.len()) else { return };
        let Some(list) = commands.list.get(range.clone()) else { return };
        let fits = list.iter().all(|command| command.instance_end() <= instances.len() as u64);
        if !fits || range.end > commands.buffer.len() {
            return;
        }
        for (binding, stream) in (0..).zip(&self.streams) {
            self.array.bind_stream(binding, stream.bytes.raw(), stream.stride);
        }
        self.array.bind_buffer(INSTANCES, instances);
        // SAFETY: the context is current. The range lies within the commands, and their instances
        // within `instances`, as was checked above. Their places lie within the buffers, which
        // `add` made large enough, and indices are less than the number of vertices:
        // `populace_character::Character::new` checks them, and `model.rs` uploads them unchanged;
        // those of contact shadows are made with their vertices. Palette reads lie within the
        // bound page, since `batch.rs` checks each instance against it.
        unsafe {
            let functions = &self.gl.functions;
            functions.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(self.indices.raw()));
            functions.bind_buffer(glow::DRAW_INDIRECT_BUFFER, Some(commands.buffer.raw()));
            self.gl.multi_draw.elements(offset, count);
        }
    }
}

impl MeshPlace {
    /// Returns the command that draws all triangles for the instances from `first` on.
    pub(crate) fn command(&self, first: u32, count: u32) -> DrawCommand {
        DrawCommand {
            index_count: u32::try_from(self.indices.len()).unwrap_or(0),
            instance_count: count,
            first_index: self.indices.start,
            // Places end below 2^31: see `allocate`.
            first_vertex: i32::try_from(self.vertices.start).unwrap_or(0),
            first_instance: first,
        }
    }
}

impl Drop for MeshPlace {
    fn drop(&mut self) {
        let Free { vertices, indices } = &mut *self.free.borrow_mut();
        for (free, range) in [(vertices, &self.vertices), (indices, &self.indices)] {
            if !range.is_empty() {
                free.free_range(range.clone());
            }
        }
    }
}

impl DrawCommand {
    /// Returns the command without the triangles after the first `count` indices.
    pub(crate) fn with_indices(self, count: u32) -> Self {
        Self { index_count: self.index_count.min(count), ..self }
    }

    /// Returns the number of triangles of all instances.
    pub(crate) fn triangles(&self) -> usize {
        (self.index_count / 3) as usize * self.instance_count as usize
    }

    fn instance_end(&self) -> u64 {
        u64::from(self.first_instance) + u64::from(self.instance_count)
    }
}

impl DrawCommands {
    pub(crate) fn new(gl: &Rc<Gl>) -> Result<Self, Error> {
        Ok(Self { list: Vec::new(), buffer: Buffer::new(gl, BufferUse::Stream)? })
    }

    /// Removes all commands.
    pub(crate) fn clear(&mut self) {
        self.list.clear();
    }

    /// Appends commands and returns their range.
    pub(crate) fn extend(&mut self, commands: &[DrawCommand]) -> Range<usize> {
        let first = self.list.len();
        self.list.extend_from_slice(commands);
        first..self.list.len()
    }

    /// Returns the number of triangles and the commands of each share of a range. A share has at
    /// most `most` triangles, or one command.
    pub(crate) fn shares(
        &self,
        range: &Range<usize>,
        most: usize,
    ) -> impl Iterator<Item = (usize, Range<usize>)> {
        let mut rest = range.clone();
        std::iter::from_fn(move || {
            let commands = self.list.get(rest.clone()).filter(|commands| !commands.is_empty())?;
            let mut triangles = commands[0].triangles();
            let others = commands[1..].iter().take_while(|command| {
                let fits = triangles + command.triangles() <= most;
                triangles += if fits { command.triangles() } else { 0 };
                fits
            });
            let end = rest.start + 1 + others.count();
            let share = rest.start..end;
            rest.start = end;
            Some((triangles, share))
        })
    }

    /// Uploads all commands, which [`Meshes::draw`] reads.
    pub(crate) fn upload(&mut self) -> Result<(), Error> {
        self.buffer.fill(&self.list, "upload the draw commands")
    }
}

/// Takes `len` free elements of up to `stride` bytes. If no free range is long enough, `grow` gives
/// the buffers room for an eighth more elements, or for as many as it takes.
fn allocate(
    free: &mut RangeAllocator<u32>,
    len: usize,
    stride: usize,
    grow: &mut dyn FnMut(usize) -> Result<(), Error>,
) -> Result<Range<u32>, Error> {
    let limit = u32::try_from(MOST_BYTES / stride).unwrap_or(u32::MAX);
    let end = free.initial_range().end;
    let too_large = || Error::TooLarge {
        what: "the number of vertices or indices of all meshes",
        size: u64::from(end) + len as u64,
        limit: u64::from(limit),
    };
    let len = u32::try_from(len).ok().filter(|len| *len <= limit).ok_or_else(too_large)?;
    if len == 0 {
        return Ok(0..0);
    }
    if let Ok(range) = free.allocate_range(len) {
        return Ok(range);
    }
    let least = end.checked_add(len).filter(|end| *end <= limit).ok_or_else(too_large)?;
    let ample = least.max(end + end / 8).min(limit);
    // Only elements that the buffers have are free.
    let end = match grow(ample as usize) {
        Err(_) if ample > least => grow(least as usize).map(|()| least)?,
        result => result.map(|()| ample)?,
    };
    free.grow_to(end);
    free.allocate_range(len).map_err(|_| too_large())
}

/// Most bytes of a buffer; `glow` takes sizes as `i32`.
const MOST_BYTES: usize = i32::MAX as usize;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Contact;

    fn vertices(radius: f32, count: usize) -> Vec<Contact> {
        vec![Contact { from: [0.0, 0.0, 0.0, radius], ..Contact::default() }; count]
    }

    fn add(meshes: &mut Meshes, radius: f32, count: usize) -> MeshPlace {
        let vertices = vertices(radius, count);
        meshes.add(&[bytemuck::cast_slice(&vertices)], &[0, 1, 2]).unwrap()
    }

    fn read(gl: &Gl, meshes: &Meshes, place: &MeshPlace) -> Vec<Contact> {
        let len = place.vertices.len() * size_of::<Contact>();
        let first = i32::try_from(place.vertices.start as usize * size_of::<Contact>()).unwrap();
        let mut bytes = vec![0; len];
        let raw = meshes.streams[0].bytes.raw();
        // SAFETY: the context is current, and the buffer holds the mesh.
        unsafe {
            gl.functions.bind_buffer(glow::COPY_READ_BUFFER, Some(raw));
            gl.functions.get_buffer_sub_data(glow::COPY_READ_BUFFER, first, &mut bytes);
        }
        bytemuck::pod_collect_to_vec(&bytes)
    }

    #[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
    #[test]
    fn places_are_used_again_and_contents_stay_when_buffers_grow() {
        let gl = Gl::headless().unwrap();
        let mut meshes = Meshes::new(&gl, &[Format::of::<Contact>()]).unwrap();
        let first = add(&mut meshes, 1.0, 10);
        let second = add(&mut meshes, 2.0, 7);
        let place = (first.vertices.clone(), first.indices.clone());
        drop(first);
        let third = add(&mut meshes, 3.0, 10);
        assert_eq!((third.vertices.clone(), third.indices.clone()), place);
        let fourth = add(&mut meshes, 4.0, 1000);
        assert!(add(&mut meshes, 5.0, 0).vertices.is_empty());
        for (place, radius, count) in [(&second, 2.0, 7), (&third, 3.0, 10), (&fourth, 4.0, 1000)] {
            assert!(read(&gl, &meshes, place) == vertices(radius, count), "{radius}");
        }
        gl.check("read the meshes").unwrap();
    }

    #[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
    #[test]
    fn shares_have_at_most_the_given_triangles_or_one_command() {
        let gl = Gl::headless().unwrap();
        let mut commands = DrawCommands::new(&gl).unwrap();
        let command = |instance_count| DrawCommand {
            index_count: 6,
            instance_count,
            first_index: 0,
            first_vertex: 0,
            first_instance: 0,
        };
        let range = commands.extend(&[3, 9, 2, 2, 1, 1].map(command));
        let shares: Vec<_> = commands.shares(&(1..range.end), 10).collect();
        assert_eq!(shares, [(18, 1..2), (10, 2..5), (2, 5..6)]);
        assert_eq!(commands.shares(&range, usize::MAX).collect::<Vec<_>>(), [(36, 0..6)]);
        assert_eq!(commands.shares(&(2..2), 10).count(), 0);
    }

    #[test]
    fn more_elements_than_opengl_can_count_are_refused() {
        let mut free = RangeAllocator::new(0..0);
        let mut allocate = |len| allocate(&mut free, len, 4, &mut |_| Ok(()));
        assert_eq!(allocate(5).unwrap(), 0..5);
        let most = MOST_BYTES / 4;
        for len in [most - 4, most + 1, u32::MAX as usize, usize::MAX / 2] {
            assert!(matches!(allocate(len), Err(Error::TooLarge { .. })), "{len}");
        }
        assert_eq!(allocate(most - 5).unwrap().len(), most - 5);
    }

    /// Memory for a thousand elements.
    #[test]
    fn smaller_meshes_are_uploaded_after_one_that_was_too_large() {
        let mut free = RangeAllocator::new(0..0);
        let mut allocate = |len| {
            allocate(&mut free, len, 4, &mut |len| {
                let operation = "grow".into();
                if len > 1000 { Err(Error::OutOfMemory { operation }) } else { Ok(()) }
            })
        };
        assert_eq!(allocate(900).unwrap(), 0..900);
        assert!(matches!(allocate(200), Err(Error::OutOfMemory { .. })));
        assert_eq!(allocate(60).unwrap(), 900..960);
        assert_eq!(allocate(40).unwrap(), 960..1000);
        assert!(matches!(allocate(1), Err(Error::OutOfMemory { .. })));
    }
}
