//! Members, their slots and their layers.

use std::cmp::Reverse;
use std::ops::Range;

use populace_model::convert::u32_from;

use super::table::Table;
use super::{BodyIndex, Tables};
use crate::Error;
use crate::layout::{
    Body, BoundClip, InertializationSlot, JOINT_BLOCK, LAYER_MASK, LAYERS_PER_MEMBER, Layer,
    MAX_PHASES, MEMBER_HIDDEN, MEMBER_LAYER_BITS, Member, NONE, PAGE_ENTRIES, PALETTE_BLOCK,
    SLOT_LIVE, SLOT_LOOP, SLOT_MACHINE, Slot,
};

const EMPTY_SLOT: Slot = Slot {
    start_tick: 0,
    phase_rate: 0,
    weight_tick: 0,
    start_phase: 0,
    bound_clip: NONE,
    layer_and_mode: SLOT_LOOP,
    start_weight: 0.0,
    weight_rate: 0.0,
    end_weight: 0.0,
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
const PLAIN_LAYER: Layer = Layer { weight: 1.0, mask_and_mode: LAYER_MASK };

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
    pub(super) fn mix_page(&mut self, member: &Member) {
        self.page_lists.mix((member.palette_first / PAGE_ENTRIES) as usize);
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

    fn reset_playback(&mut self, member_index: u32) {
        for slot in self.slot_range(member_index) {
            self.replace_slot(slot, EMPTY_SLOT);
        }
        for layer in self.layer_range(member_index) {
            self.all.layers.set(layer, PLAIN_LAYER);
        }
    }

    /// Replaces a slot of a member.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member, slot or layer does not exist, the clip is not bound to
    /// the member's body or does not allow the slot's mode, or the state machine belongs to another
    /// body.
    pub fn set_slot(&mut self, member_index: u32, index: usize, slot: Slot) -> Result<(), Error> {
        let member = self.used_member(member_index)?;
        let bad = |what: &'static str, value: u32| Err(Error::BadPlayback { what, value });
        if index >= self.slots_per_member {
            return bad("slot", u32::try_from(index).unwrap_or(NONE));
        }
        if slot.layer() >= LAYERS_PER_MEMBER {
            return bad("layer", slot.layer());
        }
        if slot.mode() == SLOT_MACHINE {
            self.check_machine_instance(&slot, &member)?;
        } else {
            self.check_bound(&slot, &member)?;
        }
        self.replace_slot(member_index as usize * self.slots_per_member + index, slot);
        self.use_layer(member_index, slot.layer());
        Ok(())
    }

    pub(super) fn check_bound(&self, slot: &Slot, member: &Member) -> Result<(), Error> {
        let bad = |what: &'static str, value: u32| Err(Error::BadPlayback { what, value });
        let bound_of = |index: u32| self.all.bound_clips.as_slice().get(index as usize);
        let bound = bound_of(slot.bound_clip);
        if slot.bound_clip != NONE && bound.is_none_or(|bound| bound.body != member.body) {
            return bad("bound clip", slot.bound_clip);
        }
        let is_live =
            |bound: &BoundClip| self.all.clips.as_slice()[bound.clip as usize].ring_rows > 0;
        if bound.is_some_and(|bound| is_live(bound) != (slot.mode() == SLOT_LIVE)) {
            return bad("slot mode for this clip", slot.mode());
        }
        if let Some(&InertializationSlot { outgoing_clip, incoming_clip, .. }) =
            slot.as_inertialization()
            && outgoing_clip != NONE
            && bound_of(incoming_clip)
                .is_none_or(|bound| bound.body != member.body || is_live(bound))
        {
            return bad("bound clip to inertialize into", incoming_clip);
        }
        Ok(())
    }

    fn replace_slot(&mut self, index: usize, slot: Slot) {
        let before = self.all.slots.as_slice()[index].machine_instance();
        self.all.slots.set(index, slot);
        self.update_instance_uses(before, slot.machine_instance());
    }

    /// Replaces a layer of a member.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member, layer or mask does not exist.
    pub fn set_layer(
        &mut self,
        member_index: u32,
        index: usize,
        layer: Layer,
    ) -> Result<(), Error> {
        let member = self.used_member(member_index)?;
        let joints = self.all.bodies.as_slice()[member.body as usize].padded_count as usize;
        let layer_index = u32::try_from(index).unwrap_or(NONE);
        if layer_index >= LAYERS_PER_MEMBER {
            return Err(Error::BadPlayback { what: "layer", value: layer_index });
        }
        if let Some(first) = layer.mask().filter(|m| *m as usize + joints > self.all.masks.len()) {
            return Err(Error::BadPlayback { what: "mask", value: first });
        }
        self.all.layers.set(member_index as usize * LAYERS_PER_MEMBER as usize + index, layer);
        self.use_layer(member_index, layer_index);
        Ok(())
    }

    pub(super) fn used_member(&self, member_index: u32) -> Result<Member, Error> {
        let member =
            self.all.members.as_slice().get(member_index as usize).filter(|m| m.body != NONE);
        member.copied().ok_or(Error::BadPlayback { what: "member", value: member_index })
    }

    fn use_layer(&mut self, member_index: u32, layer: u32) {
        let mut member = self.all.members.as_slice()[member_index as usize];
        if member.layer_count() <= layer {
            member.layers_and_phase += layer + 1 - member.layer_count();
            self.all.members.set(member_index as usize, member);
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
        let mut member = self.used_member(member_index)?;
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

    /// Range of a member's slots in [`Tables::slots`].
    #[must_use]
    pub fn slot_range(&self, member_index: u32) -> Range<usize> {
        let first = member_index as usize * self.slots_per_member;
        first..first + self.slots_per_member
    }

    /// Range of a member's layers in [`Tables::layers`].
    #[must_use]
    pub fn layer_range(&self, member_index: u32) -> Range<usize> {
        let first = member_index as usize * LAYERS_PER_MEMBER as usize;
        first..first + LAYERS_PER_MEMBER as usize
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
mod tests {
    use std::collections::HashSet;

    use super::*;
    use populace_character::PaletteEntry;
    use populace_model::{Affine, JointIndex, JointSource, Skeleton, Trs};

    /// Bodies given as (joint count, palette entry count).
    fn tables(bodies: &[(usize, usize)]) -> (Tables, Vec<BodyIndex>) {
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

    #[test]
    fn new_member_inherits_no_playback() {
        let (mut tables, bodies) = tables(&[(1, 1)]);
        let member_index = tables.add_member(bodies[0]).unwrap();
        tables
            .set_layer(member_index, 2, Layer { weight: 0.5, mask_and_mode: LAYER_MASK })
            .unwrap();
        // No clip is bound.
        tables.set_slot(member_index, 1, Slot::default().on_layer(3)).unwrap_err();
        tables.mark_clean();
        tables.remove_member(member_index);
        assert_eq!(tables.add_member(bodies[0]), Ok(member_index));
        assert_eq!(tables.members().as_slice()[member_index as usize].layers_and_phase, 1);
        assert!(
            tables.layers().as_slice()[tables.layer_range(member_index)]
                .iter()
                .all(|l| *l == PLAIN_LAYER)
        );
        assert!(
            tables.slots().as_slice()[tables.slot_range(member_index)]
                .iter()
                .all(|s| *s == EMPTY_SLOT)
        );
        // It has the index of the old member on devices.
        assert_eq!(tables.members().changed().collect::<Vec<_>>(), [member_index]);
        assert_eq!((tables.slots().changed().count(), tables.layers().changed().count()), (2, 4));
    }
}
