//! Lists of the members with palettes in each page.

use populace_model::convert::u32_from;

use super::Table;

/// One list of member indices per page. New members are appended, and the last entry fills the gap
/// when a member leaves. Sorting then brings members of a kind side by side.
#[derive(Clone, Debug, Default)]
pub(super) struct PageLists {
    lists: Vec<Table<u32>>,
    /// Position of each member in its list, by member index; arbitrary for members in no list.
    positions: Vec<u32>,
    /// Whether members may have left their kind since each list was sorted.
    mixed: Vec<bool>,
}

impl PageLists {
    pub(super) fn lists(&self) -> &[Table<u32>] {
        &self.lists
    }

    pub(super) fn add(&mut self, page: usize, member: u32) {
        while self.lists.len() <= page {
            self.lists.push(Table::new("the members of a page"));
            self.mixed.push(true);
        }
        self.mixed[page] = true;
        let list = &mut self.lists[page];
        let position = list.len();
        list.grow(position + 1, member);
        if self.positions.len() <= member as usize {
            self.positions.resize(member as usize + 1, 0);
        }
        self.positions[member as usize] = u32_from(position);
    }

    pub(super) fn remove(&mut self, page: usize, member: u32) {
        let (list, position) = (&mut self.lists[page], self.positions[member as usize] as usize);
        let last = list.len() - 1;
        let moved = list.as_slice()[last];
        if position != last {
            list.set(position, moved);
            self.positions[moved as usize] = u32_from(position);
        }
        list.truncate(last);
        self.mixed[page] = true;
    }

    /// Tells that a member of a page has changed its kind.
    pub(super) fn mix(&mut self, page: usize) {
        self.mixed[page] = true;
    }

    /// Sorts the lists in which members may have left their kind.
    pub(super) fn sort_by_key<K: Ord>(&mut self, kind: impl Fn(u32) -> K) {
        for (list, mixed) in self.lists.iter_mut().zip(&mut self.mixed) {
            if !std::mem::take(mixed) || list.as_slice().is_sorted_by_key(|member| kind(*member)) {
                continue;
            }
            let mut sorted = list.as_slice().to_vec();
            sorted.sort_by_key(|member| kind(*member));
            for (position, member) in sorted.into_iter().enumerate() {
                if list.as_slice()[position] != member {
                    list.set(position, member);
                    self.positions[member as usize] = u32_from(position);
                }
            }
        }
    }

    pub(super) fn mark_clean(&mut self) {
        self.lists.iter_mut().for_each(Table::mark_clean);
    }

    pub(super) fn mark_dirty(&mut self) {
        self.lists.iter_mut().for_each(Table::mark_dirty);
    }
}
