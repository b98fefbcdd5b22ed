//! Memory of the palettes: the device's own, or pages shared with OpenGL.

use std::sync::Arc;

use opencl3::error_codes::ClError;
use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{BackendError, PaletteTarget, ReleasedPalettes, Tables, TargetMark};

use crate::buffer::Buffer;
use crate::gl_sharing::InteropPages;
use crate::handles::CommandQueue;
use crate::{DeviceKind, OpenClDevice};

/// Elements of a whole page.
const PAGE_ELEMENTS: usize = PAGE_ENTRIES as usize * 3;

const INVALID_BUFFER: ClError = ClError(-38);

/// The pages of all palettes, with three elements for each entry.
#[derive(Default)]
pub(crate) struct Pages {
    /// Palette entries in use on each page.
    lengths: Vec<usize>,
    /// The device's own memory; empty while `interop` is not.
    own: Vec<Buffer<Float4>>,
    interop: Option<InteropPages>,
    mark: Option<TargetMark>,
}

/// Allocates a page of the device's own memory.
pub(crate) fn own_page(
    device: &OpenClDevice,
    queue: &CommandQueue,
    elements: usize,
) -> Result<Buffer<Float4>, BackendError> {
    let page = Buffer::new(device, elements, "matrix palettes")?;
    #[cfg(target_os = "linux")]
    if device.info.kind == DeviceKind::Cpu {
        let asked = page.prefer_large_pages(queue);
        asked.map_err(|error| device.failed("allocate matrix palettes", &error))?;
    }
    #[cfg(not(target_os = "linux"))]
    let _ = queue;
    Ok(page)
}

impl Pages {
    /// Palette entries in use on each page.
    pub(crate) fn lengths(&self) -> &[usize] {
        &self.lengths
    }

    /// Grows each page to the number of entries in use. Shared pages that are too small are
    /// released, and the next frame writes all palettes again.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        // Most frames allocate nothing.
        if self.lengths.iter().copied().eq(tables.page_lengths()) {
            return Ok(());
        }
        self.resize(device, queue, tables.page_lengths().collect())
    }

    fn resize(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        lengths: Vec<usize>,
    ) -> Result<(), BackendError> {
        if self.interop.as_mut().is_some_and(|interop| !interop.resize(&lengths)) {
            *self = Self::default();
        }
        if self.interop.is_none() {
            for (page, entries) in lengths.iter().enumerate() {
                if self.own.get(page).is_none_or(|own| own.len() < entries * 3) {
                    let grown = own_page(device, queue, entries * 3)?;
                    self.own.truncate(page); // no later page is in use while this one still grows
                    self.own.push(grown);
                }
            }
        }
        self.lengths = lengths;
        Ok(())
    }

    /// Returns whether the memory suffices for the tables, as it does after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        let lengths = tables.page_lengths();
        lengths.len() <= self.lengths.len() && lengths.zip(&self.lengths).all(|(a, b)| a <= *b)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.interop.iter().map(InteropPages::bytes).chain(self.own.iter().map(Buffer::bytes)).sum()
    }

    /// Switches to pages that OpenGL does not draw from. Call it before enqueueing kernels that
    /// write palettes.
    pub(crate) fn begin_frame(&mut self) -> Result<(), ClError> {
        self.interop.as_mut().map_or(Ok(()), InteropPages::begin_frame)
    }

    /// Returns the pages of the current frame.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Buffer<Float4>> {
        self.own
            .iter()
            .chain(self.interop.iter().flat_map(InteropPages::pages))
            .take(self.lengths.len())
    }

    /// Passes a page, as it was last written, to `reader`, up to the last entry in use.
    pub(crate) fn with_page(
        &mut self,
        queue: &CommandQueue,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), ClError> {
        self.with_buffer(page, |palettes| palettes.map(queue, reader))
    }

    pub(crate) fn read(
        &mut self,
        queue: &CommandQueue,
        mut first: usize,
        mut into: &mut [Float4],
    ) -> Result<(), ClError> {
        while !into.is_empty() {
            let at = first % PAGE_ELEMENTS;
            let (now, later) = into.split_at_mut(into.len().min(PAGE_ELEMENTS - at));
            self.with_buffer(first / PAGE_ELEMENTS, |palettes| palettes.read(queue, at, now))?;
            (first, into) = (first + now.len(), later);
        }
        Ok(())
    }

    /// Writes into the pages of the last frame. OpenGL may be drawing from them.
    pub(crate) fn write(
        &mut self,
        queue: &CommandQueue,
        mut first: usize,
        mut from: &[Float4],
    ) -> Result<(), ClError> {
        while !from.is_empty() {
            let at = first % PAGE_ELEMENTS;
            let (now, later) = from.split_at(from.len().min(PAGE_ELEMENTS - at));
            self.with_buffer(first / PAGE_ELEMENTS, |palettes| palettes.write(queue, at, now))?;
            (first, from) = (first + now.len(), later);
        }
        Ok(())
    }

    pub(crate) fn set_target(
        &mut self,
        device: &OpenClDevice,
        queue: &Arc<CommandQueue>,
        target: PaletteTarget,
        mark: &TargetMark,
    ) -> Result<(), BackendError> {
        let interop = InteropPages::new(device, queue, target)?;
        let mut next = Self { interop, mark: Some(mark.clone()), ..Self::default() };
        if next.interop.as_mut().is_some_and(|interop| !interop.resize(&self.lengths)) {
            let cause = "the pages are too few or too small".into();
            let operation = "write palettes into OpenGL memory".into();
            return Err(BackendError::Failed {
                device: device.info.name.clone(),
                operation,
                cause,
            });
        }
        next.resize(device, queue, self.lengths.clone())?;
        // Pages that were longer keep their capacity, but only entries in use are copied.
        let copied = self.lengths.clone().into_iter().enumerate().try_for_each(|(page, length)| {
            next.with_buffer(page, |to| {
                self.with_buffer(page, |from| to.copy_first(queue, from, length * 3))
            })
        });
        copied.map_err(|e| device.failed("copy palettes to new pages", &e))?;
        *self = next;
        Ok(())
    }

    pub(crate) fn release(&mut self) -> Result<Option<ReleasedPalettes>, ClError> {
        let set = self.interop.as_mut().map(InteropPages::release_current).transpose()?;
        Ok(self.mark.clone().map(|mark| ReleasedPalettes { mark, set }))
    }

    fn with_buffer<R>(
        &mut self,
        page: usize,
        job: impl FnOnce(&mut Buffer<Float4>) -> Result<R, ClError>,
    ) -> Result<R, ClError> {
        match &mut self.interop {
            _ if page >= self.lengths.len() => Err(INVALID_BUFFER),
            Some(interop) => {
                interop.with_buffer(|interop| job(interop.get_mut(page).ok_or(INVALID_BUFFER)?))
            }
            None => job(self.own.get_mut(page).ok_or(INVALID_BUFFER)?),
        }
    }
}
