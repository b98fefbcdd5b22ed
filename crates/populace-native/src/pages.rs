//! Where palettes live: in memory of our own, or in pages that OpenGL lends.

use populace_device::layout::Float4;
use populace_device::{
    BackendError, HandedOver, MappedPage, PAGE_SETS, PaletteTarget, Tables, TargetMark,
};

use crate::{failed, grow};

/// The pages of palettes, three elements for each entry.
#[derive(Default)]
pub(crate) struct Pages {
    /// Palette entries in use on each page.
    lengths: Vec<usize>,
    /// Our own memory; empty while `lent` is not.
    own: Vec<Vec<Float4>>,
    lent: Option<Lent>,
    mark: Option<TargetMark>,
}

/// Two sets of lent pages.
struct Lent {
    sets: [Vec<Box<dyn MappedPage>>; PAGE_SETS],
    /// Elements that each page has room for.
    lengths: Vec<usize>,
    /// The set that the last frame was written into, or is to be while there is none.
    current: usize,
    /// Whether OpenGL draws from it, so that the next frame goes into the other.
    handed_over: bool,
}

impl Pages {
    /// Palette entries in use on each page.
    pub(crate) fn lengths(&self) -> &[usize] {
        &self.lengths
    }

    /// Elements of memory held, lent or not.
    pub(crate) fn capacity(&self) -> usize {
        let lent = self.lent.iter().flat_map(|lent| &lent.lengths).sum::<usize>() * PAGE_SETS;
        lent + self.own.iter().map(Vec::len).sum::<usize>()
    }

    /// Makes room for so many entries on each page. Lent pages that are too small are given back;
    /// the next frame writes anew what stood there.
    pub(crate) fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        // The usual frame allocates nothing.
        if self.lengths.iter().copied().eq(tables.page_lengths()) {
            return Ok(());
        }
        let lengths: Vec<usize> = tables.page_lengths().collect();
        self.resize(&lengths)
    }

    fn resize(&mut self, lengths: &[usize]) -> Result<(), BackendError> {
        if self.lent.as_ref().is_some_and(|lent| !lent.fits(lengths)) {
            (self.lent, self.mark) = (None, None);
        }
        self.lengths = lengths.to_vec();
        if self.lent.is_none() {
            self.own.resize_with(lengths.len().max(self.own.len()), Vec::new);
            for (page, length) in self.own.iter_mut().zip(lengths) {
                grow(page, length * 3, "matrix palettes")?;
            }
        }
        Ok(())
    }

    /// A page as it was last written, up to the last entry in use.
    pub(crate) fn get_mut(&mut self, page: usize) -> Option<&mut [Float4]> {
        let end = self.lengths.get(page)? * 3;
        let all = match &mut self.lent {
            Some(lent) => lent.sets[lent.current][page].elements(),
            None => &mut self.own[page],
        };
        all.get_mut(..end)
    }

    /// Begins a frame: it goes into pages that OpenGL does not draw from.
    pub(crate) fn begin_frame(&mut self) {
        if let Some(lent) = &mut self.lent
            && std::mem::take(&mut lent.handed_over)
        {
            lent.current = (lent.current + 1) % PAGE_SETS;
        }
    }

    /// The pages to write the frame into, up to the last entry in use.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut [Float4]> {
        let Self { lengths, own, lent, .. } = self;
        let lent = lent
            .iter_mut()
            .flat_map(|lent| lent.sets[lent.current].iter_mut().map(|page| page.elements()));
        let all = own.iter_mut().map(Vec::as_mut_slice).chain(lent);
        all.zip(lengths).filter_map(|(page, length)| page.get_mut(..*length * 3))
    }

    pub(crate) fn set_target(
        &mut self,
        target: PaletteTarget,
        mark: &TargetMark,
    ) -> Result<(), BackendError> {
        let refused = |cause: &str| failed("write palettes into memory of OpenGL's", cause);
        let mut next = Self { mark: Some(mark.clone()), ..Self::default() };
        match target {
            PaletteTarget::Shared(_) => {
                return Err(refused("sharing buffers takes an OpenCL device"));
            }
            PaletteTarget::Mapped(sets) => next.lent = Some(Lent::new(sets)),
            PaletteTarget::Copied => {}
        }
        if next.lent.as_ref().is_some_and(|lent| !lent.fits(&self.lengths)) {
            return Err(refused("the pages are too few or too small"));
        }
        next.resize(&self.lengths)?;
        for page in 0..self.lengths.len() {
            if let (Some(to), Some(from)) = (next.get_mut(page), self.get_mut(page)) {
                to.copy_from_slice(from);
            }
        }
        *self = next;
        Ok(())
    }

    pub(crate) fn hand_over(&mut self) -> Option<HandedOver> {
        let set = self.lent.as_mut().map(|lent| {
            lent.handed_over = true;
            lent.current
        });
        Some(HandedOver { mark: self.mark.clone()?, set })
    }
}

impl Lent {
    fn new(mut sets: [Vec<Box<dyn MappedPage>>; PAGE_SETS]) -> Self {
        let [first, second] = &mut sets;
        let pages = first.iter_mut().zip(second);
        let lengths = pages.map(|(a, b)| a.elements().len().min(b.elements().len())).collect();
        Self { sets, lengths, current: 0, handed_over: false }
    }

    fn fits(&self, entries: &[usize]) -> bool {
        entries.len() <= self.lengths.len()
            && entries.iter().zip(&self.lengths).all(|(e, room)| e * 3 <= *room)
    }
}
