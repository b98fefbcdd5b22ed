//! The pages of palettes that are drawn from: uploaded, or taken from devices that write OpenGL's
//! own memory.

use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;

use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{
    BackendError, MappedPage, PAGE_SETS, PaletteSource, PaletteTarget, PaletteTransport,
    SharedPage, TargetMark,
};

use crate::Error;
use crate::gl::{Buffer, BufferUse, Fence, Gl, Page};

/// Elements of 16 bytes in each palette entry.
const ENTRY_ELEMENTS: usize = 3;
/// Pages that a 32-bit `palette_first` can name.
const PAGE_LIMIT: usize = (u32::MAX / PAGE_ENTRIES) as usize + 1;
/// Palette entries that a lent page has room for at least.
const LEAST_ENTRIES: usize = 1024;

/// The way that palettes take to OpenGL, and why it is no better one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HandOver {
    /// The way.
    pub way: PaletteTransport,
    /// The better ways, each with the reason why not, best first.
    pub refused: Vec<(PaletteTransport, String)>,
}

impl fmt::Display for HandOver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.way)?;
        for (place, (way, reason)) in self.refused.iter().enumerate() {
            write!(f, "{}not {way}: {reason}", if place == 0 { " (" } else { "; " })?;
        }
        f.write_str(if self.refused.is_empty() { "" } else { ")" })
    }
}

/// All pages, and who was lent which.
#[derive(Default)]
pub(crate) struct Palettes {
    pages: Vec<Source>,
    links: Vec<Link>,
    /// The set that `pages` were taken from last.
    taken: Option<Rc<Set>>,
}

/// Where a page's palettes stand.
enum Source {
    Nowhere,
    Uploaded(Buffer<Float4>),
    Taken { set: Rc<Set>, page: usize, entries: usize },
}

/// Pages that some crowd's device writes.
struct Link {
    mark: TargetMark,
    /// Without pages where the palettes are copied.
    sets: [Rc<Set>; PAGE_SETS],
}

/// Pages that are written and drawn from together.
#[derive(Default)]
struct Set {
    pages: Vec<Page>,
    /// Set after the last draw from it.
    drawn: RefCell<Option<Fence>>,
}

impl Palettes {
    /// Palette entries of a page; 0 for one that is not there.
    pub(crate) fn entries(&self, page: usize) -> usize {
        match self.pages.get(page) {
            Some(Source::Uploaded(buffer)) => buffer.len() / ENTRY_ELEMENTS,
            Some(Source::Taken { entries, .. }) => *entries,
            Some(Source::Nowhere) | None => 0,
        }
    }

    /// Binds a page as the storage block of a binding point.
    pub(crate) fn bind(&self, page: usize, binding: u32) {
        match self.pages.get(page) {
            Some(Source::Uploaded(buffer)) => buffer.bind_storage(binding),
            Some(Source::Taken { set, page, .. }) => set.pages[*page].bind_storage(binding),
            Some(Source::Nowhere) | None => {}
        }
    }

    /// To be called after a draw.
    pub(crate) fn drawn(&self, gl: &Rc<Gl>) -> Result<(), Error> {
        if let Some(set) = &self.taken {
            set.drawn.replace(Some(Fence::new(gl)?));
        }
        Ok(())
    }

    pub(crate) fn upload(
        &mut self,
        gl: &Rc<Gl>,
        page: usize,
        palette: &[Float4],
    ) -> Result<(), Error> {
        if page >= PAGE_LIMIT {
            let (size, limit) = (page as u64, PAGE_LIMIT as u64 - 1);
            return Err(Error::TooLarge { what: "a page number", size, limit });
        }
        let page_bytes = u64::from(PAGE_ENTRIES) * (ENTRY_ELEMENTS * size_of::<Float4>()) as u64;
        let (size, limit) =
            (size_of_val(palette) as u64, page_bytes.min(gl.limits().storage_bytes));
        if size > limit {
            return Err(Error::TooLarge { what: "the size in bytes of a page", size, limit });
        }
        if !palette.len().is_multiple_of(ENTRY_ELEMENTS) {
            return Err(Error::PartialMatrix { len: palette.len() });
        }
        if self.pages.len() <= page {
            self.pages.resize_with(page + 1, || Source::Nowhere);
        }
        if !matches!(self.pages[page], Source::Uploaded(_)) {
            self.pages[page] = Source::Uploaded(Buffer::new(gl, BufferUse::Stream)?);
        }
        match &mut self.pages[page] {
            Source::Uploaded(buffer) => buffer.fill(palette, "upload a page of palettes"),
            Source::Nowhere | Source::Taken { .. } => Ok(()),
        }
    }

    /// Lends pages in the best way that works.
    pub(crate) fn link(
        &mut self,
        gl: &Rc<Gl>,
        source: &mut dyn PaletteSource,
    ) -> Result<HandOver, Error> {
        let mut refused = Vec::new();
        for way in PaletteTransport::ALL {
            let reason = match source.refuses(way, &*gl.context()) {
                Some(reason) => reason,
                None => match self.link_by(gl, source, way) {
                    Ok(()) => return Ok(HandOver { way, refused }),
                    Err(error) if way == PaletteTransport::Copied => return Err(error),
                    Err(error) => error.to_string(),
                },
            };
            refused.push((way, reason));
        }
        let reasons: Vec<_> =
            refused.iter().map(|(way, reason)| format!("not {way}: {reason}")).collect();
        Err(Error::NoWay { reasons: reasons.join("; ") })
    }

    fn link_by(
        &mut self,
        gl: &Rc<Gl>,
        source: &mut dyn PaletteSource,
        way: PaletteTransport,
    ) -> Result<(), Error> {
        let mut needed = source.page_room();
        needed.resize(needed.len().max(1), 0);
        let (sets, target) = match way {
            PaletteTransport::Copied => Default::default(),
            PaletteTransport::Mapped if !gl.limits().maps_buffers => {
                return Err(Error::NoBufferStorage);
            }
            PaletteTransport::Mapped => mapped(gl, &needed)?,
            PaletteTransport::Shared => shared(gl, &needed)?,
        };
        let mark = TargetMark::default();
        source.set_target(target, &mark)?;
        self.links.push(Link { mark, sets: sets.map(Rc::new) });
        Ok(())
    }

    /// Takes a source's palettes for the draws to come; returns once the source can write the next
    /// frame.
    pub(crate) fn take(
        &mut self,
        gl: &Rc<Gl>,
        source: &mut dyn PaletteSource,
    ) -> Result<(), Error> {
        self.links.retain(|link| link.mark.is_held_elsewhere());
        let (link, set) = match self.handed_over(source)? {
            Some(found) => found,
            None => {
                self.link(gl, source)?;
                self.handed_over(source)?
                    .ok_or(Error::NoWay { reasons: "they are not handed over".into() })?
            }
        };
        let lengths = source.page_lengths();
        match set {
            Some(set) => {
                let sets = &self.links[link].sets;
                if let Some(fence) = sets[(set + 1) % PAGE_SETS].drawn.take() {
                    fence.wait()?;
                }
                let set = &sets[set];
                let taken = |(page, entries)| Source::Taken { set: Rc::clone(set), page, entries };
                self.pages.clear();
                self.pages.extend(lengths.into_iter().enumerate().take(set.pages.len()).map(taken));
                self.taken = Some(Rc::clone(set));
            }
            None => {
                self.taken = None;
                self.pages.truncate(lengths.len());
                for page in 0..lengths.len() {
                    let mut result = Ok(());
                    source.with_page(page, &mut |palettes| {
                        result = self.upload(gl, page, palettes)
                    })?;
                    result?;
                }
            }
        }
        Ok(())
    }

    /// Which link the source's palettes came by, and the set they stand in; `None` if not by ours.
    fn handed_over(
        &self,
        source: &mut dyn PaletteSource,
    ) -> Result<Option<(usize, Option<usize>)>, BackendError> {
        let Some(handed) = source.hand_over()? else { return Ok(None) };
        let link = self.links.iter().position(|link| link.mark == handed.mark);
        Ok(link.map(|link| (link, handed.set)))
    }
}

/// Elements of a page that is to hold so many entries, with room to grow where the driver allows.
fn elements(gl: &Gl, entries: usize) -> usize {
    let limit = gl.limits().storage_bytes / (ENTRY_ELEMENTS * size_of::<Float4>()) as u64;
    let most = usize::try_from(limit).unwrap_or(usize::MAX).min(PAGE_ENTRIES as usize);
    entries.max((entries + entries / 4).max(LEAST_ENTRIES).min(most)) * ENTRY_ELEMENTS
}

type Lent = ([Set; PAGE_SETS], PaletteTarget);

fn mapped(gl: &Rc<Gl>, needed: &[usize]) -> Result<Lent, Error> {
    let lend = || lend(needed, |entries| Page::mapped(gl, elements(gl, entries)));
    let ((a, lent_a), (b, lent_b)): ((_, Vec<Box<dyn MappedPage>>), _) = (lend()?, lend()?);
    Ok(([a, b], PaletteTarget::Mapped([lent_a, lent_b])))
}

fn shared(gl: &Rc<Gl>, needed: &[usize]) -> Result<Lent, Error> {
    let lend = || lend(needed, |entries| Page::shared(gl, elements(gl, entries)));
    let ((a, lent_a), (b, lent_b)): ((_, Vec<Box<dyn SharedPage>>), _) = (lend()?, lend()?);
    Ok(([a, b], PaletteTarget::Shared([lent_a, lent_b])))
}

fn lend<L>(
    needed: &[usize],
    page: impl Fn(usize) -> Result<(Page, L), Error>,
) -> Result<(Set, Vec<L>), Error> {
    let pages = needed.iter().map(|entries| page(*entries));
    let (pages, loans) = pages.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
    Ok((Set { pages, drawn: RefCell::default() }, loans))
}
