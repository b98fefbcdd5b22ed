//! An array copied by devices, with a record of its changes.

use std::ops::Range;

use populace_model::convert::u32_from;

use super::free_runs::FreeRuns;
use crate::Error;
use crate::layout::NONE;

/// An array that devices keep copies of. A device's copy lacks the [`tail`](Self::tail) and the
/// elements before it that [`changed`](Self::changed) lists. Recording and clearing changes takes
/// time proportional to their number, not to the number of elements.
#[derive(Clone, Debug)]
pub struct Table<T> {
    name: &'static str,
    data: Vec<T>,
    expected: usize,
    /// Number of elements at the last [`mark_clean`](Self::mark_clean).
    known: usize,
    /// Indices below `known` that changed or were removed since then, each once.
    changed: Vec<u32>,
    /// Earlier value of each element in `changed`.
    before: Vec<T>,
    /// Number of removed elements that are present while the table is reverted.
    revived: usize,
    /// One bit for each element below `known`, set for those in `changed`.
    is_changed: Vec<u64>,
    /// Runs that were released, below the end.
    free: FreeRuns,
}

impl<T: bytemuck::Pod> Table<T> {
    pub(super) fn new(name: &'static str) -> Self {
        Self {
            name,
            data: Vec::new(),
            expected: 0,
            known: 0,
            changed: Vec::new(),
            before: Vec::new(),
            revived: 0,
            is_changed: Vec::new(),
            free: FreeRuns::default(),
        }
    }

    /// The table's name, for error messages.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// All elements of the table.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.data
    }

    /// Indices of the elements before the [`tail`](Self::tail) that changed since
    /// [`Tables::mark_clean`](super::Tables::mark_clean), each once, in no particular order.
    pub fn changed(&self) -> impl Iterator<Item = u32> + '_ {
        self.changed.iter().copied().filter(|index| (*index as usize) < self.data.len())
    }

    /// Range of the elements added since [`Tables::mark_clean`](super::Tables::mark_clean). It
    /// reaches to the end of the table.
    #[must_use]
    pub fn tail(&self) -> Range<usize> {
        self.known.min(self.data.len())..self.data.len()
    }

    /// Expected maximum number of elements (see
    /// [`Tables::with_capacity`](super::Tables::with_capacity)), or 0 if unknown. Devices allocate
    /// memory for it at once.
    #[must_use]
    pub fn expected(&self) -> usize {
        self.expected
    }

    pub(super) fn set_expected(&mut self, count: usize) {
        self.expected = count;
    }

    pub(super) fn len(&self) -> usize {
        self.data.len()
    }

    #[inline]
    pub(super) fn set(&mut self, index: usize, value: T) {
        self.record_change(index);
        self.data[index] = value;
    }

    /// Changes an element where it is.
    #[inline]
    pub(super) fn change(&mut self, index: usize) -> &mut T {
        self.record_change(index);
        &mut self.data[index]
    }

    /// Overwrites existing elements from `first` on.
    pub(super) fn set_run(&mut self, first: usize, values: &[T]) {
        (first..first + values.len()).for_each(|index| self.record_change(index));
        self.data[first..first + values.len()].copy_from_slice(values);
    }

    /// Records that an element is about to change or be removed, and saves its value.
    #[inline]
    fn record_change(&mut self, index: usize) {
        if index >= self.known {
            return; // in the tail
        }
        let (word, bit) = (&mut self.is_changed[index / 64], 1 << (index % 64));
        if *word & bit == 0 {
            *word |= bit;
            self.changed.push(u32_from(index));
            self.before.push(self.data[index]);
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
        Ok(u32_from(first))
    }

    /// Adds a run of elements, where a run was released or at the end, and returns the index of the
    /// first; 0 for no elements.
    pub(super) fn add(&mut self, values: &[T]) -> Result<u32, Error> {
        if values.is_empty() {
            return Ok(0);
        }
        match self.free.take(values.len()) {
            Some(first) => {
                self.set_run(first, values);
                Ok(u32_from(first))
            }
            None => self.extend(values.iter().copied()),
        }
    }

    /// Frees a run that [`add`](Self::add) returned. A run at the end shortens the table.
    pub(super) fn release(&mut self, run: Range<usize>) {
        let length = self.free.release(run, self.data.len());
        self.truncate(length);
    }

    /// Extends the table to `count` elements; does nothing if it has as many or more.
    pub(super) fn grow(&mut self, count: usize, value: T) {
        if count > self.data.len() {
            self.data.resize(count, value);
        }
    }

    /// Shortens the table to `count` elements; does nothing if it has as many or fewer. Devices
    /// still hold the removed elements, so elements added in their place count as changed.
    pub(super) fn truncate(&mut self, count: usize) {
        (count..self.data.len().min(self.known)).for_each(|index| self.record_change(index));
        self.data.truncate(count);
    }

    /// Returns whether no change has been recorded since [`mark_clean`](Self::mark_clean).
    pub(super) fn is_clean(&self) -> bool {
        self.changed.is_empty() && self.known == self.data.len()
    }

    /// Returns the value of an element at the last [`mark_clean`](Self::mark_clean); the present
    /// one of an element added since. Takes time proportional to the number of changes, for
    /// elements that changed.
    pub(super) fn value_before(&self, index: usize) -> T {
        let is_changed =
            self.is_changed.get(index / 64).is_some_and(|w| w >> (index % 64) & 1 != 0);
        let place = is_changed.then(|| self.changed.iter().position(|of| *of as usize == index));
        place.flatten().map_or(self.data[index], |place| self.before[place])
    }

    /// Restores the element values of the last [`mark_clean`](Self::mark_clean); elements added
    /// since stay after them. No element may change until [`restore`](Self::restore) is called.
    /// Takes time proportional to the number of changes.
    pub(super) fn revert(&mut self) {
        self.revived = self.known.saturating_sub(self.data.len());
        self.data.resize(self.data.len() + self.revived, T::zeroed());
        self.swap_changes();
    }

    /// Reapplies the changes after [`revert`](Self::revert).
    pub(super) fn restore(&mut self) {
        self.swap_changes();
        self.data.truncate(self.data.len() - std::mem::take(&mut self.revived));
    }

    fn swap_changes(&mut self) {
        for (index, before) in self.changed.iter().zip(&mut self.before) {
            std::mem::swap(&mut self.data[*index as usize], before);
        }
    }

    /// Clears the record of changes.
    pub(super) fn mark_clean(&mut self) {
        self.clear_changes();
        self.known = self.data.len();
        let words = self.known.div_ceil(64);
        if words > self.is_changed.len() {
            self.is_changed.resize(words, 0);
        }
    }

    /// Makes every element part of the tail.
    pub(super) fn mark_dirty(&mut self) {
        self.clear_changes();
        self.known = 0;
    }

    fn clear_changes(&mut self) {
        for index in self.changed.drain(..) {
            self.is_changed[index as usize / 64] = 0;
        }
        self.before.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A simulated device copy that follows the recorded changes.
    #[derive(Default)]
    struct DeviceCopy(Vec<u32>);

    impl DeviceCopy {
        fn copy_changes(&mut self, table: &Table<u32>) {
            for index in table.changed() {
                self.0[index as usize] = table.as_slice()[index as usize];
            }
            let tail = table.tail();
            self.0.resize(table.len().max(self.0.len()), 0);
            self.0[tail.clone()].copy_from_slice(&table.as_slice()[tail]);
        }

        #[track_caller]
        fn assert_holds(&self, table: &Table<u32>) {
            assert_eq!(&self.0[..table.len()], table.as_slice());
        }
    }

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
    fn new_elements_form_the_tail_and_changes_are_listed_once() {
        let mut table = table_of(200);
        assert_eq!((changed(&table), table.tail()), (vec![], 0..200));
        table.set(7, 1);
        assert_eq!((changed(&table), table.tail()), (vec![], 0..200), "the tail has it already");
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
        assert_eq!(changed(&table), [7], "listed again after the record was cleared");
        table.mark_dirty();
        assert_eq!((changed(&table), table.tail()), (vec![], 0..202));
        table.mark_clean();
        table.set(7, 4);
        assert_eq!(changed(&table), [7]);
    }

    #[test]
    fn removed_elements_are_not_listed_but_their_replacements_are() {
        let mut table = table_of(100);
        table.mark_clean();
        [3, 98, 99].into_iter().for_each(|index| table.set(index, 7));
        table.truncate(97);
        assert_eq!((changed(&table), table.tail()), (vec![3], 97..97));
        table.grow(99, 5);
        assert_eq!((changed(&table), table.tail()), (vec![3, 97, 98], 99..99));
        table.grow(103, 6);
        assert_eq!((changed(&table), table.tail()), (vec![3, 97, 98, 99], 100..103));
        table.truncate(50);
        table.mark_clean();
        table.grow(52, 8);
        assert_eq!((changed(&table), table.tail()), (vec![], 50..52));
    }

    #[test]
    fn a_device_that_takes_over_what_it_is_told_holds_all() {
        let (mut table, mut rng) = (table_of(40), fastrand::Rng::with_seed(7));
        let mut copies = [DeviceCopy::default(), DeviceCopy::default()];
        let mut copied = Vec::new();
        let mut random = |below: usize| rng.usize(..below);
        for step in 0..20_000 {
            match random(100) {
                0..70 => {
                    let index = random(table.len().max(1));
                    if index < table.len() {
                        table.set(index, step);
                    }
                }
                70..80 => drop(table.extend((0..step).take(random(9))).unwrap()),
                80..85 => table.grow(table.len() + random(5), step),
                85..92 => table.truncate(table.len().saturating_sub(random(15))),
                92 => table.mark_dirty(),
                _ => {
                    // All devices copy the changes. In some frames the record is then not cleared,
                    // as if the frame had failed.
                    for copy in &mut copies {
                        copy.copy_changes(&table);
                        copy.assert_holds(&table);
                    }
                    if random(4) > 0 {
                        table.mark_clean();
                        assert!(table.is_clean());
                        copied = table.as_slice().to_vec();
                    }
                }
            }
            if table.known > 0 {
                let now = table.as_slice().to_vec();
                for _ in 0..2 {
                    table.revert();
                    assert_eq!(table.as_slice()[..table.known], copied, "step {step}");
                    table.restore();
                    assert_eq!(table.as_slice(), now, "step {step}");
                }
            }
            let changed = changed(&table);
            let (unique, tail) = (changed.windows(2).all(|w| w[0] < w[1]), table.tail());
            assert!(
                unique && changed.iter().all(|index| (*index as usize) < tail.start),
                "step {step}"
            );
            assert!(tail.end == table.len() && table.len() < 1000, "step {step}");
        }
    }
}
