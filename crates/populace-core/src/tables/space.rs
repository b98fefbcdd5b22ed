//! Places for members in the joint buffer and the palette pages.

/// Hands out runs of blocks, none across a page's border, and takes them back by length: a crowd has few bodies, so a
/// run that is given back fits the next member of its kind.
#[derive(Clone, Debug)]
pub(super) struct Space {
    page_blocks: usize,
    end: usize,
    free: Vec<(usize, Vec<usize>)>,
}

impl Space {
    pub(super) fn new(page_blocks: usize) -> Self {
        Self { page_blocks, end: 0, free: Vec::new() }
    }

    fn free_of(&mut self, count: usize) -> &mut Vec<usize> {
        let at = self.free.iter().position(|(length, _)| *length == count).unwrap_or_else(|| {
            self.free.push((count, Vec::new()));
            self.free.len() - 1
        });
        &mut self.free[at].1
    }

    /// Blocks there would be after taking a run, at most.
    pub(super) fn end_with(&self, count: usize) -> usize {
        let page = if count < self.page_blocks { self.page_blocks.min(count) } else { 0 };
        self.end.saturating_add(count).saturating_add(page)
    }

    pub(super) fn take(&mut self, count: usize) -> (usize, usize) {
        if let Some(first) = self.free_of(count).pop() {
            return (first, count);
        }
        let left = self.page_blocks - self.end % self.page_blocks;
        let first = if count > left { self.end + left } else { self.end };
        self.end = first + count;
        (first, count)
    }

    pub(super) fn give_back(&mut self, (first, count): (usize, usize)) {
        self.free_of(count).push(first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_never_cross_a_page_and_are_used_again() {
        let mut space = Space::new(10);
        assert_eq!(space.take(6), (0, 6));
        assert_eq!(space.take(6), (10, 6));
        assert_eq!(space.take(4), (16, 4));
        space.give_back((0, 6));
        assert_eq!(space.take(5), (20, 5));
        assert_eq!(space.take(6), (0, 6));
    }
}
