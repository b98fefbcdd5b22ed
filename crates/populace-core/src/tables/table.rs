//! An array that devices copy, and what changed in it since they did.

use std::ops::Range;

use super::u32_from;
use crate::Error;
use crate::layout::NONE;

/// An array of which devices keep copies. What they have not taken over yet is the [`tail`](Self::tail), and the
/// elements before it that [`changed`](Self::changed) names. Keeping and forgetting that takes time by the number of
/// changes, never by the number of elements.
#[derive(Clone, Debug)]
pub struct Table<T> {
    name: &'static str,
    data: Vec<T>,
    /// Elements that there were when devices last took over.
    known: usize,
    /// Those below `known` that changed since, each once; where the table shrank some stand past its end.
    changed: Vec<u32>,
    /// A bit for each element below `known`, set for those in `changed`.
    is_changed: Vec<u64>,
}

impl<T: bytemuck::Pod> Table<T> {
    pub(super) fn new(name: &'static str) -> Self {
        Self { name, data: Vec::new(), known: 0, changed: Vec::new(), is_changed: Vec::new() }
    }

    /// The table's name, for errors.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// All elements.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.data
    }

    /// Indices of the elements before the [`tail`](Self::tail) that changed since
    /// [`Tables::mark_clean`](super::Tables::mark_clean), each once, in no order.
    pub fn changed(&self) -> impl Iterator<Item = u32> + '_ {
        self.changed.iter().copied().filter(|index| (*index as usize) < self.data.len())
    }

    /// The elements that were added since [`Tables::mark_clean`](super::Tables::mark_clean), and all that follow them.
    #[must_use]
    pub fn tail(&self) -> Range<usize> {
        self.known.min(self.data.len())..self.data.len()
    }

    pub(super) fn len(&self) -> usize {
        self.data.len()
    }

    pub(super) fn set(&mut self, index: usize, value: T) {
        self.data[index] = value;
        self.touch(index);
    }

    fn touch(&mut self, index: usize) {
        if index >= self.known {
            return; // in the tail
        }
        let (word, bit) = (&mut self.is_changed[index / 64], 1 << (index % 64));
        if *word & bit == 0 {
            *word |= bit;
            self.changed.push(u32_from(index));
        }
    }

    pub(super) fn extend(&mut self, values: impl IntoIterator<Item = T>) -> Result<u32, Error> {
        const LIMIT: usize = NONE as usize;
        let first = self.data.len();
        self.data.extend(values);
        let count = self.data.len();
        if count > LIMIT {
            self.data.truncate(first);
            return Err(Error::TooLarge { what: self.name, count, limit: LIMIT });
        }
        self.touch_from(first);
        Ok(u32_from(first))
    }

    /// Lengthens the table to `count` elements, or leaves it where it has as many.
    pub(super) fn grow(&mut self, count: usize, value: T) {
        let first = self.data.len();
        if count > first {
            self.data.resize(count, value);
            self.touch_from(first);
        }
    }

    /// Devices still hold what stood where the table shrank and grew again.
    fn touch_from(&mut self, first: usize) {
        for index in first..self.data.len().min(self.known) {
            self.touch(index);
        }
    }

    /// Forgets which elements changed.
    pub(super) fn mark_clean(&mut self) {
        self.forget_changes();
        self.known = self.data.len();
        let words = self.known.div_ceil(64);
        if words > self.is_changed.len() {
            self.is_changed.resize(words, 0);
        }
    }

    /// Makes every element part of the tail.
    pub(super) fn mark_dirty(&mut self) {
        self.forget_changes();
        self.known = 0;
    }

    fn forget_changes(&mut self) {
        for index in self.changed.drain(..) {
            self.is_changed[index as usize / 64] = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table_of(count: u32) -> Table<u32> {
        let mut table = Table::new("numbers");
        table.extend(0..count).unwrap();
        table
    }

    fn changed(table: &Table<u32>) -> Vec<u32> {
        let mut changed: Vec<u32> = table.changed().collect();
        changed.sort_unstable();
        changed
    }

    #[test]
    fn new_elements_are_the_tail_and_old_ones_are_named_once() {
        let mut table = table_of(200);
        assert_eq!((changed(&table), table.tail()), (vec![], 0..200));
        table.set(7, 1);
        assert_eq!((changed(&table), table.tail()), (vec![], 0..200), "the tail holds it already");
        table.mark_clean();
        assert_eq!((changed(&table), table.tail()), (vec![], 200..200));
        for index in [199, 7, 64, 7, 199] {
            table.set(index, 2);
        }
        table.extend([5, 6]).unwrap();
        table.set(201, 9);
        assert_eq!((changed(&table), table.tail()), (vec![7, 64, 199], 200..202));
        table.mark_clean();
        assert_eq!((changed(&table), table.tail()), (vec![], 202..202));
        table.set(7, 3);
        assert_eq!(changed(&table), [7], "named again after it was forgotten");
        table.mark_dirty();
        assert_eq!((changed(&table), table.tail()), (vec![], 0..202));
        table.mark_clean();
        table.set(7, 4);
        assert_eq!(changed(&table), [7]);
    }
}
