//! Pages of palettes to draw from: copied, or written by a device into OpenGL buffers.

use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;

use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{
    BackendError, MappedPage, PAGE_SETS, PaletteSource, PaletteTarget, PaletteTransport,
    SharedPage, TargetMark,
};

use crate::Error;
use crate::gl::{Buffer, BufferUse, Fence, Gl, Page, Vectors};

/// Elements of 16 bytes in each palette entry.
const ENTRY_ELEMENTS: usize = 3;
/// Number of pages that a 32-bit `palette_first` can address.
const PAGE_LIMIT: usize = (u32::MAX / PAGE_ENTRIES) as usize + 1;
const COPY_PAGE: &str = "upload a page of palettes";
/// Smallest capacity of an interop page in palette entries.
const MIN_PAGE_ENTRIES: usize = 1024;

/// The transport that brings palettes to OpenGL, and why no better one is in use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PaletteInterop {
    /// The transport in use.
    pub transport: PaletteTransport,
    /// The better transports, best first, each with the reason why it is unavailable.
    pub refused: Vec<(PaletteTransport, String)>,
}

impl fmt::Display for PaletteInterop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.transport)?;
        for (index, (transport, reason)) in self.refused.iter().enumerate() {
            write!(f, "{}not {transport}: {reason}", if index == 0 { " (" } else { "; " })?;
        }
        f.write_str(if self.refused.is_empty() { "" } else { ")" })
    }
}

/// The pages to draw from, and the interop pages of all connected sources.
#[derive(Default)]
pub(crate) struct Palettes {
    /// The pages in use, and buffers of copies that were in use before.
    pages: Vec<PageSource>,
    /// Number of pages in use.
    used: usize,
    connections: Vec<Connection>,
    /// The sets that `pages` refer to, of sources whose palettes are not copied.
    acquired: Vec<Rc<PageSet>>,
}

/// Origin of one page.
enum PageSource {
    Copied(Buffer<Float4>, Vectors),
    Written { set: Rc<PageSet>, page: usize, entries: usize },
}

/// Interop pages that one source writes.
struct Connection {
    mark: TargetMark,
    /// Without pages if the palettes are copied.
    sets: [Rc<PageSet>; PAGE_SETS],
}

/// Interop pages that are written in one frame and drawn from together.
#[derive(Default)]
struct PageSet {
    pages: Vec<Page>,
    /// Fence after the last draw from the set, until it was waited for.
    last_draw: RefCell<Option<Fence>>,
}

impl Palettes {
    /// Returns the number of palette entries of each page in use.
    pub(crate) fn lengths(&self) -> Vec<usize> {
        let entries = |page: &PageSource| match page {
            PageSource::Copied(buffer, _) => buffer.len() / ENTRY_ELEMENTS,
            PageSource::Written { entries, .. } => *entries,
        };
        self.pages[..self.used].iter().map(entries).collect()
    }

    /// Binds a page in use to a texture unit.
    pub(crate) fn bind(&self, page: usize, unit: u32) {
        match &self.pages[page] {
            PageSource::Copied(_, vectors) => vectors.bind(unit),
            PageSource::Written { set, page, .. } => set.pages[*page].vectors().bind(unit),
        }
    }

    /// Places a fence after the draws so far. [`Self::acquire`] waits for it before the source
    /// writes the same set again.
    pub(crate) fn fence_draws(&self, gl: &Rc<Gl>) -> Result<(), Error> {
        for set in &self.acquired {
            set.last_draw.replace(Some(Fence::new(gl)?));
        }
        Ok(())
    }

    /// Copies a page: three elements for each palette entry.
    fn copy(&mut self, gl: &Rc<Gl>, page: usize, palette: &[Float4]) -> Result<(), Error> {
        let page_bytes = u64::from(PAGE_ENTRIES) * (ENTRY_ELEMENTS * size_of::<Float4>()) as u64;
        let (size, limit) =
            (size_of_val(palette) as u64, page_bytes.min(gl.limits().vectors_bytes));
        if size > limit {
            return Err(Error::TooLarge { what: "the size of a page in bytes", size, limit });
        }
        if !palette.len().is_multiple_of(ENTRY_ELEMENTS) {
            return Err(Error::PartialMatrix { len: palette.len() });
        }
        if let Some(PageSource::Copied(buffer, _)) = self.pages.get_mut(page) {
            return buffer.fill(palette, COPY_PAGE);
        }
        let buffer = Buffer::with(gl, BufferUse::Stream, palette, COPY_PAGE)?;
        let vectors = buffer.vectors()?;
        self.put(page, PageSource::Copied(buffer, vectors));
        Ok(())
    }

    /// Sets a page that is in `pages` or just past its end.
    fn put(&mut self, page: usize, source: PageSource) {
        match self.pages.get_mut(page) {
            Some(place) => *place = source,
            None => self.pages.push(source),
        }
    }

    /// Connects `source` by the best transport that works.
    pub(crate) fn connect(
        &mut self,
        gl: &Rc<Gl>,
        source: &mut dyn PaletteSource,
    ) -> Result<PaletteInterop, Error> {
        let mut refused = Vec::new();
        for transport in PaletteTransport::ALL {
            let reason = match source.refuses(transport, &*gl.context()) {
                Some(reason) => reason,
                None => match self.connect_by(gl, source, transport) {
                    Ok(()) => return Ok(PaletteInterop { transport, refused }),
                    Err(error) if transport == PaletteTransport::Copied => return Err(error),
                    Err(error) => error.to_string(),
                },
            };
            refused.push((transport, reason));
        }
        let reasons: Vec<_> = refused
            .iter()
            .map(|(transport, reason)| format!("not {transport}: {reason}"))
            .collect();
        Err(Error::NoTransport { reasons: reasons.join("; ") })
    }

    /// Allocates the pages that `transport` needs and makes them the target of `source`.
    fn connect_by(
        &mut self,
        gl: &Rc<Gl>,
        source: &mut dyn PaletteSource,
        transport: PaletteTransport,
    ) -> Result<(), Error> {
        let mut page_entries = source.page_room();
        page_entries.resize(page_entries.len().max(1), 0);
        let (sets, target) = match transport {
            PaletteTransport::Copied => Default::default(),
            PaletteTransport::Mapped if !gl.limits().maps_buffers => {
                return Err(Error::NoBufferStorage);
            }
            PaletteTransport::Mapped => mapped_sets(gl, &page_entries)?,
            PaletteTransport::Shared => shared_sets(gl, &page_entries)?,
        };
        let mark = TargetMark::default();
        source.set_target(target, &mark)?;
        self.connections.push(Connection { mark, sets: sets.map(Rc::new) });
        Ok(())
    }

    /// Drops all shared pages. Buffers of copied pages stay for the next crowd.
    pub(crate) fn clear(&mut self) {
        self.pages.truncate(self.used);
        self.pages.retain(|page| matches!(page, PageSource::Copied(..)));
        self.used = 0;
        self.acquired.clear();
    }

    /// Appends the pages of the source's last frame, and returns the palette entry at which they
    /// begin. Waits until the source has written them and may write its next frame.
    pub(crate) fn acquire(
        &mut self,
        gl: &Rc<Gl>,
        source: &mut dyn PaletteSource,
    ) -> Result<u32, Error> {
        self.connections.retain(|connection| connection.mark.is_held_elsewhere());
        let (connection, set) = match self.written_set(source)? {
            Some(found) => found,
            None => {
                self.connect(gl, source)?;
                self.written_set(source)?.ok_or_else(|| Error::NoTransport {
                    reasons: "the source does not write to the target that it was given".into(),
                })?
            }
        };
        let (first, lengths) = (self.used, source.page_lengths());
        if lengths.len() > PAGE_LIMIT - first {
            let (size, limit) = ((first + lengths.len()) as u64, PAGE_LIMIT as u64);
            return Err(Error::TooLarge { what: "the number of pages", size, limit });
        }
        match set {
            Some(set) => self.take_written(connection, set, &lengths)?,
            None => {
                for page in 0..lengths.len() {
                    let mut result = Ok(());
                    source.with_page(page, &mut |palettes| {
                        result = self.copy(gl, first + page, palettes)
                    })?;
                    result?;
                }
                self.used = first + lengths.len();
            }
        }
        // It saturates only where a source without pages follows a full set of them.
        Ok(u32::try_from(first).unwrap_or(u32::MAX).saturating_mul(PAGE_ENTRIES))
    }

    /// Appends the pages of a set that its source has written. Waits until OpenGL has drawn from
    /// the other set, which the source writes next.
    fn take_written(
        &mut self,
        connection: usize,
        set: usize,
        lengths: &[usize],
    ) -> Result<(), Error> {
        let sets = &self.connections[connection].sets;
        if let Some(fence) = sets[(set + 1) % PAGE_SETS].last_draw.take() {
            fence.wait()?;
        }
        let set = Rc::clone(&sets[set]);
        for (page, &entries) in lengths.iter().enumerate().take(set.pages.len()) {
            self.put(self.used, PageSource::Written { set: Rc::clone(&set), page, entries });
            self.used += 1;
        }
        self.acquired.push(set);
        Ok(())
    }

    /// Waits for the source's last frame. Returns the connection that it was written through and
    /// the set in it, which is `None` if the source keeps palettes in its own memory. Returns
    /// `None` if the source has no target, or the target of another renderer.
    fn written_set(
        &self,
        source: &mut dyn PaletteSource,
    ) -> Result<Option<(usize, Option<usize>)>, BackendError> {
        let Some(frame) = source.release_palettes()? else { return Ok(None) };
        let connection = self.connections.iter().position(|c| c.mark == frame.mark);
        Ok(connection.map(|connection| (connection, frame.set)))
    }
}

/// Returns the capacity in elements of a page for `entries` palette entries: a quarter more, to
/// leave room for growth, and at least [`MIN_PAGE_ENTRIES`], as far as the driver's limit allows.
fn page_elements(gl: &Gl, entries: usize) -> usize {
    let limit = gl.limits().vectors_bytes / (ENTRY_ELEMENTS * size_of::<Float4>()) as u64;
    let most = usize::try_from(limit).unwrap_or(usize::MAX).min(PAGE_ENTRIES as usize);
    entries.max((entries + entries / 4).max(MIN_PAGE_ENTRIES).min(most)) * ENTRY_ELEMENTS
}

/// The renderer's and the device's side of the same pages.
type Sides = ([PageSet; PAGE_SETS], PaletteTarget);

fn mapped_sets(gl: &Rc<Gl>, page_entries: &[usize]) -> Result<Sides, Error> {
    let set = || page_set(page_entries, |entries| Page::mapped(gl, page_elements(gl, entries)));
    let ((a, pages_a), (b, pages_b)): ((_, Vec<Box<dyn MappedPage>>), _) = (set()?, set()?);
    Ok(([a, b], PaletteTarget::Mapped([pages_a, pages_b])))
}

fn shared_sets(gl: &Rc<Gl>, page_entries: &[usize]) -> Result<Sides, Error> {
    let set = || page_set(page_entries, |entries| Page::shared(gl, page_elements(gl, entries)));
    let ((a, pages_a), (b, pages_b)): ((_, Vec<Box<dyn SharedPage>>), _) = (set()?, set()?);
    Ok(([a, b], PaletteTarget::Shared([pages_a, pages_b])))
}

/// Allocates one set of pages with `page` and returns it with the device's side of each page.
fn page_set<P>(
    page_entries: &[usize],
    page: impl Fn(usize) -> Result<(Page, P), Error>,
) -> Result<(PageSet, Vec<P>), Error> {
    let pages = page_entries.iter().map(|entries| page(*entries));
    let (pages, device_pages) = pages.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
    Ok((PageSet { pages, last_draw: RefCell::default() }, device_pages))
}
