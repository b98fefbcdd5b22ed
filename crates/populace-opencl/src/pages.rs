//! Where palettes live: in memory of the device's own, or in pages that OpenGL lends.

use std::sync::Arc;

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{BackendError, HandedOver, PaletteTarget, Tables, TargetMark};

use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::gl_sharing::LentPages;

/// Elements of a whole page.
const PAGE_ELEMENTS: usize = PAGE_ENTRIES as usize * 3;

const INVALID_BUFFER: ClError = ClError(-38);

/// The pages of palettes, three elements for each entry.
#[derive(Default)]
pub(crate) struct Pages {
    /// Palette entries in use on each page.
    lengths: Vec<usize>,
    /// Memory of the device's own; empty while `lent` is not.
    own: Vec<Buffer<Float4>>,
    lent: Option<LentPages>,
    mark: Option<TargetMark>,
}

impl Pages {
    /// Palette entries in use on each page.
    pub(crate) fn lengths(&self) -> &[usize] {
        &self.lengths
    }

    /// Makes room for so many entries on each page. Lent pages that are too small are given back;
    /// the next frame writes anew what stood there.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        // The usual frame allocates nothing.
        if self.lengths.iter().copied().eq(tables.page_lengths()) {
            return Ok(());
        }
        self.resize(device, tables.page_lengths().collect())
    }

    fn resize(&mut self, device: &OpenClDevice, lengths: Vec<usize>) -> Result<(), BackendError> {
        if self.lent.as_mut().is_some_and(|lent| !lent.resize(&lengths)) {
            *self = Self::default();
        }
        if self.lent.is_none() {
            for (page, entries) in lengths.iter().enumerate() {
                if self.own.get(page).is_none_or(|own| own.len() < entries * 3) {
                    let grown = Buffer::new(device, entries * 3, "matrix palettes")?;
                    self.own.truncate(page); // no later page is in use while this one still grows
                    self.own.push(grown);
                }
            }
        }
        self.lengths = lengths;
        Ok(())
    }

    /// Whether there is room for so many entries on each page, as there is after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        let lengths = tables.page_lengths();
        lengths.len() <= self.lengths.len() && lengths.zip(&self.lengths).all(|(a, b)| a <= *b)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.lent.iter().map(LentPages::bytes).chain(self.own.iter().map(Buffer::bytes)).sum()
    }

    /// Makes the pages ready to be written: never those that OpenGL draws from. To be called before
    /// kernels that write palettes are enqueued.
    pub(crate) fn begin_frame(&mut self) -> Result<(), ClError> {
        self.lent.as_mut().map_or(Ok(()), LentPages::begin_frame)
    }

    /// The pages that were written last, or are to be written since the frame began.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Buffer<Float4>> {
        self.own.iter().chain(self.lent.iter().flat_map(LentPages::pages)).take(self.lengths.len())
    }

    /// Shows a page as it was last written to `reader`, up to the last entry in use.
    pub(crate) fn with_page(
        &mut self,
        queue: &CommandQueue,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), ClError> {
        self.look_at(page, |palettes| palettes.map(queue, reader))
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
            self.look_at(first / PAGE_ELEMENTS, |palettes| palettes.read(queue, at, now))?;
            (first, into) = (first + now.len(), later);
        }
        Ok(())
    }

    /// Writes into what was written last; OpenGL may draw from it.
    pub(crate) fn write(
        &mut self,
        queue: &CommandQueue,
        mut first: usize,
        mut from: &[Float4],
    ) -> Result<(), ClError> {
        while !from.is_empty() {
            let at = first % PAGE_ELEMENTS;
            let (now, later) = from.split_at(from.len().min(PAGE_ELEMENTS - at));
            self.look_at(first / PAGE_ELEMENTS, |palettes| palettes.write(queue, at, now))?;
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
        let lent = LentPages::new(device, queue, target)?;
        let mut next = Self { lent, mark: Some(mark.clone()), ..Self::default() };
        if next.lent.as_mut().is_some_and(|lent| !lent.resize(&self.lengths)) {
            let cause = "the pages are too few or too small".into();
            let operation = "write palettes into memory of OpenGL's".into();
            return Err(BackendError::Failed {
                device: device.info.name.clone(),
                operation,
                cause,
            });
        }
        next.resize(device, self.lengths.clone())?;
        // Pages that were longer keep their room; past their length is nothing to move.
        let copied = self.lengths.clone().into_iter().enumerate().try_for_each(|(page, length)| {
            next.look_at(page, |to| {
                self.look_at(page, |from| to.copy_first(queue, from, length * 3))
            })
        });
        copied.map_err(|e| device.failed("move its palettes", &e))?;
        *self = next;
        Ok(())
    }

    pub(crate) fn hand_over(&mut self) -> Result<Option<HandedOver>, ClError> {
        let set = self.lent.as_mut().map(LentPages::hand_over).transpose()?;
        Ok(self.mark.clone().map(|mark| HandedOver { mark, set }))
    }

    fn look_at<R>(
        &mut self,
        page: usize,
        job: impl FnOnce(&mut Buffer<Float4>) -> Result<R, ClError>,
    ) -> Result<R, ClError> {
        match &mut self.lent {
            _ if page >= self.lengths.len() => Err(INVALID_BUFFER),
            Some(lent) => lent.look_at(|lent| job(lent.get_mut(page).ok_or(INVALID_BUFFER)?)),
            None => job(self.own.get_mut(page).ok_or(INVALID_BUFFER)?),
        }
    }
}
