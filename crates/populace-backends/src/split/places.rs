//! The positions of members and palettes in the last frame, updated from what changed. Splitting
//! and gathering then need neither the tables nor a walk over all members.

use std::ops::Range;

use populace_device::Tables;
use populace_device::layout::{Member, NONE, PAGE_ENTRIES, PALETTE_BLOCK};

/// Indices that are counted together.
const CHUNK: usize = 256;
/// Elements of a palette entry.
const ENTRY: usize = 3;

/// All indices.
#[derive(Default)]
pub(crate) struct Places {
    places: Vec<Place>,
    /// The number of members of each chunk.
    counts: Vec<usize>,
    members: usize,
}

/// The member at an index; its palette entries by their number over all pages.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Free,
    Taken { entry_first: u32, entry_count: u32 },
}

/// Neighbouring elements of one palette page, all written by one device.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Run {
    pub(crate) page: usize,
    pub(crate) elements: Range<usize>,
}

impl Places {
    /// Takes over changes of the tables since they were last clean.
    pub(crate) fn update(&mut self, tables: &Tables) {
        let members = tables.members();
        let all = members.as_slice();
        while self.places.len() > all.len() {
            self.set(self.places.len() - 1, Place::Free);
            self.places.pop();
        }
        self.places.resize(all.len(), Place::Free);
        self.counts.resize(all.len().div_ceil(CHUNK), 0);
        for place in members.changed().map(|place| place as usize).chain(members.tail()) {
            self.set(place, Place::of(tables, &all[place]));
        }
    }

    fn set(&mut self, place: usize, value: Place) {
        let old = std::mem::replace(&mut self.places[place], value);
        let (came, left) = (usize::from(value != Place::Free), usize::from(old != Place::Free));
        let count = &mut self.counts[place / CHUNK];
        *count = *count + came - left;
        self.members = self.members + came - left;
    }

    /// The number of members.
    pub(crate) fn members(&self) -> usize {
        self.members
    }

    /// Returns the index before which `count` members are; for all members, the end of all indices.
    pub(crate) fn place_after(&self, mut members: usize) -> u32 {
        if members >= self.members {
            return u32::MAX;
        }
        let mut chunk = 0;
        while members >= self.counts[chunk] {
            members -= self.counts[chunk];
            chunk += 1;
        }
        let first = chunk * CHUNK;
        let taken =
            (first..).zip(&self.places[first..]).filter(|(_, place)| **place != Place::Free);
        taken
            .map(|(place, _)| u32::try_from(place).unwrap_or(u32::MAX))
            .nth(members)
            .unwrap_or(u32::MAX)
    }

    /// Returns the palettes of the members in a range of indices, in order, with neighbours joined.
    pub(crate) fn palettes(&self, places: Range<u32>) -> Vec<Run> {
        let end = (places.end as usize).min(self.places.len());
        let mut blocks: Vec<Range<u32>> = self.places[(places.start as usize).min(end)..end]
            .iter()
            .filter_map(|place| match *place {
                Place::Taken { entry_first, entry_count } if entry_count > 0 => {
                    Some(entry_first..entry_first + entry_count.next_multiple_of(PALETTE_BLOCK))
                }
                _ => None,
            })
            .collect();
        blocks.sort_unstable_by_key(|block| block.start);
        let mut runs: Vec<Run> = Vec::new();
        for block in blocks {
            let page = (block.start / PAGE_ENTRIES) as usize;
            let first = (block.start % PAGE_ENTRIES) as usize * ENTRY;
            let elements = first..first + block.len() * ENTRY;
            match runs.last_mut() {
                Some(run) if run.page == page && run.elements.end == first => {
                    run.elements.end = elements.end
                }
                _ => runs.push(Run { page, elements }),
            }
        }
        runs
    }
}

impl Place {
    fn of(tables: &Tables, member: &Member) -> Self {
        if member.body == NONE {
            return Self::Free;
        }
        let entry_count = tables.bodies().as_slice()[member.body as usize].entry_count;
        Self::Taken { entry_first: member.palette_first, entry_count }
    }
}

#[cfg(test)]
mod tests {
    use populace_character::PaletteEntry;
    use populace_device::BodyIndex;
    use populace_model::{Affine, JointIndex, JointSource, Skeleton, Trs};
    use populace_testkit::Rng;

    use super::*;

    fn body(tables: &mut Tables, entries: usize) -> BodyIndex {
        let joint = JointSource { name: "root".into(), parent: None, rest: Trs::IDENTITY };
        let entry = PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY };
        tables.add_body(&Skeleton::new(&[joint]).unwrap(), &vec![entry; entries]).unwrap()
    }

    /// After any sequence of changes, incremental updates equal a full rebuild.
    #[test]
    fn incremental_updates_equal_a_full_rebuild() {
        let mut tables = Tables::new(1);
        let bodies = [0, 5, 40, 300_000].map(|entries| body(&mut tables, entries));
        let (mut kept, mut members, mut rng) = (Places::default(), Vec::new(), Rng::new(5));
        let mut random = |below: usize| rng.below(below);
        for step in 0..3000 {
            if random(10) < if step / 700 % 2 == 0 { 7 } else { 3 } || members.is_empty() {
                members.push(
                    tables.add_member(bodies[if random(50) == 0 { 3 } else { random(3) }]).unwrap(),
                );
            } else {
                tables.remove_member(members.swap_remove(random(members.len())));
            }
            if random(8) == 0 {
                kept.update(&tables);
                if random(4) > 0 {
                    tables.mark_clean(); // Otherwise a device has failed.
                }
                let mut rebuilt = Places::default();
                let mut all = tables.clone();
                all.mark_dirty();
                rebuilt.update(&all);
                assert_eq!(
                    (&kept.places, &kept.counts),
                    (&rebuilt.places, &rebuilt.counts),
                    "step {step}"
                );
                assert_eq!(
                    (kept.members(), members.len()),
                    (rebuilt.members(), members.len()),
                    "step {step}"
                );
                members.sort_unstable();
                let nth = random(members.len().max(1));
                assert_eq!(kept.place_after(nth), members.get(nth).copied().unwrap_or(u32::MAX));
                assert_eq!(kept.place_after(members.len()), u32::MAX);
            }
        }
    }

    #[test]
    fn adjacent_palettes_form_one_run_per_page() {
        let mut tables = Tables::new(1);
        let (small, none, large) =
            (body(&mut tables, 3), body(&mut tables, 0), body(&mut tables, 600_000));
        let places =
            [small, small, none, small, large, large, small].map(|b| tables.add_member(b).unwrap());
        let mut kept = Places::default();
        kept.update(&tables);
        let run = |page: usize, first: u32, end: u32| Run {
            page,
            elements: first as usize * ENTRY..end as usize * ENTRY,
        };
        let (block, large) = (PALETTE_BLOCK, 600_000_u32.next_multiple_of(PALETTE_BLOCK));
        // The block of a member without entries is not copied.
        let all =
            [run(0, 0, 2 * block), run(0, 3 * block, 4 * block + large), run(1, 0, large + block)];
        assert_eq!(kept.palettes(0..u32::MAX), all);
        assert_eq!(kept.palettes(places[1]..places[3]), [run(0, block, 2 * block)]);
        assert_eq!(kept.palettes(places[5]..places[6]), [run(1, 0, large)]);
        assert_eq!(kept.palettes(7..9), []);
        tables.mark_clean();
        tables.remove_member(places[1]);
        kept.update(&tables);
        assert_eq!(kept.palettes(0..places[4]), [run(0, 0, block), run(0, 3 * block, 4 * block)]);
    }
}
