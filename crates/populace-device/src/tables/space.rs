//! Allocation of blocks in the joint buffer and the palette pages.

use rustc_hash::FxHashMap;

/// Allocates runs of blocks that do not cross a page boundary, and reuses freed runs of equal
/// length. A crowd has few different bodies, so a freed run fits the next member of the same body.
/// Free runs at the end are dropped, so that a shrinking crowd needs less memory.
#[derive(Clone, Debug)]
pub(super) struct Space {
    page_blocks: usize,
    end: usize,
    /// First blocks of free runs, by length. Entries missing from `free_ends` are stale.
    free: Vec<(usize, Vec<usize>)>,
    /// First block of each free run, keyed by the block that follows the run.
    free_ends: FxHashMap<usize, usize>,
}

impl Space {
    pub(super) fn new(page_blocks: usize) -> Self {
        Self { page_blocks, end: 0, free: Vec::new(), free_ends: FxHashMap::default() }
    }

    /// Number of blocks up to the last one in use.
    pub(super) fn end(&self) -> usize {
        self.end
    }

    /// Upper bound of [`end`](Self::end) after allocating a run of `count` blocks.
    pub(super) fn end_with(&self, count: usize) -> usize {
        let page = if count < self.page_blocks { self.page_blocks.min(count) } else { 0 };
        self.end.saturating_add(count).saturating_add(page)
    }

    /// Allocates a run of `count` blocks and returns it as (first block, `count`). An empty run
    /// starts at block 0, so that it stays valid however the space shrinks.
    pub(super) fn take(&mut self, count: usize) -> (usize, usize) {
        if count == 0 {
            return (0, 0);
        }
        while let Some(first) = self.free_of(count).pop() {
            if self.free_ends.get(&(first + count)) == Some(&first) {
                self.free_ends.remove(&(first + count));
                return (first, count);
            }
        }
        let remaining = self.page_blocks - self.end % self.page_blocks;
        if count > remaining {
            self.make_free(self.end, remaining);
            self.end += remaining;
        }
        let first = self.end;
        self.end += count;
        (first, count)
    }

    pub(super) fn release(&mut self, (first, count): (usize, usize)) {
        if count == 0 {
            return;
        }
        if first + count < self.end {
            return self.make_free(first, count);
        }
        self.end = first;
        while let Some(below) = self.free_ends.remove(&self.end) {
            self.end = below;
        }
    }

    fn make_free(&mut self, first: usize, count: usize) {
        self.free_ends.insert(first + count, first);
        self.free_of(count).push(first);
    }

    fn free_of(&mut self, count: usize) -> &mut Vec<usize> {
        let at = self.free.iter().position(|(length, _)| *length == count).unwrap_or_else(|| {
            self.free.push((count, Vec::new()));
            self.free.len() - 1
        });
        &mut self.free[at].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_stay_within_pages_and_are_reused() {
        let mut space = Space::new(10);
        assert_eq!(space.take(6), (0, 6));
        assert_eq!(space.take(6), (10, 6));
        assert_eq!(space.take(4), (6, 4), "the rest of the first page");
        assert_eq!(space.take(4), (16, 4));
        space.release((0, 6));
        assert_eq!(space.take(5), (20, 5));
        assert_eq!(space.take(6), (0, 6));
        assert_eq!(space.take(0), (0, 0), "an empty run stays valid however the space shrinks");
        space.release((0, 0));
        assert_eq!(space.end(), 25);
    }

    #[test]
    fn free_runs_at_the_end_are_dropped_and_reallocated() {
        let mut space = Space::new(10);
        let runs = [6, 6, 3, 6].map(|count| space.take(count));
        assert_eq!((runs, space.end()), ([(0, 6), (10, 6), (16, 3), (20, 6)], 26));
        space.release(runs[1]);
        space.release(runs[3]);
        assert_eq!(space.end(), 19, "the gap at the end of the page is dropped too");
        space.release(runs[2]);
        assert_eq!(space.end(), 6, "and so are the run before it and the first page's gap");
        // No dropped run is allocated twice.
        assert_eq!(
            [4, 6, 6, 1].map(|count| space.take(count)),
            [(6, 4), (10, 6), (20, 6), (26, 1)]
        );
        assert_eq!([4, 4].map(|count| space.take(count)), [(16, 4), (30, 4)]);
    }

    #[test]
    fn runs_never_overlap_under_random_use() {
        let mut space = Space::new(16);
        let mut taken = Vec::<(usize, usize)>::new();
        let mut rng = fastrand::Rng::with_seed(1);
        let mut random = |below: usize| rng.usize(..below);
        for step in 0..20_000 {
            // Mostly allocate in one half of the time, mostly free in the other.
            if random(10) < if step / 500 % 2 == 0 { 6 } else { 4 } || taken.is_empty() {
                let (first, count) = space.take(1 + random(7));
                assert!(first / 16 == (first + count - 1) / 16, "{first} {count} crosses a page");
                let apart = |t: &&(usize, usize)| first + count <= t.0 || t.0 + t.1 <= first;
                assert_eq!(taken.iter().filter(apart).count(), taken.len(), "{first} {count}");
                taken.push((first, count));
            } else {
                space.release(taken.swap_remove(random(taken.len())));
            }
            assert_eq!(space.end(), taken.iter().map(|t| t.0 + t.1).max().unwrap_or(0));
        }
    }
}
