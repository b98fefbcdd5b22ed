//! Slots and layers of members.

use std::ops::Range;

use super::Tables;
use crate::Error;
use crate::layout::{
    BoundClip, InertializationSlot, LAYER_MASK, LAYERS_PER_MEMBER, Layer, Member, NONE, SLOT_LIVE,
    SLOT_LOOP, SLOT_MACHINE, Slot,
};

pub(super) const EMPTY_SLOT: Slot = Slot {
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
pub(super) const PLAIN_LAYER: Layer = Layer { weight: 1.0, mask_and_mode: LAYER_MASK };

impl Tables {
    /// Replaces a slot of a member.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member, slot or layer does not exist, the clip is not bound to
    /// the member's body or does not allow the slot's mode, or the state machine belongs to another
    /// body.
    #[inline]
    pub fn set_slot(&mut self, member_index: u32, index: usize, slot: &Slot) -> Result<(), Error> {
        let member = self.used_member(member_index)?;
        let place = self.place_of_slot(member_index, index)?;
        if slot.layer() >= LAYERS_PER_MEMBER {
            return Err(Error::BadPlayback { what: "layer", value: slot.layer() });
        }
        if slot.mode() == SLOT_MACHINE {
            self.check_machine_instance(slot, member)?;
        } else {
            self.check_bound(slot, member)?;
        }
        self.replace_slot(place, slot);
        self.use_layer(member_index, slot.layer());
        Ok(())
    }

    /// Changes the weight of a slot from that at `tick` to another in `secs`, at least one tick,
    /// beginning at `tick`. The change is immediate if `secs` is not above zero. Inertializing
    /// slots have no weight and stay as they are.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member or slot does not exist.
    #[inline]
    pub fn ramp_slot(
        &mut self,
        member_index: u32,
        index: usize,
        tick: u64,
        to: f32,
        secs: f32,
    ) -> Result<(), Error> {
        self.used_member(member_index)?;
        let place = self.place_of_slot(member_index, index)?;
        if !self.all.slots.as_slice()[place].is_inertialization() {
            let slot = self.all.slots.change(place);
            slot.ramp_weight(tick, slot.weight_at(tick), to, secs);
        }
        Ok(())
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

    /// Range of a member's slots in [`Tables::slots`].
    #[must_use]
    #[inline]
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

    pub(super) fn reset_playback(&mut self, member_index: u32) {
        // Most are empty or plain, which need no record of a change.
        for slot in self.slot_range(member_index) {
            if self.all.slots.as_slice()[slot] != EMPTY_SLOT {
                self.replace_slot(slot, &EMPTY_SLOT);
            }
        }
        for layer in self.layer_range(member_index) {
            if self.all.layers.as_slice()[layer] != PLAIN_LAYER {
                self.all.layers.set(layer, PLAIN_LAYER);
            }
        }
    }

    #[inline]
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

    #[inline]
    fn place_of_slot(&self, member_index: u32, index: usize) -> Result<usize, Error> {
        if index >= self.slots_per_member {
            let value = u32::try_from(index).unwrap_or(NONE);
            return Err(Error::BadPlayback { what: "slot", value });
        }
        Ok(self.slot_range(member_index).start + index)
    }

    #[inline]
    fn replace_slot(&mut self, index: usize, slot: &Slot) {
        let before = self.all.slots.as_slice()[index].machine_instance();
        self.all.slots.set(index, *slot);
        self.update_instance_uses(before, slot.machine_instance());
    }

    #[inline]
    fn use_layer(&mut self, member_index: u32, layer: u32) {
        let own = &self.all.members.as_slice()[member_index as usize];
        if own.layer_count() <= layer {
            let mut member = *own;
            member.layers_and_phase += layer + 1 - member.layer_count();
            self.all.members.set(member_index as usize, member);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SampledState;
    use crate::tables::members::tests::tables;

    #[test]
    fn new_member_inherits_no_playback() {
        let (mut tables, bodies) = tables(&[(1, 1)]);
        let member_index = tables.add_member(bodies[0]).unwrap();
        tables
            .set_layer(member_index, 2, Layer { weight: 0.5, mask_and_mode: LAYER_MASK })
            .unwrap();
        // No clip is bound.
        tables.set_slot(member_index, 1, &Slot::default().on_layer(3)).unwrap_err();
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

    #[test]
    fn ramp_changes_the_weight_of_a_slot_that_has_one() {
        let (mut tables, bodies) = tables(&[(1, 1)]);
        let member_index = tables.add_member(bodies[0]).unwrap();
        let mut looping = Slot::looping(NONE, 0, 1.0, 0.0, 1.0);
        let state = SampledState { bound_clip: NONE, row: 0.0, pace: 0.0 };
        let inertializing = Slot::inertialization(0, 900, [state; 2], [1.0, 0.0]);
        for (index, slot) in [looping, inertializing].into_iter().enumerate() {
            tables.set_slot(member_index, index, &slot).unwrap();
            tables.ramp_slot(member_index, index, 100, 0.25, 2.0).unwrap();
        }
        looping.ramp_weight(100, 1.0, 0.25, 2.0);
        assert_eq!(tables.slots().as_slice(), [looping, inertializing]);
        tables.ramp_slot(member_index, 2, 100, 0.25, 2.0).unwrap_err();
        tables.ramp_slot(member_index + 1, 0, 100, 0.25, 2.0).unwrap_err();
    }
}
