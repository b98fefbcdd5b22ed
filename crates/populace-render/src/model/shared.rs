//! Buffers that all models share.

use std::rc::{Rc, Weak};

use crate::Error;
use crate::gl::{Buffer, BufferUse, Format, Gl, Meshes};
use crate::layout::{Contact, Influences4, Influences8, Surface, Vertex};

/// Meshes and materials of all models, so that one call draws several of them.
pub(crate) struct Shared {
    four: Meshes,
    eight: Meshes,
    pub(crate) contacts: Meshes,
    surfaces: Vec<(Surface, Weak<Buffer<Surface>>)>,
    gl: Rc<Gl>,
}

impl Shared {
    pub(crate) fn new(gl: &Rc<Gl>) -> Result<Self, Error> {
        let vertex = Format::of::<Vertex>();
        Ok(Self {
            four: Meshes::new(gl, &[vertex, Format::of::<Influences4>()])?,
            eight: Meshes::new(gl, &[vertex, Format::of::<Influences8>()])?,
            contacts: Meshes::new(gl, &[Format::of::<Contact>()])?,
            surfaces: Vec::new(),
            gl: Rc::clone(gl),
        })
    }

    /// Returns the meshes with that many influences per vertex.
    pub(crate) fn skinned(&self, influences: u32) -> &Meshes {
        if influences > 4 { &self.eight } else { &self.four }
    }

    /// As [`skinned`](Self::skinned), to add meshes.
    pub(super) fn skinned_mut(&mut self, influences: u32) -> &mut Meshes {
        if influences > 4 { &mut self.eight } else { &mut self.four }
    }

    /// Returns the constants of a material on the device. Equal ones are uploaded once.
    pub(super) fn surface(&mut self, surface: Surface) -> Result<Rc<Buffer<Surface>>, Error> {
        self.surfaces.retain(|(_, buffer)| buffer.strong_count() > 0);
        let known = self.surfaces.iter().find(|(known, _)| *known == surface);
        if let Some(buffer) = known.and_then(|(_, buffer)| buffer.upgrade()) {
            return Ok(buffer);
        }
        let buffer = Buffer::with(&self.gl, BufferUse::Static, &[surface], "upload a material")?;
        let buffer = Rc::new(buffer);
        self.surfaces.push((surface, Rc::downgrade(&buffer)));
        Ok(buffer)
    }
}
