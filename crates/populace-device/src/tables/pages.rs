//! Which members' palettes stand in which page.

use populace_model::convert::u32_from;

use super::Table;

/// A list for each page, in no order: additions go to its end, and its last fills the place of one
/// that leaves.
#[derive(Clone, Debug, Default)]
pub(super) struct PageLists {
    lists: Vec<Table<u32>>,
    /// Where in its list each member stands, by its place; any number for those in none.
    positions: Vec<u32>,
}

impl PageLists {
    pub(super) fn lists(&self) -> &[Table<u32>] {
        &self.lists
    }

    pub(super) fn add(&mut self, page: usize, place: u32) {
        while self.lists.len() <= page {
            self.lists.push(Table::new("the members of a page"));
        }
        let list = &mut self.lists[page];
        let position = list.len();
        list.grow(position + 1, place);
        if self.positions.len() <= place as usize {
            self.positions.resize(place as usize + 1, 0);
        }
        self.positions[place as usize] = u32_from(position);
    }

    pub(super) fn remove(&mut self, page: usize, place: u32) {
        let (list, position) = (&mut self.lists[page], self.positions[place as usize] as usize);
        let last = list.len() - 1;
        let moved = list.as_slice()[last];
        if position != last {
            list.set(position, moved);
            self.positions[moved as usize] = u32_from(position);
        }
        list.truncate(last);
    }

    pub(super) fn mark_clean(&mut self) {
        self.lists.iter_mut().for_each(Table::mark_clean);
    }

    pub(super) fn mark_dirty(&mut self) {
        self.lists.iter_mut().for_each(Table::mark_dirty);
    }
}
