//! Slot allocation: finding a free slot, and evicting the weakest if none is free.
//!
//! A slot with weight is never dropped. If no slot is free, the weakest fades out first and the
//! start is scheduled for the end of that fade. The fade takes the start's own fade time times the
//! slot's share of the layer, so the pose moves no faster than by the requested crossfade.
//! Inertializing slots cannot be hastened: the start waits for the first of them to end before
//! another slot is evicted.

use populace_device::layout::{NONE, Slot};
use populace_device::{MAX_LAYERS, MAX_SLOTS};

use super::{Player, tick_after};
use crate::Error;
use crate::crowd::base::Base;
use crate::crowd::u32_from;

/// The share of a layer below which a slot that fades out counts as free. Dropping it moves the
/// pose by less than one frame of any crossfade shorter than ten seconds.
const NEGLIGIBLE: f32 = 1e-3;

/// The effect of a start on an occupied slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// The slot will fade out.
    Leaves,
    /// The slot continues with another weight.
    Stays,
    /// The slot is not affected.
    Apart,
}

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
fn is_vacant(slot: &Slot, tick: u64) -> bool {
    faded_out(slot, tick) && !slot.inertializes(tick)
}

impl Player {
    pub(crate) fn started(&self, base: &Base, member_index: u32, index: usize) -> Started {
        self.started[base.tables.slot_range(member_index).start + index]
    }

    /// Returns the share of each slot in its layer, 0 to 1: 0 for inertializing slots, `None` for
    /// free ones.
    fn slot_shares(&self, base: &Base, member_index: u32, tick: u64) -> [Option<f32>; MAX_SLOTS] {
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

    /// Frees `needed` slots. If too few are free, fades out the weakest and returns the tick at
    /// which they become free. Meanwhile the other weights of the layer hold, except for the
    /// strongest slot, which takes up the weight of those that fade.
    pub(crate) fn free_slots(
        &mut self,
        base: &mut Base,
        member_index: u32,
        needed: usize,
        secs: f32,
        tick: u64,
        plan: impl Fn(&Slot, Started) -> Plan,
    ) -> Result<Option<u64>, Error> {
        let vacant = base.slots(member_index).iter().filter(|slot| is_vacant(slot, tick));
        if vacant.take(needed).count() == needed {
            return Ok(None);
        }
        let shares = self.slot_shares(base, member_index, tick);
        let plans = self.plans(base, member_index, plan);
        let free = count_free(base.slots(member_index), &shares, &plans, tick);
        let missing = needed.saturating_sub(free);
        if missing == 0 {
            return Ok(None);
        }
        let (mut evicted, others) = self.by_strength(base, member_index, &shares, &plans);
        let smoothly = evicted.len() >= missing;
        evicted.extend(others);
        let splits =
            evicted.get(missing - 1).and_then(|last| self.partner(base, member_index, *last))
                == evicted.get(missing).copied();
        evicted.truncate(missing + usize::from(splits));
        if secs <= 0.0 || !smoothly {
            for index in evicted {
                self.cut(base, member_index, index, tick)?;
            }
            return Ok(None);
        }
        let share: f32 = evicted.iter().filter_map(|i| shares[*i]).sum();
        self.fade_out_for(base, member_index, &evicted, &plans, share * secs, tick).map(Some)
    }

    /// The number of slots that are free or can be freed without a jump of the pose.
    pub(crate) fn free_slot_count(
        &self,
        base: &Base,
        member_index: u32,
        tick: u64,
        plan: impl Fn(&Slot, Started) -> Plan,
    ) -> usize {
        let shares = self.slot_shares(base, member_index, tick);
        let plans = self.plans(base, member_index, plan);
        let free = count_free(base.slots(member_index), &shares, &plans, tick);
        free + self.by_strength(base, member_index, &shares, &plans).0.len()
    }

    fn plans(
        &self,
        base: &Base,
        member_index: u32,
        plan: impl Fn(&Slot, Started) -> Plan,
    ) -> Vec<Plan> {
        let slots = base.slots(member_index).iter().enumerate();
        slots.map(|(index, slot)| plan(slot, self.started(base, member_index, index))).collect()
    }

    /// Returns the other slot of a state machine. Only the device knows their weights, so both stay
    /// or leave together.
    fn partner(&self, base: &Base, member_index: u32, index: usize) -> Option<usize> {
        let slots = base.slots(member_index);
        slots[index].machine_instance()?;
        let is_mate = |slot: &Slot| {
            slot.machine_instance().is_some() && slot.bound_clip == slots[index].bound_clip ^ 1
        };
        slots.iter().position(is_mate)
    }

    /// Returns the slots that can be evicted, in order: slots that fade out, then inertializing
    /// slots by their end, then the others by weight, with the two slots of a machine next to each
    /// other. The second list holds slots that cannot fade because layer 0 would be left empty.
    fn by_strength(
        &self,
        base: &Base,
        member_index: u32,
        shares: &[Option<f32>; MAX_SLOTS],
        plans: &[Plan],
    ) -> (Vec<usize>, Vec<usize>) {
        let slots = base.slots(member_index);
        let rank = |i: usize| match slots[i].as_inertialization() {
            Some(inertialization) => (1, inertialization.end_tick()),
            None if plans[i] == Plan::Leaves || slots[i].end_weight <= 0.0 => (0, 0),
            None => (2, 0),
        };
        let is_second =
            |i: usize| self.partner(base, member_index, i).is_some_and(|partner| partner < i);
        let gives_way =
            |i: &usize| shares[*i].is_some() && plans[*i] != Plan::Stays && !is_second(*i);
        let mut order: Vec<_> = (0..slots.len()).filter(gives_way).collect();
        let both = |i: usize| [Some(i), self.partner(base, member_index, i)].into_iter().flatten();
        let share = |i: usize| both(i).filter_map(|i| shares[i]).sum::<f32>();
        order.sort_by(|&a, &b| rank(a).cmp(&rank(b)).then(share(a).total_cmp(&share(b))));
        let mut base = 0.0;
        let (fading, others): (Vec<_>, Vec<_>) = order.into_iter().partition(|&index| {
            let of_base = if slots[index].layer() == 0 { share(index) } else { 0.0 };
            let fades = base + of_base < 1.0 - NEGLIGIBLE;
            base += if fades { of_base } else { 0.0 };
            fades
        });
        (fading.into_iter().flat_map(both).collect(), others.into_iter().flat_map(both).collect())
    }

    /// Fades out `evicted` within `secs` and returns the tick at which they are free. Other slots
    /// that the start affects hold their weights until then, so that the pose moves no faster than
    /// by one crossfade.
    fn fade_out_for(
        &mut self,
        base: &mut Base,
        member_index: u32,
        evicted: &[usize],
        plans: &[Plan],
        secs: f32,
        tick: u64,
    ) -> Result<u64, Error> {
        let mut due = tick + 1;
        let mut left_behind = [0.0_f32; MAX_LAYERS];
        for &index in evicted {
            let slot = base.slots(member_index)[index];
            if let Some(inertialization) = slot.as_inertialization() {
                due = due.max(inertialization.end_tick());
                continue;
            }
            let weight = slot.weight_at(tick);
            let own =
                if slot.weight_rate < 0.0 && slot.end_weight <= 0.0 && tick >= slot.weight_tick {
                    weight / -slot.weight_rate
                } else {
                    f32::INFINITY
                };
            let secs = secs.min(own);
            base.tables.ramp_slot(member_index, index, tick, 0.0, secs)?;
            due = due.max(tick_after(tick, secs).saturating_add(1));
            left_behind[slot.layer() as usize] += weight;
        }
        for (layer, left) in (0..).zip(left_behind) {
            let of_layer = |i: &usize| {
                plans[*i] != Plan::Apart
                    && !evicted.contains(i)
                    && base.slots(member_index)[*i].layer() == layer
            };
            let mut still: Vec<_> = (0..plans.len()).filter(of_layer).collect();
            let weight = |i: &usize| base.slots(member_index)[*i].weight_at(tick);
            still.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
            let heirs: Vec<_> = still
                .first()
                .iter()
                .flat_map(|i| [Some(**i), self.partner(base, member_index, **i)])
                .flatten()
                .collect();
            for index in still {
                let slot = &base.slots(member_index)[index];
                if left > 0.0 && !faded_out(slot, tick) {
                    let more = if heirs.contains(&index) { left / heirs.len() as f32 } else { 0.0 };
                    let weight = slot.weight_at(tick) + more;
                    base.tables.ramp_slot(member_index, index, tick, weight, secs)?;
                }
            }
        }
        Ok(due)
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
    fn cut(
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
        self.note_left(base, member_index, &slot, tick);
        Ok(base.tables.ramp_slot(member_index, index, tick, 0.0, 0.0)?)
    }

    /// Keeps a slot that ends during an update, for the events before its end.
    pub(crate) fn note_left(&mut self, base: &mut Base, member_index: u32, slot: &Slot, tick: u64) {
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
        self.put_slot(base, member_index, index, slot, Started::default(), tick)
    }

    pub(crate) fn empty_slot(
        &mut self,
        base: &mut Base,
        member_index: u32,
        index: usize,
    ) -> Result<(), Error> {
        let empty = Slot { bound_clip: NONE, ..Slot::default() };
        Ok(base.tables.set_slot(member_index, index, empty)?)
    }

    /// Writes a slot to a free index; the caller has called [`free_slots`](Self::free_slots).
    pub(crate) fn fill_slot(
        &mut self,
        base: &mut Base,
        member_index: u32,
        slot: Slot,
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
        slot: Slot,
        started: Started,
        tick: u64,
    ) -> Result<(), Error> {
        let replaced = base.slots(member_index)[index];
        self.note_left(base, member_index, &replaced, tick);
        base.tables.set_slot(member_index, index, slot)?;
        let range = base.tables.slot_range(member_index);
        self.started[range.start + index] = started;
        Ok(())
    }
}

/// Returns the number of free slots. One of negligible weight that the start keeps is not free: its
/// weight rises again.
fn count_free(
    slots: &[Slot],
    shares: &[Option<f32>; MAX_SLOTS],
    plans: &[Plan],
    tick: u64,
) -> usize {
    let all = slots.iter().zip(shares).zip(plans);
    let is_free = |slot: &Slot, share: &Option<f32>, plan: Plan| {
        share.is_none() && (plan != Plan::Stays || faded_out(slot, tick))
    };
    all.filter(|((slot, share), plan)| is_free(slot, share, **plan)).count()
}
