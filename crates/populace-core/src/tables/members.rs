//! Members: their places, and what they play.

use std::ops::Range;

use super::table::Table;
use super::{BodyIndex, Tables, u32_from};
use crate::Error;
use crate::layout::{
    Body, JOINT_BLOCK, LAYER_MASK, LAYERS_PER_MEMBER, Layer, Member, NONE, PALETTE_BLOCK, SLOT_LOOP, Slot,
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
const PLAIN_LAYER: Layer = Layer { weight: 1.0, mask_and_mode: LAYER_MASK };

impl Tables {
    /// Gives a member of a body a place, without any clip; returns the place.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 32-bit offsets.
    ///
    /// # Panics
    ///
    /// If the body does not exist.
    pub fn add_member(&mut self, body: BodyIndex) -> Result<u32, Error> {
        let Body { padded_count, entry_count, .. } = self.all.bodies.as_slice()[body.0 as usize];
        let blocks = (padded_count / JOINT_BLOCK) as usize;
        for (what, count, limit) in [
            ("the joint buffer", self.joint_space.end_with(blocks), NONE / JOINT_BLOCK),
            (
                "the palettes",
                self.palette_space.end_with(palette_block_count(entry_count)),
                NONE / PALETTE_BLOCK,
            ),
        ] {
            if count > limit as usize {
                return Err(Error::TooLarge { what, count, limit: limit as usize });
            }
        }
        let place = match self.free_members.pop() {
            Some(place) => place,
            None => self.all.members.extend([Member { body: NONE, ..Member::default() }])?,
        };
        self.all.slots.grow(self.member_places() * self.slots_per_member, EMPTY_SLOT);
        self.all.layers.grow(self.member_places() * LAYERS_PER_MEMBER as usize, PLAIN_LAYER);
        let joint_block = self.joint_space.take(blocks);
        let palette_block = self.palette_space.take(palette_block_count(entry_count));
        fill(&mut self.all.joint_blocks, joint_block, place);
        fill(&mut self.all.palette_blocks, palette_block, place);
        self.reset_playback(place);
        self.all.members.set(
            place as usize,
            Member {
                body: body.0,
                joint_first: u32_from(joint_block.0 * JOINT_BLOCK as usize),
                palette_first: u32_from(palette_block.0 * PALETTE_BLOCK as usize),
                layer_count: 1,
            },
        );
        Ok(place)
    }

    /// Frees a member's place.
    ///
    /// # Panics
    ///
    /// If the place is not taken.
    pub fn remove_member(&mut self, place: u32) {
        let member = self.all.members.as_slice()[place as usize];
        let Body { padded_count, entry_count, .. } = self.all.bodies.as_slice()[member.body as usize];
        let joints = ((member.joint_first / JOINT_BLOCK) as usize, (padded_count / JOINT_BLOCK) as usize);
        let palette = ((member.palette_first / PALETTE_BLOCK) as usize, palette_block_count(entry_count));
        fill(&mut self.all.joint_blocks, joints, NONE);
        fill(&mut self.all.palette_blocks, palette, NONE);
        self.joint_space.give_back(joints);
        self.palette_space.give_back(palette);
        self.reset_playback(place);
        self.all.members.set(place as usize, Member { body: NONE, ..Member::default() });
        self.free_members.push(place);
    }

    fn reset_playback(&mut self, place: u32) {
        for slot in self.slot_range(place) {
            self.all.slots.set(slot, EMPTY_SLOT);
        }
        for layer in self.layer_range(place) {
            self.all.layers.set(layer, PLAIN_LAYER);
        }
    }

    /// Replaces one of a member's slots.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] for a place without a member, a slot that there is not, a layer past the last, or a clip
    /// that is not bound to the member's body.
    pub fn set_slot(&mut self, place: u32, index: usize, slot: Slot) -> Result<(), Error> {
        let member = self.taken(place)?;
        let bad = |what: &'static str, value: u32| Err(Error::BadPlayback { what, value });
        if index >= self.slots_per_member {
            return bad("slot", u32::try_from(index).unwrap_or(NONE));
        }
        if slot.layer() >= LAYERS_PER_MEMBER {
            return bad("layer", slot.layer());
        }
        let bound = self.all.bound_clips.as_slice().get(slot.bound_clip as usize);
        if slot.bound_clip != NONE && bound.is_none_or(|bound| bound.body != member.body) {
            return bad("bound clip", slot.bound_clip);
        }
        self.all.slots.set(place as usize * self.slots_per_member + index, slot);
        self.use_layer(place, slot.layer());
        Ok(())
    }

    /// Replaces one of a member's layers.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] for a place without a member, a layer past the last, or a mask that is not there.
    pub fn set_layer(&mut self, place: u32, index: usize, layer: Layer) -> Result<(), Error> {
        let member = self.taken(place)?;
        let joints = self.all.bodies.as_slice()[member.body as usize].joint_count as usize;
        let layer_index = u32::try_from(index).unwrap_or(NONE);
        if layer_index >= LAYERS_PER_MEMBER {
            return Err(Error::BadPlayback { what: "layer", value: layer_index });
        }
        if let Some(first) = layer.mask().filter(|m| *m as usize + joints > self.all.masks.len()) {
            return Err(Error::BadPlayback { what: "mask", value: first });
        }
        self.all.layers.set(place as usize * LAYERS_PER_MEMBER as usize + index, layer);
        self.use_layer(place, layer_index);
        Ok(())
    }

    fn taken(&self, place: u32) -> Result<Member, Error> {
        let member = self.all.members.as_slice().get(place as usize).filter(|m| m.body != NONE);
        member.copied().ok_or(Error::BadPlayback { what: "member", value: place })
    }

    fn use_layer(&mut self, place: u32, layer: u32) {
        let mut member = self.all.members.as_slice()[place as usize];
        if member.layer_count <= layer {
            member.layer_count = layer + 1;
            self.all.members.set(place as usize, member);
        }
    }

    /// Where a member's slots stand in [`Tables::slots`].
    #[must_use]
    pub fn slot_range(&self, place: u32) -> Range<usize> {
        let first = place as usize * self.slots_per_member;
        first..first + self.slots_per_member
    }

    /// Where a member's layers stand in [`Tables::layers`].
    #[must_use]
    pub fn layer_range(&self, place: u32) -> Range<usize> {
        let first = place as usize * LAYERS_PER_MEMBER as usize;
        first..first + LAYERS_PER_MEMBER as usize
    }
}

fn palette_block_count(entry_count: u32) -> usize {
    entry_count.div_ceil(PALETTE_BLOCK) as usize
}

fn fill(blocks: &mut Table<u32>, (first, count): (usize, usize), place: u32) {
    blocks.grow(first + count, NONE);
    for block in first..first + count {
        blocks.set(block, place);
    }
}
