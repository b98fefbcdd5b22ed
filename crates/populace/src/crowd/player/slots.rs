//! The slots of members: their shares of layers, which are free, and what is written to them.

use populace_device::layout::{NONE, Slot};
use populace_device::{MAX_LAYERS, MAX_SLOTS};

use super::Player;
use crate::Error;
use crate::crowd::base::Base;
use crate::crowd::u32_from;

/// The share of a layer below which a slot that fades out counts as free. Dropping it moves the
/// pose by less than one frame of any crossfade shorter than ten seconds.
pub(super) const NEGLIGIBLE: f32 = 1e-3;

/// Data of a slot that only the host has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Started {
    /// The serial number of the start. All slots of a blend space share one.
    pub(crate) serial: u64,
    /// The index of the clip in its blend space, if it belongs to one.
    pub(crate) sample: Option<u16>,
    /// Whether the clip plays once; a slot at speed 0 does not show it.
    pub(crate) once: bool,
}

/// Some of a member's slots, one bit for each. Iterates over their indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SlotSet(u32);

impl SlotSet {
    /// Returns the slots for which `is_in` is true.
    pub(crate) fn of(slots: &[Slot], is_in: impl Fn(&Slot) -> bool) -> Self {
        let bits = slots.iter().rev().fold(0, |bits, slot| bits << 1 | u32::from(is_in(slot)));
        Self(bits)
    }

    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl Iterator for SlotSet {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        let index = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (index < u32::BITS).then_some(index as usize)
    }
}

/// Returns whether the weight of a slot is 0 for good. Inertializing slots have no weight.
pub(crate) fn faded_out(slot: &Slot, tick: u64) -> bool {
    slot.bound_clip == NONE
        || slot.is_inertialization()
        || (slot.end_weight <= 0.0 && slot.weight_at(tick) <= 0.0)
}

/// Returns the slots of a layer that have not faded out.
pub(crate) fn weighing(slots: &[Slot], layer: u32, tick: u64) -> SlotSet {
    SlotSet::of(slots, |slot| !faded_out(slot, tick) && slot.layer() == layer)
}

/// Returns whether a slot is free whatever the others weigh. It has no share of its layer.
pub(super) fn is_vacant(slot: &Slot, tick: u64) -> bool {
    faded_out(slot, tick) && !slot.inertializes(tick)
}

impl Player {
    pub(crate) fn started(&self, base: &Base, member_index: u32, index: usize) -> Started {
        self.started[base.tables.slot_range(member_index).start + index]
    }

    /// Returns the share of each slot in its layer, 0 to 1: 0 for inertializing slots, `None` for
    /// free ones.
    pub(super) fn slot_shares(
        &self,
        base: &Base,
        member_index: u32,
        tick: u64,
    ) -> [Option<f32>; MAX_SLOTS] {
        let mut totals = [0.0_f32; MAX_LAYERS];
        let weighing =
            |slot: &Slot| if slot.bound_clip == NONE { 0.0 } else { slot.weight_at(tick) };
        for slot in base.slots(member_index) {
            totals[slot.layer() as usize] += weighing(slot);
        }
        // Layer 0 is always normalised. Layers above it leave the remainder to the layers beneath.
        totals[1..].iter_mut().for_each(|total| *total = total.max(1.0));
        let mut shares = [None; MAX_SLOTS];
        for (share, slot) in shares.iter_mut().zip(base.slots(member_index)) {
            let of_layer = weighing(slot) / totals[slot.layer() as usize].max(f32::MIN_POSITIVE);
            let free = faded_out(slot, tick) || (slot.end_weight <= 0.0 && of_layer < NEGLIGIBLE);
            *share = (!free || slot.inertializes(tick)).then_some(of_layer);
        }
        shares
    }

    /// Returns the first vacant slot other than `taken`.
    pub(crate) fn vacant_slot(
        &self,
        base: &Base,
        member_index: u32,
        taken: Option<usize>,
        tick: u64,
    ) -> Option<usize> {
        // A slot that was cut since the last update still contributes root motion up to the cut.
        let played = |slot: &Slot| !slot.is_inertialization() && slot.weight_tick > base.clock.tick;
        let mut slots = base.slots(member_index).iter().enumerate();
        let is_it = |(index, slot): &(usize, &Slot)| {
            is_vacant(slot, tick) && !played(slot) && Some(*index) != taken
        };
        slots.find(is_it).map(|(index, _)| index)
    }

    /// Returns the free slot of least weight.
    pub(crate) fn free_slot(&self, base: &Base, member_index: u32, tick: u64) -> Option<usize> {
        self.free_slot_beside(base, member_index, None, tick)
    }

    /// Returns the free slot of least weight other than `taken`.
    pub(crate) fn free_slot_beside(
        &self,
        base: &Base,
        member_index: u32,
        taken: Option<usize>,
        tick: u64,
    ) -> Option<usize> {
        let first = self.vacant_slot(base, member_index, taken, tick);
        if first.is_some() {
            return first;
        }
        let slots = base.slots(member_index);
        let shares = self.slot_shares(base, member_index, tick);
        let is_free = |index: usize| shares[index].is_none() && Some(index) != taken;
        let slots = slots.iter().enumerate().filter(|(index, _)| is_free(*index));
        let weight = |slot: &Slot| if faded_out(slot, tick) { -1.0 } else { slot.weight_at(tick) };
        slots.min_by(|a, b| weight(a.1).total_cmp(&weight(b.1))).map(|(index, _)| index)
    }

    /// Fades out all slots of a layer in proportion, and returns whether any had weight.
    /// Inertializing slots continue unless `secs` is 0.
    pub(crate) fn fade_out(
        &mut self,
        base: &mut Base,
        member_index: u32,
        layer: usize,
        secs: f32,
        tick: u64,
    ) -> Result<bool, Error> {
        let weighing = weighing(base.slots(member_index), u32_from(layer), tick);
        if secs > 0.0 {
            for index in weighing {
                base.tables.ramp_slot(member_index, index, tick, 0.0, secs)?;
            }
        } else {
            let of_layer = |slot: &Slot| slot.layer() as usize == layer;
            for index in SlotSet::of(base.slots(member_index), of_layer) {
                self.cut(base, member_index, index, tick)?;
            }
        }
        Ok(!weighing.is_empty())
    }

    /// Sets the weight of a slot to 0 at `tick`. Until the slot is reused it still holds its weight
    /// before `tick`.
    pub(super) fn cut(
        &mut self,
        base: &mut Base,
        member_index: u32,
        index: usize,
        tick: u64,
    ) -> Result<(), Error> {
        let slot = base.slots(member_index)[index];
        if slot.inertializes(tick) {
            return self.empty_slot(base, member_index, index);
        }
        if faded_out(&slot, tick) {
            return Ok(());
        }
        self.note_left(base, member_index, index, tick);
        Ok(base.tables.ramp_slot(member_index, index, tick, 0.0, 0.0)?)
    }

    /// Keeps a slot that ends during an update, for the events before its end.
    pub(crate) fn note_left(&mut self, base: &Base, member_index: u32, index: usize, tick: u64) {
        let slot = &base.slots(member_index)[index];
        if tick > base.clock.tick && slot.bound_clip != NONE {
            self.left.push((member_index, *slot, tick));
        }
    }

    /// Copies a slot that ends during an update to a free slot, if there is one, so that its root
    /// motion up to `tick` counts.
    pub(crate) fn leave(
        &mut self,
        base: &mut Base,
        member_index: u32,
        mut slot: Slot,
        tick: u64,
    ) -> Result<(), Error> {
        let moves = tick > base.clock.tick && base.members.all[member_index as usize].moves;
        let Some(index) = self.free_slot(base, member_index, tick).filter(|_| moves) else {
            return Ok(());
        };
        slot.ramp_weight(tick, slot.weight_at(tick), 0.0, 0.0);
        self.put_slot(base, member_index, index, &slot, Started::default(), tick)
    }

    pub(crate) fn empty_slot(
        &mut self,
        base: &mut Base,
        member_index: u32,
        index: usize,
    ) -> Result<(), Error> {
        let empty = Slot { bound_clip: NONE, ..Slot::default() };
        Ok(base.tables.set_slot(member_index, index, &empty)?)
    }

    /// Writes a slot to a free index; the caller has called [`free_slots`](Self::free_slots).
    pub(crate) fn fill_slot(
        &mut self,
        base: &mut Base,
        member_index: u32,
        slot: &Slot,
        started: Started,
        tick: u64,
    ) -> Result<(), Error> {
        let index = self.free_slot(base, member_index, tick).unwrap_or(0);
        self.put_slot(base, member_index, index, slot, started, tick)
    }

    /// Writes a slot that begins at `tick`, and keeps the one that it replaces for its events.
    pub(crate) fn put_slot(
        &mut self,
        base: &mut Base,
        member_index: u32,
        index: usize,
        slot: &Slot,
        started: Started,
        tick: u64,
    ) -> Result<(), Error> {
        self.note_left(base, member_index, index, tick);
        base.tables.set_slot(member_index, index, slot)?;
        let range = base.tables.slot_range(member_index);
        self.started[range.start + index] = started;
        Ok(())
    }
}
