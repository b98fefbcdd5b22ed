//! Members: their rows, and their joints and palette entries.

use std::cmp::Reverse;

use populace_model::convert::u32_from;

use super::slots::{EMPTY_SLOT, PLAIN_LAYER};
use super::table::Table;
use super::{BodyIndex, Tables};
use crate::Error;
use crate::layout::{
    Body, JOINT_BLOCK, LAYERS_PER_MEMBER, MAX_PHASES, MEMBER_HIDDEN, MEMBER_LAYER_BITS, Member,
    NONE, PAGE_ENTRIES, PALETTE_BLOCK,
};

const FREE_MEMBER: Member = Member {
    body: NONE,
    joint_first: 0,
    palette_first: 0,
    layers_and_phase: 0,
    control: NONE,
    posed: NONE,
    shape: NONE,
};

impl Member {
    /// Number of layers in use.
    #[inline]
    #[must_use]
    pub const fn layer_count(&self) -> u32 {
        self.layers_and_phase & ((1 << MEMBER_LAYER_BITS) - 1)
    }

    /// Phase of the frame in which the member is evaluated.
    #[inline]
    #[must_use]
    pub const fn phase(&self) -> u32 {
        (self.layers_and_phase & !MEMBER_HIDDEN) >> MEMBER_LAYER_BITS
    }

    /// Returns whether no frame evaluates the member. To kernels its phase is above all others.
    #[inline]
    #[must_use]
    pub const fn is_hidden(&self) -> bool {
        self.layers_and_phase & MEMBER_HIDDEN != 0
    }
}

impl Tables {
    /// Sorts the members of each page so that devices find those of one body and shape of program
    /// side by side. Results do not depend on it.
    pub fn sort_pages(&mut self) {
        let members = self.all.members.as_slice();
        self.page_lists.sort_by_key(|member| {
            let Member { posed, shape, .. } = members[member as usize];
            (posed, shape, member)
        });
    }

    /// Tells the list of a member's page that the member has changed its kind.
    pub(super) fn mix_page(&mut self, member_index: u32) {
        let first = self.all.members.as_slice()[member_index as usize].palette_first;
        self.page_lists.mix((first / PAGE_ENTRIES) as usize, member_index);
    }

    /// Adds a member of `body` without any clip and returns its index.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if offsets exceed 32 bits.
    ///
    /// # Panics
    ///
    /// If the body does not exist.
    pub fn add_member(&mut self, body: BodyIndex) -> Result<u32, Error> {
        let Body { padded_count, entry_count, .. } = self.all.bodies.as_slice()[body.0 as usize];
        let blocks = (padded_count / JOINT_BLOCK) as usize;
        self.check_capacity(blocks, palette_block_count(entry_count))?;
        let member_index = self.take_index()?;
        self.all.slots.grow(self.member_places() * self.slots_per_member, EMPTY_SLOT);
        self.all.layers.grow(self.member_places() * LAYERS_PER_MEMBER as usize, PLAIN_LAYER);
        let joint_block = self.joint_space.take(blocks);
        let palette_block = self.palette_space.take(palette_block_count(entry_count));
        fill(&mut self.blocks.joint_blocks, joint_block, member_index);
        fill(&mut self.blocks.palette_blocks, palette_block, member_index);
        self.all.members.set(
            member_index as usize,
            Member {
                body: body.0,
                joint_first: u32_from(joint_block.0 * JOINT_BLOCK as usize),
                palette_first: u32_from(palette_block.0 * PALETTE_BLOCK as usize),
                layers_and_phase: 1,
                control: NONE,
                posed: body.0,
                shape: NONE,
            },
        );
        self.phase_members[0] += 1;
        self.page_lists.add(page_of(palette_block), member_index);
        Ok(member_index)
    }

    fn check_capacity(&self, joint_blocks: usize, palette_blocks: usize) -> Result<(), Error> {
        let (joints, palettes) =
            (self.joint_space.end_with(joint_blocks), self.palette_space.end_with(palette_blocks));
        let slots = (self.member_places() + 1) * self.slots_per_member;
        for (what, count, limit) in [
            ("the joint buffer", joints, NONE / JOINT_BLOCK),
            ("the palettes", palettes, NONE / PALETTE_BLOCK),
            ("the slots", slots, NONE),
        ] {
            if count > limit as usize {
                return Err(Error::TooLarge { what, count, limit: limit as usize });
            }
        }
        Ok(())
    }

    /// Returns the lowest unused member index, or a new one.
    fn take_index(&mut self) -> Result<u32, Error> {
        match self.free_members.pop() {
            Some(Reverse(member_index)) if (member_index as usize) < self.member_places() => {
                Ok(member_index)
            }
            // The table may have shrunk so that the lowest unused index is past its end. The index
            // is dropped here. The table grows by one each time, so it never contains an entry that
            // is also listed as unused.
            _ => self.all.members.extend([FREE_MEMBER]),
        }
    }

    /// Removes a member. Unused entries at the end of the tables are dropped, so that devices need
    /// memory only for those in use.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    pub fn remove_member(&mut self, member_index: u32) {
        self.remove_control(member_index);
        let member = self.all.members.as_slice()[member_index as usize];
        let Body { padded_count, entry_count, .. } =
            self.all.bodies.as_slice()[member.body as usize];
        let joints =
            ((member.joint_first / JOINT_BLOCK) as usize, (padded_count / JOINT_BLOCK) as usize);
        let palette =
            ((member.palette_first / PALETTE_BLOCK) as usize, palette_block_count(entry_count));
        fill(&mut self.blocks.joint_blocks, joints, NONE);
        fill(&mut self.blocks.palette_blocks, palette, NONE);
        self.phase_members[member.phase() as usize] -= 1;
        self.joint_space.release(joints);
        self.palette_space.release(palette);
        self.page_lists.remove(page_of(palette), member_index);
        self.reset_playback(member_index);
        self.all.members.set(member_index as usize, FREE_MEMBER);
        self.free_members.push(Reverse(member_index));
        self.drop_unused_end();
    }

    fn drop_unused_end(&mut self) {
        let members = &mut self.all.members;
        let taken =
            members.as_slice().iter().rposition(|m| m.body != NONE).map_or(0, |last| last + 1);
        members.truncate(taken);
        self.all.slots.truncate(taken * self.slots_per_member);
        self.all.layers.truncate(taken * LAYERS_PER_MEMBER as usize);
        self.blocks.joint_blocks.truncate(self.joint_space.end());
        self.blocks.palette_blocks.truncate(self.palette_space.end());
    }

    pub(super) fn used_member(&self, member_index: u32) -> Result<&Member, Error> {
        match self.all.members.as_slice().get(member_index as usize) {
            Some(member) if member.body != NONE => Ok(member),
            _ => Err(Error::BadPlayback { what: "member", value: member_index }),
        }
    }

    /// Sets the phase of the frame in which a member is evaluated. An attached member needs a later
    /// phase than its parent.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member does not exist or the phase is [`MAX_PHASES`] or
    /// above.
    pub fn set_phase(&mut self, member_index: u32, phase: u32) -> Result<(), Error> {
        let mut member = *self.used_member(member_index)?;
        if phase >= MAX_PHASES {
            return Err(Error::BadPlayback { what: "phase", value: phase });
        }
        if phase == member.phase() {
            return Ok(());
        }
        self.phase_members[member.phase() as usize] -= 1;
        self.phase_members[phase as usize] += 1;
        member.layers_and_phase = phase << MEMBER_LAYER_BITS
            | member.layers_and_phase & MEMBER_HIDDEN
            | member.layer_count();
        self.all.members.set(member_index as usize, member);
        Ok(())
    }

    /// Number of phases in a frame, up to the last one that a member is evaluated in; at least 1.
    #[must_use]
    pub fn phase_count(&self) -> u32 {
        u32_from(
            self.phase_members.iter().rposition(|members| *members > 0).map_or(1, |last| last + 1),
        )
    }
}

fn page_of((palette_block, _): (usize, usize)) -> usize {
    palette_block / (PAGE_ENTRIES / PALETTE_BLOCK) as usize
}

/// Returns the blocks of a palette, at least one: the fused schedules go through the owners of blocks
/// and the members of pages, and members without entries have states and watched joints too.
fn palette_block_count(entry_count: u32) -> usize {
    entry_count.div_ceil(PALETTE_BLOCK).max(1) as usize
}

fn fill(blocks: &mut Table<u32>, (first, count): (usize, usize), member_index: u32) {
    blocks.grow(first + count, NONE);
    for block in first..first + count {
        blocks.set(block, member_index);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::layout::{LAYER_MASK, Layer};
    use populace_character::PaletteEntry;
    use populace_model::{Affine, JointIndex, JointSource, Skeleton, Trs};

    /// Bodies given as (joint count, palette entry count).
    pub(in crate::tables) fn tables(bodies: &[(usize, usize)]) -> (Tables, Vec<BodyIndex>) {
        let mut tables = Tables::new(2);
        let add = |(joints, entries): &(usize, usize)| {
            let joint = |j| JointSource { name: format!("{j}"), parent: None, rest: Trs::IDENTITY };
            let skeleton = Skeleton::new(&(0..*joints).map(joint).collect::<Vec<_>>()).unwrap();
            let entry = PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY };
            tables.add_body(&skeleton, &vec![entry; *entries]).unwrap()
        };
        let bodies = bodies.iter().map(add).collect();
        (tables, bodies)
    }

    /// Compares all lists and sizes with values recounted from the member table.
    fn assert_consistent(tables: &Tables) {
        let members = tables.members().as_slice();
        let mut pages = vec![HashSet::new(); tables.page_lengths().len()];
        let mut joint_blocks = vec![NONE; tables.joint_blocks().len()];
        let mut palette_blocks = vec![NONE; tables.palette_blocks().len()];
        for (member_index, member) in (0..).zip(members).filter(|(_, m)| m.body != NONE) {
            let body = tables.bodies().as_slice()[member.body as usize];
            let (first, count) =
                (member.joint_first / JOINT_BLOCK, body.padded_count / JOINT_BLOCK);
            joint_blocks[first as usize..][..count as usize].fill(member_index);
            pages[(member.palette_first / PAGE_ENTRIES) as usize].insert(member_index);
            let first = (member.palette_first / PALETTE_BLOCK) as usize;
            palette_blocks[first..][..palette_block_count(body.entry_count)].fill(member_index);
        }
        for (page, wanted) in pages.iter().enumerate() {
            let list = tables.page_members(page).as_slice();
            assert_eq!(list.len(), wanted.len(), "page {page} lists a member twice");
            assert_eq!(list.iter().copied().collect::<HashSet<_>>(), *wanted, "page {page}");
        }
        assert_eq!(tables.joint_blocks().as_slice(), joint_blocks);
        assert_eq!(tables.palette_blocks().as_slice(), palette_blocks);
        assert_ne!(members.last().map(|m| m.body), Some(NONE), "the last entry is in use");
        assert_ne!(joint_blocks.last(), Some(&NONE));
        assert_ne!(palette_blocks.last(), Some(&NONE));
        assert_eq!(tables.slots().len(), members.len() * tables.slots_per_member());
        assert_eq!(tables.layers().len(), members.len() * LAYERS_PER_MEMBER as usize);
    }

    #[test]
    fn page_lists_and_blocks_stay_consistent_under_random_use() {
        // A third of a page, a quarter of one, a few entries, and none.
        let (mut tables, bodies) = tables(&[(1, 350_000), (40, 262_144), (17, 3), (2, 0)]);
        let (mut taken, mut rng) = (Vec::new(), fastrand::Rng::with_seed(3));
        let mut random = |below: usize| rng.usize(..below);
        for step in 0..600 {
            // Mostly add members in one half of the time, mostly remove them in the other.
            if random(10) < if step / 40 % 2 == 0 { 7 } else { 3 } || taken.is_empty() {
                let member_index = tables.add_member(bodies[random(4)]).unwrap();
                assert!(!taken.contains(&member_index), "index {member_index} is used twice");
                taken.push(member_index);
            } else {
                tables.remove_member(taken.swap_remove(random(taken.len())));
            }
            if step % 10 == 0 {
                assert_consistent(&tables);
            }
            if random(3) == 0 {
                tables.mark_clean();
            }
        }
        taken.drain(..).for_each(|member_index| tables.remove_member(member_index));
        assert_eq!(
            (tables.member_places(), tables.joint_places(), tables.palette_places()),
            (0, 0, 0)
        );
    }

    #[test]
    fn phase_count_follows_the_members() {
        let (mut tables, bodies) = tables(&[(1, 1)]);
        assert_eq!(tables.phase_count(), 1);
        let [first, second] = [(); 2].map(|()| tables.add_member(bodies[0]).unwrap());
        tables.set_phase(second, 3).unwrap();
        tables
            .set_layer(second, 2, Layer { weight: 0.5, mask_and_mode: LAYER_MASK })
            .expect("the layer exists");
        let row = tables.members().as_slice()[second as usize];
        assert_eq!((row.phase(), row.layer_count(), tables.phase_count()), (3, 3, 4));
        tables.set_phase(first, 1).unwrap();
        tables.remove_member(second);
        assert_eq!(tables.phase_count(), 2);
        tables.set_phase(first, 0).unwrap();
        assert_eq!(tables.phase_count(), 1);
        tables.set_phase(first, MAX_PHASES).unwrap_err();
        tables.set_phase(second, 0).unwrap_err();
    }
}
