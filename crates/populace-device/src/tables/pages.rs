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
    /// Positions in each list whose members may be out of order since the list was sorted.
    strays: Vec<Vec<u32>>,
    /// Scratch buffers: members at these positions, and a list in order.
    moved: Vec<u32>,
    sorted: Vec<u32>,
}

impl PageLists {
    pub(super) fn lists(&self) -> &[Table<u32>] {
        &self.lists
    }

    pub(super) fn add(&mut self, page: usize, member: u32) {
        while self.lists.len() <= page {
            self.lists.push(Table::new("the members of a page"));
            self.strays.push(Vec::new());
        }
        let list = &mut self.lists[page];
        let position = list.len();
        list.grow(position + 1, member);
        if self.positions.len() <= member as usize {
            self.positions.resize(member as usize + 1, 0);
        }
        self.positions[member as usize] = u32_from(position);
        self.strays[page].push(u32_from(position));
    }

    pub(super) fn remove(&mut self, page: usize, member: u32) {
        let (list, position) = (&mut self.lists[page], self.positions[member as usize] as usize);
        let last = list.len() - 1;
        let moved = list.as_slice()[last];
        if position != last {
            list.set(position, moved);
            self.positions[moved as usize] = u32_from(position);
            self.strays[page].push(u32_from(position));
        }
        list.truncate(last);
    }

    /// Tells that a member of a page has changed its kind.
    pub(super) fn mix(&mut self, page: usize, member: u32) {
        self.strays[page].push(self.positions[member as usize]);
    }

    /// Sorts the lists with members that may be out of order. `kind` must differ for each member.
    pub(super) fn sort_by_key<K: Ord>(&mut self, kind: impl Fn(u32) -> K) {
        let Self { lists, positions, strays, moved, sorted } = self;
        for (list, strays) in lists.iter_mut().zip(strays) {
            if strays.is_empty() {
                continue;
            }
            collect_strays(list.as_slice(), strays, moved);
            moved.sort_unstable_by_key(|member| kind(*member));
            merge(list.as_slice(), strays, moved, &kind, sorted);
            strays.clear();
            for (position, &member) in sorted.iter().enumerate() {
                if list.as_slice()[position] != member {
                    list.set(position, member);
                    positions[member as usize] = u32_from(position);
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

/// Sorts `strays`, keeps each position of the list once, and collects the members there.
fn collect_strays(members: &[u32], strays: &mut Vec<u32>, moved: &mut Vec<u32>) {
    strays.sort_unstable();
    strays.dedup();
    strays.retain(|position| (*position as usize) < members.len());
    moved.clear();
    moved.extend(strays.iter().map(|position| members[*position as usize]));
}

/// Merges members in order into `sorted`: those of the list that are not at `strays`, and `moved`.
/// Both are in order.
fn merge<K: Ord>(
    members: &[u32],
    strays: &[u32],
    moved: &[u32],
    kind: impl Fn(u32) -> K,
    sorted: &mut Vec<u32>,
) {
    let (mut strays, mut moved) = (strays.iter().peekable(), moved.iter().peekable());
    sorted.clear();
    for (position, member) in members.iter().enumerate() {
        if strays.next_if(|stray| **stray as usize == position).is_some() {
            continue;
        }
        let own = kind(*member);
        while let Some(before) = moved.next_if(|other| kind(**other) < own) {
            sorted.push(*before);
        }
        sorted.push(*member);
    }
    sorted.extend(moved);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_sorted_after_members_come_go_and_change_their_kind() {
        let (mut lists, mut random) = (PageLists::default(), fastrand::Rng::with_seed(7));
        let mut pages: [Vec<u32>; 2] = Default::default();
        let mut kinds: Vec<u32> = Vec::new();
        for frame in 0..200 {
            for _ in 0..random.usize(..20) {
                let page = random.usize(..2);
                let members = &mut pages[page];
                let at = random.usize(..=members.len());
                match random.usize(..3) {
                    0 if at < members.len() => lists.remove(page, members.swap_remove(at)),
                    1 if at < members.len() => {
                        kinds[members[at] as usize] = random.u32(..3);
                        lists.mix(page, members[at]);
                    }
                    _ => {
                        members.push(u32_from(kinds.len()));
                        lists.add(page, u32_from(kinds.len()));
                        kinds.push(random.u32(..3));
                    }
                }
            }
            let kind = |member: u32| (kinds[member as usize], member);
            lists.sort_by_key(kind);
            for (page, list) in lists.lists().iter().enumerate() {
                let mut expected = pages[page].clone();
                expected.sort_by_key(|member| kind(*member));
                assert_eq!(list.as_slice(), expected, "page {page} in frame {frame}");
                for (position, member) in list.as_slice().iter().enumerate() {
                    assert_eq!(lists.positions[*member as usize] as usize, position);
                }
            }
        }
    }
}
