//! Values that some members have.

use populace_device::layout::NONE;

use super::u32_from;

/// Values by member index, side by side, each found by two reads. They are in the order in which
/// they were added, but a removed value leaves its place to the last one.
#[derive(Clone, Debug)]
pub(super) struct ByMember<T> {
    /// The place of each member's value in `entries`, or `NONE`.
    places: Vec<u32>,
    entries: Vec<(u32, T)>,
}

impl<T> Default for ByMember<T> {
    fn default() -> Self {
        Self { places: Vec::new(), entries: Vec::new() }
    }
}

impl<T> ByMember<T> {
    fn place(&self, member_index: u32) -> Option<usize> {
        let place = *self.places.get(member_index as usize)?;
        (place != NONE).then_some(place as usize)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    pub(super) fn get(&self, member_index: u32) -> Option<&T> {
        self.place(member_index).map(|place| &self.entries[place].1)
    }

    pub(super) fn get_mut(&mut self, member_index: u32) -> Option<&mut T> {
        self.place(member_index).map(|place| &mut self.entries[place].1)
    }

    /// Returns the member's value. `new` makes it if there is none.
    pub(super) fn get_or_insert_with(
        &mut self,
        member_index: u32,
        new: impl FnOnce() -> T,
    ) -> &mut T {
        let place = self.place(member_index).unwrap_or_else(|| {
            let count = self.places.len().max(member_index as usize + 1);
            self.places.resize(count, NONE);
            self.places[member_index as usize] = u32_from(self.entries.len());
            self.entries.push((member_index, new()));
            self.entries.len() - 1
        });
        &mut self.entries[place].1
    }

    /// Sets the member's value.
    pub(super) fn insert(&mut self, member_index: u32, value: T) {
        match self.get_mut(member_index) {
            Some(old) => *old = value,
            None => drop(self.get_or_insert_with(member_index, || value)),
        }
    }

    pub(super) fn remove(&mut self, member_index: u32) -> Option<T> {
        let place = self.place(member_index)?;
        self.places[member_index as usize] = NONE;
        let (_, value) = self.entries.swap_remove(place);
        if let Some((moved, _)) = self.entries.get(place) {
            self.places[*moved as usize] = u32_from(place);
        }
        Some(value)
    }

    /// Removes the values for which `keep` returns false.
    pub(super) fn retain(&mut self, keep: impl Fn(&T) -> bool) {
        self.entries.retain(|(_, value)| keep(value));
        self.places.fill(NONE);
        for (place, (member_index, _)) in (0..).zip(&self.entries) {
            self.places[*member_index as usize] = place;
        }
    }

    /// Iterates over member indices and values.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, &T)> {
        self.entries.iter().map(|(member_index, value)| (*member_index, value))
    }

    /// Iterates over member indices and values, to change them.
    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = (u32, &mut T)> {
        self.entries.iter_mut().map(|(member_index, value)| (*member_index, value))
    }
}

impl<T: Default> ByMember<T> {
    pub(super) fn get_or_default(&mut self, member_index: u32) -> &mut T {
        self.get_or_insert_with(member_index, T::default)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn values_are_those_of_a_map() {
        let (mut values, mut map) = (ByMember::default(), BTreeMap::new());
        let mut rng = populace_testkit::Rng::new(5);
        for step in 0..20_000_u32 {
            let member_index = u32_from(rng.below(40));
            match rng.below(100) {
                0..40 => {
                    values.insert(member_index, step);
                    map.insert(member_index, step);
                }
                40..60 => {
                    let own = values.get_or_default(member_index);
                    *own += 1;
                    let expected = map.entry(member_index).or_default();
                    *expected += 1;
                    assert_eq!(own, expected);
                }
                60..95 => assert_eq!(values.remove(member_index), map.remove(&member_index)),
                95..98 => {
                    values.iter_mut().for_each(|(_, value)| *value ^= 1);
                    map.values_mut().for_each(|value| *value ^= 1);
                }
                _ => {
                    values.retain(|value| value % 3 > 0);
                    map.retain(|_, value| *value % 3 > 0);
                }
            }
            let mut all: Vec<_> = values.iter().map(|(index, value)| (index, *value)).collect();
            all.sort_unstable();
            assert!(all.iter().copied().eq(map.iter().map(|(index, value)| (*index, *value))));
            assert_eq!(values.is_empty(), map.is_empty());
            for index in 0..41 {
                assert_eq!(values.get(index), map.get(&index), "step {step}");
            }
        }
    }
}
