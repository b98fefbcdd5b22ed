//! Memory of palettes: the device's own, or pages that OpenGL keeps mapped.

use populace_device::layout::Float4;
use populace_device::{
    BackendError, MappedPage, PAGE_SETS, PaletteTarget, ReleasedPalettes, Tables, TargetMark,
};

use crate::buffers::grow;
use crate::errors::failed;
use crate::lanes::Line;

/// Elements of a line of the cache.
const LINE: usize = size_of::<Line>() / size_of::<Float4>();

/// Pages of palettes, three elements for each entry.
#[derive(Default)]
pub(crate) struct Pages {
    /// Palette entries in use on each page.
    lengths: Vec<usize>,
    /// The device's own memory, in lines of the cache; empty while `mapped` is set.
    own: Vec<Vec<Line>>,
    mapped: Option<MappedSets>,
    mark: Option<TargetMark>,
}

/// Two sets of mapped pages.
struct MappedSets {
    sets: [Vec<Box<dyn MappedPage>>; PAGE_SETS],
    /// Capacity of each page, in elements.
    capacities: Vec<usize>,
    /// The set of the last frame; before the first frame, the set to write.
    current: usize,
    /// True once OpenGL draws from the current set, so that the next frame goes into the other one.
    released: bool,
}

impl Pages {
    /// Palette entries in use on each page.
    pub(crate) fn lengths(&self) -> &[usize] {
        &self.lengths
    }

    /// Elements of memory held, mapped or not.
    pub(crate) fn capacity(&self) -> usize {
        let capacities = self.mapped.iter().flat_map(|mapped| &mapped.capacities);
        let own = self.own.iter().map(|page| page.len() * LINE);
        capacities.sum::<usize>() * PAGE_SETS + own.sum::<usize>()
    }

    /// Resizes the pages to the tables. Mapped pages that are too small are released; the next
    /// frame writes all palettes again.
    pub(crate) fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        // Most frames allocate nothing.
        if self.lengths.iter().copied().eq(tables.page_lengths()) {
            return Ok(());
        }
        let lengths: Vec<usize> = tables.page_lengths().collect();
        self.resize(&lengths)
    }

    fn resize(&mut self, lengths: &[usize]) -> Result<(), BackendError> {
        if self.mapped.as_ref().is_some_and(|mapped| !mapped.fits(lengths)) {
            (self.mapped, self.mark) = (None, None);
        }
        self.lengths = lengths.to_vec();
        if self.mapped.is_none() {
            self.own.resize_with(lengths.len().max(self.own.len()), Vec::new);
            for (page, length) in self.own.iter_mut().zip(lengths) {
                grow(page, (length * 3).div_ceil(LINE), "matrix palettes")?;
            }
        }
        Ok(())
    }

    /// Returns a page as last written, up to the last entry in use.
    pub(crate) fn get_mut(&mut self, page: usize) -> Option<&mut [Float4]> {
        let end = self.lengths.get(page)? * 3;
        let all = match &mut self.mapped {
            Some(mapped) => mapped.sets[mapped.current][page].elements(),
            None => bytemuck::cast_slice_mut(&mut self.own[page]),
        };
        all.get_mut(..end)
    }

    /// Begins a frame: selects the set of pages that OpenGL does not draw from.
    pub(crate) fn begin_frame(&mut self) {
        if let Some(mapped) = &mut self.mapped
            && std::mem::take(&mut mapped.released)
        {
            mapped.current = (mapped.current + 1) % PAGE_SETS;
        }
    }

    /// Iterates over the pages to write the frame to, up to the last entry in use.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut [Float4]> {
        let Self { lengths, own, mapped, .. } = self;
        let mapped = mapped
            .iter_mut()
            .flat_map(|mapped| mapped.sets[mapped.current].iter_mut().map(|page| page.elements()));
        let own = own.iter_mut().map(|page| bytemuck::cast_slice_mut(page));
        let all = own.chain(mapped);
        all.zip(lengths).filter_map(|(page, length)| page.get_mut(..*length * 3))
    }

    /// Moves the pages to a target, with their contents.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] for shared buffers, and for mapped pages that are too few or too
    /// small.
    pub(crate) fn set_target(
        &mut self,
        target: PaletteTarget,
        mark: &TargetMark,
    ) -> Result<(), BackendError> {
        let refused = |cause: &str| failed("write palettes into OpenGL's memory", cause);
        let mut next = Self { mark: Some(mark.clone()), ..Self::default() };
        match target {
            PaletteTarget::Shared(_) => {
                return Err(refused("shared buffers need an OpenCL device"));
            }
            PaletteTarget::Mapped(sets) => next.mapped = Some(MappedSets::new(sets)),
            PaletteTarget::Copied => {}
        }
        if next.mapped.as_ref().is_some_and(|mapped| !mapped.fits(&self.lengths)) {
            return Err(refused("the mapped pages are too few or too small for the crowd"));
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

    /// Releases the current set to OpenGL; `None` if no target was set.
    pub(crate) fn release(&mut self) -> Option<ReleasedPalettes> {
        let set = self.mapped.as_mut().map(|mapped| {
            mapped.released = true;
            mapped.current
        });
        Some(ReleasedPalettes { mark: self.mark.clone()?, set })
    }
}

impl MappedSets {
    fn new(mut sets: [Vec<Box<dyn MappedPage>>; PAGE_SETS]) -> Self {
        let [first, second] = &mut sets;
        let pages = first.iter_mut().zip(second);
        let capacities = pages.map(|(a, b)| a.elements().len().min(b.elements().len())).collect();
        Self { sets, capacities, current: 0, released: false }
    }

    /// Returns whether each page has the capacity for its number of palette entries.
    fn fits(&self, entries: &[usize]) -> bool {
        entries.len() <= self.capacities.len()
            && entries.iter().zip(&self.capacities).all(|(e, capacity)| e * 3 <= *capacity)
    }
}
