//! Values by index, whose indices are used again.

/// Values by index. Each index has a generation, which changes when its value is removed, so that
/// an old id is not taken for a new one.
#[derive(Clone, Debug)]
pub(super) struct Slab<T> {
    entries: Vec<(u32, Option<T>)>,
}

impl<T> Default for Slab<T> {
    fn default() -> Self {
        Self { entries: Vec::new() }
    }
}

impl<T> Slab<T> {
    /// The lowest free index.
    pub(super) fn free_index(&self) -> u32 {
        let free = self.entries.iter().position(|(_, value)| value.is_none());
        super::u32_from(free.unwrap_or(self.entries.len()))
    }

    /// Adds a value at the lowest free index. Returns the index and its generation.
    pub(super) fn insert(&mut self, value: T) -> (u32, u32) {
        let index = self.free_index();
        (index, self.insert_at(index, value))
    }

    /// Adds a value at a free index. Returns the generation of the index.
    pub(super) fn insert_at(&mut self, index: u32, value: T) -> u32 {
        let count = self.entries.len().max(index as usize + 1);
        self.entries.resize_with(count, || (0, None));
        let entry = &mut self.entries[index as usize];
        entry.1 = Some(value);
        entry.0
    }

    /// Removes and returns the value at an index.
    pub(super) fn remove(&mut self, index: u32) -> Option<T> {
        let entry = self.entries.get_mut(index as usize)?;
        entry.0 = entry.0.wrapping_add(1);
        entry.1.take()
    }

    /// Returns the value of an index and generation, unless it was removed.
    pub(super) fn get(&self, (index, generation): (u32, u32)) -> Option<&T> {
        let (known, value) = self.entries.get(index as usize)?;
        value.as_ref().filter(|_| *known == generation)
    }

    /// Returns the value of an index and generation, unless it was removed.
    pub(super) fn get_mut(&mut self, (index, generation): (u32, u32)) -> Option<&mut T> {
        let (known, value) = self.entries.get_mut(index as usize)?;
        value.as_mut().filter(|_| *known == generation)
    }

    /// Returns the value at an index, of whatever generation.
    pub(super) fn at(&self, index: u32) -> Option<&T> {
        self.entries.get(index as usize)?.1.as_ref()
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.entries.len()
    }

    /// The generation of an index.
    pub(super) fn generation(&self, index: u32) -> u32 {
        self.entries.get(index as usize).map_or(0, |(generation, _)| *generation)
    }

    /// Iterates over indices, generations and values.
    pub(super) fn iter(&self) -> impl Iterator<Item = ((u32, u32), &T)> + Clone {
        let entries = (0u32..).zip(&self.entries);
        entries.filter_map(|(index, (generation, value))| {
            Some(((index, *generation), value.as_ref()?))
        })
    }

    /// Iterates over the values, to change them.
    pub(super) fn values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.entries.iter_mut().filter_map(|(_, value)| value.as_mut())
    }
}

/// The value at an index that is in use.
impl<T> std::ops::Index<u32> for Slab<T> {
    type Output = T;

    fn index(&self, index: u32) -> &T {
        self.at(index).expect("an index in use")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_is_used_again_with_another_generation() {
        let mut slab = Slab::default();
        let ids = ["a", "b", "c"].map(|value| slab.insert(value));
        assert_eq!(ids, [(0, 0), (1, 0), (2, 0)]);
        assert_eq!(slab.remove(1), Some("b"));
        assert_eq!((slab.remove(1), slab.get(ids[1]), slab.at(1)), (None, None, None));
        let next = slab.insert("d");
        assert_eq!(next.0, 1);
        assert_eq!((slab.get(ids[1]), slab.get(next)), (None, Some(&"d")));
        assert_eq!(slab.iter().map(|(_, value)| *value).collect::<Vec<_>>(), ["a", "d", "c"]);
    }
}
